module;
#include <span>
export module camber.cavity:commit;
import camber.core;
import camber.validity;
import :patch;
import :reinsert;

export namespace camber {

/// What a commit gives: the mesh, and where its entities are now. Identities while the topology stays.
template <int D>
struct Committed {
    QuadraticMesh<D> mesh;
    MeshMaps maps;
};

/// The last verb: the places of the proposal become the mesh's, if det J > 0 is certified everywhere; a bound above
/// that is the caller's to ask for (`validation().all_valid()`). All or nothing: otherwise an element is named
/// (ErrorKind::input), and the mesh stays as it was.
template <int D>
[[nodiscard]] Outcome<Committed<D>> commit(const JudgedProposal<D>& judged);

/// The same without asking for validity, for those who want to see a broken mesh, or mend it elsewhere.
template <int D>
[[nodiscard]] Committed<D> commit_uncertified(const JudgedProposal<D>& judged);

/// The same verb for cavities: the patches' nodes become the mesh's; the cost is that of the patches. Their cavities
/// must not overlap, or one would undo what the other was planned against (see `independent_vertices`). Errors
/// (internal): a patch with an edge that the mesh does not have.
template <int D>
[[nodiscard]] Outcome<Curving<D>> commit(Curving<D> curving, std::span<const Patch<D>> patches);

}  // namespace camber
