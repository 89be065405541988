module;
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
module camber.transfer;
import :fields;
import :integrals;
import :materials;
import :sums;
import :totals;
import :transferred;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

template <int D>
std::vector<std::uint32_t> materials_of(const QuadraticMesh<D>& mesh, const Materials<D>& materials) {
    std::vector<std::uint32_t> all(mesh.linear.elements.size());
    for (std::size_t e = 0; e < all.size(); ++e) all[e] = static_cast<std::uint32_t>(materials.of(mesh.linear, e));
    return all;
}

template <int D>
Outcome<std::vector<Sum>> integrals_of(const QuadraticMesh<D>& mesh, const TransferField& field,
                                       const std::vector<std::uint32_t>& material_of, std::size_t materials,
                                       const Execution& execution) {
    const auto components = static_cast<std::size_t>(field.components);
    const auto element = [](std::size_t e) { return e; };
    return field.degree == 1 ? integrals_by_group<D, 1>(mesh, element, material_of, materials, field.values.view(),
                                                        components, execution)
                             : integrals_by_group<D, 2>(mesh, element, material_of, materials, field.values.view(),
                                                        components, execution);
}

}  // namespace

template <int D>
Outcome<std::vector<std::vector<MaterialIntegrals>>> total_integrals(
    const QuadraticMesh<D>& old_mesh, std::span<const TransferField> old_fields, const QuadraticMesh<D>& new_mesh,
    std::span<const TransferField> new_fields, const Materials<D>& materials, const Execution& execution) {
    const auto old_materials = materials_of(old_mesh, materials), new_materials = materials_of(new_mesh, materials);
    std::vector<std::uint8_t> has_elements(materials.size(), 0);
    for (const std::uint32_t m : old_materials) has_elements[m] = 1;
    for (const std::uint32_t m : new_materials) has_elements[m] = 1;
    std::vector<std::vector<MaterialIntegrals>> all;
    for (std::size_t f = 0; f < old_fields.size(); ++f) {
        const auto before = integrals_of(old_mesh, old_fields[f], old_materials, materials.size(), execution);
        if (!before) return fail(before.error());
        const auto after = integrals_of(new_mesh, new_fields[f], new_materials, materials.size(), execution);
        if (!after) return fail(after.error());
        const auto components = static_cast<std::size_t>(old_fields[f].components);
        std::vector<MaterialIntegrals> rows;
        for (std::size_t m = 0; m < materials.size(); ++m) {
            if (has_elements[m] == 0) continue;
            MaterialIntegrals row{.reference = materials.reference(m), .before = {}, .after = {}};
            for (std::size_t c = 0; c < components; ++c) {
                row.before.push_back((*before)[m * components + c].value());
                row.after.push_back((*after)[m * components + c].value());
            }
            rows.push_back(std::move(row));
        }
        all.push_back(std::move(rows));
    }
    return all;
}

#define CAMBER_INSTANTIATE(D)                                                             \
    template Outcome<std::vector<std::vector<MaterialIntegrals>>> total_integrals<D>(     \
        const QuadraticMesh<D>&, std::span<const TransferField>, const QuadraticMesh<D>&, \
        std::span<const TransferField>, const Materials<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
