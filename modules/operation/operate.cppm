// Accepted patches, workspaces, the cavity operation, commits, and passes.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>
export module camber.operation:operate;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.metric;
import camber.edge_optimisation;
import camber.validity;
import camber.surface;
import :state;

export namespace camber {

/// An accepted patch. Only `operate` creates it. Only `commit` applies it, to the state for which it was planned.
template <int D>
class JudgedPatch {
  public:
    [[nodiscard]] const Patch<D>& patch() const { return patch_; }
    [[nodiscard]] const VertexRow<D>& vertex() const { return vertex_; }
    /// True if the point moved only a part of the way to the geometry.
    [[nodiscard]] bool is_short_of_geometry() const { return is_short_; }
    /// Qualities (`shape_of`), first of the elements in `Patch::reshaped`, then of the new elements in the order of
    /// `Star::joined`. Negative: unknown.
    [[nodiscard]] std::span<const double> shapes() const { return shapes_; }
    /// Degree 2: lengths (`length_of`) of the edges from the point to the vertices of `Star::boundary`.
    [[nodiscard]] std::span<const double> lengths() const { return lengths_; }
    [[nodiscard]] Patch<D> take_patch() && { return std::move(patch_); }

  private:
    template <int, class>
    friend class OperationRunner;

    Patch<D> patch_;
    VertexRow<D> vertex_;
    std::vector<double> shapes_, lengths_;
    bool is_short_ = false;
};

template <int D>
class JudgedNode {
  public:
    [[nodiscard]] EdgeId edge() const { return edge_; }
    [[nodiscard]] const LagrangeNode<D>& node() const { return node_; }

  private:
    template <int>
    friend class NodeShell;

    EdgeId edge_;
    LagrangeNode<D> node_;
};

// Workspace for quadratic stars, reused from star to star.

/// An edge from the star's point to a boundary vertex.
template <int D>
struct Spoke {
    EdgeKind kind = EdgeKind::volume;  ///< `fixed`: the edge also belongs to elements or facets outside
    /// `target`: node position required by metric or geometry. `extended`: node position on the old curves.
    Vec<D> target, extended;
    Vec<D> node;
    bool is_extended = false;
    double share = 1;  ///< position of `node` between `extended` (0) and `target` (1)
    LineId line;       ///< for a ridge: the removed line that this edge continues
    /// `length`: last computed length; negative: not computed. `measured`: the node with which it was computed.
    double length = -1;
    Vec<D> measured;
};

/// A new element: an outer face joined to the star's point by spokes.
template <int D>
struct Cone {
    QuadraticNodes<D> nodes{};
    std::array<const LogMetric<D>*, D + 1> metrics{};
    std::array<std::uint32_t, D + 1> spokes{};  ///< index of the spoke at each local vertex except `point`
    int point = 0;                              ///< local index of the star's point
    bool is_stale = true, is_flat = false;
    bool is_surely_straight_positive = false;  ///< the straight volume is positive and exceeds its rounding error
    Verdict verdict = Verdict::undecided;
    double shape = -1;  ///< quality of a valid element; negative: unknown
};

/// An inner edge on the star's outer faces, whose node may move.
template <int D>
struct RimEdge {
    EdgeId edge;
    Vec<D> before, target, node;
};

/// An element outside the star that has a `RimEdge`.
template <int D>
struct OutsideElement {
    ElementId element;
    QuadraticNodes<D> nodes{};
    double bound = 0;  ///< minimum scaled Jacobian
};

/// A removed element as a map from its straight to its curved shape.
template <int D>
struct OldElement {
    ElementId element;
    double size = 0;  ///< absolute determinant of the straight element
    Vec<D> origin;
    std::array<Vec<D>, D> gradients{};                 ///< gradients of barycentric coordinates 1 … D
    std::array<Vec<D>, edges_per_simplex<D>> offsets;  ///< offsets of edge nodes from chord middles
};

template <int D>
struct CurvedWorkspace {
    std::vector<Spoke<D>> spokes;
    std::vector<Cone<D>> cones;
    std::vector<std::size_t> stale;
    std::vector<RimEdge<D>> rim;
    std::vector<OutsideElement<D>> outside;
    std::vector<ElementId> around;
    std::vector<OldElement<D>> old_elements;
    std::vector<FacetSite<D>> facets;
    std::vector<std::array<std::uint32_t, 2>> of_facets;  ///< each pair: index of a spoke, index of a new facet that
                                                          ///< contains this spoke
    std::vector<Vec<D>> chords, offsets;
    std::vector<EndSamples<D>> ends;
    std::vector<double> lengths;
    std::vector<BentSpoke<D>> bent;
    std::vector<FreeEdge<D>> searched;
    std::vector<EdgeMinimum<D>> found;
    std::vector<std::uint32_t> free;
    std::vector<std::uint32_t> short_of_place;
    int optimisation_problems = 0;
};

// Smoothing of the node of one inner edge by the distortion of the elements around the edge.

/// An element around the edge: data that do not depend on the edge's node. `node`: local index of that node.
template <int D>
struct DistortedElement {
    QuadraticNodes<D> nodes{};
    ElementMetric<D> metric;
    int node = 0;
    double bound = 0;  ///< minimum scaled Jacobian
};

/// A position `y` of the node (in coordinates of `NodeShell`) and the objective there. `sum`: Σ η̄² over the elements
/// around the edge, where η̄ is the mean distortion of an element. Squares emphasise the worst element, and the
/// gradient does not depend on the metric's scale. `worst`: minimum quality.
template <int D>
struct NodePlace {
    Vec<D> y;
    Vec<D> point;
    double sum = 0;
    double worst = 0;
    Vec<D> gradient;
};

/// Optimises a node by BFGS, in coordinates in which the metric at the edge's middle is the identity. In these
/// coordinates, elements have size about 1 for any anisotropy.
template <int D>
class NodeShell {
  public:
    std::vector<DistortedElement<D>> elements;

