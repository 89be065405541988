module;
#include <array>
#include <cstddef>
module camber.metric:edge_pack_shorten;
import :edge_wedge;
import :edge_pack_objective;
import :packs;
import camber.core;

/// From near the energy's minimum on to the length's. The Hessian of the length is all but singular along the edge: to
/// learn it from gradients takes a search long. But there the points tell it, of q = l'ᵀ M l': ∂²√q = ∂²q/(2√q) − ∂q
/// ∂qᵀ/(4 q^{3/2}), the first with the metric frozen.
namespace camber {

/// What makes the Hessian of the length regular, as a share of its first part.
inline constexpr double length_stiffness = 0.01;
/// Of a matrix that is further from the identity, by products of its diagonal and its inverse's, steps are not taken.
inline constexpr double max_length_condition = 1e4;

/// H⁻¹ by Cholesky's factors: H is as badly conditioned as a metric.
template <int D>
[[nodiscard, gnu::always_inline]] inline SymPack<D> inverse_of(const SymPack<D>& h) {
    MatPack<D> root;      // H = root rootᵀ
    MatPack<D> inverted;  // root⁻¹
    for (int j = 0; j < D; ++j) {
        Pack pivot = h(j, j);
        for (int k = 0; k < j; ++k) pivot -= root(j, k) * root(j, k);
        root(j, j) = sqrt(max(pivot, 1e-15 * h(j, j)));
        for (int i = j + 1; i < D; ++i) {
            Pack sum = h(i, j);
            for (int k = 0; k < j; ++k) sum -= root(i, k) * root(j, k);
            root(i, j) = sum / root(j, j);
        }
    }
    for (int j = 0; j < D; ++j) {
        inverted(j, j) = 1 / root(j, j);
        for (int i = j + 1; i < D; ++i) {
            Pack sum = packed(0);
            for (int k = j; k < i; ++k) sum -= root(i, k) * inverted(k, j);
            inverted(i, j) = sum / root(i, i);
        }
    }
    SymPack<D> out;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j <= i; ++j) {
            out(i, j) = packed(0);
            for (int k = i; k < D; ++k) out(i, j) += inverted(k, i) * inverted(k, j);
        }
    return out;
}

/// Both parts, point by point, in the unit frame.
template <int D>
struct LengthHessian {
    SymPack<D> frozen{}, spread{};

    /// A point at t of that weight; slope: ∂q.
    [[gnu::always_inline]] inline void add(const ChordFrame<D>& f, const PointPack<D>& point, double weight, double t,
                                           const VecPack<D>& slope) {
        const Pack root = sqrt(point.squared);
        const Pack half = select(root > 0, 0.5 / root, packed(0));
        const Pack by_slope = (2 * weight) * half * half * half;
        const double c = 4 * (1 - 2 * t);
        const Pack by_metric = (2 * c * c * weight) * half;
        const SymPack<D> metric = composed(point.log_metric.vectors, point.values);
        for (int i = 0; i < D; ++i) {
            const Pack metric_row = by_metric * f.scale[i];
            const Pack slope_row = by_slope * slope[i];
            for (int j = 0; j <= i; ++j) {
                frozen(i, j) += metric_row * f.scale[j] * metric(i, j);
                spread(i, j) += slope_row * slope[j];
            }
        }
    }

    /// Its inverse; where it is not positive that of the energy's, of a curve as long as that at constant speed.
    [[nodiscard, gnu::always_inline]] inline SymPack<D> inverse(Pack length) const {
        SymPack<D> h;
        for (int k = 0; k < sym_size<D>; ++k) h.c[k] = (1 + length_stiffness) * frozen.c[k] - spread.c[k];
        SymPack<D> out = inverse_of(h);
        Mask positive(-1);
        for (int i = 0; i < D; ++i) positive &= (h(i, i) > 0) & (h(i, i) * out(i, i) < max_length_condition);
        for (int i = 0; i < D; ++i)
            for (int j = 0; j <= i; ++j) out(i, j) = select(positive, out(i, j), i == j ? 2 * length : packed(0));
        return out;
    }
};

}  // namespace camber
