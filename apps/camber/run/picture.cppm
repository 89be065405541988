module;
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
export module camber.run:picture;
import camber.core;
import camber.drawing;
import camber.io;
import :solution;
import :stages;

/// A mesh as a picture: `camber picture`.
export namespace camber::run {

/// What the colours of a picture stand for.
enum class PictureColour : std::uint8_t { scaled_jacobian, quality, reference, anisotropy, solution, none };
constexpr auto words(PictureColour) {
    return words_of(Word{PictureColour::scaled_jacobian, "scaled-jacobian"}, Word{PictureColour::quality, "quality"},
                    Word{PictureColour::reference, "reference"}, Word{PictureColour::anisotropy, "anisotropy"},
                    Word{PictureColour::solution, "solution"}, Word{PictureColour::none, "none"});
}

struct PictureChoice {
    std::size_t width = 1200, height = 900;  ///< pixels
    std::optional<Cut<3>> cut = {};          ///< of a 2D mesh the normal's z is 0
    std::optional<Vec<3>> from = {};         ///< where the viewer is, as a direction; none: obliquely, onto the cut
    std::optional<PictureOptions::Zoom> zoom = {};
    /// None: the solution, else the metric's anisotropy, where they are given; else scaled Jacobians, of degree 1
    /// qualities.
    std::optional<PictureColour> colour = {};
    Background background = Background::light;
    Edges edges = Edges::shown;
    std::size_t worst = 0;  ///< how many of the worst elements to point at
};

/// What a picture is made from; the metric has rows at the vertices.
struct PictureInputs {
    DecodedMesh mesh;
    std::optional<MetricFile> metric = {};
    std::optional<NamedField> solution = {};
};

/// Errors: nothing to draw; colours by a metric or a solution that is not given (usage); those of metric files.
[[nodiscard]] Outcome<Scene> picture_of(const PictureInputs& inputs, const PictureChoice& choice,
                                        const Execution& execution);

}  // namespace camber::run
