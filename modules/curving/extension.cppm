module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <numeric>
#include <span>
#include <utility>
#include <vector>
export module camber.curving:extension;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.validity;
import camber.optimisation;

/// What runs over a whole mesh, written for parts of it: each does what belongs to its own vertices, on a mesh with two
/// rings of elements around them, and hears of others what is theirs. A mesh by itself is one part.
export namespace camber {

/// What belongs to a part: its own vertices are [first, last), and all of which they are the lowest vertex. Over some
/// runs of them sums are taken by themselves, so that these are the same however many runs are in a part.
struct OwnVertices {
    VertexId first, last;
    std::vector<VertexId> later_runs = {};  ///< where all runs but the first begin

    [[nodiscard]] bool owns(VertexId v) const { return v >= first && v < last; }
    template <std::size_t N>
    [[nodiscard]] bool owns(const std::array<VertexId, N>& simplex) const {
        return owns(std::ranges::min(simplex));
    }
    [[nodiscard]] std::size_t runs() const { return later_runs.size() + 1; }
    [[nodiscard]] std::size_t run_of(VertexId v) const {
        return static_cast<std::size_t>(std::ranges::upper_bound(later_runs, v) - later_runs.begin());
    }
};
template <int D>
[[nodiscard]] OwnVertices whole(const LinearMesh<D>& mesh) {
    return {VertexId(0), VertexId(mesh.points.size())};
}

/// A sum over the elements of each run, as `reduce_each`: accumulate(value, element).
template <class T, int D>
[[nodiscard]] Outcome<std::vector<T>> reduce_own(const Execution& execution, const LinearMesh<D>& mesh,
                                                 const OwnVertices& own, const T& init, const auto& accumulate,
                                                 const auto& join) {
    return guarded([&]() -> Outcome<std::vector<T>> {
        // Chunks are those of a run's elements, which a mesh by itself need not list.
        const bool is_whole = own.runs() == 1 && own.first.index() == 0 && own.last.index() == mesh.points.size();
        std::vector<std::size_t> begin(own.runs() + 1, 0);
        Buffer<ElementId> listed;
        if (!is_whole) {
            const auto lowest = [&](std::size_t e) { return std::ranges::min(mesh.elements.vertices[e]); };
            for (std::size_t e = 0; e < mesh.elements.size(); ++e)
                if (own.owns(lowest(e))) ++begin[own.run_of(lowest(e)) + 1];
            std::partial_sum(begin.begin(), begin.end(), begin.begin());
            listed = Buffer<ElementId>(begin.back());
            std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
            for (std::size_t e = 0; e < mesh.elements.size(); ++e)
                if (own.owns(lowest(e))) listed[next[own.run_of(lowest(e))]++] = ElementId(e);
        } else
            begin.back() = mesh.elements.size();
        std::vector<T> sums;
        for (std::size_t r = 0; r < own.runs(); ++r) {
            auto sum = reduce_each(
                execution, begin[r + 1] - begin[r], init,
                [&](T& value, std::size_t i) { accumulate(value, is_whole ? ElementId(i) : listed[begin[r] + i]); },
                join);
            if (!sum) return fail(sum.error());
            sums.push_back(std::move(*sum));
        }
        return sums;
    });
}

/// Some edges of each part.
using EdgesOfParts = std::vector<std::vector<EdgeId>>;

/// What goes between the parts of a mesh, wherever they are.
template <int D>
class BetweenParts {
  public:
    virtual ~BetweenParts() = default;
    /// What parts here found of each of their runs, in their order, made what all found, in theirs. Errors: of any.
    [[nodiscard]] virtual Outcome<std::vector<double>> gather(Outcome<std::vector<double>> of_parts) = 0;
    /// Of a part's own edges those that other parts have too.
    [[nodiscard]] virtual std::vector<EdgeId> shared(std::size_t part, std::vector<EdgeId> edges) const = 0;
    /// `rows` has a row an edge for each part here: brings those of these edges, which are `shared`, to all other parts
    /// that have them. The edges that were brought to each part here, rising. Errors: of any.
    [[nodiscard]] virtual Outcome<EdgesOfParts> bring(std::span<const std::span<Vec<D>>> rows,
                                                      const EdgesOfParts& edges) = 0;

