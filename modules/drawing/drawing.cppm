module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>
/// Pictures of meshes with curved faces, as pixels or SVG, without a display or graphics processor.
export module camber.drawing;
import camber.core;

export namespace camber {

/// Red, green and blue from 0 to 1 (sRGB).
struct Colour {
    double red = 0, green = 0, blue = 0;
    friend bool operator==(const Colour&, const Colour&) = default;
};
[[nodiscard]] constexpr Colour blend(const Colour& a, const Colour& b, double t) {
    return {a.red + t * (b.red - a.red), a.green + t * (b.green - a.green), a.blue + t * (b.blue - a.blue)};
}
[[nodiscard]] constexpr Colour scaled(const Colour& c, double factor) {
    return {c.red * factor, c.green * factor, c.blue * factor};
}
[[nodiscard]] std::string hex(const Colour& colour);

enum class Background : std::uint8_t { light, dark, transparent };
constexpr auto words(Background) {
    return words_of(Word{Background::light, "light"}, Word{Background::dark, "dark"},
                    Word{Background::transparent, "transparent"});
}

/// Colours of everything except values.
struct Theme {
    Colour paper, ink, line, plain, missing, accent;
};
[[nodiscard]] Theme theme_of(Background background);

/// Colour ramps. `plain` is for quantities whose high values are neither good nor bad.
enum class Ramp : std::uint8_t { plain, good_is_high };
enum class Spacing : std::uint8_t { linear, logarithmic };

/// Maps values from `low` to `high` to a colour ramp. Values outside this range get the colour of the nearest end.
struct ColourRange {
    double low = 0, high = 1;
    Ramp ramp = Ramp::plain;
    Spacing spacing = Spacing::linear;
    /// Position of the value between `low` (0) and `high` (1).
    [[nodiscard]] double place_of(double value) const;
    [[nodiscard]] double value_at(double place) const;
};
/// Colours for kinds without an order, for example references. Value i of a face stands for the kind with reference
/// `numbers[i]`.
struct ColourKinds {
    std::vector<Reference> numbers;
    std::vector<std::string> names = {};       ///< name of each entry of `numbers`, possibly empty; or no entries
    std::vector<std::uint8_t> is_listed = {};  ///< for each entry of `numbers`: 1 if it is in the legend, else 0; no
                                               ///< entries: all are in it
};
struct OneColour {};
using Colouring = std::variant<OneColour, ColourRange, ColourKinds>;

/// Colour of a value. NaN, and values that stand for no kind, get the colour `missing`; infinite values get the colour
/// of the range's end.
[[nodiscard]] Colour colour_of(const Colouring& colouring, double value, const Theme& theme);
[[nodiscard]] Colour colour_at(Ramp ramp, double place);
[[nodiscard]] Colour colour_of_kind(std::size_t i);

// Visible faces and edges of a mesh.

/// Number of a node: vertices from 0, then edge nodes in the order of the edge set.
using NodeNumber = std::uint32_t;

enum class FaceKind : std::uint8_t {
    boundary,   ///< the face belongs to only one element, or to a surface mesh
    uncovered,  ///< the element on the other side is not drawn
    plane,      ///< the face is an element of a 2D mesh
    facet,      ///< the face is a facet of a group in `DrawnGroups::shown`
};

/// A triangle to draw. In 3D the corners are counter-clockwise seen from outside the element; in 2D they are in the
/// element's order.
struct Face {
    std::array<NodeNumber, 6> nodes{};  ///< corners, then nodes of the edges 01, 12, 20
    std::uint32_t element = 0;          ///< number of the element (in a surface mesh: of the facet)
    Reference reference = 0;  ///< reference of the facet on the face (0: none); for an uncovered face that of its
                              ///< element
    FaceKind kind = FaceKind::boundary;
    friend bool operator==(const Face&, const Face&) = default;
};

struct FaceEdge {
    std::array<NodeNumber, 3> nodes{};  ///< end nodes, then the mid node
    std::uint32_t faces = 0;            ///< number of drawn faces at the edge; 1 on the border of the drawn faces
    friend bool operator==(const FaceEdge&, const FaceEdge&) = default;
};

/// Cuts the mesh with a plane: elements in the half space dot(normal, x) > offset are removed.
template <int D>
struct Cut {
    Vec<D> normal{};
    double offset = 0;
};

/// For each element (in a surface mesh: facet), 0 if the mean of its vertices is in the removed half space, else 1.
/// Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Column<std::uint8_t>> elements_inside_cut(const Cut<D>& cut, const Mesh<D>& mesh,
                                                                const Execution& execution);

