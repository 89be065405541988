module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>
module camber.transfer:mass_matrix;
import camber.core;
import camber.bezier;
import :key_table;
import :reference_mass;
import :simplex;

namespace camber {

/// The mass matrix of the fields of degree K over some elements of a mesh, for those of their nodes that are free: as
/// the elements' matrices, of which a straight one is a number. It is symmetric positive definite where no element
/// vanishes.
template <int D, int K>
class MassMatrix {
  public:
    static constexpr int nodes = field_nodes<D, K>;
    using Local = std::array<std::uint32_t, nodes>;

    /// `is_free` of each node of the mesh. Errors: memory, stopped.
    [[nodiscard]] static Outcome<MassMatrix> make(const QuadraticMesh<D>& mesh,
                                                  const std::vector<std::uint32_t>& elements,
                                                  const Buffer<std::uint8_t>& is_free,
                                                  const ReferenceMass<D, K>& reference, const Execution& execution);

    [[nodiscard]] std::size_t size() const { return node_of_.size(); }
    /// The node of each unknown.
    [[nodiscard]] std::span<const std::uint32_t> node_of() const { return node_of_; }
    /// The unknowns of the nodes of element number `slot` of those given; `none` where a node is not free.
    [[nodiscard]] const Local& unknowns(std::size_t slot) const { return unknowns_[slot]; }
    [[nodiscard]] std::size_t turned() const { return turned_; }
    /// ∫ φ_i over element number `slot`: the sums of its matrix's rows, since the φ sum up to 1.
    [[nodiscard]] std::array<double, nodes> integrals(std::size_t slot) const {
        std::array<double, nodes> one{};
        one.fill(1);
        return local_product(slot, one);
    }

    /// Σ over the elements of what `local(slot)` gives for their nodes, at each unknown in the order of the elements.
    template <class LocalOf>
    [[nodiscard]] Outcome<Done> assemble(const LocalOf& local, std::span<double> out, const Execution& execution);

    /// x with M x = r, by Chebyshev's iteration with the diagonal: the eigenvalues of diag(M)⁻¹ M are known beforehand
    /// (Wathen 1987; Wathen and Rees 2009), so it takes no inner products, and what is left of the error is a known
    /// share (10⁻¹⁰) in each patch by itself, of whatever size its elements are. `r` becomes the residual.
    [[nodiscard]] Outcome<Done> solve(std::span<double> r, std::span<double> x, const Execution& execution);

  private:
    void number(const QuadraticMesh<D>& mesh, const std::vector<std::uint32_t>& elements,
                const Buffer<std::uint8_t>& is_free);
    [[nodiscard]] Outcome<Done> weigh(const QuadraticMesh<D>& mesh, const std::vector<std::uint32_t>& elements,
                                      const ReferenceMass<D, K>& reference, const Execution& execution);
    [[nodiscard]] std::array<double, nodes> product(std::size_t slot, std::span<const double> x) const;
    [[nodiscard]] std::array<double, nodes> local_product(std::size_t slot, const std::array<double, nodes>& in) const;
    [[nodiscard]] double diagonal(std::size_t slot, int i) const;

    std::vector<std::uint32_t> node_of_;
    Buffer<Local> unknowns_;
    Buffer<double> scales_;            ///< of each element: |det J| where it is straight
    Buffer<std::uint32_t> curved_at_;  ///< of each element: its matrix among those of the curved ones, or `none`
    Buffer<typename ReferenceMass<D, K>::Matrix> curved_;
    std::array<double, nodes * nodes> straight_{};  ///< the reference element's, as a square
    Buffer<std::uint32_t> offsets_, items_;         ///< of each unknown: slot · nodes + local node, rising
    Buffer<double> inverse_diagonal_;
    Buffer<std::array<double, nodes>> products_;
    double low_ = 1, high_ = 1;
    std::size_t turned_ = 0;
};

template <int D, int K>
template <class LocalOf>
Outcome<Done> MassMatrix<D, K>::assemble(const LocalOf& local, std::span<double> out, const Execution& execution) {
    auto done = each(execution, unknowns_.size(), [&](std::size_t slot) { products_[slot] = local(slot); });
    if (!done) return done;
    return each(
        execution, size(),
        [&](std::size_t u) {
            double sum = 0;
            for (std::uint32_t k = offsets_[u]; k < offsets_[u + 1]; ++k)
                sum += products_[items_[k] / nodes][items_[k] % nodes];
            out[u] = sum;
        },
        1024);
}

}  // namespace camber
