module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>
module camber.repair;
import :guide;
import :state;
import :vertex_moves;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;

namespace camber {

namespace {

/// Steps from one tangent plane to the next.
constexpr int max_slide_steps = 10;
/// What a slide weighs more than a move in the volume: it takes the surface's best approximation along.
constexpr double slide_weight = 10;
/// Beside it the geometry is left at no price.
constexpr double off_weight = 1e8;
/// What it costs an element to bring points back onto the geometry, as a scaled Jacobian: so much more is asked for, of
/// the seed most.
constexpr double slack = 2e-5, slack_of_seed = 1e-4;
/// A node is at most this share of its chord from where the chord's middle is on the geometry, or where it was: at a
/// quarter the curve's speed vanishes at an end.
constexpr double farthest = 0.24;
/// What vertices that move are asked to leave of the determinants around them, as shares, one after the other.
constexpr std::array kept_shares{0.2, 0.02};

/// A point that moves, and the projector onto the directions that it cannot go: 0 in the volume.
template <int D>
struct Slider {
    Vec<D> at;
    Sym<D> across = {};

    /// x without its part off the geometry.
    [[nodiscard]] Vec<D> along(const Vec<D>& x) const { return x - across * x; }
};

/// Where the nodes and vertices of a cavity are after some steps, in the order of its edges and vertices.
template <int D>
struct Sliding {
    const RepairState<D>& state;
    const RepairCavity<D>& cavity;
    std::vector<Slider<D>> nodes;
    std::vector<Slider<D>> points;

