module;
#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>
export module camber.curving:extension_part;
import camber.core;
import :parts;

export namespace camber {

/// What the rows of a part say after a step.
struct ExtensionSums {
    double by_product = 0;  ///< correction · product
    double by_residual = 0;
    double largest = 0;  ///< correction, as a share of the height
    double joined = 0;   ///< rows

    friend ExtensionSums operator+(const ExtensionSums& a, const ExtensionSums& b) {
        return {a.by_product + b.by_product, a.by_residual + b.by_residual, std::max(a.largest, b.largest),
                a.joined + b.joined};
    }
};

/// The direction's product with the matrix, and its own with that and with the residual.
struct AlongDirection {
    double curvature = 0, slope = 0;

    friend AlongDirection operator+(const AlongDirection& a, const AlongDirection& b) {
        return {a.curvature + b.curvature, a.slope + b.slope};
    }
};

/// The equations of extend_boundary for the edges of one part of a mesh, as far as the displacement has been felt.
template <int D>
class ExtensionPart {
  public:
    /// Errors: columns that do not fit the mesh (internal), stopped, memory. All must outlive it.
    [[nodiscard]] static Outcome<ExtensionPart> make(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                                     std::span<const LagrangeNode<D>> boundary_nodes,
                                                     const Incidence<ElementId>& shells, const OwnVertices& own,
                                                     const Execution& execution);
    ExtensionPart(const ExtensionPart&) = delete;
    ExtensionPart& operator=(const ExtensionPart&) = delete;
    ExtensionPart(ExtensionPart&&) noexcept;
    ExtensionPart& operator=(ExtensionPart&&) noexcept;
    ~ExtensionPart();

    /// Whether a node of the boundary is off the middle of its chord.
    [[nodiscard]] bool is_displaced() const;
    /// Of each run Σ |det| over its elements, and how many these are.
    [[nodiscard]] Outcome<std::vector<double>> volume_and_count(const Execution& execution) const;

    /// What is given is moved, and all beside it has a row. `mean`: of |det| over the elements of all parts.
    [[nodiscard]] Outcome<Done> begin(double mean, double stiffening, const Execution& execution);
    /// Moves along the direction, and looks at what is left: of each run.
    [[nodiscard]] Outcome<std::vector<ExtensionSums>> step(double length, double tolerance, const Execution& execution);
    /// The next direction, conjugate to the last. What joined in the last step moves.
    [[nodiscard]] Outcome<Done> turn_by(double turn, const Execution& execution);
    /// All around what has joined, here or in other parts (`of_others`), gets a row.
    [[nodiscard]] Outcome<Done> join(std::span<const EdgeId> of_others, const Execution& execution);
    /// Of each run.
    [[nodiscard]] Outcome<std::vector<AlongDirection>> multiply(const Execution& execution);

    [[nodiscard]] std::span<Vec<D>> directions();                  ///< one an edge
    [[nodiscard]] const std::vector<EdgeId>& joined_last() const;  ///< rising in each round
    [[nodiscard]] std::size_t moving() const;                      ///< its rows
    /// One an edge: of its own where they are now. Nothing is left of it. Errors: stopped, memory.
    [[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> nodes(const Execution& execution) &&;

  private:
    struct Impl;
    explicit ExtensionPart(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace camber
