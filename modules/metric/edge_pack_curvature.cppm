module;
#include <array>
#include <cstddef>
module camber.metric:edge_pack_curvature;
import camber.core;
import :edge_pack_lanes;
import :edge_pack_objective;
import :edge_wedge;
import :packs;

/// The energy's Hessian before a search has met it: with the metric frozen it is the identity, and where log M changes
/// much within the shell steps by that are far too long. The energy is ∫ |r|² of r = exp(L/2) l', and 2 ∫ ∂rᵀ ∂r
/// (Gauss and Newton) takes in that the curve bulges into another metric. By the middle of the chord, where L is
/// diagonal in the frame and l' does not change: ∂r = 4t(1−t) J, J_km = ½ Σ_i F_ki (∂_m L)_ki c_i, with the divided
/// differences F of exp(x/2).
namespace camber {

/// 2 ∫ (4t(1−t))² dt = 16/15, twice: where L keeps its axes r·∂²r, which is left out, is as much again (e^{gs} has g²,
/// of which Gauss and Newton see a half).
inline constexpr double bulge_curvature = 2 * 16.0 / 15;

/// F_ij = (e^{λ_i/2} − e^{λ_j/2})/(λ_i/2 − λ_j/2) at the chord's middle.
template <int D>
[[nodiscard, gnu::always_inline]] inline SymPack<D> divided_roots(const ChordFrame<D>& f) {
    VecPack<D> root;
    VecPack<D> half;
    for (int i = 0; i < D; ++i) {
        root[i] = 1 / (unit_offset * f.scale[i]);
        half[i] = 0.5 * f.log_metric(i, i) + 0.25 * f.change(i, i);
    }
    SymPack<D> divided;
    for (int i = 0; i < D; ++i) {
        divided(i, i) = root[i];
        for (int j = 0; j < i; ++j) {
            const Pack x = half[i] - half[j];
            const Mask near = abs(x) < 1e-3;
            const Pack apart = (root[i] - root[j]) / select(near, packed(1), x);
            divided(i, j) = select(near, 0.5 * (root[i] + root[j]), apart);
        }
    }
    return divided;
}

/// J, in the unit frame.
template <int D>
[[nodiscard, gnu::always_inline]] inline MatPack<D> bulge_jacobian(const ChordFrame<D>& f, const WedgePack<D>& w) {
    const SymPack<D> divided = divided_roots(f);
    MatPack<D> jacobian;
    const auto add = [&](const SymPack<D>& change, const VecPack<D>& rise) __attribute__((always_inline)) {
        for (int k = 0; k < D; ++k) {
            Pack sum = divided(k, 0) * change(k, 0) * f.chord[0];
            for (int i = 1; i < D; ++i) sum += divided(k, i) * change(k, i) * f.chord[i];
            for (int m = 0; m < D; ++m) jacobian(k, m) += 0.5 * sum * rise[m];
        }
    };
    add(f.change, w.rise_b);
    for (int n = 0; n < D - 1; ++n) add(w.change[n], w.rise[n]);
    return jacobian;
}

/// Of a matrix that is not less than the identity, by cofactors.
template <int D>
[[nodiscard, gnu::always_inline]] inline SymPack<D> inverse_by_cofactors(const SymPack<D>& h) {
    SymPack<D> out;
    Pack determinant;
    if constexpr (D == 2) {
        out(0, 0) = h(1, 1);
        out(1, 0) = -h(1, 0);
        out(1, 1) = h(0, 0);
        determinant = h(0, 0) * h(1, 1) - h(1, 0) * h(1, 0);
    } else {
        out(0, 0) = h(1, 1) * h(2, 2) - h(2, 1) * h(2, 1);
        out(1, 0) = h(2, 1) * h(2, 0) - h(1, 0) * h(2, 2);
        out(2, 0) = h(1, 0) * h(2, 1) - h(1, 1) * h(2, 0);
        out(1, 1) = h(0, 0) * h(2, 2) - h(2, 0) * h(2, 0);
        out(2, 1) = h(1, 0) * h(2, 0) - h(0, 0) * h(2, 1);
        out(2, 2) = h(0, 0) * h(1, 1) - h(1, 0) * h(1, 0);
        determinant = h(0, 0) * out(0, 0) + h(1, 0) * out(1, 0) + h(2, 0) * out(2, 0);
    }
    const Pack scale = 1 / determinant;
    for (int k = 0; k < sym_size<D>; ++k) out.c[k] *= scale;
    return out;
}

/// Of a curvature above this cofactors keep too few digits: steps begin by the identity.
inline constexpr double max_bulge_curvature = 1e6;

/// H⁻¹ in that wedge.
template <int D>
[[nodiscard, gnu::always_inline]] inline SymPack<D> inverse_hessian_at_chord(const ChordFrame<D>& f,
                                                                             const WedgePack<D>& w) {
    const MatPack<D> jacobian = bulge_jacobian(f, w);
    SymPack<D> h;
    Pack trace = packed(0);
    for (int i = 0; i < D; ++i) {
        for (int j = 0; j < i; ++j) h(i, j) = bulge_curvature * dot(jacobian.column[i], jacobian.column[j]);
        h(i, i) = 1 + bulge_curvature * dot(jacobian.column[i], jacobian.column[i]);
        trace += h(i, i);
    }
    SymPack<D> inverse = multiple_of_identity<D>(packed(1));
    choose(trace < max_bulge_curvature, inverse, inverse_by_cofactors(h));
    return inverse;
}

}  // namespace camber
