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

/// A difference between a file and the decoded mesh. The text is a sentence without a full stop.
struct Notice {
    std::string what;
    bool is_detail = false;  ///< printed only with --verbose, because no name and no field is lost
    friend bool operator==(const Notice&, const Notice&) = default;
};

/// The bytes of a file, in parts.
using Chunks = std::vector<Buffer<std::byte>>;

/// Handling of cells that are not simplices of degree 1 or 2.
enum class UnsupportedCells : std::uint8_t {
    refuse,
    count,  ///< skips such cells and counts them
};

/// Options for reading; a format ignores those that do not apply to it.
struct DecodeOptions {
    /// Name of the cell array that contains the references (VTU, VTK). Empty: the first array with a known name.
    std::string reference_array = {};
    /// Zone to read (SU2: number, CGNS: name or number). Empty: all zones, joined into one mesh.
    std::string zone = {};
    UnsupportedCells unsupported_cells = UnsupportedCells::refuse;
    /// Reads another file that a PVTU file names; `path` is relative to the folder of the PVTU file. Null: such files
    /// cannot be read.
    std::function<Outcome<Buffer<std::byte>>(const std::string& path)> beside = {};
};

struct CellCount {
    std::string kind;
    std::size_t count = 0;
    friend bool operator==(const CellCount&, const CellCount&) = default;
};

/// Kinds of fields, with their numbers in GMF files.
enum class FieldKind { scalar = 1, vector = 2, symmetric_tensor = 3, full_tensor = 4 };

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
    Column<double> values = {};     ///< for each row the values of all fields; symmetric tensors as in `Sym`
    bool single_precision = false;  ///< true if the file read has 4-byte reals (version 1); encoders always write 8
                                    ///< bytes

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
    node,  ///< a row for each vertex, then (degree 2) for each edge node in the order of the edge set
    cell,  ///< a row for each element, then for each facet and each feature edge
};

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

/// Immutable list of fields. Fields with the same centring have different names.
class MeshFields {
  public:
    MeshFields() = default;
    /// Gives the same result as calling `with` for each field, but takes only the time of a sort.
    explicit MeshFields(std::vector<MeshField> fields);

