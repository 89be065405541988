module;
#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>
export module camber.optimisation:edge_programme;
import camber.core;
import camber.bezier;
import camber.validity;
import :programmes;

export namespace camber {

/// An element around an edge.
template <int D>
struct ShellElement {
    NodalSimplex<D> element;
    int edge = 0;  ///< which of its local edges is the shell's
    /// Scaled Jacobian that this element must keep; none: a programme's own demand holds for it.
    std::optional<double> keep;
};

/// The elements around one edge, whose node they share.
template <int D>
struct EdgeShell {
    LagrangeNode<D> node;  ///< the edge's, as the elements have it
    std::vector<ShellElement<D>> elements;
};

/// The shell of an edge of a mesh, with these mid nodes.
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

/// The element with the edge's node elsewhere.
template <int D>
[[nodiscard]] inline NodalSimplex<D> with_node(const ShellElement<D>& s, const LagrangeNode<D>& node) {
    NodalSimplex<D> moved = s.element;
    moved.nodes[D + 1 + s.edge] = node.point;
    return moved;
}

/// How far the programmes of one edge go where the coefficient test is too weak: there an element is bisected, and the
/// coefficients of its parts, affine in the node as well, take the place of its own.
struct EdgeProgrammeOptions {
    double tolerance = 1e-3;  ///< cuts end when the optimum is known to this, relative to max(1, |optimum|)
    int max_cuts = 60;        ///< bisections in all; 0: the plain coefficient test
    /// Cuts end when the largest smallest value is known to be above or below this.
    double enough = std::numeric_limits<double>::infinity();
    /// Without cuts: no node is returned unless its coefficients exceed this, which costs less to detect.
    double least = -std::numeric_limits<double>::infinity();
};

/// The place of the edge's node that makes the smallest scaled Jacobian of the shell largest.
template <int D>
struct HighestNode {
    LagrangeNode<D> node;
    /// Certified: det J / |det straight| is nowhere less in the elements that `keep` nothing, with this node.
    double lower = 0;
    /// No node reaches more, but for rounding (without cuts: none by its coefficients); ∞ if `enough` was there at
    /// once.
    double upper = 0;
    int cuts = 0;  ///< bisections made
};

/// The valid node nearest to a target position.
template <int D>
struct NearestNode {
    LagrangeNode<D> node;
    double cost = 0;  ///< of the model there
    int cuts = 0;
};

/// Can this edge alone repair its shell? The node with the largest smallest value of det J / |det straight| in the
/// elements without `keep`, while the others stay above theirs: a linear programme in D unknowns and the bound, then
/// cuts until `lower` and `upper` agree to the tolerance or tell which side of `enough` they are on. None if the
/// elements that `keep` something cannot, or no element is to be raised.
template <int D>
[[nodiscard]] std::optional<HighestNode<D>> highest_node(const EdgeShell<D>& shell,
                                                         const EdgeProgrammeOptions& options = {});

/// The node of the least model value among those with which every element is valid by `decide`: above `bound`, or above
/// what it `keep`s. A quadratic programme, then cuts where coefficients that are no values of det J hold it back. None
/// if there is no such node, or none was found with the cuts allowed.
template <int D>
[[nodiscard]] std::optional<NearestNode<D>> nearest_node(const EdgeShell<D>& shell, const QuadraticModel<D>& model,
                                                         double bound, const EdgeProgrammeOptions& options = {});

/// Whether all elements of the shell are valid by `decide` with this node: above `bound`, or above what they `keep`.
template <int D>
[[nodiscard]] bool holds(const EdgeShell<D>& shell, const LagrangeNode<D>& node, double bound);

/// Certified lower bound of det J / |det straight| in the elements that `keep` nothing: the coefficients', or `enough`,
/// where these do; within scaled_jacobian_tolerance of the minimum elsewhere.
template <int D>
[[nodiscard]] double smallest_scaled_jacobian(const EdgeShell<D>& shell, const LagrangeNode<D>& node, double enough);

/// One unknown point's part of the objective: ½ (x − centre)ᵀ H (x − centre), x its offset from where it is.
template <int D>
struct OffsetModel {
    Vec<D> centre;
    Sym<D> hessian;

    [[nodiscard]] double operator()(const Vec<D>& offset) const {
        const Vec<D> r = offset - centre;
        return 0.5 * dot(r, hessian * r);
    }
};

/// Edge nodes and vertices that move together, and the elements that watch them. A vertex takes half of its
/// displacement along to the nodes of its edges; a node's own unknown is its offset beyond that.
template <int D>
struct JointProgramme {
    static constexpr int fixed = -1;

    struct Element {
        QuadraticSimplex<D, D> bezier;                   ///< where its points are now
        std::array<int, quadratic_nodes<D>> unknowns{};  ///< of its vertices and edges, in that order; or fixed
        double floor = 0;  ///< what the coefficients are to be above, as shares of |det straight|
        double least =
            -std::numeric_limits<double>::infinity();  ///< and as they are: vertices take |det straight| along
    };
    std::vector<OffsetModel<D>> unknowns;
    std::vector<Element> elements;
    double first_penalty = weak;                                ///< of a shortfall, beside the models
    double max_work = std::numeric_limits<double>::infinity();  ///< after it no more steps are taken

    static constexpr double weak = 0.1;   ///< the first steps choose the way that costs little
    static constexpr double strong = 10;  ///< they go where the constraints hold
};

/// Work is counted so that what is decided by it does not depend on the machine; a unit takes about 50 µs. A step with
/// ten unknowns and thirty elements is about one: 0.4 (unknowns / 10)² for its equations, and this for each evaluation
/// of an element.
inline constexpr double element_work = 0.01;
[[nodiscard]] constexpr double equations_work(std::size_t unknowns) {
    const auto n = static_cast<double>(unknowns);
    return 0.4 * n * n / 100;
}

/// How far below its floor a coefficient may end, as a share of |det straight|.
inline constexpr double largest_shortfall = 1e-6;

/// Where the unknowns ended.
template <int D>
struct JointSolution {
    std::vector<Vec<D>> offsets;
    double shortfall = 0;  ///< how far below its floor the lowest coefficient is; at most 0 when all are above
    double work = 0;       ///< of all steps, and of those that led nowhere
};

/// Minimises the sum of the models subject to c ≥ max(floor · |det straight|, least) for every Bézier coefficient c of
/// det J of every element: an augmented Lagrangian (Hestenes, Powell, Rockafellar) of Gauss–Newton steps from the
/// offsets `start`, which need not be feasible. The unknowns are in the metric's frame by their models, and the
/// constraints by the division, so thin elements are not punished for being thin. A local minimum; deterministic; one
/// thread.
template <int D>
[[nodiscard]] JointSolution<D> solve(const JointProgramme<D>& programme, std::vector<Vec<D>> start);

}  // namespace camber
