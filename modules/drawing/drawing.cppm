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
/// Draws meshes with curved faces as pixel images or SVG, without a display or a graphics processor.
export module camber.drawing;
import camber.core;

export namespace camber {

/// Red, green and blue from 0 to 1 (sRGB).
struct Colour {
    double red = 0, green = 0, blue = 0;
    friend bool operator==(const Colour&, const Colour&) = default;
};
/// Returns (1 − t) a + t b.
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

/// Colours of everything that is not coloured by values.
struct Theme {
    Colour paper, ink, line, plain, missing, accent;
};
[[nodiscard]] Theme theme_of(Background background);

/// Colour scale for values: `plain` is neutral, `good_is_high` shows high values as good.
enum class Ramp : std::uint8_t { plain, good_is_high };
enum class Spacing : std::uint8_t { linear, logarithmic };

/// Interval of values with colours. Values outside get the colour of the nearest end.
struct ColourRange {
    double low = 0, high = 1;
    Ramp ramp = Ramp::plain;
    Spacing spacing = Spacing::linear;
    /// Relative position of the value between `low` and `high`, from 0 to 1.
    [[nodiscard]] double place_of(double value) const;
    [[nodiscard]] double value_at(double place) const;
};
/// Colours for unordered kinds. A field value i stands for the kind `numbers[i]`.
struct ColourKinds {
    std::vector<Reference> numbers;
    std::vector<std::string> names = {};       ///< name of each number, may be empty; or no entries at all
    std::vector<std::uint8_t> is_listed = {};  ///< for each number: 0 if it is not in the legend; no entries: all are
};
struct OneColour {};
using Colouring = std::variant<OneColour, ColourRange, ColourKinds>;

/// NaN, and values that are not a kind, get the colour of missing values. Infinite values of a range get the colour of
/// its ends.
[[nodiscard]] Colour colour_of(const Colouring& colouring, double value, const Theme& theme);
/// `place`: relative position on the scale, from 0 to 1.
[[nodiscard]] Colour colour_at(Ramp ramp, double place);
[[nodiscard]] Colour colour_of_kind(std::size_t i);

// Visible faces and edges of a mesh.

/// Node numbers from 0: first the vertices, then the edge nodes in the order of the edge set.
using NodeNumber = std::uint32_t;

enum class FaceKind : std::uint8_t {
    boundary,   ///< no element lies behind the face; also all faces of a surface mesh
    uncovered,  ///< the face became visible because an adjacent element is not drawn
    plane,      ///< the face is an element of a 2D mesh
    facet,      ///< the face is a mesh facet of a group in `DrawnGroups::shown`
};

/// A triangle to draw. In 3D its corners are counter-clockwise seen from outside the element, in 2D in the element's
/// order.
struct Face {
    std::array<NodeNumber, 6> nodes{};  ///< corners, then nodes of the edges 01, 12, 20
    std::uint32_t element = 0;          ///< element that has the face; in a surface mesh the facet number
    Reference reference = 0;            ///< that of the facet on this face (0: none listed); for uncovered faces that
                                        ///< of the element
    FaceKind kind = FaceKind::boundary;
    friend bool operator==(const Face&, const Face&) = default;
};

struct FaceEdge {
    std::array<NodeNumber, 3> nodes{};  ///< end nodes, then the mid node
    std::uint32_t faces = 0;            ///< number of adjacent faces; 1 on a border
    friend bool operator==(const FaceEdge&, const FaceEdge&) = default;
};

/// A cutting plane. Elements in the half space dot(normal, x) > offset are not drawn.
template <int D>
struct Cut {
    Vec<D> normal{};
    double offset = 0;
};

/// Returns a flag for each element (in a surface mesh: facet): 0 if the centroid of its vertices is in the removed half
/// space, else 1. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Column<std::uint8_t>> kept_by(const Cut<D>& cut, const Mesh<D>& mesh, const Execution& execution);

/// Returns the visible faces of the elements with flag 1 in `kept` (from `kept_by`; empty: all), by ascending element.
/// In 3D these are the faces of exactly one such element, in 2D the elements, in a surface mesh the facets. Errors:
/// unsupported (not simplices of degree 2: elevate the degree first), stopped.
template <int D>
[[nodiscard]] Outcome<Column<Face>> faces_to_draw(const Mesh<D>& mesh, std::span<const std::uint8_t> kept,
                                                  const Execution& execution);

struct DrawnGroups {
    std::span<const std::uint8_t> bodies = {};  ///< for each element: 1 if all its visible faces are drawn; empty: all
                                                ///< 1
    std::vector<Reference> shown = {};  ///< ascending references of facets to draw also on elements with body flag 0
    std::vector<Reference> hidden = {};         ///< ascending references of facets not to draw
};

/// Same, restricted to groups. Elements with body flag 0 show only the facets of shown groups. Boundary faces that are
/// not listed facets have reference 0. Errors: those of the function above.
[[nodiscard]] Outcome<Column<Face>> faces_to_draw(const Mesh<3>& mesh, std::span<const std::uint8_t> kept,
                                                  const DrawnGroups& groups, const Execution& execution);

/// Returns each edge of the faces once, in the order of the edge set.
template <int D>
[[nodiscard]] Column<FaceEdge> edges_to_draw(const Mesh<D>& mesh, std::span<const Face> faces);

template <int D>
[[nodiscard]] inline Vec<D> node_point(const Mesh<D>& mesh, NodeNumber node) {
    const std::size_t vertices = mesh.points.size();
    return node < vertices ? mesh.points[node] : mesh.edge_nodes[node - vertices].point;
}

// Orthographic projection from space onto paper.

/// Orthonormal axes of the viewer.
struct View {
    Vec<3> right{{1, 0, 0}}, up{{0, 1, 0}}, towards{{0, 0, 1}};  ///< `towards` points to the viewer
};

/// `from`: direction to the viewer, not 0. The z axis points up; for vertical views the y axis does.
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

/// Maps a point in space to pixels on paper: x to the right, y down, z towards the viewer.
struct PaperProjection {
    View view = {};
    double scale = 1;       ///< pixels per model unit
    double x0 = 0, y0 = 0;  ///< position of the origin of space on paper (pixels)

