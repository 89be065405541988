module;
#include <array>
#include <cstddef>
#include <span>
module camber.metric;
import :packs;
import camber.core;

namespace camber {

namespace {

/// kernel(begin) for each pack of n items.
template <class Kernel>
[[gnu::always_inline]] inline void each_pack(std::size_t n, const Kernel& kernel) {
    for (std::size_t begin = 0; begin < n; begin += pack_size) kernel(begin);
}

template <int D>
[[gnu::always_inline]] inline void scatter_sym(const SymPack<D>& s, std::size_t begin, std::size_t n, auto&& out) {
    for (std::size_t lane = 0; lane < pack_size && begin + lane < n; ++lane) {
        Sym<D>& to = out(begin + lane);
        for (int k = 0; k < sym_size<D>; ++k) to.c[k] = s.c[k][lane];
    }
}

}  // namespace

template <int D>
void metric_norms(std::span<const LogMetric<D>> metrics, std::span<const Vec<D>> vectors, std::span<double> norms,
                  Instructions set) {
    with_instructions(set, [&]() __attribute__((always_inline)) {
        each_pack(norms.size(), [&](std::size_t begin) __attribute__((always_inline)) {
            const EigenPack<D> e = eigen_system<D>(gathered_sym<D>(
                metrics, begin,
                [](const LogMetric<D>& m) __attribute__((always_inline)) -> const Sym<D>& { return m.l; }));
            const VecPack<D> v = gathered_vec<D>(
                vectors, begin, [](const Vec<D>& x) __attribute__((always_inline)) -> const Vec<D>& { return x; });
            Pack square = packed(0);
            for (int i = 0; i < D; ++i) {
                const Pack w = dot(e.vectors.column[i], v);
                square += exp(e.values[i]) * w * w;
            }
            const Pack norm = sqrt(square);
            for (std::size_t lane = 0; lane < pack_size && begin + lane < norms.size(); ++lane)
                norms[begin + lane] = norm[lane];
        });
    });
}

template <int D>
void natural_log_metrics(std::span<const std::array<Vec<D>, D + 1>> simplices, std::span<LogMetric<D>> metrics,
                         Instructions set) {
    using Simplex = std::array<Vec<D>, D + 1>;
    const Mat<D> reference = inverse(regular_simplex<D>());
    with_instructions(set, [&]() __attribute__((always_inline)) {
        each_pack(metrics.size(), [&](std::size_t begin) __attribute__((always_inline)) {
            std::array<VecPack<D>, D + 1> p{};
            for (int i = 0; i <= D; ++i)
                p[i] = gathered_vec<D>(simplices, begin,
                                       [&](const Simplex& s)
                                           __attribute__((always_inline)) -> const Vec<D>& { return s[i]; });
            const RightSingularPack<D> s = right_singular<D>(natural_frame<D>(p, reference));
            scatter_sym<D>(natural_log_metric<D>(s), begin, metrics.size(),
                           [&](std::size_t i) __attribute__((always_inline)) -> Sym<D>& { return metrics[i].l; });
        });
    });
}

template <int D>
void see_through(std::span<const LogMetric<D>> metrics, std::span<const Mat<D>> jacobians,
                 std::span<SeenMetric<D>> seen, Instructions set) {
    with_instructions(set, [&]() __attribute__((always_inline)) {
        each_pack(seen.size(), [&](std::size_t begin) __attribute__((always_inline)) {
            const SymPack<D> metric = gathered_sym<D>(
                metrics, begin,
                [](const LogMetric<D>& m) __attribute__((always_inline)) -> const Sym<D>& { return m.l; });
            const MatPack<D> jacobian = gathered_mat<D>(
                jacobians, begin, [](const Mat<D>& m) __attribute__((always_inline)) -> const Mat<D>& { return m; });
            const SeenPack<D> pack = seen_through<D>(metric, jacobian);
            scatter_sym<D>(pack.log_metric, begin, seen.size(),
                           [&](std::size_t i)
                               __attribute__((always_inline)) -> Sym<D>& { return seen[i].log_metric.l; });
            for (std::size_t lane = 0; lane < pack_size && begin + lane < seen.size(); ++lane)
                for (int i = 0; i < D; ++i)
                    for (int j = 0; j < D; ++j) seen[begin + lane].axes(i, j) = pack.axes(i, j)[lane];
        });
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                      \
    template void metric_norms<D>(std::span<const LogMetric<D>>, std::span<const Vec<D>>, std::span<double>,       \
                                  Instructions);                                                                   \
    template void natural_log_metrics<D>(std::span<const std::array<Vec<D>, D + 1>>, std::span<LogMetric<D>>,      \
                                         Instructions);                                                            \
    template void see_through<D>(std::span<const LogMetric<D>>, std::span<const Mat<D>>, std::span<SeenMetric<D>>, \
                                 Instructions);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