    void begin(const Vec<D>& node, const LogMetric<D>& log_metric) {
        origin_ = node;
        const MeasuringMetric<D> metric(log_metric);
        for (int k = 0; k < D; ++k) axes_[k] = metric.rows[k] / norm_squared(metric.rows[k]);
    }
    [[nodiscard]] NodePlace<D> at(const Vec<D>& y) const {
        NodePlace<D> place{y, origin_, 0, std::numeric_limits<double>::infinity(), {}};
        for (int k = 0; k < D; ++k) place.point += y[k] * axes_[k];
        Vec<D> gradient;
        for (const DistortedElement<D>& e : elements) {
            const CurvedQualityGradient<D> q = curved_quality_gradient<D>(with_node(e, place.point), e.metric);
            place.worst = std::min(place.worst, q.mean);
            if (!(q.mean > 0)) {
                place.sum = std::numeric_limits<double>::infinity();
                return place;
            }
            place.sum += 1 / (q.mean * q.mean);
            gradient += (-2 / (q.mean * q.mean * q.mean)) * q.by_node[e.node];
        }
        for (int k = 0; k < D; ++k) place.gradient[k] = dot(axes_[k], gradient);
        return place;
    }
    /// Returns a position with a lower `sum` and no lower `worst`, or `here` if none is found.
    [[nodiscard]] NodePlace<D> better(const NodePlace<D>& here) const {
        constexpr int max_steps = 12;
        constexpr double worthwhile = 1e-4;  // relative decrease of the sum that a step must promise
        NodePlace<D> now = here;
        // First estimate of the inverse Hessian, for regular elements.
        Sym<D> inverse_hessian = (0.05 / static_cast<double>(elements.size())) * Sym<D>::identity();
        for (int step = 0; step < max_steps; ++step) {
            Vec<D> way = -1.0 * (inverse_hessian * now.gradient);
            if (!(-dot(way, now.gradient) > worthwhile * now.sum)) break;
            if (const double length = norm(way); length > longest_way) way *= longest_way / length;
            const NodePlace<D> next = along(now, way, here.worst);
            if (!(next.sum < now.sum)) break;
            update(inverse_hessian, next.y - now.y, next.gradient - now.gradient);
            now = next;
        }
        return now;
    }
    /// Accepts `node` if certificates prove that the edge's elements meet their Jacobian bounds there. The bounds then
    /// hold on the whole way to `node`, because they hold at both ends and det J is affine in the node.
    [[nodiscard]] std::optional<JudgedNode<D>> judged(EdgeId edge, const Vec<D>& node) const {
        const bool is_valid = std::ranges::all_of(elements, [&](const DistortedElement<D>& e) {
            return decide(NodalSimplex<D>{with_node(e, node)}, e.bound) == Verdict::valid;
        });
        if (!is_valid) return {};
        JudgedNode<D> out;
        out.edge_ = edge;
        out.node_ = {node};
        return out;
    }

