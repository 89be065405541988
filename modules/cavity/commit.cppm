export module camber.cavity:commit;
import camber.core;
import camber.validity;

export namespace camber {

/// The last verb: the proposal's nodes become the mesh's. All or nothing: a proposal whose validation found an element
/// that is not certified valid is refused with that element named (ErrorKind::input), and the mesh stays as it was.
template <int D>
[[nodiscard]] Outcome<QuadraticMesh<D>> commit(QuadraticMesh<D> mesh, const Proposal<D>& proposal,
                                               const Validation<D>& validation);

/// The same without asking for validity, for those who want to see a broken mesh, or repair it elsewhere.
template <int D>
[[nodiscard]] Outcome<QuadraticMesh<D>> commit_unvalidated(QuadraticMesh<D> mesh, const Proposal<D>& proposal);

}  // namespace camber