    [[nodiscard]] Vec<3> operator()(const Vec<3>& p) const {
        return {{x0 + scale * dot(view.right, p), y0 - scale * dot(view.up, p), scale * dot(view.towards, p)}};
    }
};

/// A rectangle in pixels.
struct PaperFrame {
    double left = 0, top = 0, width = 0, height = 0;
};

/// Fits `box` into the frame; its coordinates are along the axes `right`, `up` and `towards`.
[[nodiscard]] inline PaperProjection fitted(const View& view, const Box<3>& box, const PaperFrame& frame) {
    const double wide = box.high[0] - box.low[0], high = box.high[1] - box.low[1];
    const double scale = std::fmin(wide > 0 ? frame.width / wide : HUGE_VAL, high > 0 ? frame.height / high : HUGE_VAL);
    PaperProjection p{view, std::isfinite(scale) ? scale : 1};
    p.x0 = frame.left + frame.width / 2 - p.scale * (box.low[0] + box.high[0]) / 2;
    p.y0 = frame.top + frame.height / 2 + p.scale * (box.low[1] + box.high[1]) / 2;
    return p;
}

// The projection is affine, so a projected face is again a triangle of degree 2.

enum class LineKind : std::uint8_t { none, shared, rim };

struct DrawnFace {
    std::array<Vec<3>, 6> nodes;      ///< on paper (pixels), in the order of `Face`
    std::array<float, 6> values{};    ///< field values at the nodes
    std::array<LineKind, 3> lines{};  ///< lines along the edges 01, 12, 20
    bool is_marked = false;
    std::uint32_t face = 0;
};

using FacePoint = std::array<double, 3>;  ///< barycentric coordinates on a face

/// Lagrange interpolation of degree 2.
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
    // y is down on paper, so counter-clockwise for the viewer means positive z here.
    return cross(partial[2] - partial[0], partial[1] - partial[0]);
}

/// Sums ambient light and light from a lamp above the viewer's left shoulder. The normal is oriented towards the
/// viewer.
[[nodiscard]] inline double brightness(const std::array<Vec<3>, 6>& nodes, const FacePoint& xi) {
    Vec<3> n = normalised(normal_at(nodes, xi));
    if (n[2] < 0) n = -n;
    constexpr Vec<3> lamp{{-0.41, -0.51, 0.756}};  // its y component points down
    const double direct = dot(n, lamp), above = 0.5 - 0.5 * n[1];
    return 0.52 + 0.08 * above + 0.45 * (direct > 0 ? direct : 0);
}

