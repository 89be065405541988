// Options and generators of boxes, channels with a bump, and shells. Generators by rows, and estimates of numbers of
// elements.
module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <tuple>
#include <vector>
export module camber.shapes:box;
import camber.core;
import :delaunay;

export namespace camber {

/// Layers on a wall. Their heights, beginning at the wall, are first_height, first_height × growth, ….
struct BoundaryLayer {
    int count = 0;
    double first_height = 0.02;  ///< height of the layer at the wall (model units)
    double growth = 1.25;        ///< height of a layer divided by that of the layer below it
    Reference material = 1;      ///< material of the layers; all other elements have material 1
    Reference interface = 9;     ///< reference of the facets between the layers and another material

    [[nodiscard]] static constexpr auto options() {
        using S = BoundaryLayer;
        return std::tuple(
            option("count", &S::count, "number of layers; 0 for none").at_least(0).at_most(1000),
            option("first_height", &S::first_height, "height of the layer at the wall").unit("model units").above(0),
            option("growth", &S::growth, "ratio of the height of a layer to that of the next layer towards the wall")
                .above(0),
            option("material", &S::material, "reference of the elements in the layers; the other elements have 1"),
            option("interface", &S::interface,
                   "reference of the facets between the layers and the other elements, if their materials differ"));
    }
    friend bool operator==(const BoundaryLayer&, const BoundaryLayer&) = default;
};

/// For each layer, the distance of its outer side from the wall, ascending.
[[nodiscard]] inline std::vector<double> layer_distances(const BoundaryLayer& layer) {
    std::vector<double> distances;
    double height = layer.first_height, total = 0;
    for (int k = 0; k < layer.count; ++k, height *= layer.growth) distances.push_back(total += height);
    return distances;
}

[[nodiscard]] inline double thickness(const BoundaryLayer& layer) {
    return layer.count > 0 ? layer_distances(layer).back() : 0.0;
}

/// A rectangle or box. Cells of a graded lattice are cut along random diagonals, and warped by a map that preserves the
/// sides. The facet reference is 2i + 1 on the side of low x_i, and 2i + 2 on the side of high x_i.
template <int D>
struct BoxOptions {
    Vec<D> low{};
    Vec<D> high = [] {
        Vec<D> one;
        for (double& x : one.c) x = 1;
        return one;
    }();
    std::array<int, D> cells = [] {
        std::array<int, D> four{};
        for (int& n : four) n = 4;
        return four;
    }();
    std::array<double, D> grading = [] {
        std::array<double, D> even{};
        for (double& ratio : even) ratio = 1;
        return even;
    }();  ///< for each axis: length of the last cell divided by that of the first (geometric series)
    double warp = 0;         ///< x_i moves by warp (high_i − low_i) ∏_j sin(2π u_j); u: position in the unit box
    double jitter = 0.2;     ///< maximum random move along each axis, in cell sizes; sides stay plane
    std::uint64_t seed = 1;  ///< seed of random diagonals and jitter

    [[nodiscard]] static constexpr auto options() {
        using S = BoxOptions;
        return std::tuple(
            option("low", &S::low, "corner with the smallest coordinates").unit("model units"),
            option("high", &S::high, "corner with the largest coordinates").unit("model units"),
            option("cells", &S::cells, "number of cells along each axis").at_least(1),
            option("grading", &S::grading,
                   "ratio of the last cell length to the first along each axis; the lengths form a geometric series")
                .at_least(1e-6)
                .at_most(1e6),
            option("warp", &S::warp,
                   "bends inner edges: each coordinate moves by this times the product, over all axes, of a sine with "
                   "one period in the box")
                .unit("lengths of the box along its axis")
                .at_least(-0.05)
                .at_most(0.05),
            option("jitter", &S::jitter, "largest random displacement of a vertex along each axis")
                .unit("cell sizes")
                .at_least(0)
                .at_most(0.5),
            option("seed", &S::seed, "seed of the random numbers; equal seeds give identical meshes"));
    }
    friend bool operator==(const BoxOptions&, const BoxOptions&) = default;
};

/// Errors: usage (no cells, high not above low); stopped.
template <int D>
[[nodiscard]] Outcome<LinearMesh<D>> generate(const BoxOptions<D>& options, const Execution& execution = {});

/// Lattice of a box of n_x × n_y × n_z cells. Vertex (i, j, k) has the number i + (n_x + 1) (j + (n_y + 1) k).
template <int D>
struct Lattice {
    std::array<int, D> cells{};
    Buffer<Vec<D>> points;
    Buffer<SimplexVertices<D>> elements;

