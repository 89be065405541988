// Delaunay cavities of inserted points, and reinsertion of all vertices.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>
module camber.adapt;
import camber.core;
import camber.cavity;
import camber.metric;
import camber.validity;
import camber.operation;

namespace camber {

namespace {

/// True if the origin is inside the smallest sphere through the corners of the triangle.
bool is_origin_in_sphere(const std::array<Vec<3>, 3>& y) {
    const Vec<3> u = y[1] - y[0];
    const Vec<3> v = y[2] - y[0];
    const Vec<3> n = cross(u, v);
    const double area = norm_squared(n);
    if (!(area > 0)) return false;
    const Vec<3> to_centre = (norm_squared(u) * cross(v, n) + norm_squared(v) * cross(n, u)) / (2 * area);
    return norm_squared(y[0] + to_centre) < norm_squared(to_centre);
}

/// Vertices near a point, and the tangents at the point of the edges to them. If the first edges bend little, the other
/// edges are replaced by chords, which suffice for sphere tests.
template <int D>
class NearbyVertices {
  public:
    NearbyVertices(const Adaptation<D>& r, BentSpokes<D>& spokes)
        : r_(r), spokes_(spokes), is_bent_(!spokes.are_nearly_straight()) {
        for (std::size_t i = 0; i < spokes.size(); ++i) push(spokes.vertex(i), spokes.tangent(i));
    }
    void add(VertexId v) {
        if (is_among(vertices_, v)) return;
        push(v, r_.mesh.points[v] - spokes_.point().place);
        if (is_bent_) spokes_.add(v, r_.mesh.points[v], r_.vertices.metrics[v]);
    }
    void bend() {
        if (!is_bent_) return;
        spokes_.bend();
        for (std::size_t i = 0; i < tangents_.size(); ++i) tangents_[i] = spokes_.tangent(i);
    }
    [[nodiscard]] const Vec<D>& tangent(VertexId v) const { return tangents_[index_of(v)]; }
    [[nodiscard]] double length(VertexId v) const {
        const std::size_t i = index_of(v);
        if (i < spokes_.size()) return spokes_.length(i);
        if (r_.mesh.is_at_infinity(v)) return length_to_infinity;
        return edge_length(spokes_.point().metric->measure, r_.vertices.metrics[v].measure, tangents_[i]);
    }

  private:
    void push(VertexId v, const Vec<D>& tangent) {
        vertices_.push_back(v);
        tangents_.push_back(tangent);
    }
    [[nodiscard]] std::size_t index_of(VertexId v) const {
        return static_cast<std::size_t>(std::ranges::find(vertices_, v) - vertices_.begin());
    }
    const Adaptation<D>& r_;
    BentSpokes<D>& spokes_;
    bool is_bent_;
    std::vector<VertexId> vertices_;
    std::vector<Vec<D>> tangents_;
};

template <int D>
bool is_in_metric_sphere(const Adaptation<D>& r, ElementId e, const ConePoint<D>& point,
                         const NearbyVertices<D>& nearby) {
    const auto& vertices = r.mesh.elements.vertices[e];
    if constexpr (D == 3)
        if (r.mesh.is_surface()) {
            std::array<Vec<3>, 3> y;
            for (int i = 0; i < 3; ++i)
                for (int k = 0; k < 3; ++k) y[i][k] = dot(point.metric->measure.rows[k], nearby.tangent(vertices[i]));
            return is_origin_in_sphere(y);
        }
    // y_i: position of the element's vertex i relative to the point, in coordinates in which the metric is the
    // identity. The origin is inside the sphere through all y_i if the determinant with rows (y_i, |y_i|²) has the sign
    // of the volume.
    std::array<Vec<D>, D + 1> y;
    std::array<double, D + 1> squares{};
    for (int i = 0; i <= D; ++i) {
        const Vec<D> x = nearby.tangent(vertices[i]);
        for (int k = 0; k < D; ++k) y[i][k] = dot(point.metric->measure.rows[k], x);
        squares[i] = norm_squared(y[i]);
    }
    // The determinants are expanded by the last column. Each minor is the volume of the simplex of a face and the
    // point.
    double lifted = 0;
    double volume = 0;
    for (int i = 0; i <= D; ++i) {
        const auto face = face_opposite<D>(i);
        Mat<D> sides;
        for (int k = 0; k < D; ++k) sides.column[k] = y[face[k]];
        const double part = det(sides);
        lifted += part * squares[i];
        volume += part;
    }
    return volume > 0 ? lifted > 0 : lifted < 0;
}

template <int D>
bool breaks_across(const DynamicMesh<D>& mesh, ElementId e, int face) {
    if (!mesh.is_surface() || face == D) return false;
    return mesh.line_at(mesh.edges_of[e][edge_between<D>[(face + 1) % 3][(face + 2) % 3]]).valid();
}

/// Element across the face; invalid if a cavity may not grow across it.
template <int D>
ElementId beyond(const DynamicMesh<D>& mesh, ElementId e, int face) {
    const FaceNeighbour across = mesh.face_neighbours[e][face];
    const bool is_open = across.valid() && across.is_element() && !breaks_across(mesh, e, face);
    return is_open ? across.element() : ElementId{};
}

template <int D>
void add_nearby(const DynamicMesh<D>& mesh, ElementId e, NearbyVertices<D>& nearby) {
    for (const VertexId v : mesh.elements.vertices[e]) nearby.add(v);
    for (int face = 0; face <= D; ++face)
        if (const ElementId next = beyond(mesh, e, face); next.valid()) nearby.add(opposite_vertex(mesh, next, e));
}

}  // namespace

template <int D>
void grow_delaunay(const Adaptation<D>& r, BentSpokes<D>& spokes, std::size_t most, double shortest,
                   Cavity<D>& cavity) {
    auto& elements = cavity.elements;
    const ConePoint<D>& point = spokes.point();
    NearbyVertices<D> nearby(r, spokes);
    std::size_t expanded = 0;  // number of elements whose neighbours were added to `nearby`
    for (std::size_t i = 0; i < elements.size() && elements.size() < most; ++i) {
        if (i == expanded) {
            for (; expanded < elements.size(); ++expanded) add_nearby(r.mesh, elements[expanded], nearby);
            nearby.bend();
        }
        for (int face = 0; face <= D && elements.size() < most; ++face) {
            const ElementId next = beyond(r.mesh, elements[i], face);
            if (!next.valid() || is_among(elements, next) || !is_in_metric_sphere(r, next, point, nearby)) continue;
            if (!(nearby.length(opposite_vertex(r.mesh, next, elements[i])) < shortest)) join(r.mesh, cavity, next);
        }
    }
}

namespace {

template <int D>
class Reinsertions final : public Pass<D> {
  public:
    Reinsertions(const Adaptation<D>& r, const AdaptationGoal<D>& goal, const ReinsertionOptions& options)
        : goal_(goal), options_(options), touched_(r.mesh.points.size(), 1) {}

