module;
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>
export module camber.io:any_mesh;
import camber.core;
import :decode_options;
import :mesh_fields;
import :notice;

export namespace camber {

/// What a mesh file may turn out to hold. Surface meshes in space are 3D meshes without elements.
using AnyMesh = std::variant<LinearMesh<2>, LinearMesh<3>, QuadraticMesh<2>, QuadraticMesh<3>>;

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

}  // namespace camber
