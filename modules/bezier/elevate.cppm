export module camber.bezier:elevate;
import camber.core;

export namespace camber {

/// The first verb: the same mesh in degree 2, each edge with its node at the middle of the chord. Exact: no point of
/// any element moves. Errors: those of `unique_edges`, stopped.
template <int D>
[[nodiscard]] Outcome<QuadraticMesh<D>> elevate(LinearMesh<D> mesh, const Execution& execution);

}  // namespace camber
