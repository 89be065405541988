module;
#include <optional>
#include <vector>
export module camber.io:flat;
import camber.core;
import :any_mesh;
import :mesh_fields;
import :solution;

/// Flat meshes: triangles alone in one plane z = constant, as programs write 2D meshes that know files of dimension 3
/// only. Functions fail for want of memory, or when stopped.
export namespace camber {

/// A flat mesh in 2D, with what puts it back into space.
template <class Mesh>
struct Flattened {
    Mesh mesh;
    Lift lift;
};

/// The mesh in 2D if it is flat: it has triangles and no tetrahedra, and all that its triangles and edges use has the
/// very same z. Triangles become elements, edges facets, and ridges count these; the order of everything stays, and so
/// does the way round of the triangles. None if it is not flat.
[[nodiscard]] Outcome<std::optional<Flattened<LinearMesh<2>>>> flattened(const LinearMesh<3>& mesh,
                                                                         const Execution& execution);
[[nodiscard]] Outcome<std::optional<Flattened<QuadraticMesh<2>>>> flattened(const QuadraticMesh<3>& mesh,
                                                                            const Execution& execution);

/// The mesh in space: that which was flattened, or what became of it meanwhile; its vertices must be as many.
[[nodiscard]] Outcome<LinearMesh<3>> raised(const LinearMesh<2>& mesh, const Lift& lift, const Execution& execution);
[[nodiscard]] Outcome<QuadraticMesh<3>> raised(const QuadraticMesh<2>& mesh, const Lift& lift,
                                               const Execution& execution);
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