/// Bézier control point of an edge from a to b; `middle`: the node on the edge.
[[nodiscard]] constexpr Vec<3> control_point(const Vec<3>& a, const Vec<3>& b, const Vec<3>& middle) {
    return 2.0 * middle - 0.5 * (a + b);
}
[[nodiscard]] constexpr Vec<3> control_point(const DrawnFace& patch, std::size_t edge) {
    return control_point(patch.nodes[edge], patch.nodes[(edge + 1) % 3], patch.nodes[3 + edge]);
}

/// Bounding box of the corners and control points, which contains the curved face.
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
    Vec<3> at;  ///< position in space; z = 0 for a 2D mesh
    std::string text;
};

struct PictureOptions {
    std::size_t width = 1200, height = 900;  ///< in pixels
    Background background = Background::light;
    Edges edges = Edges::shown;
    Colouring colouring = OneColour{};
    std::string title = {};  ///< title of the legend
    View view = {};
    /// Visible region: centre and half width of a box (model units); none: the whole mesh. The drawing is clipped to
    /// the box.
    struct Zoom {
        Vec<3> centre;
        double radius;
    };
    std::optional<Zoom> zoom = {};
    std::vector<Pointer> pointers = {};

    [[nodiscard]] bool has_legend() const { return !std::holds_alternative<OneColour>(colouring); }
};

/// Width in pixels; proportional to the picture's size, from `least` to 4.
[[nodiscard]] inline double line_width(const PictureOptions& options, double least) {
    return std::clamp(static_cast<double>(std::min(options.width, options.height)) / 800, least, 4.0);
}
/// Opacity of lines around a triangle of this height (pixels). Lines have a fixed width; those of narrow triangles are
/// paler, so that thin layers do not become black.
[[nodiscard]] inline double line_opacity(double height, double width, double most) {
    return std::clamp(height / (7 * width), 0.1, most);
}

enum class VisibleSides : std::uint8_t {
    outer,  ///< for solids: faces that face away from the viewer are hidden
    both,   ///< for surfaces and 2D meshes
};
enum class Lighting : std::uint8_t { flat, lit };

struct Scene {
    PictureOptions options;
    PaperProjection projection;
    VisibleSides sides = VisibleSides::both;
    Lighting lighting = Lighting::flat;
    Buffer<DrawnFace> patches;
    std::optional<PaperFrame> clip = {};  ///< the drawing is clipped to this frame; none: the whole paper
};

using FaceValues = std::function<std::array<float, 6>(const Face&)>;

/// Builds a scene with the faces as large as the paper allows. `marked`: ascending numbers of elements to highlight.
/// Errors: input (nothing to draw), stopped.
template <int D>
[[nodiscard]] Outcome<Scene> make_scene(const Mesh<D>& mesh, std::span<const Face> faces, const FaceValues& values,
                                        std::span<const std::uint32_t> marked, PictureOptions options,
                                        const Execution& execution);

// Legend and pointers, in pixels, with y down.

enum class Anchor { start, middle, end };
struct TextMark {
    double x = 0, y = 0, size = 0;  ///< anchor point on the base line; height of a capital letter and a descender
                                    ///< together
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

/// Returns the marks of the legend and, for each pointer, a ring with text.
[[nodiscard]] std::vector<PictureMark> marks_of(const Scene& scene);

[[nodiscard]] std::string short_number(double value);

/// Rows from top to bottom. A pixel has four bytes: red, green, blue, opacity (not premultiplied).
struct Image {
    std::size_t width = 0, height = 0;
    Buffer<std::uint8_t> bytes;
    friend bool operator==(const Image&, const Image&) = default;
};

/// Draws the scene with a depth buffer, without the legend and pointers. Curves deviate by at most 1/20 pixel. The
/// bytes do not depend on the number of threads. Errors: stopped, memory.
[[nodiscard]] Outcome<Image> rasterised(const Scene& scene, const Execution& execution);

/// Ascending numbers of faces (`DrawnFace::face`) that are at least partly visible.
[[nodiscard]] Outcome<Buffer<std::uint32_t>> visible_faces(const Scene& scene, const Execution& execution);

/// Draws the marks onto the image. Text is in lower case, in a stroke font.
[[nodiscard]] Image with_marks(Image image, const std::vector<PictureMark>& marks);

/// Encodes a PNG file. Errors: memory.
[[nodiscard]] Outcome<Buffer<std::byte>> png(const Image& image);

/// Encodes the scene and its marks as SVG, with exact quadratic Bézier curves as edges. Hidden faces are omitted;
/// nearer faces are drawn over partly hidden ones. Errors: stopped, memory.
[[nodiscard]] Outcome<std::string> svg_of(const Scene& scene, const Execution& execution);

}  // namespace camber