/// Returns the visible faces of the selected elements, in ascending order of elements. In 3D these are the faces of
/// exactly one selected element, in 2D the elements, in a surface mesh the facets. `selected`: 1 for each selected
/// element; empty: all. Errors: unsupported (not simplices of degree 2: elevate the degree first), stopped.
template <int D>
[[nodiscard]] Outcome<Column<Face>> faces_to_draw(const Mesh<D>& mesh, std::span<const std::uint8_t> selected,
                                                  const Execution& execution);

struct DrawnGroups {
    std::span<const std::uint8_t> bodies = {};  ///< for each element 1 if all its visible faces are drawn, else 0;
                                                ///< empty: all 1
    std::vector<Reference> shown = {};   ///< ascending references of facets that are drawn even on elements with 0 in
                                         ///< `bodies`
    std::vector<Reference> hidden = {};  ///< ascending references of facets that are not drawn
};

/// Returns the visible faces of the selected elements that `groups` does not hide. Elements with 0 in `bodies` show
/// only facets of the groups `shown`. A boundary face that is no facet of the mesh has reference 0. Errors: unsupported
/// (not simplices of degree 2), stopped.
[[nodiscard]] Outcome<Column<Face>> faces_to_draw(const Mesh<3>& mesh, std::span<const std::uint8_t> selected,
                                                  const DrawnGroups& groups, const Execution& execution);

/// Edges of the faces, each once, in the order of the edge set.
template <int D>
[[nodiscard]] Column<FaceEdge> edges_to_draw(const Mesh<D>& mesh, std::span<const Face> faces);

template <int D>
[[nodiscard]] inline Vec<D> node_point(const Mesh<D>& mesh, NodeNumber node) {
    const std::size_t vertices = mesh.points.size();
    return node < vertices ? mesh.points[node] : mesh.edge_nodes[node - vertices].point;
}

// Orthographic projection from space onto paper.

/// Orthonormal axes of a view, in space.
struct View {
    Vec<3> right{{1, 0, 0}}, up{{0, 1, 0}}, towards{{0, 0, 1}};  ///< `towards` points to the viewer
};

/// View of the mesh from the direction `from`, which must not be 0. The axis z points up, or y if `from` is parallel to
/// z.
[[nodiscard]] inline View view_from(const Vec<3>& from) {
    View view;
    view.towards = normalised(from);
    const bool is_vertical = std::abs(view.towards[2]) > 1 - 1e-9;
    const Vec<3> upwards = is_vertical ? Vec<3>{{0, 1, 0}} : Vec<3>{{0, 0, 1}};
    view.right = normalised(cross(upwards, view.towards));
    view.up = cross(view.towards, view.right);
    return view;
}

[[nodiscard]] constexpr Vec<3> in_space(const Vec<2>& p) { return {{p[0], p[1], 0}}; }
[[nodiscard]] constexpr Vec<3> in_space(const Vec<3>& p) { return p; }

/// Projects points to pixels: x to the right, y down, z towards the viewer.
struct PaperProjection {
    View view = {};
    double scale = 1;       ///< pixels per model unit
    double x0 = 0, y0 = 0;  ///< pixel position of the origin of space

    [[nodiscard]] Vec<3> operator()(const Vec<3>& p) const {
        return {{x0 + scale * dot(view.right, p), y0 - scale * dot(view.up, p), scale * dot(view.towards, p)}};
    }
};

struct PaperFrame {
    double left = 0, top = 0, width = 0, height = 0;
};