  protected:
    BetweenParts() = default;
    BetweenParts(const BetweenParts&) = default;
    BetweenParts(BetweenParts&&) = default;
    BetweenParts& operator=(const BetweenParts&) = default;
    BetweenParts& operator=(BetweenParts&&) = default;
};

/// Of a mesh by itself.
template <int D>
class OnePart final : public BetweenParts<D> {
  public:
    [[nodiscard]] Outcome<std::vector<double>> gather(Outcome<std::vector<double>> of_parts) override {
        return of_parts;
    }
    [[nodiscard]] std::vector<EdgeId> shared(std::size_t, std::vector<EdgeId>) const override { return {}; }
    [[nodiscard]] Outcome<EdgesOfParts> bring(std::span<const std::span<Vec<D>>> rows, const EdgesOfParts&) override {
        return EdgesOfParts(rows.size());
    }
};

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

/// How far the linear extension goes.
struct ExtensionOptions {
    /// Nodes end where what a step of Jacobi's would still change is below this share of the smallest height of the
    /// elements around their edge: there det (I + ∇u) is known to about as much, in layers of any anisotropy.
    double tolerance = 1e-3;
    int max_iterations = 1000;
    /// Elements count with (mean |det straight| / |det straight|)^stiffening: 0 is the plain Dirichlet energy; more
    /// makes small elements stiffer, so that large ones take up the deformation.
    double stiffening = 2;
};

/// What the extension came to.
template <int D>
struct Extension {
    Buffer<LagrangeNode<D>> nodes;  ///< one an edge
    int iterations = 0;
    double correction = 0;   ///< what is left, as the tolerance says it
    std::size_t solved = 0;  ///< edges whose displacement was asked for; all others are straight
};

/// Carries the displacement of the given nodes off the middles of their chords into the volume: nodes of volume edges
/// get the displacement u that minimises Σ over the straight elements of ∫ |∇u|² dx, u in the space of the P2 edge
/// functions 4 ξ_i ξ_j (vertices stay). det (I + ∇u) is the scaled Jacobian. Since the gradient is taken in space, u
/// varies least across thin elements: a stack of layers moves with its wall. Solved by conjugate gradients, with
/// rows for as much of the mesh as the displacement reaches by more than the tolerance; the same bytes for any number
/// of threads. Errors: columns that do not fit the mesh (internal), stopped.
template <int D>
[[nodiscard]] Outcome<Extension<D>> extend_boundary(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                                    const Column<LagrangeNode<D>>& boundary_nodes,
                                                    const Incidence<ElementId>& shells, const ExtensionOptions& options,
                                                    const Execution& execution);

struct ExtensionSolve {
    int iterations = 0;
    double correction = 0;
};
/// The same for the parts of a mesh that are here, which are as they were made and of which one somewhere is displaced:
/// conjugate gradients with the diagonal as preconditioner; the D components share their steps. Rows join as the
/// residual reaches them, so each new direction is made conjugate to the last by the product itself (Polak, Ribière).
/// Sums go over the parts in their order, whoever has them.
template <int D>
[[nodiscard]] Outcome<ExtensionSolve> solve_extension(std::span<ExtensionPart<D>> parts, BetweenParts<D>& between,
                                                      const ExtensionOptions& options, const Execution& execution);

}  // namespace camber

/// The energy Σ_K w_K ∫_K |∇u|² dx of displacements of edge nodes, u = Σ_e 4 ξ_i ξ_j u_e: an element's part of its
/// matrix follows from the products of its ∇ξ.
namespace camber {

/// How much an element counts, by |det| of its edges. Bounded, so that the slightest elements do not drown the others.
struct Weighting {
    double mean = 1, stiffening = 0;

