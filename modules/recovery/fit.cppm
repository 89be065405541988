module;
#include <array>
#include <cstddef>
#include <span>
#include <vector>
module camber.recovery:fit;
import camber.core;
import :monomials;

namespace camber {

/// A polynomial by its coefficients of the monomials of degree at most P in y, in their order.
template <int D, int P>
using Coefficients = std::array<double, monomials_up_to<D>(P)>;

/// The weighted least squares of polynomials in whitened coordinates y = B (x − vertex) over some nodes: min Σ w² (p(y)
/// − u)², w = 1/(core + |y|). The normal matrix is the table of the moments Σ w² y^{α+β}, of which there are a quarter
/// as many as entries; factorised once for all fields. Monomials rise by degree, so its leading blocks are the factors
/// of lower degrees.
template <int D, int P>
class Fit {
  public:
    static constexpr std::size_t size = monomials_up_to<D>(P);
    static constexpr double nothing_left = 1e-30;

    /// offsets: x − vertex, of the vertex's own first; noise: that of the coordinates.
    void place(std::span<const Vec<D>> offsets, double noise, double core);

    [[nodiscard]] const Mat<D>& whitened_by() const { return whitened_by_; }
    [[nodiscard]] std::size_t nodes() const { return nodes_; }
    /// Of the monomials of that degree and below: the least share of one's squared length that no combination of those
    /// before it has. Small where the nodes hardly tell them apart, 0 where they do not.
    [[nodiscard]] double independence(int degree) const { return independence_[static_cast<std::size_t>(degree)]; }

    /// The polynomial of that degree of values, one a node; coefficients of higher degrees are 0. One step of iterative
    /// refinement gives the digits that the normal equations would lose.
    [[nodiscard]] Coefficients<D, P> solve(std::span<const double> values, int degree);

  private:
    using Lanes = std::array<double, pack_size>;
    struct Block {
        std::array<Lanes, D> y{};
        Lanes squared_weight{};  ///< 0 where there is no node
    };

    void sum_moments();
    void factorise();
    void correct(Coefficients<D, P>& c, std::size_t unknowns) const;

    Mat<D> whitened_by_;
    std::size_t nodes_ = 0;
    std::vector<Block> blocks_;
    std::vector<Lanes> values_;
    std::array<double, monomials_up_to<D>(2 * P)> moments_{};
    std::array<double, size> scale_{};  ///< of each monomial, so that the matrix has 1 on its diagonal
    std::array<std::array<double, size>, size> factor_{};  ///< U, the upper triangle; 1 / U_ii on the diagonal
    std::array<double, P + 1> independence_{};
};

}  // namespace camber