/// Projection that fits a box into the frame. The box has coordinates along the view's axes.
[[nodiscard]] inline PaperProjection fitted(const View& view, const Box<3>& box, const PaperFrame& frame) {
    const double wide = box.high[0] - box.low[0], high = box.high[1] - box.low[1];
    const double scale = std::fmin(wide > 0 ? frame.width / wide : HUGE_VAL, high > 0 ? frame.height / high : HUGE_VAL);
    PaperProjection p{view, std::isfinite(scale) ? scale : 1};
    p.x0 = frame.left + frame.width / 2 - p.scale * (box.low[0] + box.high[0]) / 2;
    p.y0 = frame.top + frame.height / 2 + p.scale * (box.low[1] + box.high[1]) / 2;
    return p;
}

// Faces on paper. The projection is affine, so the image of a quadratic triangle is again a quadratic triangle.

enum class LineKind : std::uint8_t { none, shared, rim };

struct DrawnFace {
    std::array<Vec<3>, 6> nodes;  ///< positions on paper (pixels), in the order of `Face::nodes`
    std::array<float, 6> values{};
    std::array<LineKind, 3> lines{};  ///< kinds of lines along the edges 01, 12, 20
    bool is_marked = false;
    std::uint32_t face = 0;
};

using FacePoint = std::array<double, 3>;  ///< barycentric coordinates on a face

[[nodiscard]] constexpr Vec<3> point_at(const std::array<Vec<3>, 6>& nodes, const FacePoint& xi) {
    Vec<3> sum{};
    for (std::size_t i = 0; i < 3; ++i) {
        sum += vertex_shape(xi[i]) * nodes[i];
        sum += edge_shape<2>(xi, static_cast<int>(i)) * nodes[3 + i];
    }
    return sum;
}
[[nodiscard]] constexpr double value_at(const std::array<float, 6>& values, const FacePoint& xi) {
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        sum += static_cast<double>(values[i]) * vertex_shape(xi[i]);
        sum += static_cast<double>(values[3 + i]) * edge_shape<2>(xi, static_cast<int>(i));
    }
    return sum;
}

/// Normal of the projected face, not normalised. It points to the side from which the corners are counter-clockwise.
[[nodiscard]] constexpr Vec<3> normal_at(const std::array<Vec<3>, 6>& n, const FacePoint& xi) {
    std::array<Vec<3>, 3> partial{};
    for (std::size_t i = 0; i < 3; ++i) {
        partial[i] += (4 * xi[i] - 1) * n[i];
        add_edge_derivatives<2>(xi, static_cast<int>(i), n[3 + i], partial);
    }
    // This order gives positive z to faces that are counter-clockwise for the viewer, because y is down on paper.
    return cross(partial[2] - partial[0], partial[1] - partial[0]);
}

/// Brightness from ambient light and from a lamp above the viewer's left shoulder. The normal is first turned towards
/// the viewer.
[[nodiscard]] inline double brightness(const std::array<Vec<3>, 6>& nodes, const FacePoint& xi) {
    Vec<3> n = normalised(normal_at(nodes, xi));
    if (n[2] < 0) n = -n;
    constexpr Vec<3> lamp{{-0.41, -0.51, 0.756}};  // y is down, so this lamp is above
    const double direct = dot(n, lamp), above = 0.5 - 0.5 * n[1];
    return 0.52 + 0.08 * above + 0.45 * (direct > 0 ? direct : 0);
}

/// Bézier control point of a quadratic edge from a to b; `middle`: its mid node.
[[nodiscard]] constexpr Vec<3> control_point(const Vec<3>& a, const Vec<3>& b, const Vec<3>& middle) {
    return 2.0 * middle - 0.5 * (a + b);
}
[[nodiscard]] constexpr Vec<3> control_point(const DrawnFace& patch, std::size_t edge) {
    return control_point(patch.nodes[edge], patch.nodes[(edge + 1) % 3], patch.nodes[3 + edge]);
}

/// Box of the control points, which contains the curved face.
[[nodiscard]] constexpr Box<3> box_of(const DrawnFace& patch) {
    Box<3> box;
    for (std::size_t i = 0; i < 3; ++i) {
        box.include(patch.nodes[i]);
        box.include(control_point(patch, i));
    }
    return box;
}

// Content of a picture on paper, for any output format.

enum class Edges : std::uint8_t { shown, hidden };

