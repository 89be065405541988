module;
#include <vector>
export module camber.interpolation:gauss_jacobi;

export namespace camber {

/// ∫_0^1 f(t) (1 − t)^power dt ≈ Σ weight_i f(node_i), exact for polynomials of degree 2n − 1; nodes rise.
struct GaussJacobi {
    std::vector<double> nodes, weights;
};

/// The rule of n ≥ 1 nodes: Newton's method on the Jacobi polynomial P_n^(power, 0), found roots deflated.
[[nodiscard]] GaussJacobi gauss_jacobi(int n, int power);

}  // namespace camber
