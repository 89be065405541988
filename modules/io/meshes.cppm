module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
/// Values of files: decoded meshes, fields, options, notices, arrays in memory.
export module camber.io:meshes;
import camber.core;
import camber.bezier;

export namespace camber {

/// A difference between a file and its decoded value: one sentence without a full stop.
struct Notice {
    std::string what;
    bool is_detail = false;  ///< for --verbose: no name and no field is lost
    friend bool operator==(const Notice&, const Notice&) = default;
};

/// A file: the concatenation of the chunks.
using Chunks = std::vector<Buffer<std::byte>>;

/// Policy for cells that are not simplices of degree 1 or 2; `refuse` is an error.
enum class Unheld : std::uint8_t {
    refuse,
    count,  ///< skip and count in `DecodedMesh::unheld`
};

/// Options for reading; each format uses those that apply to it.
struct DecodeOptions {
    /// Cell array with the references (VTU, VTK); empty: the first with a known name.
    std::string reference_array = {};
    /// Zone to read (SU2: number, CGNS: name or number); empty: all, joined into one mesh.
    std::string zone = {};
    Unheld unheld = Unheld::refuse;
    /// Reads a file relative to the mesh's folder (PVTU); null if unavailable.
    std::function<Outcome<Buffer<std::byte>>(const std::string& path)> beside = {};
};

struct CellCount {
    std::string kind;
    std::size_t count = 0;
    friend bool operator==(const CellCount&, const CellCount&) = default;
};

/// With the numbers of GMF files.
enum class FieldKind { scalar = 1, vector = 2, symmetric_tensor = 3, full_tensor = 4 };

/// In 2 or 3 dimensions.
[[nodiscard]] constexpr int values_per_vertex(FieldKind kind, int dimension) {
    switch (kind) {
        case FieldKind::scalar: return 1;
        case FieldKind::vector: return dimension;
        case FieldKind::symmetric_tensor: return dimension * (dimension + 1) / 2;
        case FieldKind::full_tensor: return dimension * dimension;
    }
    return 0;
}

struct Solution {
    int dimension = 3;
    std::vector<FieldKind> fields = {};
    std::size_t rows = 0;
    Column<double> values = {};     ///< by row, then by field; symmetric tensors as in `Sym`
    bool single_precision = false;  ///< the file had 4-byte reals (version 1); encoders write 8 bytes

    friend bool operator==(const Solution&, const Solution&) = default;
};

[[nodiscard]] inline std::size_t row_width(const Solution& solution) {
    int width = 0;
    for (const FieldKind kind : solution.fields) width += values_per_vertex(kind, solution.dimension);
    return static_cast<std::size_t>(width);
}

struct DecodedSolution {
    Solution solution;
    std::vector<Notice> notices;
};

enum class Centring : std::uint8_t {
    node,  ///< vertices, then (degree 2) each edge's node in the order of the edge set
    cell,  ///< elements, then facets, then feature edges
};

/// Values by row.
using FieldValues = std::variant<Column<double>, Column<std::int32_t>>;

/// Symmetric tensors are in the order of `Sym`, full tensors row by row.
struct MeshField {
    std::string name;
    Centring centring = Centring::node;
    FieldKind kind = FieldKind::scalar;
    FieldValues values;

    [[nodiscard]] std::size_t size() const {
        return std::visit([](const auto& column) { return column.size(); }, values);
    }
    friend bool operator==(const MeshField&, const MeshField&) = default;
};

/// Immutable; names are unique for each centring.
class MeshFields {
  public:
    MeshFields() = default;
    /// Same as `with` for each field, in the time of a sort.
    explicit MeshFields(std::vector<MeshField> fields);

    /// Adds a field or replaces the one of the same name and centring.
    [[nodiscard]] MeshFields with(MeshField field) && {
        for (MeshField& old : fields_)
            if (old.name == field.name && old.centring == field.centring) {
                old = std::move(field);
                return std::move(*this);
            }
        fields_.push_back(std::move(field));
        return std::move(*this);
    }
    [[nodiscard]] MeshFields with(MeshField field) const& { return MeshFields(*this).with(std::move(field)); }

    [[nodiscard]] const MeshField* find(std::string_view name, Centring centring) const {
        for (const MeshField& field : fields_)
            if (field.name == name && field.centring == centring) return &field;
        return nullptr;
    }
    [[nodiscard]] auto begin() const { return fields_.begin(); }
    [[nodiscard]] auto end() const { return fields_.end(); }
    [[nodiscard]] std::size_t size() const { return fields_.size(); }
    [[nodiscard]] bool empty() const { return fields_.empty(); }
    friend bool operator==(const MeshFields&, const MeshFields&) = default;