  private:
    static constexpr double longest_way = 0.25;  ///< maximum length of a step in the metric

    [[nodiscard]] static QuadraticNodes<D> with_node(const DistortedElement<D>& e, const Vec<D>& node) {
        QuadraticNodes<D> nodes = e.nodes;
        nodes[e.node] = node;
        return nodes;
    }
    /// Armijo line search in the direction `way`. Requires at least quality `worst`. Returns `from` if it fails.
    [[nodiscard]] NodePlace<D> along(const NodePlace<D>& from, const Vec<D>& way, double worst) const {
        const double slope = dot(from.gradient, way);
        for (double share = 1; share > 0.01; share /= 2) {
            const NodePlace<D> there = at(from.y + share * way);
            if (there.worst >= worst && there.sum < from.sum + 1e-3 * share * slope) return there;
        }
        return from;
    }
    static void update(Sym<D>& h, const Vec<D>& s, const Vec<D>& d) {
        const double sd = dot(s, d);
        if (!(sd > 1e-10 * norm(s) * norm(d))) return;
        const Vec<D> hd = h * d;
        const double factor = (1 + dot(d, hd) / sd) / sd;
        for (int i = 0; i < D; ++i)
            for (int j = 0; j <= i; ++j) h(i, j) += factor * s[i] * s[j] - (hd[i] * s[j] + s[i] * hd[j]) / sd;
    }

    Vec<D> origin_;
    std::array<Vec<D>, D> axes_{};
};

// Cavity operator for linear (paper §1.3) and quadratic meshes (§3.2): joins a cavity to a point, checks the result,
// and corrects it.

template <int D>
struct OperationWorkspace {
    StarWorkspace<D> star;
    Cavity<D> cavity;
    std::vector<std::size_t> pieces;  ///< smooth piece of each removed facet
    std::vector<double> shapes;
    std::vector<std::size_t> defective,
        defective_before;  ///< `defective`: elements with the last fault; `defective_before`: those with a fault before
                           ///< nodes were corrected
    CurvedWorkspace<D> curved;
};

struct OperationResult {
    RejectionReason rejected = RejectionReason::none;
    bool is_planned = true;  ///< false: rejected before planning
    double worst_shape = 0;  ///< lowest quality of new elements, if accepted
    int corrections = 0;
    int optimisation_problems = 0;  ///< number of problems solved, see `PassStatistics`
    double farthest_facet = 0;
    bool straight_inverted = false, straight_positive = false, relaxed = false;
    bool bends_around = false;  ///< nodes on outer faces of the cavity move
};

/// Joins a cavity to its point, computes the edge nodes, and checks and corrects the new elements. `out` is valid only
/// if the request is not rejected. Signs of volumes are exact. In degree 2, straight elements may be inverted (see
/// `CurvedNodes`).
///
/// If new elements stay faulty, the removed elements that they replace leave the cavity, if allowed (see
/// `fixed_element_count`). If none may leave, the element across the outer face of a faulty element joins the cavity.
/// `PatchLimits::corrections` limits the number of these changes.
template <int D>
[[nodiscard]] OperationResult operate(const Adaptation<D>& r, const AdaptationGoal<D>& goal,
                                      const CavityRequest<D>& request, const PatchLimits& limits,
                                      OperationWorkspace<D>& workspace, JudgedPatch<D>& out);

template <int D>
struct CommittedState {
    Adaptation<D> state;
    TopologyChanges changes;
};

/// Applies patches (`replace_cavities`) and updates all other data of the state. Pass the state by `std::move` to avoid
/// a copy; an error then destroys it. Errors: those of `replace_cavities`.
template <int D>
[[nodiscard]] Outcome<CommittedState<D>> commit(Adaptation<D> state, std::vector<JudgedPatch<D>> patches);

/// Moves edge nodes without a change of topology. Patches planned before become invalid. Precondition: no two of the
/// nodes' edges share an element.
template <int D>
[[nodiscard]] Adaptation<D> commit(Adaptation<D> state, std::span<const JudgedNode<D>> nodes);

template <int D>
struct FinishedMesh {
    CompactMesh<D> compact;
    Column<LogMetric<D>> log_metrics;
    Column<GeometryPosition> places;  ///< see `VertexData`
};

/// Returns the mesh without free slots. The mesh lists all corners and, in 3D, all ridges. Ridges that the input did
/// not list (`implied`) are included, because angles between facets need not show them. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<FinishedMesh<D>> finished(const Adaptation<D>& r, const Execution& execution);

struct PassStatistics {
    std::size_t rounds = 0;     ///< number of rounds that committed patches
    std::size_t proposals = 0;  ///< number of requests; a deferred request counts each time
    std::size_t planned = 0;    ///< requests not rejected before planning
    std::size_t accepted = 0;
    std::size_t corrections = 0;
    std::size_t shortened = 0;  ///< accepted points that did not reach the geometry
    /// Counts for degree 2. `straight_inverted`: accepted although a straight element is not positive.
    /// `straight_positive`: rejected as `volume` although all straight elements are positive. `relaxed`: accepted with
    /// relaxed nodes.
    std::size_t straight_inverted = 0, straight_positive = 0, relaxed = 0;
    std::size_t bent_around = 0;            ///< accepted operations that moved nodes around the cavity
    std::size_t optimisation_problems = 0;  ///< problems solved, also for rejected operations
    /// Largest `FacetDistance::largest` of accepted swaps and collapses.
    double farthest_facet = 0;
    std::size_t moved_nodes = 0;  ///< nodes moved to reduce distortion
    std::array<std::size_t, rejection_reasons> rejected{};