    /// Indices of a vertex along the axes.
    [[nodiscard]] std::array<int, D> place(std::size_t vertex) const {
        std::array<int, D> at{};
        for (int i = 0; i < D; ++i) {
            at[i] = static_cast<int>(vertex % (cells[i] + 1));
            vertex /= cells[i] + 1;
        }
        return at;
    }
    [[nodiscard]] bool on_boundary(std::size_t vertex) const {
        const auto at = place(vertex);
        for (int i = 0; i < D; ++i)
            if (at[i] == 0 || at[i] == cells[i]) return true;
        return false;
    }
    /// Facet reference as in BoxOptions; 0 if the facet is not on a side.
    [[nodiscard]] Reference side(const SimplexVertices<D - 1>& facet) const {
        for (int i = 0; i < D; ++i)
            for (const int end : {0, cells[i]}) {
                bool all = true;
                for (const VertexId v : facet) all = all && place(v.index())[i] == end;
                if (all) return 2 * i + (end == 0 ? 1 : 2);
            }
        return 0;
    }
};

/// Lattice of the unit box with equal cells. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Lattice<D>> lattice_of(const std::array<int, D>& cells, std::uint64_t seed,
                                             const Execution& execution);

/// A 2D channel [0, length] × [0, height] with a bump on the floor: b(x) = bump_height (1 − s²)³ for |s| < 1, with s =
/// 2 (x − length/2)/bump_width. The bump is C² at its ends. Facet references: 1 inlet (x = 0), 2 outlet, 3 floor, 4
/// ceiling. The mesh has four corners.
struct BumpOptions {
    double length = 3, height = 1;             ///< in model units
    double bump_height = 0.2, bump_width = 1;  ///< size of the bump at the middle of the floor (model units)
    std::array<int, 2> cells{36, 8};           ///< number of cells along the channel, and of rows above the layers
    BoundaryLayer floor_layer{.count = 0, .first_height = 0.01, .growth = 1.3};
    double jitter = 0.2;  ///< maximum random move of inner vertices along each axis, in cell sizes
    std::uint64_t seed = 1;

    [[nodiscard]] static constexpr auto options() {
        using S = BumpOptions;
        return std::tuple(
            option("length", &S::length, "length of the channel").unit("model units").above(0),
            option("height", &S::height, "height of the channel").unit("model units").above(0),
            option("bump_height", &S::bump_height, "height of the bump at its middle; negative: a dent")
                .unit("model units"),
            option("bump_width", &S::bump_width, "width of the bump at its foot").unit("model units").above(0),
            option("cells", &S::cells, "number of cells along the channel, and across it above the layers").at_least(1),
            option("floor_layer", &S::floor_layer, "boundary layers on the floor"),
            option("jitter", &S::jitter, "largest random displacement of a vertex along each axis")
                .unit("cell sizes")
                .at_least(0)
                .at_most(0.5),
            option("seed", &S::seed, "seed of the random numbers; equal seeds give identical meshes"));
    }
    friend bool operator==(const BumpOptions&, const BumpOptions&) = default;
};

[[nodiscard]] double floor_height(const BumpOptions& options, double x);

/// Errors: usage (incompatible sizes); stopped.
[[nodiscard]] Outcome<LinearMesh<2>> generate(const BumpOptions& options, const Execution& execution = {});

enum class ShellStructure : std::uint8_t {
    unstructured,  ///< Delaunay mesh of points on spheres; points move until no element is flat
    prisms,        ///< rows of prisms over an icosphere, cut along random diagonals; faster
};
[[nodiscard]] constexpr auto words(ShellStructure) {
    return words_of(Word{ShellStructure::unstructured, "unstructured"}, Word{ShellStructure::prisms, "prisms"});
}

