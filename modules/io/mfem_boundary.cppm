module camber.io:mfem_boundary;
import camber.core;

namespace camber::mfem {

/// Those simplices of the boundary that are faces of elements, in their order, with their references. Errors: stopped.
template <int K>
[[nodiscard]] Outcome<Simplices<K - 1>> faces_of(const Simplices<K>& elements, const Simplices<K - 1>& boundary,
                                                 const Execution& execution);

}  // namespace camber::mfem