    [[nodiscard]] std::size_t of(RejectionReason reason) const { return rejected[static_cast<std::size_t>(reason)]; }
    PassStatistics& operator+=(const PassStatistics& other) {
        rounds += other.rounds;
        proposals += other.proposals;
        planned += other.planned;
        accepted += other.accepted;
        corrections += other.corrections;
        shortened += other.shortened;
        straight_inverted += other.straight_inverted;
        straight_positive += other.straight_positive;
        relaxed += other.relaxed;
        bent_around += other.bent_around;
        optimisation_problems += other.optimisation_problems;
        farthest_facet = std::max(farthest_facet, other.farthest_facet);
        moved_nodes += other.moved_nodes;
        for (std::size_t i = 0; i < rejected.size(); ++i) rejected[i] += other.rejected[i];
        return *this;
    }
    friend bool operator==(const PassStatistics&, const PassStatistics&) = default;
};

/// A task at the mesh entity with number `id`. Tasks with the smallest `order` come first. Numbers of removed entities
/// are reused, so `Pass::candidate` must check again whether the task is necessary.
struct Task {
    double order = 0;
    std::uint64_t rank = 0;  ///< decides between tasks of equal order
    std::uint32_t id = 0;
    friend bool operator<(const Task& a, const Task& b) {
        return std::tie(a.order, a.rank, a.id) < std::tie(b.order, b.rank, b.id);
    }
};
template <class Tag>
[[nodiscard]] Task task(double order, Id<Tag> id) {
    return {order, spread_rank(id), id.value};
}

/// A remeshing pass. It creates a request for each task, and new tasks after each commit.
template <int D>
class Pass {
  public:
    virtual ~Pass() = default;
    /// Returns the request of a task; empty if the task is unnecessary. Several threads call this at the same time.
    [[nodiscard]] virtual std::optional<Candidate<D>> candidate(const Adaptation<D>& r, const Task& task) const = 0;
    /// Returns the same request, but the point moves only by this share of its way to the geometry. Empty if there is
    /// no such request.
    [[nodiscard]] virtual std::optional<Candidate<D>> shortened(const Adaptation<D>&, const Task&, double) const {
        return {};
    }
    /// Called with the tasks of a round that were rejected or unnecessary.
    virtual void refused(Adaptation<D>&, std::span<const Task>) const {}
    virtual void follow(Adaptation<D>& r, const TopologyChanges& changes, std::vector<Task>& tasks) = 0;

  protected:
    Pass() = default;
    Pass(const Pass&) = default;
    Pass(Pass&&) = default;
    Pass& operator=(const Pass&) = default;
    Pass& operator=(Pass&&) = default;
};

/// Executes tasks, and the tasks that these create, in rounds. A round plans the first tasks against one mesh and
/// commits their patches in order. A task waits for the next round if its patch conflicts with an earlier one: if both
/// have a common element, create the same edge, or have crossing facets. The result does not depend on the number of
/// threads. Errors: those of `commit`; stopped, memory.
template <int D>
[[nodiscard]] Outcome<PassStatistics> run_pass(Adaptation<D>& r, const AdaptationGoal<D>& goal, Pass<D>& pass,
                                               std::vector<Task> tasks, const Execution& execution);

}  // namespace camber
