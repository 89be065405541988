// Natural metrics of straight and curved meshes.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
module camber.metric;
import camber.core;

namespace camber {

namespace {

template <int D>
using Corners = std::array<Vec<D>, D + 1>;

template <int D>
Corners<D> corners_of(const LinearMesh<D>& mesh, std::size_t e) {
    Corners<D> p;
    for (int i = 0; i <= D; ++i) p[i] = mesh.points[mesh.elements.vertices[e][i]];
    return p;
}

template <int D>
double determinant(const Corners<D>& p) {
    Mat<D> sides;
    for (int i = 0; i < D; ++i) sides.column[i] = p[i + 1] - p[0];
    return det(sides);
}

/// Contribution of an element to N averaged metrics at one of its corners. A negative volume marks flat elements, which
/// have no natural metric.
template <int D, int N>
struct Part {
    std::array<Sym<D>, N> weighted;
    std::array<double, N> volume{};
};
template <int D, int N>
using Parts = std::array<Part<D, N>, D + 1>;
constexpr double no_weight = -1;

template <int D, int N>
Outcome<std::array<Buffer<LogMetric<D>>, N>> means(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                   const Execution& execution, const auto& make) {
    return guarded([&]() -> Outcome<std::array<Buffer<LogMetric<D>>, N>> {
        std::array<Buffer<LogMetric<D>>, N> logs;
        logs.fill(Buffer<LogMetric<D>>(mesh.points.size(), LogMetric<D>{}));
        Buffer<std::array<double, N>> volumes(mesh.points.size(), std::array<double, N>{});
        auto summed = sum_over_balls<Part<D, N>>(mesh, balls, execution, make, [&](VertexId v, const auto& each_part) {
            Part<D, N> sum{{}, volumes[v.index()]};
            for (int n = 0; n < N; ++n) sum.weighted[n] = logs[n][v.index()].l;
            each_part([&](const Part<D, N>& part) {
                for (int n = 0; n < N; ++n) {
                    if (!(part.volume[n] >= 0)) continue;
                    sum.weighted[n] += part.weighted[n];
                    sum.volume[n] += part.volume[n];
                }
            });
            for (int n = 0; n < N; ++n) logs[n][v.index()].l = sum.weighted[n];
            volumes[v.index()] = sum.volume;
        });
        if (!summed) return fail(summed.error());
        auto divided = each(without_progress(execution), volumes.size(), [&](std::size_t v) {
            for (int n = 0; n < N; ++n)
                if (volumes[v][n] > 0) logs[n][v].l *= 1 / volumes[v][n];
        });
        if (!divided) return fail(divided.error());
        return logs;
    });
}

template <int D>
struct CurvedElement {
    Corners<D> corners;
    std::array<Vec<D>, edges_per_simplex<D>> displacements;
};

template <int D>
CurvedElement<D> curved_element(const QuadraticMesh<D>& mesh, std::size_t e) {
    CurvedElement<D> element{corners_of(mesh.linear, e), {}};
    const auto& p = element.corners;
    for (int k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        element.displacements[k] = mesh.mid_nodes[mesh.edges.of_elements[ElementId(e)][k]].point - midpoint(p[i], p[j]);
    }
    return element;
}

template <int D>
using CornerPacks = std::array<VecPack<D>, D + 1>;

template <int D>
[[nodiscard, gnu::always_inline]] inline Pack determinant(const CornerPacks<D>& p) {
    MatPack<D> sides;
    for (int i = 0; i < D; ++i)
        for (int c = 0; c < D; ++c) sides(c, i) = p[i + 1][c] - p[0][c];
    return det(sides);
}

/// Straight elements whose edges at corner v are the tangents of the curved edges there. `are_bent` marks the lanes in
/// which tangents differ from chords.
template <int D>
struct Tangents {
    CornerPacks<D> corners;
    Mask are_bent{};
};
template <int D>
[[nodiscard, gnu::always_inline]] inline Tangents<D> tangents_at(
    int v, const CornerPacks<D>& p, const std::array<VecPack<D>, edges_per_simplex<D>>& displacements) {
    Tangents<D> tangents{p};
    for (int k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        if (i != v && j != v) continue;
        tangents.are_bent |= dot(displacements[k], displacements[k]) != 0;
        for (int c = 0; c < D; ++c) tangents.corners[i == v ? j : i][c] += 4 * displacements[k][c];
    }
    return tangents;
}

template <int D, int N>
[[gnu::always_inline]] inline void put(const SymPack<D>& log_metric, Pack volume, std::size_t begin, int corner,
                                       int form, std::span<Parts<D, N>> parts) {
    Pack trace = log_metric(0, 0);
    for (int i = 1; i < D; ++i) trace += log_metric(i, i);
    const Pack weight = select(abs(trace) < 1e300, volume, packed(no_weight));
    const std::size_t lanes = std::min<std::size_t>(pack_size, parts.size() - begin);
    for (std::size_t lane = 0; lane < lanes; ++lane) parts[begin + lane][corner].volume[form] = weight[lane];
    for (int k = 0; k < sym_size<D>; ++k) {
        const Pack weighted = volume * log_metric.c[k];
        for (std::size_t lane = 0; lane < lanes; ++lane)
            parts[begin + lane][corner].weighted[form].c[k] = weighted[lane];
    }
}

enum MetricForm : std::uint8_t { straight, curved };

template <int D>
[[gnu::always_inline]] inline void parts_of_pack(std::span<const CurvedElement<D>> elements, std::size_t begin,
                                                 const Mat<D>& reference, std::span<Parts<D, 2>> parts) {
    using Element = CurvedElement<D>;
    constexpr double flattened = 0.05;
    CornerPacks<D> p;
    std::array<VecPack<D>, edges_per_simplex<D>> displacements;
    for (int i = 0; i <= D; ++i)
        p[i] = gathered_vec<D>(elements, begin, [&](const Element& e) __attribute__((always_inline)) -> const Vec<D>& {
            return e.corners[i];
        });
    for (int k = 0; k < edges_per_simplex<D>; ++k)
        displacements[k] = gathered_vec<D>(
            elements, begin,
            [&](const Element& e) __attribute__((always_inline)) -> const Vec<D>& { return e.displacements[k]; });
    const Pack volume = determinant<D>(p);
    const RightSingularPack<D> chords = right_singular<D>(natural_frame<D>(p, reference));
    const SymPack<D> of_chords = natural_log_metric<D>(chords);
    for (int v = 0; v <= D; ++v) {
        put<D, 2>(of_chords, abs(volume), begin, v, straight, parts);
        const Tangents<D> tangents = tangents_at<D>(v, p, displacements);
        const Mask bent = tangents.are_bent & (determinant<D>(tangents.corners) / volume > flattened);
        SymPack<D> here = of_chords;
        if (any(bent)) {
            const MatPack<D> frame = natural_frame<D>(tangents.corners, reference);
            const SymPack<D> own =
                natural_log_metric<D>(right_singular_from<D>({times<D>(frame, chords.vectors), chords.vectors}));
            for (int k = 0; k < sym_size<D>; ++k) here.c[k] = select(bent, own.c[k], of_chords.c[k]);
        }
        put<D, 2>(here, abs(volume), begin, v, curved, parts);
    }
}

}  // namespace

template <int D>
Outcome<NaturalLogMetrics<D>> curved_natural_log_metrics(const QuadraticMesh<D>& mesh,
                                                         const Incidence<ElementId>& balls,
                                                         const Execution& execution) {
    const Mat<D> reference = inverse(regular_simplex<D>());
    auto both = means<D, 2>(mesh.linear, balls, execution,
                            [&](std::size_t begin, std::size_t end, std::span<Parts<D, 2>> parts) {
                                std::vector<CurvedElement<D>> elements;
                                elements.reserve(end - begin);
                                for (std::size_t e = begin; e < end; ++e) elements.push_back(curved_element(mesh, e));
                                with_instructions(widest_instructions(), [&]() __attribute__((always_inline)) {
                                    for (std::size_t first = 0; first < elements.size(); first += pack_size)
                                        parts_of_pack<D>(elements, first, reference, parts);
                                });
                            });
    if (!both) return fail(both.error());
    return NaturalLogMetrics<D>{std::move((*both)[straight]), std::move((*both)[curved])};
}

template <int D>
Outcome<Buffer<LogMetric<D>>> natural_log_metrics(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                  const Execution& execution) {
    if constexpr (D == 3)
        if (is_standalone_surface(mesh)) return natural_surface_log_metrics(mesh, execution);
    auto mean =
        means<D, 1>(mesh, balls, execution, [&](std::size_t begin, std::size_t end, std::span<Parts<D, 1>> parts) {
            std::vector<Corners<D>> simplices;
            simplices.reserve(end - begin);
            for (std::size_t e = begin; e < end; ++e) simplices.push_back(corners_of(mesh, e));
            std::vector<LogMetric<D>> logs(simplices.size());
            natural_log_metrics<D>(simplices, logs);
            for (std::size_t i = 0; i < parts.size(); ++i) {
                const double volume = std::abs(determinant<D>(simplices[i]));
                const bool counts = std::isfinite(trace(logs[i].l));
                parts[i].fill({{volume * logs[i].l}, {counts ? volume : no_weight}});
            }
        });
    if (!mean) return fail(mean.error());
    return std::move((*mean)[0]);
}

#define CAMBER_INSTANTIATE(D)                                                                                        \
    template Outcome<Buffer<LogMetric<D>>> natural_log_metrics<D>(const LinearMesh<D>&, const Incidence<ElementId>&, \
                                                                  const Execution&);                                 \
    template Outcome<NaturalLogMetrics<D>> curved_natural_log_metrics<D>(                                            \
        const QuadraticMesh<D>&, const Incidence<ElementId>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
