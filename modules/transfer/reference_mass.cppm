module;
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>
module camber.transfer:reference_mass;
import camber.core;
import camber.bezier;
import :rule;
import :simplex;

namespace camber {

/// The entries i ≥ j of a symmetric matrix of N rows, row after row.
template <int N>
inline constexpr int packed_size = N * (N + 1) / 2;
[[nodiscard]] constexpr int packed_index(int i, int j) { return i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i; }

/// ∫ φ_i φ_j |det J| over elements, by a quadrature of which all are sums with positive weights.
template <int D, int K>
class ReferenceMass {
  public:
    static constexpr int nodes = field_nodes<D, K>;
    using Matrix = std::array<double, packed_size<nodes>>;
    using Functions = std::array<double, nodes>;

    explicit ReferenceMass(int points_a_direction);

    std::vector<RulePoint<D>> rule;
    std::vector<Functions> functions;  ///< φ at the points
    Matrix matrix{};                   ///< of the reference element: that of a straight one by |det J|
    double low = 1, high = 1;          ///< eigenvalues of diag(M)⁻¹ M are between

    /// Of an element that is not straight, with the least and the largest det J at the points.
    struct Curved {
        Matrix matrix{};
        double least = 0, largest = 0;
    };
    [[nodiscard]] Curved curved(const ElementMap<D>& map) const;
    /// Bounds of the eigenvalues of diag(M)⁻¹ M of an element.
    [[nodiscard]] static std::array<double, 2> eigenvalues(const Matrix& matrix);
};

}  // namespace camber
