module;
#include <cstddef>
module camber.metric:quadratic_root;
import camber.core;
import :curved_simplex;
import :element_frame;

namespace camber {

/// A solution of F(ξ) = P_0 + r, near which it is known to be.
template <int D>
struct Root {
    Barycentrics<D> xi{};
    bool is_proven = false;
    double radius = 0;      ///< exactly one solution lies within it of ξ, by the largest of ξ_1 … ξ_D
    double uniqueness = 0;  ///< and there is no other within this

    /// How far below zero a coordinate may be of a point of the element: what rounding may have done to it.
    [[nodiscard]] double tolerance() const {
        constexpr double least = 1e-12;
        return D * radius > least ? D * radius : least;
    }
    [[nodiscard]] bool is_inside() const {
        if (!is_proven) return false;
        for (const double u : xi)
            if (!(u >= -tolerance())) return false;
        return true;
    }
};

/// What is known of ξ as a solution, with an approximate inverse of the Jacobian: Kantorovich's theorem, in coordinates
/// in which a thin element that bends away by many thicknesses looks round.
template <int D>
[[nodiscard]] Root<D> proven_root(const CurvedSimplex<D, D>& element, const Vec<D>& r, const Barycentrics<D>& xi,
                                  const Mat<D>& inverse);

/// Where Newton's method from ξ ends; where it does not, its first iterate: the element's linear map there.
template <int D>
struct RootIterate {
    Barycentrics<D> xi{};
    Mat<D> inverse;  ///< of the Jacobian a step before
    bool has_converged = false;
};
template <int D>
[[nodiscard]] RootIterate<D> newton(const CurvedSimplex<D, D>& element, const Vec<D>& r, const Barycentrics<D>& from);
/// The same with its proof.
template <int D>
[[nodiscard]] Root<D> newton_root(const CurvedSimplex<D, D>& element, const Vec<D>& r, const Barycentrics<D>& from);

/// False where all Bézier points of the element lie on one side of the point: a quick look.
template <int D>
[[nodiscard]] bool may_hold(const CurvedSimplex<D, D>& element, const Vec<D>& r);

/// Whether a point lies in an element.
enum class Membership { inside, not_inside, undecided };
template <int D>
struct Found {
    Membership membership = Membership::undecided;
    Root<D> root;
};

/// By bisection of the element: of each part either all Bézier points lie on one side of the point in some direction,
/// or Newton's method finds a solution from its centre; one outside whose ball of uniqueness holds the part leaves none
/// in it.
template <int D>
[[nodiscard]] Found<D> find_in_element(const CurvedSimplex<D, D>& element, const Vec<D>& r);

}  // namespace camber
