module;
#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>
export module camber.optimisation:edge_program;
import camber.core;
import camber.bezier;
import camber.validity;
import :small_programs;

export namespace camber {

template <int D>
struct ShellElement {
    NodalSimplex<D> element;
    int edge = 0;
    /// Scaled Jacobian that this element must keep; nothing: the bound of the problem.
    std::optional<double> required_jacobian;
};

/// The elements around one edge.
template <int D>
struct EdgeShell {
    LagrangeNode<D> node;
    std::vector<ShellElement<D>> elements;
};

template <int D>
[[nodiscard]] inline EdgeShell<D> edge_shell(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> mid_nodes,
                                             std::span<const ElementId> shell, EdgeId edge) {
    EdgeShell<D> s{mid_nodes[edge.index()], {}};
    s.elements.reserve(shell.size());
    for (const ElementId e : shell) {
        const auto& edges = mesh.edges.of_elements[e];
        int local = 0;
        while (local + 1 < edges_per_simplex<D> && edges[local] != edge) ++local;
        s.elements.push_back({nodal_element<D>(mesh, mid_nodes, e), local, {}});
    }
    return s;
}

template <int D>
[[nodiscard]] inline NodalSimplex<D> with_node(const ShellElement<D>& s, const LagrangeNode<D>& node) {
    NodalSimplex<D> moved = s.element;
    moved.nodes[D + 1 + s.edge] = node.point;
    return moved;
}

/// Accuracy and effort of bisections. If the coefficients of an element prove too little, it is bisected. The
/// coefficients of its parts, which are also affine in the node, then replace those of the element.
struct EdgeProgramOptions {
    double tolerance = 1e-3;  ///< tolerance of the optimum, relative to max(1, |optimum|)
    int max_cuts = 60;        ///< maximum number of bisections; 0: only coefficients are tested
    /// Bisections end when the maximum is certainly above or below this.
    double enough = std::numeric_limits<double>::infinity();
    /// Without bisections, a node is returned only if its minimum coefficient is at least this. The limit saves work.
    double least = -std::numeric_limits<double>::infinity();
};

template <int D>
struct MaxMinNode {
    LagrangeNode<D> node;
    /// Certified lower bound of det J / |det straight| in elements without `required_jacobian`.
    double lower = 0;
    /// Upper bound for any node, up to rounding (without bisections: by coefficients); ∞ if `enough` was reached at
    /// once.
    double upper = 0;
    int cuts = 0;  ///< bisections
};

template <int D>
struct NearestNode {
    LagrangeNode<D> node;
    double cost = 0;  ///< model value at the node
    int cuts = 0;
};

/// Maximises the minimum of det J / |det straight| over the elements without `required_jacobian`. The other elements
/// must keep their `required_jacobian`. Solves a linear program, then bisects until `lower` and `upper` agree to the
/// tolerance or lie on one side of `enough`. Nothing if infeasible or if all elements have `required_jacobian`.
template <int D>
[[nodiscard]] std::optional<MaxMinNode<D>> max_min_node(const EdgeShell<D>& shell,
                                                        const EdgeProgramOptions& options = {});

/// Minimises the model subject to validity of all elements by `decide`: above `bound`, or above their
/// `required_jacobian`. Solves a quadratic program, then bisects where active coefficients are not values of det J.
/// Nothing if no such node was found.
template <int D>
[[nodiscard]] std::optional<NearestNode<D>> nearest_node(const EdgeShell<D>& shell, const QuadraticModel<D>& model,
                                                         double bound, const EdgeProgramOptions& options = {});

/// True if `decide` certifies all elements: above `bound`, or above their `required_jacobian`.
template <int D>
[[nodiscard]] bool holds(const EdgeShell<D>& shell, const LagrangeNode<D>& node, double bound);

/// Certified lower bound of det J / |det straight| in elements without `required_jacobian`: from coefficients or
/// `enough` if these suffice, else within scaled_jacobian_tolerance.
template <int D>
[[nodiscard]] double smallest_scaled_jacobian(const EdgeShell<D>& shell, const LagrangeNode<D>& node, double enough);

/// Cost model ½ (x − centre)ᵀ H (x − centre); x is the offset from the current position.
template <int D>
struct OffsetModel {
    Vec<D> centre;
    Sym<D> hessian;

    [[nodiscard]] double operator()(const Vec<D>& offset) const {
        const Vec<D> r = offset - centre;
        return 0.5 * dot(r, hessian * r);
    }
};

/// Joint problem of edge nodes and vertices with their elements. Nodes move with half of the displacement of their
/// edge's vertices; their own unknowns are additional offsets.
template <int D>
struct JointProblem {
    static constexpr int fixed = -1;

    struct Element {
        QuadraticSimplex<D, D> bezier;                   ///< current positions
        std::array<int, quadratic_nodes<D>> unknowns{};  ///< index of the unknown of each vertex, then of each edge
                                                         ///< node; `fixed`: no unknown
        double floor = 0;                                ///< minimum of the coefficients, as a share of |det straight|
        double least = -std::numeric_limits<double>::infinity();  ///< absolute minimum of the coefficients, since
                                                                  ///< vertices change |det straight|
    };
    std::vector<OffsetModel<D>> unknowns;
    std::vector<Element> elements;
    double first_penalty = weak;
    double max_work = std::numeric_limits<double>::infinity();

    static constexpr double weak = 0.1;   ///< penalty that favours low cost
    static constexpr double strong = 10;  ///< penalty that favours feasibility
};

/// Work of evaluating one element, in units of about 50 µs. A step with ten unknowns and thirty elements takes about
/// one unit: 0.4 (unknowns / 10)² for its equations, plus evaluations. Decisions depend on these counts and not on
/// times, so they are equal on all machines.
inline constexpr double element_work = 0.01;
[[nodiscard]] constexpr double equations_work(std::size_t unknowns) {
    const auto n = static_cast<double>(unknowns);
    return 0.4 * n * n / 100;
}

/// Maximum violation of a constraint, as a share of |det straight|.
inline constexpr double largest_shortfall = 1e-6;

template <int D>
struct JointSolution {
    std::vector<Vec<D>> offsets;
    double shortfall = 0;  ///< at most 0 if all constraints hold
    double work = 0;       ///< includes rejected steps
};

/// Minimises the sum of the models subject to c ≥ max(floor · |det straight|, least) for every Bézier coefficient c of
/// det J. Augmented Lagrangian (Hestenes, Powell, Rockafellar) with Gauss–Newton steps; `start` may be infeasible.
/// Scaled constraints do not penalise thin elements. Returns a local minimum; deterministic; single-threaded.
template <int D>
[[nodiscard]] JointSolution<D> solve(const JointProblem<D>& problem, std::vector<Vec<D>> start);

}  // namespace camber
