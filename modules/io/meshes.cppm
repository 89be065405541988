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
export module camber.io:meshes;
import camber.core;
import camber.bezier;

export namespace camber {

/// A difference between a file and the decoded mesh: a sentence without a full stop.
struct Notice {
    std::string what;
    bool is_detail = false;  ///< only for --verbose; no name and no field is lost
    friend bool operator==(const Notice&, const Notice&) = default;
};

/// The bytes of a file, in parts.
using Chunks = std::vector<Buffer<std::byte>>;

/// Handling of cells that are not simplices of degree 1 or 2; `refuse`: an error.
enum class UnsupportedCells : std::uint8_t {
    refuse,
    count,  ///< skips and counts them in `DecodedMesh`
};

/// Options for reading; a format ignores those that do not apply to it.
struct DecodeOptions {
    /// Name of the cell array with the references (VTU, VTK); empty: the first known name.
    std::string reference_array = {};
    /// Zone to read (SU2: number, CGNS: name or number); empty: all, joined into one mesh.
    std::string zone = {};
    UnsupportedCells unsupported_cells = UnsupportedCells::refuse;
    /// Reads a file for PVTU; the path is relative to the mesh's folder. Null: unavailable.
    std::function<Outcome<Buffer<std::byte>>(const std::string& path)> beside = {};
};

struct CellCount {
    std::string kind;
    std::size_t count = 0;
    friend bool operator==(const CellCount&, const CellCount&) = default;
};

/// The values are those of GMF files.
enum class FieldKind { scalar = 1, vector = 2, symmetric_tensor = 3, full_tensor = 4 };

/// `dimension`: 2 or 3.
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
    Column<double> values = {};     ///< by row, within a row by field; symmetric tensors as in `Sym`
    bool single_precision = false;  ///< the file has 4-byte reals (version 1); encoders write 8 bytes

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
    node,  ///< one row for each vertex, then (degree 2) edge node in the order of the edge set
    cell,  ///< one row for each element, facet, feature edge
};

/// Values, row by row.
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
    /// Same result as `with` for each field, in the time of a sort.
    explicit MeshFields(std::vector<MeshField> fields);

    /// Adds a field, or replaces that with the same name and centring.
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

/// Converts node fields to a solution at the first `vertices` nodes, for a file beside a mesh of this dimension. Cell
/// fields and values at edge nodes are dropped. Errors: usage (no field at nodes).
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

/// Data of a flat mesh in space that its 2D form cannot store: see `flattened` and `raised`.
struct Lift {
    double z = 0;                 ///< of all used nodes (model units)
    Column<double> heights = {};  ///< of vertices, if those of unused ones differ; else empty
    /// Empty unless a direction leaves the plane.
    DirectionsAtVertices<3> normals = {}, tangents = {};
    friend bool operator==(const Lift&, const Lift&) = default;
};

/// Tags in the file (Gmsh); empty where they are 1, 2, 3 …
struct FileTags {
    Column<std::uint64_t> vertices;
    std::array<Column<std::uint64_t>, 4> simplices = {};  ///< tags of simplices, by dimension
};

/// Reference of the edge's ends if both agree, else 0.
[[nodiscard]] constexpr Reference mid_node_reference(Reference a, Reference b) { return a == b ? a : 0; }

struct DecodedMesh {
    AnyMesh mesh;
    std::vector<Notice> notices;
    /// Quadratic meshes: number in the file (from 1) of each vertex, then of each edge node (0: not in the file), for
    /// messages; empty if 1, 2, 3 …
    Column<std::uint32_t> node_numbers = {};
    std::optional<Lift> lift = {};  ///< for a flat mesh converted to 2D
    MeshFields fields = {};
    /// The format has only meshes in space, so a flat mesh means a 2D mesh, not a surface.
    bool is_always_3d = false;
    std::vector<CellCount> unsupported_cells = {};
    FileTags tags = {};
    std::string_view format = {};  ///< name in `mesh_formats()`
};