    [[nodiscard]] std::size_t unknowns() const { return nodes.size() + points.size(); }
    [[nodiscard]] Vec<D> point(VertexId v) const {
        const int at = position_in(cavity.vertices, v);
        return at < 0 ? state.moved.points[v] : points[static_cast<std::size_t>(at)].at;
    }
    [[nodiscard]] NodalSimplex<D> element(ElementId e) const {
        NodalSimplex<D> s = state.element(e);
        for (int i = 0; i <= D; ++i) s.nodes[i] = point(state.mesh().linear.elements.vertices[e][i]);
        for (int i = 0; i < edges_per_simplex<D>; ++i)
            if (const int at = position_in(cavity.edges, state.mesh().edges.of_elements[e][i]); at >= 0)
                s.nodes[D + 1 + i] = nodes[static_cast<std::size_t>(at)].at;
        return s;
    }
    [[nodiscard]] bool slides(std::size_t i) const { return state.kinds[cavity.edges[i]] != EdgeKind::volume; }
    [[nodiscard]] Vec<D> middle(std::size_t i) const {
        const auto& [a, b] = state.mesh().edges.vertices[cavity.edges[i]];
        return midpoint(point(a), point(b));
    }
    [[nodiscard]] double chord(std::size_t i) const {
        const auto& [a, b] = state.mesh().edges.vertices[cavity.edges[i]];
        return distance(point(a), point(b));
    }
    [[nodiscard]] Slider<D> foot(std::size_t i, const Vec<D>& p) const {
        if (!slides(i)) return {p};
        const GeometryFoot<D> there = (*state.onto)(cavity.edges[i], p);
        return {there.point, there.across};
    }
    [[nodiscard]] Slider<D> vertex_foot(std::size_t i, const Vec<D>& p) const {
        const VertexId v = cavity.vertices[i];
        if (state.around_vertices.freedom[v] != VertexFreedom::sliding) return {p};
        const GeometryFoot<D> there = (*state.vertices_onto)(v, p);
        return {there.point, there.across};
    }
    /// Goes on by these offsets of nodes and vertices, each in its tangent plane, and back onto the geometry. Vertices
    /// take half of their ways along to the nodes of their edges.
    void go(const std::vector<Vec<D>>& offsets) {
        std::vector<Vec<D>> before(nodes.size());
        for (std::size_t i = 0; i < nodes.size(); ++i) before[i] = middle(i);
        for (std::size_t i = 0; i < points.size(); ++i)
            points[i] = vertex_foot(i, points[i].at + points[i].along(offsets[nodes.size() + i]));
        for (std::size_t i = 0; i < nodes.size(); ++i)
            nodes[i] = foot(i, nodes[i].at + nodes[i].along(offsets[i]) + (middle(i) - before[i]));
    }
};

/// Where nodes of boundary edges begin: where they are, or where the middles of their chords are on the geometry.
/// Sliding goes downhill, and does not come out of a wrinkle of the boundary.
enum class SlideStart : std::uint8_t { as_it_is, from_middles };

template <int D>
Sliding<D> beginning(const RepairState<D>& state, const RepairCavity<D>& cavity, SlideStart start) {
    Sliding<D> at{state, cavity, {}, {}};
    at.points.reserve(cavity.vertices.size());
    for (std::size_t i = 0; i < cavity.vertices.size(); ++i) {
        at.points.push_back({state.moved.points[cavity.vertices[i]]});
        at.points[i] = at.vertex_foot(i, at.points[i].at);
    }
    at.nodes.reserve(cavity.edges.size());
    for (std::size_t i = 0; i < cavity.edges.size(); ++i) {
        const bool from_middle = start == SlideStart::from_middles && at.slides(i);
        at.nodes.push_back(at.foot(i, from_middle ? at.middle(i) : state.moved.nodes[cavity.edges[i]].point));
    }
    return at;
}

/// The model about where it is wanted, `back` of here, for a point that stays on the geometry.
template <int D>
OffsetModel<D> on_geometry(const Slider<D>& slider, const Vec<D>& back, const Sym<D>& hessian) {
    double trace = 0;
    for (int k = 0; k < D; ++k) trace += hessian(k, k);
    return {slider.along(back), slide_weight * hessian + off_weight * trace * slider.across};
}

/// What it costs node i to go on from where it is; one of the boundary is wanted where its chord's middle is.
template <int D>
OffsetModel<D> node_model(const Sliding<D>& at, std::size_t i) {
    const QuadraticModel<D> model = at.state.model(at.cavity.edges[i]);
    const Slider<D>& node = at.nodes[i];
    if (!at.slides(i)) return {model.centre - node.at, model.hessian};
    return on_geometry(node, at.foot(i, at.middle(i)).at - node.at, model.hessian);
}

template <int D>
OffsetModel<D> vertex_model(const Sliding<D>& at, std::size_t i) {
    const VertexId v = at.cavity.vertices[i];
    const OffsetModel<D> model = model_of(at.state, v);
    const Vec<D> back = at.state.mesh().linear.points[v] - at.points[i].at;
    if (at.state.around_vertices.freedom[v] != VertexFreedom::sliding) return {back, model.hessian};
    return on_geometry(at.points[i], back, model.hessian);
}

/// `wanted`: what the seed is to have; `share`: what is to be left of determinants where vertices move.
template <int D>
JointProgramme<D> programme_at(const Sliding<D>& at, ElementId seed, double wanted, double share) {
    const RepairState<D>& state = at.state;
    JointProgramme<D> programme;
    programme.first_penalty = JointProgramme<D>::strong;
    programme.unknowns.reserve(at.unknowns());
    for (std::size_t i = 0; i < at.nodes.size(); ++i) programme.unknowns.push_back(node_model(at, i));
    for (std::size_t i = 0; i < at.points.size(); ++i) programme.unknowns.push_back(vertex_model(at, i));
    const int edges = static_cast<int>(at.nodes.size());
    programme.elements.reserve(at.cavity.elements.size());
    const double bound = state.options.min_scaled_jacobian + slack;
    for (const ElementId e : at.cavity.elements) {
        const double kept = jacobian_to_keep(state, e, wanted);
        typename JointProgramme<D>::Element element{.bezier = bezier_form(at.element(e)),
                                                    .unknowns = {},
                                                    .floor = e == seed       ? wanted
                                                             : state.good(e) ? std::max(kept, bound)
                                                                             : kept};
        if (!at.points.empty()) element.least = min_of(state, at.cavity, e, share);
        for (int i = 0; i <= D; ++i) {
            const int vertex = position_in(at.cavity.vertices, state.mesh().linear.elements.vertices[e][i]);
            element.unknowns[i] = vertex < 0 ? JointProgramme<D>::fixed : edges + vertex;
        }
        for (int i = 0; i < edges_per_simplex<D>; ++i)
            element.unknowns[D + 1 + i] = position_in(at.cavity.edges, state.mesh().edges.of_elements[e][i]);
        programme.elements.push_back(element);
    }
    return programme;
}

/// Whether each node is where its edge's speed vanishes nowhere, or no farther than it was.
template <int D>
bool within_chords(const Sliding<D>& at) {
    for (std::size_t i = 0; i < at.nodes.size(); ++i) {
        if (!at.slides(i)) continue;
        const Vec<D> middle = at.foot(i, at.middle(i)).at;
        const EdgeId edge = at.cavity.edges[i];
        if (distance(at.nodes[i].at, middle) > farthest * at.chord(i) &&
            distance(at.nodes[i].at, middle) > distance(at.state.moved.nodes[edge].point, middle))
            return false;
    }
    return true;
}

/// The places as a plan with its verdicts; nothing where they spoil an element or do not repair the seed.
template <int D>
std::optional<Moves<D>> plan_of(const Sliding<D>& at, ElementId seed) {
    const RepairState<D>& state = at.state;
    if (!within_chords(at)) return std::nullopt;
    Moves<D> plan;
    for (const ElementId e : at.cavity.elements) {
        const NodalSimplex<D> next = at.element(e);
        const Verdict now = verdict_of(state, e, next);
        if (is_degraded(state, e, next, now) || (e == seed && now != Verdict::valid)) return std::nullopt;
        if (!keeps_shape(state, e, next, now)) return std::nullopt;
        plan.verdicts.emplace_back(e, now);
    }
    for (std::size_t i = 0; i < at.nodes.size(); ++i) plan.nodes.push_back({at.cavity.edges[i], {at.nodes[i].at}});
    for (std::size_t i = 0; i < at.points.size(); ++i) plan.points.emplace_back(at.cavity.vertices[i], at.points[i].at);
    return plan;
}

}  // namespace

template <int D>
Planned<D> plan_slide_repair(const RepairState<D>& state, const RepairCavity<D>& cavity, ElementId seed, double asked,
                             double max_work) {
    const auto is_volume = [&](EdgeId e) { return state.kinds[e] == EdgeKind::volume; };
    if (std::ranges::all_of(cavity.edges, is_volume)) return {};
    const double wanted = std::max<double>(state.options.min_scaled_jacobian, asked) + slack_of_seed;
    Planned<D> planned;
    const auto try_from = [&](SlideStart start, double share) {
        Sliding<D> at = beginning(state, cavity, start);
        for (int step = 0; step < max_slide_steps && planned.work < max_work && !planned.plan; ++step) {
            auto programme = programme_at(at, seed, wanted, share);
            programme.max_work = max_work - planned.work;
            const auto solution = solve(programme, std::vector<Vec<D>>(at.unknowns()));
            planned.work += solution.work;
            at.go(solution.offsets);
            planned.plan = plan_of(at, seed);
        }
    };
    for (const double share : kept_shares)
        for (const SlideStart start : {SlideStart::as_it_is, SlideStart::from_middles})
            if (!planned.plan && (share == kept_shares[0] || !cavity.vertices.empty())) try_from(start, share);
    return planned;
}

#define CAMBER_INSTANTIATE(D) \
    template Planned<D> plan_slide_repair<D>(const RepairState<D>&, const RepairCavity<D>&, ElementId, double, double);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
