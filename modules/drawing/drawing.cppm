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
/// Pictures of meshes: what of a mesh is to be seen, with its curves, on paper; as pixels or as an SVG file. No display
/// and no graphics processor is needed.
export module camber.drawing;
import camber.core;

/// What colours stand for.
export namespace camber {

/// Parts of red, green and blue from 0 to 1, as screens take them (sRGB).
struct Colour {
    double red = 0, green = 0, blue = 0;
    friend bool operator==(const Colour&, const Colour&) = default;
};
/// (1 − t) a + t b.
[[nodiscard]] constexpr Colour blend(const Colour& a, const Colour& b, double t) {
    return {a.red + t * (b.red - a.red), a.green + t * (b.green - a.green), a.blue + t * (b.blue - a.blue)};
}
[[nodiscard]] constexpr Colour scaled(const Colour& c, double factor) {
    return {c.red * factor, c.green * factor, c.blue * factor};
}
/// "#3f86a6".
[[nodiscard]] std::string hex(const Colour& colour);

enum class Background : std::uint8_t { light, dark, transparent };
constexpr auto words(Background) {
    return words_of(Word{Background::light, "light"}, Word{Background::dark, "dark"},
                    Word{Background::transparent, "transparent"});
}

/// The colours of everything but the values.
struct Theme {
    Colour paper, ink, line, plain, missing, accent;
};
[[nodiscard]] Theme theme_of(Background background);

/// Which end of a range is good: a number may be neither.
enum class Ramp : std::uint8_t { plain, good_is_high };
enum class Spacing : std::uint8_t { linear, logarithmic };

/// A range of numbers; those beyond have the colour of its end.
struct ColourRange {
    double low = 0, high = 1;
    Ramp ramp = Ramp::plain;
    Spacing spacing = Spacing::linear;
    /// Where a value lies between the ends, from 0 to 1.
    [[nodiscard]] double place_of(double value) const;
    [[nodiscard]] double value_at(double place) const;
};
/// Kinds without an order, each with a number; their values are 0, 1, 2 …, by their places here.
struct ColourKinds {
    std::vector<Reference> numbers;
    std::vector<std::string> names = {};       ///< one per number, empty if it has none; no entries: none has a name
    std::vector<std::uint8_t> is_listed = {};  ///< one per number, 0 if the legend omits it; no entries: all are listed
};
struct OneColour {};
using Colouring = std::variant<OneColour, ColourRange, ColourKinds>;

/// The colour of a value; that of what is missing where it is not finite, or none of the kinds.
[[nodiscard]] Colour colour_of(const Colouring& colouring, double value, const Theme& theme);
/// The colour at a place of a ramp, from 0 to 1.
[[nodiscard]] Colour colour_at(Ramp ramp, double place);
/// The colour of the i-th kind.
[[nodiscard]] Colour colour_of_kind(std::size_t i);

// What of a mesh is to be seen: faces with all their nodes, and their edges.

/// A node by its number from 0: the vertices, then the nodes of the edge set's edges.
using NodeNumber = std::uint32_t;

/// How a face comes to be seen.
enum class FaceKind : std::uint8_t {
    boundary,   ///< no element behind it; of a surface alone all
    uncovered,  ///< the element behind it is left out
    plane,      ///< an element of a 2D mesh, itself
    facet,      ///< a listed facet of a shown group, whatever is behind it
};

/// A triangle of degree 2. In 3D its corners turn counter-clockwise seen from outside of its element; in 2D they are
/// the element's own.
struct Face {
    std::array<NodeNumber, 6> nodes{};  ///< corners, then those of the edges 01, 12, 20
    std::uint32_t element = 0;          ///< of which it is seen; of a surface alone the number of the facet
    Reference reference = 0;            ///< of the facet that stands there (0: none is listed), else of the element
    FaceKind kind = FaceKind::boundary;
    friend bool operator==(const Face&, const Face&) = default;
};

/// An edge of faces.
struct FaceEdge {
    std::array<NodeNumber, 3> nodes{};  ///< both ends, then the middle
    std::uint32_t faces = 0;            ///< how many faces have it; 1: a rim
    friend bool operator==(const FaceEdge&, const FaceEdge&) = default;
};

/// What lies beyond a plane, dot(normal, x) > offset, is cut away.
template <int D>
struct Cut {
    Vec<D> normal{};
    double offset = 0;
};

/// A number an element (of a surface alone: a facet): 1 where it stays, since its centroid, that of its vertices, does
/// not lie beyond the plane; else 0. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Column<std::uint8_t>> kept_by(const Cut<D>& cut, const Mesh<D>& mesh, const Execution& execution);

/// The faces to be seen of the elements that are kept (`kept` as `kept_by` has it; empty: all), by rising element: in
/// 3D faces with one kept element on them, in 2D the elements, of a surface alone its facets. Errors: unsupported (no
/// simplices of degree 2: a mesh of degree 1 is elevated first), stopped.
template <int D>
[[nodiscard]] Outcome<Column<Face>> faces_to_draw(const Mesh<D>& mesh, std::span<const std::uint8_t> kept,
                                                  const Execution& execution);

/// Groups that a picture of tetrahedra is limited to.
struct DrawnGroups {
    std::span<const std::uint8_t> bodies = {};  ///< one per element, 1 if all its faces are drawn; empty: 1 for all
    std::vector<Reference> shown = {};          ///< rising, of facets that are drawn on other elements too
    std::vector<Reference> hidden = {};         ///< rising, of facets that are not drawn
};

/// The faces as above, limited to groups. Of kept elements that are no bodies it draws the facets of shown groups only.
/// A face of the boundary that is not listed as a facet has the reference 0. Errors: as above.
[[nodiscard]] Outcome<Column<Face>> faces_to_draw(const Mesh<3>& mesh, std::span<const std::uint8_t> kept,
                                                  const DrawnGroups& groups, const Execution& execution);

/// The edges of the faces, each once, in the order of the mesh's edge set.
template <int D>
[[nodiscard]] Column<FaceEdge> edges_to_draw(const Mesh<D>& mesh, std::span<const Face> faces);

/// Where a node is.
template <int D>
[[nodiscard]] inline Vec<D> node_point(const Mesh<D>& mesh, NodeNumber node) {
    const std::size_t vertices = mesh.points.size();
    return node < vertices ? mesh.points[node] : mesh.edge_nodes[node - vertices].point;
}

// From space onto paper, without perspective: lengths along the paper stay in proportion.

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

// A face on paper: a triangle of degree 2 again, since the projection is affine.

/// How an edge of a face is drawn.
enum class LineKind : std::uint8_t { none, shared, rim };

struct DrawnFace {
    std::array<Vec<3>, 6> nodes;      ///< on paper (pixels), as `Face` has them
    std::array<float, 6> values{};    ///< at the nodes
    std::array<LineKind, 3> lines{};  ///< of the edges 01, 12, 20
    bool is_marked = false;
    std::uint32_t face = 0;
};

using FacePoint = std::array<double, 3>;  ///< barycentric coordinates on a patch

/// Σ of the Lagrange functions of degree 2 times what is at the nodes.
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

/// The normal on paper, of no unit length, towards the side from which the corners turn counter-clockwise.
[[nodiscard]] constexpr Vec<3> normal_at(const std::array<Vec<3>, 6>& n, const FacePoint& xi) {
    std::array<Vec<3>, 3> partial{};
    for (std::size_t i = 0; i < 3; ++i) {
        partial[i] += (4 * xi[i] - 1) * n[i];
        add_edge_derivatives<2>(xi, static_cast<int>(i), n[3 + i], partial);
    }
    // y is downwards on paper: what is counter-clockwise to the viewer has a positive z so.
    return cross(partial[2] - partial[0], partial[1] - partial[0]);
}

/// How bright a place is whose normal is turned to the viewer: a lamp above the viewer's left shoulder, and the room.
[[nodiscard]] inline double brightness(const std::array<Vec<3>, 6>& nodes, const FacePoint& xi) {
    Vec<3> n = normalised(normal_at(nodes, xi));
    if (n[2] < 0) n = -n;
    constexpr Vec<3> lamp{{-0.41, -0.51, 0.756}};  // y is downwards
    const double direct = dot(n, lamp), above = 0.5 - 0.5 * n[1];
    return 0.52 + 0.08 * above + 0.45 * (direct > 0 ? direct : 0);
}

/// The control point of an edge's Bézier form, from its ends and the node on it.
[[nodiscard]] constexpr Vec<3> control_point(const Vec<3>& a, const Vec<3>& b, const Vec<3>& middle) {
    return 2.0 * middle - 0.5 * (a + b);
}
[[nodiscard]] constexpr Vec<3> control_point(const DrawnFace& patch, std::size_t edge) {
    return control_point(patch.nodes[edge], patch.nodes[(edge + 1) % 3], patch.nodes[3 + edge]);
}

/// The box of the control points, in which the patch lies.
[[nodiscard]] constexpr Box<3> box_of(const DrawnFace& patch) {
    Box<3> box;
    for (std::size_t i = 0; i < 3; ++i) {
        box.include(patch.nodes[i]);
        box.include(control_point(patch, i));
    }
    return box;
}

// All that a picture shows, on paper, whatever it is then made as.

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
    /// The middle and the half width of the box that is shown (model units); none: all. The picture has nothing that
    /// lies outside of the box on paper.
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
    std::optional<PaperFrame> clip = {};  ///< outside of it nothing is drawn; none: the whole paper
};

/// The values of a face at its six nodes.
using FaceValues = std::function<std::array<float, 6>(const Face&)>;

/// The faces on paper, as large as there is room. `marked`: elements to be stressed, rising. Errors: nothing to draw
/// (input), stopped.
template <int D>
[[nodiscard]] Outcome<Scene> make_scene(const Mesh<D>& mesh, std::span<const Face> faces, const FaceValues& values,
                                        std::span<const std::uint32_t> marked, PictureOptions options,
                                        const Execution& execution);

// What stands on a picture beside the mesh: the legend of the colours, and pointers. All in pixels, y downwards.

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