    [[nodiscard]] std::optional<Candidate<D>> candidate(const Adaptation<D>& r, const Task& task) const override {
        return candidate_at(r, task, 1);
    }
    /// Only for boundary vertices: the nodes of their edges move a share of the way.
    [[nodiscard]] std::optional<Candidate<D>> shortened(const Adaptation<D>& r, const Task& task,
                                                        double share) const override {
        if (r.mesh.states[VertexId(std::size_t{task.id})].place == VertexPlace::inside) return {};
        return candidate_at(r, task, share);
    }
    void follow(Adaptation<D>& r, const TopologyChanges& changes, std::vector<Task>&) override {
        for (const ElementId e : changes.elements.created)
            for (const VertexId v : r.mesh.elements.vertices[e]) touched_[v.index()] = 1;
    }
    [[nodiscard]] std::vector<Task> tasks(const Adaptation<D>& r) {
        std::vector<std::uint8_t> is_short(r.mesh.points.size(), 0);
        for (std::size_t e = 0; e < r.mesh.edges.size(); ++e)
            if (r.mesh.nodes[e] != goal_.target_nodes[e])
                for (const VertexId v : r.mesh.edges[e]) is_short[v.index()] = 1;
        std::vector<Task> tasks;
        for (std::size_t v = 0; v < is_short.size(); ++v)
            if (is_short[v] != 0 && touched_[v] != 0)
                tasks.push_back(task(r.mesh.states[v].place == VertexPlace::inside ? 0 : 1, VertexId(v)));
        touched_.assign(r.mesh.points.size(), 0);
        return tasks;
    }

    [[nodiscard]] bool is_approaching() const { return is_approaching_; }
    /// From now on, nodes move towards their targets as far as elements allow, not only in half steps. In earlier
    /// sweeps, this would prevent moves of other nodes.
    [[nodiscard]] bool begin_approaching() {
        if (is_approaching_) return false;
        touched_.assign(touched_.size(), 1);
        return is_approaching_ = true;
    }

