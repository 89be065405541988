module;
#include <cmath>
export module camber.drawing:view;
import camber.core;

/// From space onto paper, without perspective: lengths along the paper stay in proportion.
export namespace camber {

/// Three directions of unit length, each normal to the others.
struct View {
    Vec<3> right{{1, 0, 0}}, up{{0, 1, 0}}, towards{{0, 0, 1}};  ///< towards the viewer
};

/// Seen from the direction `from` (any length but 0), with z upwards; from above or below with y upwards.
[[nodiscard]] inline View view_from(const Vec<3>& from) {
    View view;
    view.towards = normalised(from);
    const bool is_vertical = std::abs(view.towards[2]) > 1 - 1e-9;
    const Vec<3> upwards = is_vertical ? Vec<3>{{0, 1, 0}} : Vec<3>{{0, 0, 1}};
    view.right = normalised(cross(upwards, view.towards));
    view.up = cross(view.towards, view.right);
    return view;
}

/// A point of a mesh in space; of one in 2D with z = 0.
[[nodiscard]] constexpr Vec<3> in_space(const Vec<2>& p) { return {{p[0], p[1], 0}}; }
[[nodiscard]] constexpr Vec<3> in_space(const Vec<3>& p) { return p; }

/// Points of space on paper: x to the right and y downwards (pixels), z towards the viewer (pixels).
struct PaperProjection {
    View view = {};
    double scale = 1;       ///< pixels a model unit
    double x0 = 0, y0 = 0;  ///< where the origin of space is (pixels)

    [[nodiscard]] Vec<3> operator()(const Vec<3>& p) const {
        return {{x0 + scale * dot(view.right, p), y0 - scale * dot(view.up, p), scale * dot(view.towards, p)}};
    }
};

/// A rectangle of the paper (pixels).
struct PaperFrame {
    double left = 0, top = 0, width = 0, height = 0;
};

/// What lies in `box` (coordinates along right, up, towards) fills the frame.
[[nodiscard]] inline PaperProjection fitted(const View& view, const Box<3>& box, const PaperFrame& frame) {
    const double wide = box.high[0] - box.low[0], high = box.high[1] - box.low[1];
    const double scale = std::fmin(wide > 0 ? frame.width / wide : HUGE_VAL, high > 0 ? frame.height / high : HUGE_VAL);
    PaperProjection p{view, std::isfinite(scale) ? scale : 1};
    p.x0 = frame.left + frame.width / 2 - p.scale * (box.low[0] + box.high[0]) / 2;
    p.y0 = frame.top + frame.height / 2 + p.scale * (box.low[1] + box.high[1]) / 2;
    return p;
}

}  // namespace camber