/// Volume between concentric spheres (2D: circles), with optional layers on both. `inner_size` and `outer_size` are
/// edge lengths at the tops of the layers.
template <int D>
struct ShellOptions {
    Vec<D> centre{};
    double inner_radius = 1, outer_radius = 5;  ///< in model units
    double inner_size = 0.6, outer_size = 1.8;  ///< edge lengths at the spheres (model units), linear between them
    BoundaryLayer inner_layer{}, outer_layer{};
    ShellStructure structure = ShellStructure::unstructured;
    double jitter = 0.15;  ///< maximum random move of a point, in edge lengths
    Reference inner_reference = 2, outer_reference = 1;
    std::uint64_t seed = 1;

    [[nodiscard]] static constexpr auto options() {
        using S = ShellOptions;
        return std::tuple(
            option("centre", &S::centre, (D == 3 ? "centre of both spheres" : "centre of both circles"))
                .unit("model units"),
            option("inner_radius", &S::inner_radius,
                   (D == 3 ? "radius of the inner sphere" : "radius of the inner circle"))
                .unit("model units")
                .above(0),
            option("outer_radius", &S::outer_radius,
                   (D == 3 ? "radius of the outer sphere" : "radius of the outer circle"))
                .unit("model units")
                .above(0),
            option("inner_size", &S::inner_size,
                   (D == 3 ? "edge length at the inner sphere (above its layers)"
                           : "edge length at the inner circle (above its layers)"))
                .unit("model units")
                .above(0),
            option("outer_size", &S::outer_size,
                   (D == 3 ? "edge length at the outer sphere (below its layers); prisms ignore it"
                           : "edge length at the outer circle (below its layers); prisms ignore it"))
                .unit("model units")
                .above(0),
            option("inner_layer", &S::inner_layer,
                   (D == 3 ? "boundary layers on the inner sphere" : "boundary layers on the inner circle")),
            option("outer_layer", &S::outer_layer,
                   (D == 3 ? "boundary layers on the outer sphere" : "boundary layers on the outer circle")),
            option("structure", &S::structure,
                   "unstructured: Delaunay mesh of scattered points; prisms: rows of prisms divided along random "
                   "diagonals, fast at any size"),
            option("jitter", &S::jitter, "largest random displacement of a point")
                .unit("edge lengths")
                .at_least(0)
                .at_most(0.3),
            option("inner_reference", &S::inner_reference,
                   (D == 3 ? "reference of the inner sphere" : "reference of the inner circle")),
            option("outer_reference", &S::outer_reference,
                   (D == 3 ? "reference of the outer sphere" : "reference of the outer circle")),
            option("seed", &S::seed, "seed of the random numbers; equal seeds give identical meshes"));
    }
    friend bool operator==(const ShellOptions&, const ShellOptions&) = default;
};

/// Boundary vertices are on the spheres up to rounding. Errors: usage (incompatible sizes); stopped.
template <int D>
[[nodiscard]] Outcome<LinearMesh<D>> generate(const ShellOptions<D>& options, const Execution& execution = {});

/// Position of a vertex: on a sphere, on top of the layers of a sphere, or elsewhere.
enum class ShellSide : std::uint8_t { between, inner, outer, above_inner_layer, above_outer_layer };

/// A shell without layers, centred at the origin.
template <int D>
struct ShellCore {
    Buffer<Vec<D>> points;
    Buffer<ShellSide> sides;
    Buffer<SimplexVertices<D>> elements;
    Buffer<SimplexVertices<D - 1>> inner, outer;  ///< the edges of a facet and the outward direction are positively
                                                  ///< oriented
};

/// Edge lengths between two spheres; they are linear in the radius.
struct ShellSizes {
    double inner_radius, outer_radius, inner_size, outer_size, jitter;

    [[nodiscard]] double at(double radius) const {
        return inner_size + (outer_size - inner_size) * (radius - inner_radius) / (outer_radius - inner_radius);
    }
};

template <int D>
[[nodiscard]] ShellSizes core_sizes(const ShellOptions<D>& o) {
    return {o.inner_radius + thickness(o.inner_layer), o.outer_radius - thickness(o.outer_layer), o.inner_size,
            o.outer_size, o.jitter};
}

