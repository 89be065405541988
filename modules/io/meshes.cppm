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
/// Mesh and field values as files hold them: decoded meshes, fields, options, notices, arrays in memory.
export module camber.io:meshes;
import camber.core;
import camber.bezier;

export namespace camber {

/// Something of a file that the value made from it does not hold: one sentence without a full stop.
struct Notice {
    std::string what;
    bool is_detail = false;  ///< printed with --verbose only: neither a name nor a field is lost
    friend bool operator==(const Notice&, const Notice&) = default;
};

/// An encoded file: its bytes are those of the chunks, one after the other.
using Chunks = std::vector<Buffer<std::byte>>;

/// What is done about a file's cells that no mesh here holds: those that are no simplices, or of a degree above 2.
enum class Unheld : std::uint8_t {
    refuse,  ///< an error that names them
    count,   ///< they are left out and counted (`DecodedMesh::unheld`): to tell what is in a file
};

/// What a caller may choose of how a mesh file is read; each format takes what is its own.
struct DecodeOptions {
    /// The array of cells that is their reference (VTU, VTK); empty: the first with a name that is known for such.
    std::string reference_array = {};
    /// The zone to read (SU2: its number, CGNS: its name or number); empty: all, joined into one mesh.
    std::string zone = {};
    Unheld unheld = Unheld::refuse;
    /// Reads a file that the mesh's file names, by a path from its folder (PVTU); none: nobody does.
    std::function<Outcome<Buffer<std::byte>>(const std::string& path)> beside = {};
};

/// So many cells of a kind, which is in the plural.
struct CellCount {
    std::string kind;
    std::size_t count = 0;
    friend bool operator==(const CellCount&, const CellCount&) = default;
};

/// What one field holds at each vertex; the numbers are those of GMF files.
enum class FieldKind { scalar = 1, vector = 2, symmetric_tensor = 3, full_tensor = 4 };

/// Values that a field has at each vertex, in 2 or 3 dimensions.
[[nodiscard]] constexpr int values_per_vertex(FieldKind kind, int dimension) {
    switch (kind) {
        case FieldKind::scalar: return 1;
        case FieldKind::vector: return dimension;
        case FieldKind::symmetric_tensor: return dimension * (dimension + 1) / 2;
        case FieldKind::full_tensor: return dimension * dimension;
    }
    return 0;
}

/// Fields at the vertices of a mesh.
struct Solution {
    int dimension = 3;
    std::vector<FieldKind> fields = {};
    std::size_t rows = 0;           ///< vertices
    Column<double> values = {};     ///< row after row, field after field; symmetric tensors in the order of `Sym`
    bool single_precision = false;  ///< the file held reals of 4 bytes (version 1); encoders write 8

    friend bool operator==(const Solution&, const Solution&) = default;
};

/// Values in one row of the solution.
[[nodiscard]] inline std::size_t row_width(const Solution& solution) {
    int width = 0;
    for (const FieldKind kind : solution.fields) width += values_per_vertex(kind, solution.dimension);
    return static_cast<std::size_t>(width);
}

/// What a solution file holds, and what is to be said about it.
struct DecodedSolution {
    Solution solution;
    std::vector<Notice> notices;
};

/// What a field has a row for.
enum class Centring : std::uint8_t {
    node,  ///< each vertex, then (degree 2) the node of each edge in the order of the edge set
    cell,  ///< each element, then each facet, then each feature edge
};

/// Rows one after the other; whole numbers are kept as such.
using FieldValues = std::variant<Column<double>, Column<std::int32_t>>;

/// One field of a mesh. Symmetric tensors have their components in the order of `Sym`, full tensors row by row.
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

/// Named fields of one mesh in D dimensions, no name twice for a centring: a value; `with` gives another.
class MeshFields {
  public:
    MeshFields() = default;
    /// All of them at once, which is as one after the other `with` the others, but takes no longer than to sort them.
    explicit MeshFields(std::vector<MeshField> fields);

