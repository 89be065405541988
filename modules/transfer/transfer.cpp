module;
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
module camber.transfer;
import :checks;
import :fields;
import :interpolate;
import :materials;
import :patches;
import :projection;
import :same;
import :sources;
import :totals;
import :transferred;
import camber.core;

namespace camber {

template <int D>
Outcome<Transferred> transfer(const QuadraticMesh<D>& old_mesh, std::span<const TransferField> fields,
                              const QuadraticMesh<D>& new_mesh, const TransferOptions& options,
                              const Execution& execution) {
    return guarded([&]() -> Outcome<Transferred> {
        if (auto sound = check_input(old_mesh, fields, new_mesh, options, without_progress(execution)); !sound)
            return fail(sound.error());
        if (fields.empty()) return Transferred{};
        const Materials<D> materials(old_mesh.linear, new_mesh.linear);
        const auto same = find_same(old_mesh, new_mesh, materials, part_of(execution, 0, 0.1));
        if (!same) return fail(same.error());
        const auto sources =
            Sources<D>::make(old_mesh, materials, asked_materials(new_mesh, materials), part_of(execution, 0.1, 0.2));
        if (!sources) return fail(sources.error());
        auto values = interpolate(old_mesh, fields, new_mesh, materials, *same, *sources, part_of(execution, 0.2, 0.5));
        if (!values) return fail(values.error());
        const Buffer<std::uint32_t> near = std::move(values->near);
        const Changed changed = find_changed(old_mesh, new_mesh, *same);
        if (options.method == TransferMethod::conserve) {
            const TransferScene<D> scene{old_mesh, new_mesh, materials, *same, *sources, changed, near, options};
            values = conserve(scene, fields, std::move(*values), part_of(execution, 0.5, 0.95));
            if (!values) return fail(values.error());
        }
        Transferred out{{}, std::move(values->statistics)};
        out.statistics.changed_elements = changed.new_elements.size();
        for (std::size_t f = 0; f < fields.size(); ++f)
            out.fields.push_back({fields[f].components, fields[f].degree, std::move(values->values[f])});
        auto integrals =
            total_integrals<D>(old_mesh, fields, new_mesh, out.fields, materials, part_of(execution, 0.95, 1));
        if (!integrals) return fail(integrals.error());
        out.statistics.integrals = std::move(*integrals);
        return out;
    });
}

#define CAMBER_INSTANTIATE(D)                                                                          \
    template Outcome<Transferred> transfer<D>(const QuadraticMesh<D>&, std::span<const TransferField>, \
                                              const QuadraticMesh<D>&, const TransferOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