/// Spreads and triangulates points between two spheres, and moves the vertices of flat elements. An additional vertex
/// in the centre is removed with its elements, which fill the hole. Errors: usage (edges too long for the gap between
/// the spheres); stopped.
template <int D>
[[nodiscard]] Outcome<ShellCore<D>> unstructured_core(const ShellSizes& sizes, const Noise& noise,
                                                      const Execution& execution);

/// Numbers of prisms for the edge length `inner_size`. `cuts`: number of parts into which an icosphere edge (2D: a
/// fifth of the circle) is divided; `rows`: number of rows.
struct PrismCounts {
    double cuts, rows;
};
template <int D>
[[nodiscard]] PrismCounts prism_counts(const ShellSizes& sizes);

/// Rows of prisms over an icosphere. Memory for `layers` more rows is reserved. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<ShellCore<D>> prism_core(const ShellSizes& sizes, int layers, const Noise& noise,
                                               const Execution& execution);

/// Quality of a simplex: 1 if regular, 0 if flat, negative if inverted.
[[nodiscard]] double quality(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c);
[[nodiscard]] double quality(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& d);

struct ShapeCounts {
    std::size_t vertices = 0, elements = 0, facets = 0, edges = 0;
};

/// Mesh of consecutive rows of a shape; numbers are those of the whole mesh.
template <int D>
struct ShapeRun {
    std::size_t first_vertex = 0, first_element = 0, first_facet = 0;
    Buffer<Vec<D>> points = {};
    Buffer<Reference> point_references = {};
    Buffer<SimplexVertices<D>> elements = {};
    Buffer<Reference> materials = {};
    Buffer<SimplexVertices<D - 1>> facets = {};
    Buffer<Reference> facet_references = {};
};

/// Rows of prisms over one base. All rows together are the mesh of `generate`.
template <int D>
class ShapeRows {
  public:
    virtual ~ShapeRows() = default;
    [[nodiscard]] virtual ShapeCounts counts() const = 0;
    [[nodiscard]] virtual std::size_t rows() const = 0;
    /// Computes rows [first, last), for which it also needs a few neighbouring rows. Errors: usage (an element without
    /// positive volume); memory, stopped.
    [[nodiscard]] virtual Outcome<ShapeRun<D>> run(std::size_t first, std::size_t last,
                                                   const Execution& execution) const = 0;
    /// Returns a mesh that has only corners, feature edges and ridges.
    [[nodiscard]] virtual Outcome<LinearMesh<D>> lists() const = 0;

  protected:
    ShapeRows() = default;
    ShapeRows(const ShapeRows&) = default;
    ShapeRows(ShapeRows&&) = default;
    ShapeRows& operator=(const ShapeRows&) = default;
    ShapeRows& operator=(ShapeRows&&) = default;
};

/// Returns the rows of a shape. Errors: those of `generate`; unsupported (unstructured shells).
template <int D>
[[nodiscard]] Outcome<std::unique_ptr<const ShapeRows<D>>> rows_of_shape(const BoxOptions<D>& options,
                                                                         const Execution& execution = {});
template <int D>
[[nodiscard]] Outcome<std::unique_ptr<const ShapeRows<D>>> rows_of_shape(const ShellOptions<D>& options,
                                                                         const Execution& execution = {});

/// Number of elements for valid options. It is exact for boxes, channels and prism shells, and within a few per cent
/// for unstructured shells.
template <int D>
[[nodiscard]] double expected_elements(const ShellOptions<D>& options);
template <int D>
[[nodiscard]] double expected_elements(const BoxOptions<D>& options);
[[nodiscard]] double expected_elements(const BumpOptions& options);

/// Scales edge lengths or numbers of cells so that the mesh has about `count` elements (at least 1). Layers do not
/// change.
template <int D>
[[nodiscard]] ShellOptions<D> with_elements(ShellOptions<D> options, double count);
template <int D>
[[nodiscard]] BoxOptions<D> with_elements(BoxOptions<D> options, double count);
[[nodiscard]] BumpOptions with_elements(BumpOptions options, double count);

}  // namespace camber
