module;
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>
export module camber.reports:picture;
import camber.core;
import camber.recipes;
import camber.drawing;
import camber.io;

/// Pictures of histograms.
export namespace camber::run {

/// A histogram as an SVG picture: a panel for the mesh before correction and one for after (or one alone), on the same
/// axes, the mean marked; lengths of the straight edges as an outline behind. Bins beyond the first and the last limit
/// are paler. Empty bins at the ends are left out.
[[nodiscard]] std::string svg(const Histogram& histogram);

/// All of them below each other in one picture.
[[nodiscard]] std::string svg(const std::vector<Histogram>& histograms);

}  // namespace camber::run

/// A mesh as a picture: `camber picture`.
export namespace camber::run {

/// Quantity that the colours of a picture show.
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
    /// Names of groups or reference numbers of boundary facets and of elements; of a 2D mesh of elements, of a
    /// standalone surface mesh of its facets. Only groups of `show` are drawn (empty: all), and none of `hide`.
    std::vector<std::string> show = {}, hide = {};
};

/// Inputs of a picture; the metric has rows at the vertices.
struct PictureInputs {
    DecodedMesh mesh;
    std::optional<MetricFile> metric = {};
    std::optional<NamedField> solution = {};
};

/// A picture before it is drawn, and notes on it for the user.
struct Picture {
    Scene scene;
    std::vector<std::string> notices = {};
};

/// Errors: nothing to draw; a group that the mesh does not have (usage); colours by a metric or a solution that is not
/// given (usage); those of metric files.
[[nodiscard]] Outcome<Picture> picture_of(const PictureInputs& inputs, const PictureChoice& choice,
                                          const Execution& execution);

}  // namespace camber::run