    [[nodiscard]] double of(double volume) const { return std::min(pow(mean / volume, stiffening), 1e12); }
};

template <int D>
[[nodiscard]] inline Mat<D> edge_vectors(const LinearMesh<D>& mesh, ElementId e) {
    const auto& v = mesh.elements.vertices[e];
    Mat<D> edges;
    for (int a = 0; a < D; ++a) edges.column[a] = mesh.points[v[a + 1]] - mesh.points[v[0]];
    return edges;
}

template <int D>
[[nodiscard]] inline Outcome<Weighting> weighting_of(const LinearMesh<D>& mesh, double stiffening,
                                                     const Execution& execution) {
    const auto sum = reduce_each(
        execution, mesh.elements.size(), 0.0,
        [&](double& total, std::size_t e) { total += std::abs(det(edge_vectors(mesh, ElementId(e)))); },
        [](double a, double b) { return a + b; });
    if (!sum) return fail(sum.error());
    return Weighting{*sum / static_cast<double>(std::max<std::size_t>(1, mesh.elements.size())), stiffening};
}

/// w |K| ∇ξ_i · ∇ξ_j of an element's edges ij, but for a constant factor. Since Σ ∇ξ_i = 0, the squares are less the
/// sums of these.
template <int D>
using Gradients = std::array<double, edges_per_simplex<D>>;

template <int D>
struct ElementEnergy {
    Gradients<D> gradients{};
    double height = std::numeric_limits<double>::infinity();  ///< the smallest of the straight element
};

/// Flat elements have no say.
template <int D>
[[nodiscard]] inline ElementEnergy<D> element_energy(const LinearMesh<D>& mesh, ElementId e,
                                                     const Weighting& weighting) {
    const Mat<D> edges = edge_vectors(mesh, e);
    const double volume = std::abs(det(edges));
    const auto rows = cofactors(edges);
    // ∇ξ_i times det: its factor 1/det² joins the volume's.
    std::array<Vec<D>, D + 1> gradient{};
    for (int a = 0; a < D; ++a) gradient[a + 1] = rows[a], gradient[0] -= rows[a];
    const double factor = weighting.of(volume) / volume;
    ElementEnergy<D> energy;
    if (!std::isfinite(factor)) return energy;
    double steepest = 0;
    for (const Vec<D>& g : gradient) steepest = std::max(steepest, norm_squared(g));
    energy.height = volume / std::sqrt(steepest);
    for (int k = 0; k < edges_per_simplex<D>; ++k)
        energy.gradients[k] = factor * dot(gradient[local_edges<D>[k][0]], gradient[local_edges<D>[k][1]]);
    return energy;
}

/// Of a local edge ij: the edges ik and jk for each further vertex k, and kl where there are two.
template <int D>
struct EdgesBeside {
    std::array<int, D - 1> first{}, second{};
    int opposite = 0;
};

template <int D>
inline constexpr auto edges_beside = [] {
    const auto between = [](int a, int b) {
        int k = 0;
        while (local_edges<D>[k] != std::array{a, b} && local_edges<D>[k] != std::array{b, a}) ++k;
        return k;
    };
    std::array<EdgesBeside<D>, edges_per_simplex<D>> table{};
    for (int e = 0; e < edges_per_simplex<D>; ++e) {
        const auto [i, j] = local_edges<D>[e];
        std::array<int, D - 1> others{};
        for (int k = 0, n = 0; k <= D; ++k)
            if (k != i && k != j) others[n++] = k;
        for (int n = 0; n < D - 1; ++n) {
            table[e].first[n] = between(i, others[n]);
            table[e].second[n] = between(j, others[n]);
        }
        if constexpr (D == 3) table[e].opposite = between(others[0], others[1]);
    }
    return table;
}();

/// What the element adds to an edge's row, add(local edge, entry) each. From ∫ ξ_a ξ_b = (1 + δ_ab) · constant, with
/// g_ii and g_jj put as sums; the edge kl opposite takes the sum of all that are beside.
template <int D, class Add>
inline void each_row_entry(const Gradients<D>& g, int own, const Add& add) {
    const auto& beside = edges_beside<D>[own];
    double firsts = 0;
    double seconds = 0;
    for (int n = 0; n < D - 1; ++n) firsts += g[beside.first[n]], seconds += g[beside.second[n]];
    add(own, -2 * (g[own] + firsts + seconds));
    for (int n = 0; n < D - 1; ++n) {
        const double b = g[beside.first[n]];
        const double d = g[beside.second[n]];
        add(beside.first[n], 2 * d + b - firsts);
        add(beside.second[n], 2 * b + d - seconds);
    }
    if constexpr (D == 3) add(beside.opposite, firsts + seconds);
}

template <int D>
[[nodiscard]] inline int local_edge(const std::array<EdgeId, edges_per_simplex<D>>& edges, EdgeId edge) {
    int own = 0;
    for (int k = 1; k < edges_per_simplex<D>; ++k) own += edges[k] == edge ? k : 0;  // which branch is anybody's guess
    return own;
}

}  // namespace camber