    /// Adds a field. It replaces the field with the same name and centring, if there is one.
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

/// Converts node fields to a solution at the first `vertices` nodes. Cell fields and values at edge nodes are dropped.
/// Errors: usage (there is no node field).
[[nodiscard]] Outcome<Solution> solution_of(const MeshFields& fields, int dimension, std::size_t vertices,
                                            const Execution& execution);

/// Surface meshes in space are 3D meshes without elements.
using AnyMesh = std::variant<Mesh<2>, Mesh<3>>;

/// Returns the mesh as M, a LinearMesh<D> or QuadraticMesh<D>; columns are shared. Errors: unsupported (another
/// dimension or degree, or not simplices).
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

/// Data of a flat mesh in space that the 2D mesh cannot store; see `flattened` and `raised`.
struct Lift {
    double z = 0;                 ///< z of all used nodes (model units)
    Column<double> heights = {};  ///< z of each vertex if an unused vertex has another z, else empty
    /// Empty if all directions lie in the plane.
    DirectionsAtVertices<3> normals = {}, tangents = {};
    friend bool operator==(const Lift&, const Lift&) = default;
};

/// Tags of vertices and simplices in a Gmsh file. A column is empty if the tags are 1, 2, 3 …
struct FileTags {
    Column<std::uint64_t> vertices;
    std::array<Column<std::uint64_t>, 4> simplices = {};
};

/// Returns the reference of a mid node: that of the edge's ends if both agree, else 0.
[[nodiscard]] constexpr Reference mid_node_reference(Reference a, Reference b) { return a == b ? a : 0; }

struct DecodedMesh {
    AnyMesh mesh;
    std::vector<Notice> notices;
    /// For messages: number in the file, from 1, of each vertex, then of each edge node (0: not in the file), for
    /// degree 2. Empty: 1, 2, 3 …
    Column<std::uint32_t> node_numbers = {};
    std::optional<Lift> lift = {};  ///< for a flat mesh converted to 2D
    MeshFields fields = {};
    /// The format has only meshes in space, so a flat mesh stands for a 2D mesh, not for a surface.
    bool is_always_3d = false;
    std::vector<CellCount> unsupported_cells = {};
    FileTags tags = {};
    std::string_view format = {};  ///< name in `mesh_formats()`
};

// Meshes as arrays in memory: coordinates of points, and nodes of cells in VTK's order.

/// K-simplices of one degree. Their nodes are numbers of points, from 0.
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

/// `coordinates`: D numbers for each point. The result shares the array if `owner` keeps it alive and unchanged (see
/// Column); if `owner` is null, the array is copied.
template <int D>
[[nodiscard]] Column<Vec<D>> points_of(std::span<const double> coordinates, std::shared_ptr<const void> owner);

/// Builds a mesh, which shares the columns of `arrays` if it has degree 1. For degree 2, vertices come first, in the
/// order of the points (see DecodedMesh::node_numbers). Flat meshes stay in space; see `with_flat_in_2d`. Errors: input
/// (a coordinate that is not finite, a cell with an invalid or repeated node, contradictory mid nodes).
template <int D>
[[nodiscard]] Outcome<DecodedMesh> mesh_of_arrays(MeshArrays<D> arrays, const Execution& execution);

/// Nodes of quadratic simplices in VTK's order: first the vertices, then the edge nodes. The node of edge e has the
/// number n + e, where n is the number of vertices of the mesh.
template <int K>
[[nodiscard]] Buffer<std::array<VertexId, quadratic_nodes<K>>> nodes_of_cells(
    const Column<SimplexVertices<K>>& vertices, const Column<std::array<EdgeId, edges_per_simplex<K>>>& edges,
    std::size_t n);

// A flat mesh is a surface mesh in space with faces only, all in one plane z = constant. Programs whose file format is
// always 3D write 2D meshes in this form. Errors of these functions: memory, stopped, unsupported (nodes inside faces).

struct Flattened {
    Mesh<2> mesh;
    Lift lift;
};

/// Converts a flat mesh to 2D; none if the mesh has elements, has no faces, or if z differs between nodes of faces or
/// edges. Faces become elements, edges become facets, and ridges refer to these. Orders and orientations are preserved.
[[nodiscard]] Outcome<std::optional<Flattened>> flattened(const Mesh<3>& mesh, const Execution& execution);

/// Converts a 2D mesh back to space. The mesh may have changed since `flattened`, but not its number of vertices.
[[nodiscard]] Outcome<Mesh<3>> raised(const Mesh<2>& mesh, const Lift& lift, const Execution& execution);
/// Converts a 2D mesh back to space; a mesh in space is returned unchanged.
[[nodiscard]] Outcome<AnyMesh> raised(const AnyMesh& mesh, const Lift& lift, const Execution& execution);

/// Converts 2D fields to space: vectors and tensors get z components of zero.
[[nodiscard]] Outcome<MeshFields> raised(const MeshFields& fields, const Execution& execution);

[[nodiscard]] Outcome<MeshFields> flattened(const MeshFields& fields, const Execution& execution);

/// Returns for each component of a field in space: true for z components.
[[nodiscard]] std::vector<bool> involves_z(FieldKind kind);

/// Converts a flat mesh to 2D and stores its lift. Other meshes stay in space; there is a notice if their z values
/// differ only by rounding.
[[nodiscard]] Outcome<DecodedMesh> with_flat_in_2d(DecodedMesh decoded, const Execution& execution);

/// Projects a solution to the plane z = constant. Vectors lose their z component; tensors keep the upper left 2 × 2
/// block, so that a metric gives the same lengths in the plane. A 2D solution is returned unchanged.
[[nodiscard]] Outcome<Solution> flattened(Solution solution, const Execution& execution);

}  // namespace camber