    /// These fields and one more; one of the same name and centring is replaced.
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

/// The fields at nodes as a solution at the first `vertices` nodes, for files beside a mesh of that dimension; fields
/// at cells and the values at edges' nodes are left out. Errors: usage (none of the fields is at nodes).
[[nodiscard]] Outcome<Solution> solution_of(const MeshFields& fields, int dimension, std::size_t vertices,
                                            const Execution& execution);

/// What a mesh file may turn out to hold. Surface meshes in space are 3D meshes without elements.
using AnyMesh = std::variant<Mesh<2>, Mesh<3>>;

/// The mesh as M, which is LinearMesh<D> or QuadraticMesh<D>; columns are shared. Errors: unsupported (it has another
/// dimension or degree, or elements that are no simplices).
template <class M>
[[nodiscard]] Outcome<M> mesh_as(AnyMesh mesh) {
    constexpr int dimension = M::dimension;
    auto* const same = std::get_if<Mesh<dimension>>(&mesh);
    if (!same)
        return fail(ErrorKind::unsupported, "is a mesh in " + std::to_string(5 - dimension) +
                                                "D, and this needs one in " + std::to_string(dimension) + "D");
    if constexpr (std::is_same_v<M, LinearMesh<dimension>>)
        return as_linear(std::move(*same));
    else
        return as_quadratic(std::move(*same));
}

/// What a flat mesh in space has and the same mesh in 2D does not hold: see `flattened` and `raised`.
struct Lift {
    double z = 0;                 ///< of every node that a triangle or an edge uses (model units)
    Column<double> heights = {};  ///< z of each vertex, where unused ones have another; else empty
    /// Its normals, its tangents, where one of them leaves the plane; else empty.
    DirectionsAtVertices<3> normals = {}, tangents = {};
    friend bool operator==(const Lift&, const Lift&) = default;
};

/// The numbers that a file gives by itself (tags of Gmsh's), where these are not 1, 2, 3 …; else empty.
struct FileTags {
    Column<std::uint64_t> vertices;
    std::array<Column<std::uint64_t>, 4> simplices = {};  ///< of edges, triangles and tetrahedra, by their dimension
};

/// The reference that a mid node is written with: that of the edge's ends where both agree, else 0.
[[nodiscard]] constexpr Reference mid_node_reference(Reference a, Reference b) { return a == b ? a : 0; }

/// What a mesh file holds, and what is to be said about it.
struct DecodedMesh {
    AnyMesh mesh;
    std::vector<Notice> notices;
    /// Of a quadratic mesh: the file's number, from 1, of each vertex, then of each edge's node (0: it has none), for
    /// messages; empty where they are 1, 2, 3 …
    Column<std::uint32_t> node_numbers = {};
    std::optional<Lift> lift = {};  ///< of a 2D mesh that was a flat one in space
    MeshFields fields = {};         ///< of formats that have them beside the mesh
    /// The file's format has three coordinates of every mesh: a flat one in it is a mesh in 2D, and no surface.
    bool always_in_space = false;
    std::vector<CellCount> unheld = {};  ///< cells that were left out (Unheld::count)
    FileTags tags = {};
    std::string_view format = {};  ///< the name of the file's row of `mesh_formats()`
};

// Meshes as programs hand them on in memory: coordinates, and nodes of cells in VTK's order.

/// K-simplices of one degree, of `Nodes` nodes each, which count the points from 0.
template <int Nodes>
struct CellArray {
    Column<std::array<VertexId, Nodes>> nodes = {};
    Column<Reference> references = {};  ///< one a cell; none: 0 of all
};
template <int K>
struct CellArrays {
    CellArray<K + 1> straight = {};
    CellArray<quadratic_nodes<K>> curved = {};  ///< mid nodes as `local_edges` has the edges

