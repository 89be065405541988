export module camber.validity:commit;
import camber.core;
import :validate;

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

/// The same without asking for validity, for those who want to see a broken mesh, or repair it elsewhere.
template <int D>
[[nodiscard]] Committed<D> commit_uncertified(const JudgedProposal<D>& judged);

}  // namespace camber