// Meshes as arrays in memory: coordinates, and nodes of cells in VTK's order.

/// K-simplices of one degree; nodes count from 0.
template <int Nodes>
struct CellArray {
    Column<std::array<VertexId, Nodes>> nodes = {};
    Column<Reference> references = {};  ///< for each cell; empty: all 0
};
template <int K>
struct CellArrays {
    CellArray<K + 1> straight = {};
    CellArray<quadratic_nodes<K>> curved = {};  ///< quadratic; mid nodes in the order of `local_edges`

    [[nodiscard]] std::size_t size() const { return straight.nodes.size() + curved.nodes.size(); }
};

template <int D>
struct MeshArrays {
    Column<Vec<D>> points;
    Column<Reference> point_references = {};  ///< for each point; empty: all 0
    CellArrays<D> elements = {};
    CellArrays<D - 1> facets = {};
    CellArrays<1> edges = {};
    std::vector<Group> groups = {};
};

/// `coordinates`: D for each point. Shares the array if `owner` keeps it alive and unchanged (see Column); copies it if
/// `owner` is null.
template <int D>
[[nodiscard]] Column<Vec<D>> points_of(std::span<const double> coordinates, std::shared_ptr<const void> owner);

/// Shares columns of degree 1. For degree 2, vertices come first, in their order (see DecodedMesh::node_numbers). Flat
/// meshes stay in space: see `with_flat_in_2d`. Errors: input (a coordinate that is not finite, a cell with an invalid
/// or repeated node, contradictory mid nodes).
template <int D>
[[nodiscard]] Outcome<DecodedMesh> mesh_of_arrays(MeshArrays<D> arrays, const Execution& execution);

/// Nodes of quadratic simplices in VTK's order: vertices, then n + edge number; n: number of vertices.
template <int K>
[[nodiscard]] Buffer<std::array<VertexId, quadratic_nodes<K>>> nodes_of_cells(
    const Column<SimplexVertices<K>>& vertices, const Column<std::array<EdgeId, edges_per_simplex<K>>>& edges,
    std::size_t n);

// Flat meshes have only faces, in one plane z = constant. Programs whose file format is always 3D write 2D meshes in
// this form. Errors of these functions: memory, stopped, unsupported (nodes inside faces).

struct Flattened {
    Mesh<2> mesh;
    Lift lift;
};

/// Converts a mesh to 2D if it has faces but no elements and exactly one z for faces and edges; otherwise none. Faces
/// become elements, edges become facets, to which ridges refer. Orders and orientations are preserved.
[[nodiscard]] Outcome<std::optional<Flattened>> flattened(const Mesh<3>& mesh, const Execution& execution);

/// Inverse of `flattened`, also for a modified mesh with the same number of vertices.
[[nodiscard]] Outcome<Mesh<3>> raised(const Mesh<2>& mesh, const Lift& lift, const Execution& execution);
/// Same; a mesh in space is returned unchanged.
[[nodiscard]] Outcome<AnyMesh> raised(const AnyMesh& mesh, const Lift& lift, const Execution& execution);

/// Vectors and tensors get z components of zero.
[[nodiscard]] Outcome<MeshFields> raised(const MeshFields& fields, const Execution& execution);

[[nodiscard]] Outcome<MeshFields> flattened(const MeshFields& fields, const Execution& execution);

/// For each component in space: true for z components.
[[nodiscard]] std::vector<bool> involves_z(FieldKind kind);

/// Converts a flat mesh and stores its lift. Other meshes stay in space, with a notice if z differs only by rounding.
[[nodiscard]] Outcome<DecodedMesh> with_flat_in_2d(DecodedMesh decoded, const Execution& execution);

/// Projects a solution to the plane: vectors lose z; tensors keep the upper left 2 × 2 block (for a metric, lengths in
/// the plane stay the same). A 2D solution is returned unchanged.
[[nodiscard]] Outcome<Solution> flattened(Solution solution, const Execution& execution);

}  // namespace camber
