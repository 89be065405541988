module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>
export module camber.drawing:scene;
import camber.core;
import :colour;
import :faces;
import :drawn_face;
import :view;

/// All that a picture shows, on paper, whatever it is then made as.
export namespace camber {

enum class Edges : std::uint8_t { shown, hidden };

/// A place that is pointed at.
struct Pointer {
    Vec<3> at;  ///< in space; of a 2D mesh with z = 0
    std::string text;
};

/// What is wanted of a picture, beside the mesh.
struct PictureOptions {
    std::size_t width = 1200, height = 900;  ///< pixels
    Background background = Background::light;
    Edges edges = Edges::shown;
    Colouring colouring = OneColour{};
    std::string title = {};  ///< of the legend
    View view = {};
    /// The middle and the half width of what is shown (model units); none: all.
    struct Zoom {
        Vec<3> centre;
        double radius;
    };
    std::optional<Zoom> zoom = {};
    std::vector<Pointer> pointers = {};

    [[nodiscard]] bool has_legend() const { return !std::holds_alternative<OneColour>(colouring); }
};

/// The width of lines (pixels), the same share of pictures of any size, but for very small and large ones.
[[nodiscard]] inline double line_width(const PictureOptions& options, double least) {
    return std::clamp(static_cast<double>(std::min(options.width, options.height)) / 800, least, 4.0);
}
/// How much of a line's colour there is beside a triangle of this height (pixels). A line keeps its width on paper;
/// where triangles are hardly wider than lines these are paler, so that layers do not become black.
[[nodiscard]] inline double line_opacity(double height, double width, double most) {
    return std::clamp(height / (7 * width), 0.1, most);
}

/// Which sides of faces can be seen.
enum class VisibleSides : std::uint8_t {
    outer,  ///< solids: the faces that look away are behind others
    both,   ///< surfaces, and meshes in 2D
};
enum class Lighting : std::uint8_t { flat, lit };

struct Scene {
    PictureOptions options;
    PaperProjection projection;
    VisibleSides sides = VisibleSides::both;
    Lighting lighting = Lighting::flat;
    Buffer<DrawnFace> patches;
};

/// The values of a face at its six nodes.
using FaceValues = std::function<std::array<float, 6>(const Face&)>;

/// The faces on paper, as large as there is room. `marked`: elements to be stressed, rising. Errors: nothing to draw
/// (input), stopped.
template <int D>
[[nodiscard]] Outcome<Scene> make_scene(const QuadraticMesh<D>& mesh, std::span<const Face> faces,
                                        const FaceValues& values, std::span<const std::uint32_t> marked,
                                        PictureOptions options, const Execution& execution);

}  // namespace camber
