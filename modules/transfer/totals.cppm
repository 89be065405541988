module;
#include <span>
#include <vector>
module camber.transfer:totals;
import camber.core;
import :fields;
import :materials;
import :transferred;

namespace camber {

/// The integrals of each field by material, before and after; materials without elements are left out. Errors: memory,
/// stopped.
template <int D>
[[nodiscard]] Outcome<std::vector<std::vector<MaterialIntegrals>>> total_integrals(
    const QuadraticMesh<D>& old_mesh, std::span<const TransferField> old_fields, const QuadraticMesh<D>& new_mesh,
    std::span<const TransferField> new_fields, const Materials<D>& materials, const Execution& execution);

}  // namespace camber
