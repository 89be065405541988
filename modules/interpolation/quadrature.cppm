module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
module camber.interpolation:quadrature;
import camber.core;
import camber.bezier;
import :collapsed_rule;
import :error;
import :piece;

namespace camber {

using Squares = std::array<double, Integrals::quantities>;

/// The rules by rising number of points.
template <int D>
using Rules = std::vector<CollapsedRule<D>>;
template <int D>
[[nodiscard]] Rules<D> quadrature_rules();

/// What is known of one element.
struct State {
    Integrals integrals;
    Squares change{};  ///< by the last refinement
    std::uint32_t evaluations = 0;
    std::int8_t level = -1;
};

/// Where the integrals over elements of a mesh are refined: level after level, first with more points, then on parts of
/// an element, until what the last refinements changed is small in all.
template <int D>
class Quadrature {
  public:
    /// `nodal`: of a function of degree 2 that is given at the mesh's nodes; empty: of the interpolants.
    Quadrature(const QuadraticMesh<D>& mesh, std::vector<std::uint32_t> elements, const ScalarField<D>& field,
               std::span<const double> nodal, const Rules<D>& rules, Sides sides, double tolerance,
               const Execution& execution)
        : mesh_(mesh),
          field_(field),
          nodal_(nodal),
          rules_(rules),
          sides_(sides),
          tolerance_(tolerance),
          execution_(execution),
          elements_(std::move(elements)),
          states_(elements_.size(), State{}) {}

    /// To what is asked for together with `beside`, the squares of the mesh's other elements.
    [[nodiscard]] Outcome<Done> integrate(const Squares& beside);

    /// Entries of its elements, in a list of those of the mesh's.
    void put_into(std::vector<const State*>& states) const {
        for (std::size_t i = 0; i < elements_.size(); ++i) states[elements_[i]] = &states_[i];
    }
    [[nodiscard]] std::size_t evaluations() const;
    /// Elements that are not settled, at the highest level or at the highest that could be afforded.
    [[nodiscard]] std::size_t unresolved() const { return unresolved_; }

  private:
    // Elements are told by their rows in `elements_`.
    [[nodiscard]] Outcome<Done> refine(const std::vector<std::uint32_t>& active);
    void refine(std::uint32_t row, const Squares& enough, Integrator<D>& integrator);
    [[nodiscard]] bool affordable(const std::vector<std::uint32_t>& active) const;
    [[nodiscard]] Squares total() const;
    [[nodiscard]] Squares enough_of_parts() const;
    [[nodiscard]] std::vector<std::uint32_t> unsettled();
    [[nodiscard]] double threshold_of(std::size_t q, double allowed) const;
    [[nodiscard]] Error not_finite(std::uint32_t row) const;

    const QuadraticMesh<D>& mesh_;
    const ScalarField<D>& field_;
    const std::span<const double> nodal_;
    const Rules<D>& rules_;
    Sides sides_;
    double tolerance_;
    const Execution& execution_;
    std::vector<std::uint32_t> elements_;
    std::vector<State> states_;  ///< one an element of these
    Squares beside_{};
    std::size_t unresolved_ = 0;
};

/// The integrals over a piece and by how much they changed at last.
struct Integrated {
    Integrals integrals;
    Squares change{};
    std::size_t evaluations = 0;
};

/// What the squares changed by, rounding left out; of H1 nothing where det J is not positive.
[[nodiscard]] Squares effective_change(const Integrals& now, const Integrals& before);

/// Parts of parts, as deep as told (at least 1), wherever the parts together differ from the whole by more than
/// `enough`.
template <int D>
[[nodiscard]] Integrated integrate_parts(const Piece<D>& whole, const Integrals& of_whole, const Squares& enough,
                                         int depth, const CollapsedRule<D>& rule, Integrator<D>& integrator);

/// Why an element's integrals are no numbers.
template <int D>
[[nodiscard]] Error find_not_finite(const QuadraticMesh<D>& mesh, std::size_t e, Sides sides, const Rules<D>& rules,
                                    Integrator<D>& integrator);

}  // namespace camber
