module;
#include <string>
#include <variant>
#include <vector>
export module camber.drawing:marks;
import camber.core;
import :colour;
import :scene;
import :view;

/// What stands on a picture beside the mesh: the legend of the colours, and pointers. All in pixels, y downwards.
export namespace camber {

enum class Anchor { start, middle, end };
struct TextMark {
    double x = 0, y = 0, size = 0;  ///< of the base line's anchor; of a capital letter and what is below it
    Anchor anchor = Anchor::start;
    Colour colour = {};
    std::string text = {};
};
struct BoxMark {
    PaperFrame frame = {};
    Colour colour = {};
};
struct RingMark {
    double x = 0, y = 0, radius = 0, width = 0;
    Colour colour = {};
};
using PictureMark = std::variant<BoxMark, RingMark, TextMark>;

/// The room that the legend takes at the right of the picture (pixels).
[[nodiscard]] double legend_width(const PictureOptions& options);

/// The legend, and a ring with a text at each pointer.
[[nodiscard]] std::vector<PictureMark> marks_of(const Scene& scene);

/// Three significant digits, as short as can be: "0.982", "1e-07", "12".
[[nodiscard]] std::string short_number(double value);

}  // namespace camber