struct Pointer {
    Vec<3> at;  ///< position in space, with z = 0 for a 2D mesh
    std::string text;
};

struct PictureOptions {
    std::size_t width = 1200, height = 900;  ///< size of the picture in pixels
    Background background = Background::light;
    Edges edges = Edges::shown;
    Colouring colouring = OneColour{};
    std::string title = {};
    View view = {};
    /// Centre and half width of the visible box (model units); none: the whole mesh is visible. The drawing is clipped
    /// to this box.
    struct Zoom {
        Vec<3> centre;
        double radius;
    };
    std::optional<Zoom> zoom = {};
    std::vector<Pointer> pointers = {};

    [[nodiscard]] bool has_legend() const { return !std::holds_alternative<OneColour>(colouring); }
};

/// Line width in pixels. It is proportional to the picture's size, but at least `least` and at most 4.
[[nodiscard]] inline double line_width(const PictureOptions& options, double least) {
    return std::clamp(static_cast<double>(std::min(options.width, options.height)) / 800, least, 4.0);
}
/// Opacity of the lines of a triangle with the given height, where `height` and `width` (of the lines) are in pixels.
/// It is at most `most`. Narrow triangles get paler lines, so that thin layers are not black.
[[nodiscard]] inline double line_opacity(double height, double width, double most) {
    return std::clamp(height / (7 * width), 0.1, most);
}

enum class VisibleSides : std::uint8_t {
    outer,  ///< for solids: faces turned away from the viewer are hidden
    both,   ///< for surfaces and 2D meshes
};
enum class Lighting : std::uint8_t { flat, lit };

struct Scene {
    PictureOptions options;
    PaperProjection projection;
    VisibleSides sides = VisibleSides::both;
    Lighting lighting = Lighting::flat;
    Buffer<DrawnFace> patches;
    std::optional<PaperFrame> clip = {};  ///< frame to which the drawing is clipped, if any
};

using FaceValues = std::function<std::array<float, 6>(const Face&)>;

/// Projects the faces so that they fit into the picture. `marked`: ascending numbers of highlighted elements. Errors:
/// input (nothing to draw), stopped.
template <int D>
[[nodiscard]] Outcome<Scene> make_scene(const Mesh<D>& mesh, std::span<const Face> faces, const FaceValues& values,
                                        std::span<const std::uint32_t> marked, PictureOptions options,
                                        const Execution& execution);

// Legend and pointers, in pixels, with y down.

enum class Anchor { start, middle, end };
struct TextMark {
    double x = 0, y = 0, size = 0;  ///< position of the anchor, on the base line; text height from the descender to the
                                    ///< top of capital letters
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

[[nodiscard]] double legend_width(const PictureOptions& options);

/// Marks of the legend; for each pointer a ring and its text.
[[nodiscard]] std::vector<PictureMark> marks_of(const Scene& scene);

[[nodiscard]] std::string short_number(double value);

/// Rows from the top. Four bytes per pixel: red, green, blue, opacity; not premultiplied.
struct Image {
    std::size_t width = 0, height = 0;
    Buffer<std::uint8_t> bytes;
    friend bool operator==(const Image&, const Image&) = default;
};

/// Draws the scene without legend and pointers. Curves are exact to 1/20 pixel. The image does not depend on the number
/// of threads. Errors: stopped, memory.
[[nodiscard]] Outcome<Image> rasterised(const Scene& scene, const Execution& execution);

/// Ascending numbers of the faces of which a part is visible.
[[nodiscard]] Outcome<Buffer<std::uint32_t>> visible_faces(const Scene& scene, const Execution& execution);

/// Draws the marks on the image. Their text is in lower case, in a stroke font.
[[nodiscard]] Image with_marks(Image image, const std::vector<PictureMark>& marks);

/// Encodes a PNG file. Errors: memory.
[[nodiscard]] Outcome<Buffer<std::byte>> png(const Image& image);

/// Encodes the scene and its marks as SVG, with exact quadratic Bézier curves. Hidden faces are omitted. If a face is
/// partly hidden, the nearer face is drawn over it. Errors: stopped, memory.
[[nodiscard]] Outcome<std::string> svg_of(const Scene& scene, const Execution& execution);

}  // namespace camber
