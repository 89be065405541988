module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
module camber.transfer;
import :block;
import :interpolate;
import :mass_matrix;
import :patches;
import :projection;
import :reference_mass;
import camber.core;

namespace camber {

namespace {

template <int D, int K>
Outcome<Projection<D, K>> begin_projection(const TransferScene<D>& scene, std::span<const TransferField> fields,
                                           const Interpolated& interpolated, const Execution& execution) {
    Projection<D, K> projection{.block = block_of(K, fields, interpolated.values),
                                .reference = ReferenceMass<D, K>(scene.options.points),
                                .matrix = {},
                                .before = {},
                                .residual = {},
                                .low = {},
                                .high = {}};
    if (projection.block.components == 0) return projection;
    auto matrix = MassMatrix<D, K>::make(scene.new_mesh, scene.changed.new_elements, scene.changed.is_free,
                                         projection.reference, without_progress(execution));
    if (!matrix) return fail(matrix.error());
    projection.matrix = std::move(*matrix);
    return projection;
}

/// The nearest field in L2, from the residual of the interpolated one; then its integrals, and its limits.
template <int D, int K>
Outcome<Done> finish_projection(const TransferScene<D>& scene, const typename PatchSearch<D>::Patches& patches,
                                Projection<D, K>& projection, const Execution& execution) {
    const Execution quiet = without_progress(execution);
    Buffer<double> change(projection.matrix.size());
    for (std::size_t c = 0; c < projection.block.components; ++c) {
        if (auto solved = projection.matrix.solve(projection.residual_of(c), change, quiet); !solved) return solved;
        projection.add(c, change);
        report_progress(execution, c + 1, projection.block.components);
    }
    if (projection.block.components == 0) return Done{};
    auto before = integrals_before(scene, patches, projection, quiet);
    if (!before) return fail(before.error());
    projection.before = std::move(*before);
    if (auto kept = keep_integrals(scene, patches, projection, quiet); !kept) return kept;
    if (scene.options.bounds == TransferBounds::none) return Done{};
    return keep_limits(scene, patches, projection, quiet);
}

}  // namespace

template <int D>
Outcome<Interpolated> conserve(const TransferScene<D>& scene, std::span<const TransferField> fields,
                               Interpolated interpolated, const Execution& execution) {
    if (scene.changed.new_elements.empty()) return interpolated;
    auto linear = begin_projection<D, 1>(scene, fields, interpolated, execution);
    if (!linear) return fail(linear.error());
    auto quadratic = begin_projection<D, 2>(scene, fields, interpolated, execution);
    if (!quadratic) return fail(quadratic.error());
    PatchSearch<D> search(scene.old_mesh, scene.new_mesh, scene.same, scene.changed);
    auto done = integrate_residuals(scene, *linear, *quadratic, search, part_of(execution, 0, 0.7));
    if (!done) return fail(done.error());
    const auto patches = search.patches(scene.old_mesh, scene.new_mesh, scene.materials);
    done = finish_projection(scene, patches, *linear, part_of(execution, 0.7, 0.8));
    if (done) done = finish_projection(scene, patches, *quadratic, part_of(execution, 0.8, 1));
    if (!done) return fail(done.error());
    put_back(linear->block, fields, interpolated.values);
    put_back(quadratic->block, fields, interpolated.values);
    TransferStatistics& statistics = interpolated.statistics;
    statistics.projected = std::max(linear->matrix.size(), quadratic->matrix.size());
    statistics.turned = std::max(linear->matrix.turned(), quadratic->matrix.turned());
    statistics.patches = patches.patches;
    statistics.spread = std::max(linear->spread, quadratic->spread);
    statistics.unkept = std::max(linear->unkept, quadratic->unkept);
    return interpolated;
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template Outcome<Interpolated> conserve<D>(const TransferScene<D>&, std::span<const TransferField>, Interpolated, \
                                               const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
