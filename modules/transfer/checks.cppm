module;
#include <span>
module camber.transfer:checks;
import camber.core;
import :fields;
import :transferred;

namespace camber {

/// The errors of `transfer` that its input alone makes.
template <int D>
[[nodiscard]] Outcome<Done> check_input(const QuadraticMesh<D>& old_mesh, std::span<const TransferField> fields,
                                        const QuadraticMesh<D>& new_mesh, const TransferOptions& options,
                                        const Execution& execution);

}  // namespace camber
