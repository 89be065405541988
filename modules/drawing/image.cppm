module;
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>
export module camber.drawing:image;
import camber.core;
import :marks;
import :scene;

export namespace camber {

/// Rows from the top; red, green, blue and how opaque, a byte each, not multiplied with each other.
struct Image {
    std::size_t width = 0, height = 0;
    Buffer<std::uint8_t> bytes;
    friend bool operator==(const Image&, const Image&) = default;
};

/// The scene without its marks: what is nearer hides what is behind, faces and edges by their curves to a twentieth of
/// a pixel. The same bytes for any number of threads. Errors: stopped, memory.
[[nodiscard]] Outcome<Image> rasterised(const Scene& scene, const Execution& execution);

/// The faces that the picture shows some of, rising.
[[nodiscard]] Outcome<Buffer<std::uint32_t>> visible_faces(const Scene& scene, const Execution& execution);

/// The image with the marks upon it; texts in a small alphabet of strokes (letters are small ones).
[[nodiscard]] Image with_marks(Image image, const std::vector<PictureMark>& marks);

/// As a PNG file. Errors: memory.
[[nodiscard]] Outcome<Buffer<std::byte>> png(const Image& image);

/// Scene and marks as an SVG file: edges as quadratic Bézier curves, exact. Of what is hidden in part the nearer face
/// is drawn later; what is hidden altogether is left out. Errors: stopped, memory.
[[nodiscard]] Outcome<std::string> svg_of(const Scene& scene, const Execution& execution);

}  // namespace camber
