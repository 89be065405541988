module;
#include <array>
#include <cstddef>
export module camber.surface:cubic;
import camber.core;
import camber.bezier;

export namespace camber {

/// A P3 K-simplex in D dimensions, K = 1 or 2, by its Bézier points in the order of multi_indices<3, K>:
/// 30 21 12 03, and 300 210 201 120 111 102 030 021 012 003.
template <int K, int D>
struct CubicSimplex {
    std::array<Vec<D>, node_count<3, K>> control{};

    [[nodiscard]] constexpr const Vec<D>& at(const MultiIndex<K>& alpha) const {
        return control[position<3, K>(alpha)];
    }
    [[nodiscard]] constexpr Vec<D>& at(const MultiIndex<K>& alpha) { return control[position<3, K>(alpha)]; }
    friend bool operator==(const CubicSimplex&, const CubicSimplex&) = default;
};

/// A cubic simplex at one place: the point, and its derivatives by ξ_a with ξ_0 = 1 − Σ ξ_a: first[a−1] = F_a and
/// second[a−1][b−1] = F_ab.
template <int K, int D>
struct CubicExpansion {
    Vec<D> point;
    std::array<Vec<D>, K> first{};
    std::array<std::array<Vec<D>, K>, K> second{};
};

/// De Casteljau: after r steps the net b^r holds the derivatives, ∂_i∂_j F = 6 b^1_{e_i+e_j}, ∂_i F = 3 b^2_{e_i}.
template <int K, int D>
[[nodiscard]] CubicExpansion<K, D> expand(const CubicSimplex<K, D>& simplex, const Barycentric<K>& xi);

/// F(ξ) = Σ B_α(ξ) P_α, of degree 3.
template <int K, int D>
[[nodiscard]] Vec<D> point_at(const CubicSimplex<K, D>& simplex, const Barycentric<K>& xi);

/// A place on a cubic simplex.
template <int K, int D>
struct CubicFoot {
    Barycentric<K> xi{};
    Vec<D> point;
    double distance_squared = 0;
};

/// A local minimum of the distance from p over the simplex: Newton's method with the constraints kept, from `start`.
/// Never farther from p than the start is.
template <int K, int D>
[[nodiscard]] CubicFoot<K, D> closest_from(const CubicSimplex<K, D>& simplex, const Vec<D>& p,
                                           const Barycentric<K>& start);

/// The nearest place: where the squared distance is convex over the simplex, as from near a simplex that bends little,
/// the one minimum; else the best of those from the three nearest points of the lattice of quarters.
template <int K, int D>
[[nodiscard]] CubicFoot<K, D> closest_on(const CubicSimplex<K, D>& simplex, const Vec<D>& p);

/// The cubic from a to b with the given tangents (any length, both along a → b) whose handles are those of a circle:
/// |e| (2/3)/(1 + cos φ), φ the angle of chord and tangent. Error O(h⁴) in the middle, O(h⁶) on circles. A tangent that
/// leaves the chord by more than 75° is replaced by the chord.
template <int D>
[[nodiscard]] CubicSimplex<1, D> cubic_edge(const Vec<D>& a, const Vec<D>& tangent_a, const Vec<D>& tangent_b,
                                            const Vec<D>& b);

/// The classical middle point of a cubic triangle with its nine rim points set, exact on quadratics:
/// b_111 = ¼ Σ edge points − ⅙ Σ vertices.
template <int D>
[[nodiscard]] Vec<D> classical_centre(const CubicSimplex<2, D>& triangle);

}  // namespace camber
