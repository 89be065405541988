module;
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
module camber.metric;
import camber.core;

namespace camber {

namespace {

/// log M = λ_t I + (λ_n − λ_t) n nᵀ with λ = −2 log h.
template <int D>
LogMetric<D> thin_along(const Vec<D>& normal, double tangent_size, double normal_size) {
    const double tangential = -2 * log(tangent_size);
    const double difference = -2 * log(normal_size) - tangential;
    LogMetric<D> out{tangential * Sym<D>::identity()};
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j) out.l(i, j) += difference * normal[i] * normal[j];
    return out;
}

}  // namespace

template <int D>
Outcome<Column<LogMetric<D>>> surface_log_metrics(const VertexNormals<D>& normals, const SurfaceMetricOptions& options,
                                                  const Execution& execution) {
    const double volume_size = options.volume_size.value_or(options.tangent_size);
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    if (!(volume_size > 0) || !std::isfinite(volume_size))
        return fail(ErrorKind::usage, "volume_size must be a finite number above 0");
    auto logs = map_each(execution, normals.size(), [&](std::size_t v) {
        LogMetric<D> out{-2 * log(volume_size) * Sym<D>::identity()};
        bool on_boundary = false;
        for (const Vec<D>& given : normals[v]) {
            const double length = norm(given);
            if (!(length > 0)) continue;
            const LogMetric<D> side = thin_along(given / length, options.tangent_size, options.normal_size);
            out = on_boundary ? intersection(out, side) : side;
            on_boundary = true;
        }
        return out;
    });
    if (!logs) return fail(logs.error());
    return Column<LogMetric<D>>(std::move(*logs));
}

#define CAMBER_INSTANTIATE(D)                                                              \
    template Outcome<Column<LogMetric<D>>> surface_log_metrics<D>(const VertexNormals<D>&, \
                                                                  const SurfaceMetricOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