export namespace camber {

/// How far the shape of elements is evened out.
struct ShapeOptions {
    ExtensionOptions extension;
    /// Of the programmes. Without cuts elements count by their coefficients, which are close where shapes are good.
    EdgeProgrammeOptions programme{.tolerance = 1e-3, .max_cuts = 0};
    double enough = 0.95;    ///< elements with such a scaled Jacobian are let be
    double min_gain = 1e-3;  ///< a step must raise the smallest scaled Jacobian around its edge by so much
    /// Elements are raised together that are less than this above the worst, of max(1, |worst|).
    double band = 0.02;
    int rings = 2;               ///< of elements that are raised with the worst, where these alone do not rise
    std::size_t max_steps = 20;  ///< in one band, for each of its elements
    int max_bands = 100;
};

/// What `shape` came to.
template <int D>
struct Shaped {
    Proposal<D> proposal;
    int iterations = 0;          ///< of the linear extension
    std::size_t solved = 0;      ///< edges that it was solved for
    std::size_t steps = 0;       ///< nodes moved by programmes
    double after_extension = 0;  ///< smallest scaled Jacobian of the mesh, at most `enough`
    double smallest = 0;         ///< the same in the end
};

/// The second verb with the elements' shape as its aim, for a mesh without a field: boundary edges take
/// `boundary_nodes`, and nodes of volume edges are put so that the scaled Jacobian is as even as it may: by the linear
/// extension of the boundary's displacement, then by programmes of single edges, worst elements first, each of which
/// raises the smallest scaled Jacobian around its edge as far as that edge can, until all have `enough` or the worst
/// cannot be raised. The same bytes for any number of threads. Errors: as extend_boundary.
template <int D>
[[nodiscard]] Outcome<Shaped<D>> shape(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                       const Column<LagrangeNode<D>>& boundary_nodes,
                                       const Incidence<ElementId>& shells, const ShapeOptions& options,
                                       const Execution& execution);

}  // namespace camber

namespace camber {

/// What programmes of single edges came to.
template <int D>
struct Polished {
    Buffer<LagrangeNode<D>> nodes;
    std::size_t steps = 0;  ///< nodes moved
    double before = 0;      ///< smallest scaled Jacobian of the mesh, at most `enough`
    double smallest = 0;    ///< the same in the end
};

/// Nodes of volume edges moved so that the smallest scaled Jacobian rises: band after band of the worst elements, in
/// rounds. In a round the programmes of the edges around all elements of the band are solved, but for those around
/// which nothing has changed since; then elements, the worst first, take the edge that raises the smallest value around
/// it most, unless one that came before has changed an element there. So the result does not depend on the threads.
/// Where the worst of a band do not rise, the elements around them are raised too, and then the band is tried once
/// more. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<Polished<D>> polish(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                          Buffer<LagrangeNode<D>> nodes, const Incidence<ElementId>& shells,
                                          const ShapeOptions& options, const Execution& execution);

}  // namespace camber

export namespace camber {

/// Draws offsets of edges back, in place, until what they add to the error of a smooth function is at most the share
/// `loss` of it, by a model: its third derivatives are even, |∇²u| = ℓ|∇³u| with ℓ the domain's radius of gyration, and
/// the P2 interpolant errs by them on straight edges. An offset d of the edge e adds 24 ∇²u[e, d] to its third
/// derivative along e (see docs/algorithms/smooth-loss.md), in L2 and in H1
///
///   g_e = (24 ℓ |e| |d|)² Σ_K |K|/n (1/Σ|K|h⁶ + 0.1/(a_K² Σ|K|h⁴)),   Σ_e g_e k_e² ≤ (1 + loss)² − 1,   k_e = 1/(1 +
///   (g_e/c)²),
///
/// K: the elements around the edge, of n edges and the smallest height a_K; h² the mean of their squared edges. Offsets
/// are multiplied by k_e with the largest c for which the sum holds: those that cost most per element go first. Returns
/// how many were more than halved. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<std::size_t> limit_smooth_loss(const QuadraticMesh<D>& mesh, const Incidence<ElementId>& shells,
                                                     double loss, std::span<Vec<D>> offsets,
                                                     const Execution& execution);

