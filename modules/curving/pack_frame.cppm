module;
#include <array>
#include <cstddef>
export module camber.curving:pack_frame;
import camber.core;
import :lattice_polynomial;

/// Eight curved elements at once as maps from the reference simplex, in which what is known of a solution is told.
namespace camber {

/// A Jacobian with its inverse, which is 0 where the determinant is next to 0.
template <int D>
struct PackJacobian {
    std::array<PackVec<D>, D> inverse;  ///< rows
    Pack det;

    [[gnu::always_inline]] explicit PackJacobian(const std::array<PackVec<D>, D>& columns) {
        if constexpr (D == 2) {
            det = columns[0][0] * columns[1][1] - columns[0][1] * columns[1][0];
            inverse = {PackVec<2>{columns[1][1], -columns[1][0]}, PackVec<2>{-columns[0][1], columns[0][0]}};
        } else {
            inverse = {cross(columns[1], columns[2]), cross(columns[2], columns[0]), cross(columns[0], columns[1])};
            det = columns[0][0] * inverse[0][0] + columns[0][1] * inverse[0][1] + columns[0][2] * inverse[0][2];
        }
        Pack most = packed(1);
        for (const auto& column : columns) {
            Pack square = column[0] * column[0];
            for (int i = 1; i < D; ++i) square += column[i] * column[i];
            most = most * sqrt(square);
        }
        const Mask is_flat = abs(det) <= flat * most;
        const Pack over = select(is_flat, packed(0), 1 / select(is_flat, packed(1), det));
        for (auto& row : inverse)
            for (Pack& x : row) x = x * over;
    }
    /// J⁻¹ v, and J⁻ᵀ g.
    [[nodiscard, gnu::always_inline]] PackVec<D> pulled_back(const PackVec<D>& v) const {
        PackVec<D> out;
        for (int a = 0; a < D; ++a) {
            out[a] = inverse[a][0] * v[0];
            for (int i = 1; i < D; ++i) out[a] += inverse[a][i] * v[i];
        }
        return out;
    }
    [[nodiscard, gnu::always_inline]] PackVec<D> in_space(const PackVec<D>& g) const {
        PackVec<D> out;
        for (int i = 0; i < D; ++i) {
            out[i] = inverse[0][i] * g[0];
            for (int a = 1; a < D; ++a) out[i] += inverse[a][i] * g[a];
        }
        return out;
    }

  private:
    static constexpr double flat = 1e-13;  // of what its columns could span

    [[gnu::always_inline]] static PackVec<3> cross(const PackVec<3>& a, const PackVec<3>& b) {
        return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    }
};

/// F(ξ) = Σ λ_v x_v + Σ 4 λ_i λ_j f of the edge from i to j: J is linear, and F(ξ + s) − F(ξ) = J(ξ + s/2) s.
template <int D>
class PackFrame {
  public:
    /// axes[a]: x_{a + 1} − x_0.
    [[gnu::always_inline]] PackFrame(const std::array<PackVec<D>, D>& axes,
                                     const std::array<PackVec<D>, edges_per_simplex<D>>& offsets)
        : first_(axes) {
        for (int e = 0; e < edges_per_simplex<D>; ++e) {
            const auto [i, j] = local_edges<D>[e];
            for (int k = 0; k < D; ++k) {
                const Pack f = 4 * offsets[e][k];
                if (i == 0 || j == 0) {  // λ_0 λ_v = (1 − Σ ξ) ξ_v
                    const int v = i + j - 1;
                    first_[v][k] += f;
                    for (int b = 0; b < D; ++b) {
                        second_[v][b][k] -= f;
                        second_[b][v][k] -= f;
                    }
                } else {
                    second_[i - 1][j - 1][k] += f;
                    second_[j - 1][i - 1][k] += f;
                }
            }
        }
    }

    [[nodiscard, gnu::always_inline]] PackJacobian<D> jacobian(const PackVec<D>& at) const {
        return PackJacobian<D>(columns(at));
    }

    /// Where F is displaced by δ from F(ξ): ξ + s with J(ξ + s/2) s = δ by Newton's method, and J there; each lane
    /// stops by itself. Where δ leads to a fold of F or beyond it F goes on by its tangent at ξ.
    struct Place {
        PackVec<D> at;
        PackJacobian<D> jacobian;
    };
    [[nodiscard, gnu::always_inline]] Place displaced(const PackVec<D>& from, const PackJacobian<D>& there,
                                                      const PackVec<D>& delta) const {
        const PackVec<D> tangent = there.pulled_back(delta);
        PackVec<D> s = tangent;
        Place place{from, there};
        Mask is_far;
        for (int step = 0;; ++step) {
            place.jacobian = jacobian(plus(from, s));
            const PackVec<D> correction = place.jacobian.pulled_back(residual(from, s, delta));
            place.at = plus(plus(from, s), correction);
            is_far = largest(correction) > near;
            if (step == newton_steps || !any(is_far)) break;
            for (int i = 0; i < D; ++i) s[i] = select(is_far, s[i] + correction[i], s[i]);
        }
        const Mask is_beyond = is_far | (place.jacobian.det * there.det < least_ratio * there.det * there.det);
        for (int i = 0; i < D; ++i) {
            place.at[i] = select(is_beyond, from[i] + tangent[i], place.at[i]);
            for (int k = 0; k < D; ++k)
                place.jacobian.inverse[i][k] = select(is_beyond, there.inverse[i][k], place.jacobian.inverse[i][k]);
        }
        return place;
    }

  private:
    static constexpr int newton_steps = 4;
    /// The last correction is no larger, in reference coordinates; the error that is left is of its square.
    static constexpr double near = 1e-3;
    /// Of det J to where the displacement begins.
    static constexpr double least_ratio = 0.1;

    [[gnu::always_inline]] static Pack largest(const PackVec<D>& v) {
        Pack most = abs(v[0]);
        for (int i = 1; i < D; ++i) most = max(most, abs(v[i]));
        return most;
    }

    [[gnu::always_inline]] static PackVec<D> plus(PackVec<D> a, const PackVec<D>& b) {
        for (int i = 0; i < D; ++i) a[i] += b[i];
        return a;
    }
    [[nodiscard, gnu::always_inline]] std::array<PackVec<D>, D> columns(const PackVec<D>& at) const {
        std::array<PackVec<D>, D> out = first_;
        for (int a = 0; a < D; ++a)
            for (int b = 0; b < D; ++b)
                for (int k = 0; k < D; ++k) out[a][k] += second_[a][b][k] * at[b];
        return out;
    }
    /// δ − (F(ξ + s) − F(ξ)).
    [[nodiscard, gnu::always_inline]] PackVec<D> residual(const PackVec<D>& from, const PackVec<D>& s,
                                                          PackVec<D> delta) const {
        PackVec<D> half;
        for (int i = 0; i < D; ++i) half[i] = from[i] + 0.5 * s[i];
        const auto chord = columns(half);
        for (int i = 0; i < D; ++i)
            for (int a = 0; a < D; ++a) delta[i] -= chord[a][i] * s[a];
        return delta;
    }

    std::array<PackVec<D>, D> first_;                    // columns of J at 0
    std::array<std::array<PackVec<D>, D>, D> second_{};  // ∂²F/∂ξ_a∂ξ_b
};

}  // namespace camber