    [[nodiscard]] std::size_t size() const { return straight.nodes.size() + curved.nodes.size(); }
};

template <int D>
struct MeshArrays {
    Column<Vec<D>> points;                    ///< nodes of degree 2 among them
    Column<Reference> point_references = {};  ///< one a point; none: 0 of all
    CellArrays<D> elements = {};
    CellArrays<D - 1> facets = {};
    CellArrays<1> edges = {};  ///< feature edges of a mesh in 3D
    std::vector<Group> groups = {};
};

/// Coordinates, D of each point, as a column: the array of somebody else who leaves it as it is (see Column), or a copy
/// where nobody does.
template <int D>
[[nodiscard]] Column<Vec<D>> points_of(std::span<const double> coordinates, std::shared_ptr<const void> owner);

/// The mesh: of degree 1, which shares the columns, or of degree 2, whose vertices come first, in their order
/// (DecodedMesh::node_numbers says which point each node was). Triangles in one plane z = constant stay in space: see
/// `with_flat_in_2d`. Errors: input, a coordinate that is not finite, a cell that has a node which is no point or one
/// twice, mid nodes that contradict each other; memory, stopped.
template <int D>
[[nodiscard]] Outcome<DecodedMesh> mesh_of_arrays(MeshArrays<D> arrays, const Execution& execution);

/// Nodes of the simplices of a mesh of degree 2 in VTK's order: vertices, then n plus the edge's number for its node,
/// where n is the number of vertices.
template <int K>
[[nodiscard]] Buffer<std::array<VertexId, quadratic_nodes<K>>> nodes_of_cells(
    const Column<SimplexVertices<K>>& vertices, const Column<std::array<EdgeId, edges_per_simplex<K>>>& edges,
    std::size_t n);

// Flat meshes: faces alone in one plane z = constant, as programs write 2D meshes that know files of dimension 3 only.
// Functions fail for want of memory, when stopped, and on meshes with nodes inside faces (unsupported).

/// A flat mesh in 2D, with what puts it back into space.
struct Flattened {
    Mesh<2> mesh;
    Lift lift;
};

/// The mesh in 2D if it is flat: it has faces and no elements, and all that its faces and edges use has the very same
/// z. Faces become elements, edges facets, and ridges count these; the order of everything stays, and so does the way
/// round of the faces. None if it is not flat.
[[nodiscard]] Outcome<std::optional<Flattened>> flattened(const Mesh<3>& mesh, const Execution& execution);

/// The mesh in space: that which was flattened, or what became of it meanwhile; its vertices must be as many.
[[nodiscard]] Outcome<Mesh<3>> raised(const Mesh<2>& mesh, const Lift& lift, const Execution& execution);
/// Meshes in space are given back as they are.
[[nodiscard]] Outcome<AnyMesh> raised(const AnyMesh& mesh, const Lift& lift, const Execution& execution);

/// Fields of a 2D mesh for the same mesh raised: vectors and tensors have zeros for z.
[[nodiscard]] Outcome<MeshFields> raised(const MeshFields& fields, const Execution& execution);

/// Fields of a flat mesh in space for the same mesh in 2D: what vectors and tensors say of z is left out.
[[nodiscard]] Outcome<MeshFields> flattened(const MeshFields& fields, const Execution& execution);

/// Which values of a field's row in space speak of z.
[[nodiscard]] std::vector<bool> involves_z(FieldKind kind);

/// What a file holds with a flat mesh in 2D and its lift; any other as it is, with a notice where z differs by
/// rounding.
[[nodiscard]] Outcome<DecodedMesh> with_flat_in_2d(DecodedMesh decoded, const Execution& execution);

/// What a solution in space says of directions in the plane: vectors without z, the upper left 2 × 2 of tensors (of a
/// metric: the lengths of edges in the plane are the same). One in 2D is given back as it is.
[[nodiscard]] Outcome<Solution> flattened(Solution solution, const Execution& execution);

}  // namespace camber
