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

/// Draws a histogram as SVG: panels for the mesh before and after correction (or one panel) with the same axes, the
/// mean, and the straight edges' lengths as an outline. Bins beyond the first and last limits are paler. Empty bins at
/// the ends are omitted.
[[nodiscard]] std::string svg(const Histogram& histogram);

/// Draws all histograms below each other.
[[nodiscard]] std::string svg(const std::vector<Histogram>& histograms);

}  // namespace camber::run

/// Pictures of meshes, for `camber picture`.
export namespace camber::run {

/// Quantity that the colours show.
enum class PictureColour : std::uint8_t { scaled_jacobian, quality, reference, anisotropy, solution, none };
constexpr auto words(PictureColour) {
    return words_of(Word{PictureColour::scaled_jacobian, "scaled-jacobian"}, Word{PictureColour::quality, "quality"},
                    Word{PictureColour::reference, "reference"}, Word{PictureColour::anisotropy, "anisotropy"},
                    Word{PictureColour::solution, "solution"}, Word{PictureColour::none, "none"});
}

struct PictureChoice {
    std::size_t width = 1200, height = 900;  ///< pixels
    std::optional<Cut<3>> cut = {};          ///< for a 2D mesh, z of the normal is 0
    std::optional<Vec<3>> from = {};         ///< direction towards the viewer; none: oblique, towards the cut
    std::optional<PictureOptions::Zoom> zoom = {};
    /// If none: the solution if specified, else the metric's anisotropy if specified, else scaled Jacobians (degree 2)
    /// or qualities (degree 1).
    std::optional<PictureColour> colour = {};
    Background background = Background::light;
    Edges edges = Edges::shown;
    std::size_t worst = 0;  ///< number of worst elements to mark
    /// Names of groups or reference numbers of boundary facets and elements. In a 2D mesh they select elements, in a
    /// standalone surface mesh its facets. Only groups of `show` are drawn (empty: all), without groups of `hide`.
    std::vector<std::string> show = {}, hide = {};
};

/// Inputs of a picture. The metric has rows at the vertices.
struct PictureInputs {
    DecodedMesh mesh;
    std::optional<MetricFile> metric = {};
    std::optional<NamedField> solution = {};
};

/// A scene to draw, and notes for the user.
struct Picture {
    Scene scene;
    std::vector<std::string> notices = {};
};

/// Errors: input (nothing to draw); usage (unknown group, colours by a missing metric or solution); those of metric
/// files.
[[nodiscard]] Outcome<Picture> picture_of(const PictureInputs& inputs, const PictureChoice& choice,
                                          const Execution& execution);

}  // namespace camber::run