  private:
    std::vector<MeshField> fields_;
};

/// Fields at nodes as a solution at the first `vertices` nodes, for files beside a mesh of that dimension; others and
/// edge nodes are dropped. Errors: usage (no field at nodes).
[[nodiscard]] Outcome<Solution> solution_of(const MeshFields& fields, int dimension, std::size_t vertices,
                                            const Execution& execution);

/// Surface meshes in space are 3D meshes without elements.
using AnyMesh = std::variant<Mesh<2>, Mesh<3>>;

/// M is LinearMesh<D> or QuadraticMesh<D>; columns are shared. Errors: unsupported (another dimension or degree, or not
/// simplices).
template <class M>
[[nodiscard]] Outcome<M> mesh_as(AnyMesh mesh) {
    constexpr int dimension = M::dimension;
    auto* const same = std::get_if<Mesh<dimension>>(&mesh);
    if (!same)
        return fail(ErrorKind::unsupported, "is a mesh in " + std::to_string(5 - dimension) +
                                                "D, but this operation needs one in " + std::to_string(dimension) +
                                                "D");
    if constexpr (std::is_same_v<M, LinearMesh<dimension>>)
        return as_linear(std::move(*same));
    else
        return as_quadratic(std::move(*same));
}

/// Data of a flat mesh in space that its 2D form cannot hold: see `flattened` and `raised`.
struct Lift {
    double z = 0;                 ///< of all used nodes (model units)
    Column<double> heights = {};  ///< of vertices, if unused ones differ from z; else empty
    /// Each is empty unless a direction leaves the plane.
    DirectionsAtVertices<3> normals = {}, tangents = {};
    friend bool operator==(const Lift&, const Lift&) = default;
};

/// Explicit numbers (Gmsh tags); empty where they are 1, 2, 3 …
struct FileTags {
    Column<std::uint64_t> vertices;
    std::array<Column<std::uint64_t>, 4> simplices = {};  ///< of edges, triangles and tetrahedra, by dimension
};

/// Reference of the edge's ends if both agree, else 0.
[[nodiscard]] constexpr Reference mid_node_reference(Reference a, Reference b) { return a == b ? a : 0; }

struct DecodedMesh {
    AnyMesh mesh;
    std::vector<Notice> notices;
    /// Quadratic meshes: file number (from 1) of each vertex, then of each edge's node (0: none), for messages; empty
    /// where they are 1, 2, 3 …
    Column<std::uint32_t> node_numbers = {};
    std::optional<Lift> lift = {};  ///< for a flat mesh now in 2D
    MeshFields fields = {};         ///< if the mesh file has fields
    /// The format has only meshes in space: a flat one is a 2D mesh, not a surface.
    bool always_in_space = false;
    std::vector<CellCount> unheld = {};  ///< cells skipped with Unheld::count
    FileTags tags = {};
    std::string_view format = {};  ///< name in `mesh_formats()`
};

// Meshes as arrays in memory: coordinates, and nodes of cells in VTK's order.

/// K-simplices of one degree; nodes count from 0.
template <int Nodes>
struct CellArray {
    Column<std::array<VertexId, Nodes>> nodes = {};
    Column<Reference> references = {};  ///< one a cell; empty: all 0
};
template <int K>
struct CellArrays {
    CellArray<K + 1> straight = {};
    CellArray<quadratic_nodes<K>> curved = {};  ///< mid nodes in the order of `local_edges`

    [[nodiscard]] std::size_t size() const { return straight.nodes.size() + curved.nodes.size(); }
};

template <int D>
struct MeshArrays {
    Column<Vec<D>> points;
    Column<Reference> point_references = {};  ///< one a point; empty: all 0
    CellArrays<D> elements = {};
    CellArrays<D - 1> facets = {};
    CellArrays<1> edges = {};
    std::vector<Group> groups = {};
};

/// `coordinates`: D for each point. Shares the array if `owner` keeps it alive and unchanged (see Column); without an
/// owner it copies.
template <int D>
[[nodiscard]] Column<Vec<D>> points_of(std::span<const double> coordinates, std::shared_ptr<const void> owner);

/// Degree 1 shares the columns; for degree 2 vertices come first, in their order (see DecodedMesh::node_numbers). Flat
/// meshes stay in space: see `with_flat_in_2d`. Errors: input (a coordinate that is not finite, a cell with an invalid
/// or repeated node, contradictory mid nodes).
template <int D>
[[nodiscard]] Outcome<DecodedMesh> mesh_of_arrays(MeshArrays<D> arrays, const Execution& execution);

/// Nodes of quadratic simplices in VTK's order: vertices, then n + edge number; n is the number of vertices.
template <int K>
[[nodiscard]] Buffer<std::array<VertexId, quadratic_nodes<K>>> nodes_of_cells(
    const Column<SimplexVertices<K>>& vertices, const Column<std::array<EdgeId, edges_per_simplex<K>>>& edges,
    std::size_t n);

// Flat meshes: faces only, in one plane z = constant. Programs whose file format is always 3D write 2D meshes so.
// Errors of the functions: memory, stopped, unsupported (nodes inside faces).

struct Flattened {
    Mesh<2> mesh;
    Lift lift;
};

/// Converts a mesh that has faces, no elements, and exactly the same z for all points of faces and edges; none for
/// others. Faces become elements and edges facets, which ridges refer to; orders and orientations stay.
[[nodiscard]] Outcome<std::optional<Flattened>> flattened(const Mesh<3>& mesh, const Execution& execution);

/// `mesh`: flattened, or modified with the same number of vertices.
[[nodiscard]] Outcome<Mesh<3>> raised(const Mesh<2>& mesh, const Lift& lift, const Execution& execution);
/// Meshes in space are returned unchanged.
[[nodiscard]] Outcome<AnyMesh> raised(const AnyMesh& mesh, const Lift& lift, const Execution& execution);

/// Vectors and tensors get zeros for z.
[[nodiscard]] Outcome<MeshFields> raised(const MeshFields& fields, const Execution& execution);

/// Drops z components.
[[nodiscard]] Outcome<MeshFields> flattened(const MeshFields& fields, const Execution& execution);

/// True for z components of a row in space.
[[nodiscard]] std::vector<bool> involves_z(FieldKind kind);

/// Converts a flat mesh and stores its lift; others stay, with a notice if z differs by rounding only.
[[nodiscard]] Outcome<DecodedMesh> with_flat_in_2d(DecodedMesh decoded, const Execution& execution);

/// Projects a solution to the plane: vectors without z, the upper left 2 × 2 of tensors (for a metric, lengths in the
/// plane stay the same). One in 2D is returned unchanged.
[[nodiscard]] Outcome<Solution> flattened(Solution solution, const Execution& execution);

}  // namespace camber
