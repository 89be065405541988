module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
module camber.metric:edge_frame;
import :back_mesh;
import :edge_accuracy;
import :packs;
import camber.core;

/// What eight edges see of a field, in the frame of its axes at their middles.
namespace camber {

template <int D>
using GradientPack = std::array<SymPack<D>, D>;

/// The field as the straight edge sees it, at one of its ends or at its middle.
template <int D>
struct EdgeSight {
    SymPack<D> log_metric;     ///< log M̂, M̂ = Fᵀ M F
    GradientPack<D> gradient;  ///< in the reference
    MatPack<D> jacobian;       ///< F
    SymPack<D> change = {};    ///< of the middle: of log M̂ from one end to the other
};

/// The field at an end as the straight edge sees it, where that is bent.
template <int D>
[[gnu::always_inline]] inline void see_through_map(EdgeSight<D>& sight, Mask bent) {
    const SeenPack<D> seen = seen_through<D>(sight.log_metric, sight.jacobian);
    GradientPack<D> turned;
    for (int j = 0; j < D; ++j) turned[j] = congruence_transposed(seen.axes, sight.gradient[j]);
    for (int i = 0; i < D; ++i)
        for (int k = 0; k < sym_size<D>; ++k) {
            Pack along = sight.jacobian(0, i) * turned[0].c[k];
            for (int j = 1; j < D; ++j) along += sight.jacobian(j, i) * turned[j].c[k];
            sight.gradient[i].c[k] = select(bent, along, sight.gradient[i].c[k]);
        }
    for (int k = 0; k < sym_size<D>; ++k)
        sight.log_metric.c[k] = select(bent, seen.log_metric.c[k], sight.log_metric.c[k]);
}

template <int D>
[[nodiscard, gnu::always_inline]] inline EdgeSight<D> seen_from_end(std::span<const EdgeEnds<D>> edges,
                                                                    std::size_t begin, EdgeEnd<D> EdgeEnds<D>::* end) {
    using Ends = EdgeEnds<D>;
    EdgeSight<D> seen{};
    seen.log_metric = gathered_sym<D>(edges, begin, [&](const Ends& e) __attribute__((always_inline)) -> const Sym<D>& {
        return (e.*end).log_metric.l;
    });
    for (int i = 0; i < D; ++i)
        seen.gradient[i] = gathered_sym<D>(
            edges, begin,
            [&](const Ends& e) __attribute__((always_inline)) -> const Sym<D>& { return (e.*end).gradient[i]; });
    seen.jacobian = gathered_mat<D>(
        edges, begin, [&](const Ends& e) __attribute__((always_inline)) -> const Mat<D>& { return (e.*end).jacobian; });
    return seen;
}
/// Whether all lanes have one end, as edges from one point have: it need not be gathered.
template <int D>
[[nodiscard]] inline bool is_one_end(std::span<const EndSights<D>> edges, std::size_t begin, std::size_t end) {
    const std::size_t last = std::min<std::size_t>(begin + pack_size, edges.size());
    for (std::size_t lane = begin + 1; lane < last; ++lane)
        if (edges[lane][end].gradient != edges[begin][end].gradient ||
            edges[lane][end].log_metric != edges[begin][end].log_metric)
            return false;
    return true;
}
template <int D>
[[nodiscard, gnu::always_inline]] inline SymPack<D> in_all_lanes(const Sym<D>& one) {
    SymPack<D> all;
    for (int k = 0; k < sym_size<D>; ++k) all.c[k] = packed(one.c[k]);
    return all;
}
/// Of edges that nothing of the mesh itself bends: F is the identity.
template <int D>
[[nodiscard, gnu::always_inline]] inline EdgeSight<D> seen_from_end(std::span<const EndSights<D>> edges,
                                                                    std::size_t begin, std::size_t end) {
    using Ends = EndSights<D>;
    EdgeSight<D> seen{};
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) seen.jacobian(i, j) = packed(i == j ? 1 : 0);
    if (is_one_end(edges, begin, end)) {
        const EndSight<D>& one = edges[begin][end];
        seen.log_metric = in_all_lanes(one.log_metric->l);
        for (int i = 0; i < D; ++i) seen.gradient[i] = in_all_lanes((*one.gradient)[i]);
        return seen;
    }
    seen.log_metric = gathered_sym<D>(edges, begin, [&](const Ends& e) __attribute__((always_inline)) -> const Sym<D>& {
        return e[end].log_metric->l;
    });
    for (int i = 0; i < D; ++i)
        seen.gradient[i] = gathered_sym<D>(
            edges, begin,
            [&](const Ends& e) __attribute__((always_inline)) -> const Sym<D>& { return (*e[end].gradient)[i]; });
    return seen;
}