  private:
    [[nodiscard]] std::optional<Candidate<D>> candidate_at(const Adaptation<D>& r, const Task& task,
                                                           double share) const {
        const VertexId v(std::size_t{task.id});
        if (r.mesh.is_free(v) || r.mesh.states[v].marks.has(Mark::frozen)) return {};
        Candidate<D> candidate;
        cavity_of_vertex(r.mesh, v, candidate.request.cavity);
        candidate.request.join_to(r, v);
        candidate.request.share = share;
        candidate.limits.below_minimum = BelowMinimum::accepted_if_no_worse;
        candidate.limits.min_jacobian = std::max(options_.target, options_.min_scaled_jacobian);
        candidate.limits.lowest_jacobian = options_.min_scaled_jacobian;
        candidate.limits.invalid_replacement = InvalidReplacement::may_stay;
        candidate.limits.facet_cosine = any_facet;
        candidate.limits.corrections = 0;
        candidate.limits.node_gain = NodeGain::requested;
        candidate.limits.approaching = is_approaching_ ? max_approaching : 0;
        return candidate;
    }
    static constexpr int max_approaching = 24;
    static constexpr double any_facet = -2;  ///< below any cosine: the limit is off, because corners of facets do not
                                             ///< move
    const AdaptationGoal<D>& goal_;
    ReinsertionOptions options_;
    bool is_approaching_ = false;
    std::vector<std::uint8_t> touched_;  ///< per vertex: 1 if an element at it has changed
};

template <int D>
Proposal<D> proposal_of(const QuadraticMesh<D>& mesh, const DynamicMesh<D>& result,
                        const Proposal<D>& target_proposal) {
    Buffer<EdgeChange> changes(mesh.edges.size());
    for (std::size_t e = 0; e < changes.size(); ++e)
        changes[e] = result.nodes[e] == target_proposal.mid_nodes[e] ? target_proposal.changes[e] : EdgeChange::relaxed;
    return {mesh.linear.points, result.nodes, target_proposal.kinds, std::move(changes)};
}

template <int D>
QuadraticMesh<D> with_bare_edges(QuadraticMesh<D> mesh, const Column<LagrangeNode<D>>& target_proposal) {
    std::vector<std::uint8_t> is_fixed(mesh.edges.size(), 0);
    for (const auto& edges : mesh.edges.of_elements)
        for (const EdgeId e : edges) is_fixed[e.index()] = 1;
    if (std::ranges::find(is_fixed, std::uint8_t{0}) == is_fixed.end()) return mesh;
    auto nodes = take(std::move(mesh.mid_nodes));
    for (std::size_t e = 0; e < nodes.size(); ++e)
        if (is_fixed[e] == 0) nodes[e] = target_proposal[e];
    mesh.mid_nodes = std::move(nodes);
    return mesh;
}

template <int D>
Outcome<ReinsertionResult<D>> reinserted(const QuadraticMesh<D>& mesh, const Proposal<D>& target_proposal,
                                         const BreaksOfMesh& breaks, const BackMesh<D>& field,
                                         const ReinsertionOptions& options, const Execution& execution) {
    AdaptationGoal<D> goal{field, {}};
    goal.target_nodes = target_proposal.mid_nodes;
    auto initial = begin_adaptation(mesh, breaks, goal, part_of(execution, 0, 0.05));
    if (!initial) return fail(initial.error());
    ReinsertionResult<D> out;
    Reinsertions<D> pass(*initial, goal, options);
    std::vector<Task> tasks = pass.tasks(*initial);
    constexpr int max_approaching_sweeps = 10;  // further sweeps improve little
    int approaching_sweeps = 0;
    while (static_cast<int>(out.sweeps) < options.max_sweeps) {
        if (tasks.empty() && pass.begin_approaching()) tasks = pass.tasks(*initial);
        if (pass.is_approaching() && approaching_sweeps++ == max_approaching_sweeps) tasks.clear();
        if (tasks.empty()) break;
        auto statistics = run_pass<D>(*initial, goal, pass, std::move(tasks), part_of(execution, 0.05, 1));
        if (!statistics) return fail(statistics.error());
        out.statistics += *statistics;
        ++out.sweeps;
        tasks = pass.tasks(*initial);
    }
    out.left = tasks.size();
    out.proposal = proposal_of(mesh, initial->mesh, target_proposal);
    return out;
}

}  // namespace

template <int D>
Outcome<ReinsertionResult<D>> reinsert(const QuadraticMesh<D>& mesh, const Proposal<D>& target_proposal,
                                       const BreaksOfMesh& breaks, const BackMesh<D>& field,
                                       const ReinsertionOptions& options, const Execution& execution) {
    const std::size_t n = mesh.edges.size();
    if (target_proposal.mid_nodes.size() != n || target_proposal.kinds.size() != n ||
        target_proposal.changes.size() != n)
        return fail(ErrorKind::internal, "reinsert needs a target node for each of the " + std::to_string(n) +
                                             " edges, not " + std::to_string(target_proposal.mid_nodes.size()));
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    return guarded([&]() -> Outcome<ReinsertionResult<D>> {
        const QuadraticMesh<D> begin = with_bare_edges(mesh, target_proposal.mid_nodes);
        if (mesh.linear.elements.size() == 0) {  // standalone surface
            ReinsertionResult<D> out;
            out.proposal = {mesh.linear.points, begin.mid_nodes, target_proposal.kinds, target_proposal.changes};
            return out;
        }
        return reinserted(begin, target_proposal, breaks, field, options, execution);
    });
}

#define CAMBER_INSTANTIATE(D)                                                                              \
    template void grow_delaunay<D>(const Adaptation<D>&, BentSpokes<D>&, std::size_t, double, Cavity<D>&); \
    template Outcome<ReinsertionResult<D>> reinsert<D>(const QuadraticMesh<D>&, const Proposal<D>&,        \
                                                       const BreaksOfMesh&, const BackMesh<D>&,            \
                                                       const ReinsertionOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
