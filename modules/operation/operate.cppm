// Judged patches, workspaces, the operation, commits, and rounds of tasks.
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

/// A patch that was judged, and found good enough: only `operate` makes one, and `commit` takes no other. It speaks of
/// the state that it was planned for.
template <int D>
class JudgedPatch {
  public:
    [[nodiscard]] const Patch<D>& patch() const { return patch_; }
    /// What becomes known of its point.
    [[nodiscard]] const VertexRow<D>& vertex() const { return vertex_; }
    /// Whether its point went a part of its way to the geometry only.
    [[nodiscard]] bool is_short_of_geometry() const { return is_short_; }
    /// Of the elements that it reshapes, then of its own in the order of the star's `joined`: shape_of, below 0 where
    /// that is not known.
    [[nodiscard]] std::span<const double> shapes() const { return shapes_; }
    /// Of degree 2: of its edges at the point, in the order of the star's `boundary`, length_of.
    [[nodiscard]] std::span<const double> lengths() const { return lengths_; }
    /// Its patch, out of it.
    [[nodiscard]] Patch<D> take_patch() && { return std::move(patch_); }

  private:
    template <int, class>
    friend class Operating;

    Patch<D> patch_;
    VertexRow<D> vertex_;
    std::vector<double> shapes_, lengths_;
    bool is_short_ = false;
};

/// A node of an inner edge, elsewhere than it was, that was judged: only `NodeShell` makes one.
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

// What curving a star fills anew each time.

/// An edge from the point to a vertex of the star's boundary.
template <int D>
struct Spoke {
    EdgeKind kind = EdgeKind::volume;  ///< fixed: of elements or facets outside of the cavity too
    /// Where the metric (the geometry) has its node, and the cavity's old curves.
    Vec<D> wanted, extended;
    Vec<D> node;
    bool is_extended = false;  ///< whether `extended` is known
    double share = 1;          ///< of the way from `extended` to `wanted`
    LineId line;               ///< of a ridge: one that it continues
    /// The last that was measured, with which node.
    double length = -1;
    Vec<D> measured;
};

/// A new element: its face outside, and which spokes lead from there to the point.
template <int D>
struct Cone {
    QuadraticNodes<D> nodes{};
    std::array<const LogMetric<D>*, D + 1> metrics{};  ///< of each local vertex
    std::array<std::uint32_t, D + 1> spokes{};         ///< of each local vertex but `point`
    int point = 0;                                     ///< local vertex
    bool is_stale = true, is_flat = false;
    bool is_surely_straight_positive = false;  ///< its straight element, beyond rounding
    Verdict verdict = Verdict::undecided;
    double shape = -1;  ///< of a valid one, once it was asked for
};

/// An inner edge of the star's outer faces, whose node may follow.
template <int D>
struct RimEdge {
    EdgeId edge;
    Vec<D> before, wanted, node;
};

/// An element outside of the cavity that has such an edge.
template <int D>
struct OutsideElement {
    ElementId element;
    QuadraticNodes<D> nodes{};
    double bound = 0;  ///< what its scaled Jacobian is to keep
};

/// A removed element as a map from its straight shape to its curved one.
template <int D>
struct OldElement {
    ElementId element;
    double size = 0;  ///< of the straight one, whichever way round
    Vec<D> origin;
    std::array<Vec<D>, D> gradients{};                 ///< of the barycentric coordinates 1 … D
    std::array<Vec<D>, edges_per_simplex<D>> offsets;  ///< of the nodes from the middles of chords
};

template <int D>
struct CurvedWorkspace {
    std::vector<Spoke<D>> spokes;
    std::vector<Cone<D>> cones;
    std::vector<std::size_t> stale;  ///< of them
    std::vector<RimEdge<D>> rim;
    std::vector<OutsideElement<D>> outside;
    std::vector<ElementId> around;
    std::vector<OldElement<D>> old_elements;
    std::vector<FacetSite<D>> facets;                     ///< new ones
    std::vector<std::array<std::uint32_t, 2>> of_facets;  ///< spoke, and the new facet with it
    std::vector<Vec<D>> chords, offsets;
    std::vector<EndSights<D>> ends;
    std::vector<double> lengths;
    std::vector<BentSpoke<D>> bent;  ///< of this operation, but for those that its request has
    std::vector<FreeEdge<D>> searched;
    std::vector<EdgeMinimum<D>> found;
    std::vector<std::uint32_t> free;            ///< spokes that are to be bent
    std::vector<std::uint32_t> short_of_place;  ///< spokes that approach where they are wanted
    int programmes = 0;                         ///< spent
};

// The node of one inner edge, and how its place distorts the elements around it.