/// The mean of both ends.
template <int D>
[[nodiscard, gnu::always_inline]] inline EdgeSight<D> middle_of(EdgeSight<D> a, const EdgeSight<D>& b) {
    for (int k = 0; k < sym_size<D>; ++k) {
        a.change.c[k] = b.log_metric.c[k] - a.log_metric.c[k];
        a.log_metric.c[k] = (a.log_metric.c[k] + b.log_metric.c[k]) / 2;
        for (int i = 0; i < D; ++i) a.gradient[i].c[k] = (a.gradient[i].c[k] + b.gradient[i].c[k]) / 2;
    }
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) a.jacobian(i, j) = (a.jacobian(i, j) + b.jacobian(i, j)) / 2;
    return a;
}
template <int D>
[[nodiscard, gnu::always_inline]] inline EdgeSight<D> seen_from_middle(std::span<const EdgeEnds<D>> edges,
                                                                       std::size_t begin) {
    using Ends = EdgeEnds<D>;
    const Pack bent =
        gathered(edges, begin, [](const Ends& e) __attribute__((always_inline)) { return e.is_bent ? 1.0 : 0.0; });
    EdgeSight<D> a = seen_from_end(edges, begin, &Ends::a);
    EdgeSight<D> b = seen_from_end(edges, begin, &Ends::b);
    if (any(bent != 0)) {
        see_through_map(a, bent != 0);
        see_through_map(b, bent != 0);
    }
    return middle_of(a, b);
}
template <int D>
[[nodiscard, gnu::always_inline]] inline EdgeSight<D> seen_from_middle(std::span<const EndSights<D>> edges,
                                                                       std::size_t begin) {
    return middle_of(seen_from_end(edges, begin, 0), seen_from_end(edges, begin, 1));
}

/// ∂_v of a field with this gradient.
template <int D>
[[nodiscard, gnu::always_inline]] inline SymPack<D> derivative(const GradientPack<D>& gradient, const VecPack<D>& v) {
    SymPack<D> along;
    for (int k = 0; k < sym_size<D>; ++k) {
        along.c[k] = v[0] * gradient[0].c[k];
        for (int a = 1; a < D; ++a) along.c[k] += v[a] * gradient[a].c[k];
    }
    return along;
}

/// aᵀ m b.
template <int D>
[[nodiscard, gnu::always_inline]] inline Pack bilinear(const SymPack<D>& m, const VecPack<D>& a, const VecPack<D>& b) {
    Pack sum = packed(0);
    for (int i = 0; i < D; ++i) {
        Pack row = m(i, 0) * b[0];
        for (int j = 1; j < D; ++j) row += m(i, j) * b[j];
        sum += a[i] * row;
    }
    return sum;
}

/// What an edge sees in the frame of the axes at its middle.
template <int D>
struct EdgeFrame {
    EigenPack<D> log_metric;
    VecPack<D> sizes;                        ///< e^{λ_i}
    VecPack<D> chord;                        ///< c
    SymPack<D> along_chord;                  ///< A
    std::array<std::array<Pack, D>, D> x{};  ///< x_ij = λ_i − λ_j
    SymPack<D> likeness;                     ///< K_ij
};

template <int D>
[[nodiscard, gnu::always_inline]] inline EdgeFrame<D> edge_frame(const VecPack<D>& chord, const EdgeSight<D>& middle,
                                                                 ChangeAlong change) {
    EdgeFrame<D> f{};
    f.log_metric = eigen_system<D>(middle.log_metric);
    f.chord = times_transposed(f.log_metric.vectors, chord);
    const SymPack<D> along =  // ∂_e L
        change == ChangeAlong::of_ends ? middle.change : derivative<D>(middle.gradient, chord);
    f.along_chord = congruence_transposed(f.log_metric.vectors, along);
    for (int i = 0; i < D; ++i) {
        f.sizes[i] = exp(f.log_metric.values[i]);
        for (int j = 0; j < D; ++j) f.x[i][j] = f.log_metric.values[i] - f.log_metric.values[j];
        for (int j = 0; j < i; ++j) f.likeness(i, j) = exp(-abs(f.x[i][j]));
        f.likeness(i, i) = packed(1);
    }
    return f;
}
template <int D>
[[nodiscard, gnu::always_inline]] inline Pack metric_length(const EdgeFrame<D>& f, const VecPack<D>& v) {
    Pack q = f.sizes[0] * v[0] * v[0];
    for (int j = 1; j < D; ++j) q += f.sizes[j] * v[j] * v[j];
    return sqrt(q);
}
}  // namespace camber