/// A part of a mesh with its offsets, one an edge; those of other parts do not count.
template <int D>
struct PartLosses {
    const QuadraticMesh<D>& mesh;
    const Incidence<ElementId>& shells;
    OwnVertices owned;
    std::span<Vec<D>> offsets;
};
/// The same of all parts of a mesh: their own offsets are drawn back. How many of those here were more than halved.
template <int D>
[[nodiscard]] Outcome<std::size_t> limit_smooth_loss(std::span<const PartLosses<D>> parts, double loss,
                                                     BetweenParts<D>& between, const Execution& execution);

}  // namespace camber

/// A field that goes along with its walls: the displacement of the boundary's nodes is extended into the volume, and
/// the metric read through that. docs/algorithms/curved-back-mesh.md.
export namespace camber {

/// Where nodes go along with the boundary: where they are `extended` (one an edge: see extend_boundary), but the
/// middles of chords where the displacement is less than a hundredth of the metric's unit at both ends, so that nothing
/// is searched where nothing moves. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> noticeable_nodes(const QuadraticMesh<D>& mesh,
                                                                std::span<const LagrangeNode<D>> extended,
                                                                const Column<LogMetric<D>>& log_metrics,
                                                                const Execution& execution);

/// Of these nodes (one an edge) those of a back mesh, for make_curved_back_mesh: displacements that would bring an
/// element below a tenth of the straight one's Jacobian are limited, on the boundary too; so it is the field's map
/// alone, and no place for a mesh's nodes. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> back_mesh_nodes(const QuadraticMesh<D>& mesh,
                                                               std::span<const LagrangeNode<D>> nodes,
                                                               const Incidence<ElementId>& shells,
                                                               const Execution& execution);

/// A part of a mesh with nodes, one an edge, those of other parts as they have them.
template <int D>
struct PartNodes {
    const QuadraticMesh<D>& mesh;
    const Incidence<ElementId>& shells;
    OwnVertices owned;
    std::span<LagrangeNode<D>> nodes;
};
/// The same of the parts of a mesh that are here, in place.
template <int D>
[[nodiscard]] Outcome<Done> limit_to_back_mesh(std::span<const PartNodes<D>> parts, BetweenParts<D>& between,
                                               const Execution& execution);

/// Nodes as their elements bear them: where `base` + `offsets` (one row an edge) would bring an element's scaled
/// Jacobian below `least`, those of its edges go only a part of their way, the largest of 3/4, 1/2, 1/4 and 0 that
/// holds it, or the best where none does; an edge takes the least share that its elements ask for. Elements around what
/// was limited are looked at again, until none asks for more (through a stack of layers that is a round a layer), and
/// shares multiply. What an edge alone does not see: error in the gradient grows as
/// 1/det J, so that a few elements that are nearly flat cost more than all others gain. The number of edges that
/// were limited. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<std::size_t> limit_by_jacobian(const QuadraticMesh<D>& mesh,
                                                     std::span<const LagrangeNode<D>> base,
                                                     const Incidence<ElementId>& shells, double least,
                                                     std::span<Vec<D>> offsets, const Execution& execution);

/// A part of a mesh with its rows: one an edge, those of other parts as they have them.
template <int D>
struct PartOffsets {
    const QuadraticMesh<D>& mesh;
    std::span<const LagrangeNode<D>> base;  ///< none: the middles of chords
    const Incidence<ElementId>& shells;
    OwnVertices owned;
    std::span<Vec<D>> offsets;
};
/// The same of the parts of a mesh that are here; how many of their own edges were limited.
template <int D>
[[nodiscard]] Outcome<std::size_t> limit_by_jacobian(std::span<const PartOffsets<D>> parts, double least,
                                                     BetweenParts<D>& between, const Execution& execution);

}  // namespace camber