/// An element around the edge with all that does not depend on the node.
template <int D>
struct DistortedElement {
    QuadraticNodes<D> nodes{};
    ElementMetric<D> metric;
    int node = 0;      ///< which of its nodes is the edge's
    double bound = 0;  ///< what its scaled Jacobian is to keep
};

/// What a place of the node comes to. The sum is that of η̄², η̄ the mean distortion of an element: the squares make the
/// worst element count most, and the sum has the same gradient for any scale of the metric.
template <int D>
struct NodePlace {
    Vec<D> y;          ///< in the frame
    Vec<D> point;      ///< its node
    double sum = 0;    ///< infinite where an element folds
    double worst = 0;  ///< the least quality, 1/η̄
    Vec<D> gradient;   ///< of the sum, in the frame
};

/// Finds the place by BFGS in the frame in which the metric at the edge's middle is the identity, where elements are
/// about as large as 1 at any anisotropy.
template <int D>
class NodeShell {
  public:
    std::vector<DistortedElement<D>> elements;

    /// The node's frame: where it is now, and the metric at the edge's middle.
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
    /// A place of a lower sum, whose worst element is no worse; `here` where there is none.
    [[nodiscard]] NodePlace<D> better(const NodePlace<D>& here) const {
        constexpr int max_steps = 12;
        constexpr double worthwhile = 1e-4;  // of the sum, promised by a step
        NodePlace<D> now = here;
        // About the inverse of the second derivative in an element that is regular.
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
    /// The edge's node there, if every element keeps its bound by the certificate: with it at both ends, and det J
    /// affine in the node, all of the way is certified.
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
    static constexpr double longest_way = 0.25;  ///< of a unit edge

    [[nodiscard]] static QuadraticNodes<D> with_node(const DistortedElement<D>& e, const Vec<D>& node) {
        QuadraticNodes<D> nodes = e.nodes;
        nodes[e.node] = node;
        return nodes;
    }
    /// By Armijo's rule, and as the worst element may be; `from` where nothing serves.
    [[nodiscard]] NodePlace<D> along(const NodePlace<D>& from, const Vec<D>& way, double worst) const {
        const double slope = dot(from.gradient, way);
        for (double share = 1; share > 0.01; share /= 2) {
            const NodePlace<D> there = at(from.y + share * way);
            if (there.worst >= worst && there.sum < from.sum + 1e-3 * share * slope) return there;
        }
        return from;
    }
    /// BFGS, where the curvature is positive.
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

// The cavity operator, of degree 1 (paper §1.3) and 2 (§3.2): a cavity and a point, joined, judged, corrected where
// that helps.

template <int D>
struct OperationWorkspace {
    StarWorkspace<D> star;
    Cavity<D> cavity;
    std::vector<std::size_t> pieces;                 ///< of the cavity's facets
    std::vector<double> shapes;                      ///< of the star's elements, as far as they were judged
    std::vector<std::size_t> faulty, faulty_before;  ///< of them, by the last fault, and before nodes were corrected
    CurvedWorkspace<D> curved;
};

/// What came of a request.
struct OperationResult {
    RejectionReason rejected = RejectionReason::none;
    bool is_planned = true;  ///< false: the candidate was rejected before
    double worst_shape = 0;  ///< of the new elements, where nothing is rejected
    int corrections = 0;
    /// Of degree 2: what the test of degree 1 says of the same star: that an element has no volume, or that all have
    /// one. And whether nodes were drawn back from where the metric has them.
    int programmes = 0;         ///< spent
    double farthest_facet = 0;  ///< see PassStatistics
    bool straight_inverted = false, straight_positive = false, drawn_back = false;
    bool bends_around = false;  ///< nodes around the cavity follow
};

/// The way of a request: its star, the star's nodes by the degree, the judge, corrections; what is good enough in the
/// end is `out`, which means something only where nothing is rejected. The state is as it was in any case. Signs of
/// volumes are exact; in a mesh of degree 2 straight elements may be as they like (see CurvedNodes). Where an element
/// would be inverted or bad, the one that it comes of leaves the cavity if it may (see `holders`), and of
/// degree 2, which looks at all, with it the others of which that is so: no other change would mend them; otherwise the
/// one across its outer face joins it: up to `corrections` times.
template <int D>
[[nodiscard]] OperationResult operate(const Adaptation<D>& r, const AdaptationGoal<D>& goal,
                                      const CavityRequest<D>& request, const PatchLimits& limits,
                                      OperationWorkspace<D>& workspace, JudgedPatch<D>& out);

/// A state with patches in place, and which entities that changed.
template <int D>
struct CommittedState {
    Adaptation<D> state;
    TopologyChanges changes;
};

/// The last verb of the operator, and the only way into a state: patches in the place of their cavities (see
/// replace_cavities), and with them all that is known of vertices; walls; points that are short of the geometry. Give
/// the state away (std::move), or all of it is copied; with an error it is lost then. Errors: of replace_cavities.
template <int D>
[[nodiscard]] Outcome<CommittedState<D>> commit(Adaptation<D> state, std::vector<JudgedPatch<D>> patches);

/// Nodes alone: topology stays, and patches that were planned before are not of this state. The edges share no element.
template <int D>
[[nodiscard]] Adaptation<D> commit(Adaptation<D> state, std::span<const JudgedNode<D>> nodes);

/// A mesh that was remeshed, as any other mesh, its metric at each vertex, and what that lies on.
template <int D>
struct FinishedMesh {
    CompactMesh<D> compact;
    Column<LogMetric<D>> log_metrics;
    Column<GeometryPlace> places;  ///< see Adaptation
};

/// The mesh without free places. All corners are listed in it and all lines on which its surfaces break (3D), those
/// too that nobody listed before: who reads the mesh sees the breaks that the passes kept, which angles between new
/// facets need not show. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<FinishedMesh<D>> finished(const Adaptation<D>& r, const Execution& execution);

/// What a pass did.
struct PassStatistics {
    std::size_t rounds = 0;     ///< commits
    std::size_t proposals = 0;  ///< requests; one that waits is made again, and counted again
    std::size_t planned = 0;    ///< those of them that a pass's own measures let through, of which a star was made
    std::size_t accepted = 0;
    std::size_t corrections = 0;  ///< how often elements joined or left cavities of accepted ones
    std::size_t shortened = 0;    ///< accepted points that went a part of their way to the geometry only
    /// Of degree 2: accepted that the straight test would refuse, refused as `volume` that it would accept, and
    /// accepted whose nodes are not where the metric has them.
    std::size_t straight_inverted = 0, straight_positive = 0, drawn_back = 0;
    std::size_t bent_around = 0;  ///< accepted that take nodes around their cavity along
    std::size_t programmes = 0;   ///< spent on inner edges, accepted or not
    /// Of facets that swaps and collapses made: how far one is from the geometry at most, as a share of its longest
    /// edge.
    double farthest_facet = 0;
    std::size_t moved_nodes = 0;  ///< of inner edges, by distortion; they are no proposals
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
        drawn_back += other.drawn_back;
        bent_around += other.bent_around;
        programmes += other.programmes;
        farthest_facet = std::max(farthest_facet, other.farthest_facet);
        moved_nodes += other.moved_nodes;
        for (std::size_t i = 0; i < rejected.size(); ++i) rejected[i] += other.rejected[i];
        return *this;
    }
    friend bool operator==(const PassStatistics&, const PassStatistics&) = default;
};

/// A thing to be done at an entity: the least `order` first. Numbers of entities are taken again, so a task may come to
/// speak of another one: whoever makes a request of it looks whether there is reason for one.
struct Task {
    double order = 0;
    std::uint64_t rank = 0;  ///< where orders are equal
    std::uint32_t id = 0;
    friend bool operator<(const Task& a, const Task& b) {
        return std::tie(a.order, a.rank, a.id) < std::tie(b.order, b.rank, b.id);
    }
};
template <class Tag>
[[nodiscard]] Task task(double order, Id<Tag> id) {
    return {order, spread_rank(id), id.value};
}

/// One pass: how a task becomes a request, and what tasks a commit brings.
template <int D>
class Pass {
  public:
    virtual ~Pass() = default;
    /// Nothing where there is no reason for one. Asked by several threads.
    [[nodiscard]] virtual std::optional<Candidate<D>> candidate(const Adaptation<D>& r, const Task& task) const = 0;
    /// The same request for a point that goes this share of its way to the geometry; nothing where it has no such way.
    [[nodiscard]] virtual std::optional<Candidate<D>> shortened(const Adaptation<D>&, const Task&, double) const {
        return {};
    }
    /// Told of requests that were refused, or for which there was no reason, in the mesh as it is.
    virtual void refused(Adaptation<D>&, std::span<const Task>) const {}
    virtual void follow(Adaptation<D>& r, const TopologyChanges& changes, std::vector<Task>& tasks) = 0;

  protected:
    Pass() = default;
    Pass(const Pass&) = default;
    Pass(Pass&&) = default;
    Pass& operator=(const Pass&) = default;
    Pass& operator=(Pass&&) = default;
};

/// Does the tasks, and those that come of them, in rounds: the first are planned together against one mesh; of those
/// patches the first is taken, then each that removes no element and makes no edge of one before; one commit. Threads
/// have no say in it. Errors: of commit; stopped, memory.
template <int D>
[[nodiscard]] Outcome<PassStatistics> run_pass(Adaptation<D>& r, const AdaptationGoal<D>& goal, Pass<D>& pass,
                                               std::vector<Task> tasks, const Execution& execution);

}  // namespace camber
