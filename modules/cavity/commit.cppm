module;
#include <span>
export module camber.cavity:commit;
import camber.core;
import camber.validity;
import :patch;
import :reinsert;

export namespace camber {

/// The last verb: the proposal's nodes become the mesh's. All or nothing: a proposal whose validation found an element
/// that is not certified valid is refused with that element named (ErrorKind::input), and the mesh stays as it was.
template <int D>
[[nodiscard]] Outcome<QuadraticMesh<D>> commit(QuadraticMesh<D> mesh, const Proposal<D>& proposal,
                                               const Validation<D>& validation);

/// The same without asking for validity, for those who want to see a broken mesh, or repair it elsewhere.
template <int D>
[[nodiscard]] Outcome<QuadraticMesh<D>> commit_unvalidated(QuadraticMesh<D> mesh, const Proposal<D>& proposal);

/// The same verb for cavities: the patches' nodes become the mesh's; the cost is that of the patches. Their cavities
/// must not overlap, or one would undo what the other was planned against (see `independent_vertices`). Errors
/// (internal): a patch with an edge that the mesh does not have.
template <int D>
[[nodiscard]] Outcome<Curving<D>> commit(Curving<D> curving, std::span<const Patch<D>> patches);

}  // namespace camber
