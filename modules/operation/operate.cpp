// The cavity operation on linear and quadratic meshes, and commits of operations.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <numeric>
#include <span>
#include <utility>
#include <vector>
module camber.operation;
import camber.core;
import camber.cavity;
import camber.metric;
import camber.validity;
import camber.surface;

namespace camber {

namespace {

RejectionReason reason_of(StarFailure failure) {
    switch (failure) {
        case StarFailure::none: return RejectionReason::none;
        case StarFailure::empty: return RejectionReason::empty;
        case StarFailure::required: return RejectionReason::required;
        case StarFailure::surface: return RejectionReason::surface;
        case StarFailure::line: return RejectionReason::line;
        case StarFailure::ball: return RejectionReason::ball;
        case StarFailure::exists: return RejectionReason::exists;
    }
    return RejectionReason::empty;
}

/// True if the edge's node moves noticeably: in the metric of at least one end, by more than 0.001 and by more than 5 %
/// of its distance from its target.
template <int D>
bool is_noticeable(const Adaptation<D>& r, const AdaptationGoal<D>& goal, EdgeId edge, const Vec<D>& to) {
    constexpr double length = 1e-3, share = 0.05;
    const Vec<D>& here = r.mesh.nodes[edge].point;
    return std::ranges::any_of(r.mesh.edges[edge], [&](VertexId v) {
        const MeasuringMetric<D>& metric = r.vertices.metrics[v].measure;
        const double least =
            std::max(length * length, share * share * metric.length_squared(goal.target_nodes[edge].point - here));
        return metric.length_squared(to - here) > least;
    });
}

/// Precondition: the patch does not change the topology.
template <int D>
bool moves_noticeably(const Adaptation<D>& r, const AdaptationGoal<D>& goal, const Patch<D>& patch) {
    for (const ElementId e : patch.removed.elements) {
        const auto& vertices = r.mesh.elements.vertices[e];
        const int at = local_vertex(vertices, patch.point.vertex);
        for (int i = 0; i <= D; ++i) {
            if (i == at) continue;
            const auto spoke = std::ranges::find(patch.star.boundary, vertices[i]) - patch.star.boundary.begin();
            const EdgeId edge = r.mesh.edges_of[e][edge_between<D>[i][at]];
            const LagrangeNode<D>& node = patch.nodes[static_cast<std::size_t>(spoke)];
            const bool arrives = node == goal.target_nodes[edge] && node != r.mesh.nodes[edge];
            if (arrives || is_noticeable(r, goal, edge, node.point)) return true;
        }
    }
    return false;
}

// Linear star (paper §1.3). Its edges have no nodes, so no nodes can be corrected.

template <int D>
std::array<Vec<D>, D + 1> corners_of(const Adaptation<D>& r, const ElementFace& open, const Vec<D>& place) {
    std::array<Vec<D>, D + 1> p;
    for (int i = 0; i <= D; ++i)
        p[i] = i == static_cast<int>(open.opposite) ? place : r.mesh.points[r.mesh.elements.vertices[open.element][i]];
    return p;
}

template <int D>
class StraightNodes {
  public:
    StraightNodes(const JudgedRequest<D>& judged, OperationWorkspace<D>&, Patch<D>& patch, QualityCriterion<D>&)
        : r_(judged.mesh), request_(judged.request), star_(patch.star) {}

    static constexpr int degree = 1;
    static constexpr bool is_judged_by_element = true;  ///< the check ends at the first fault: qualities cost more than
                                                        ///< signs of volumes

    void place_inner() {}
    [[nodiscard]] bool place_others() { return false; }
    [[nodiscard]] bool is_placed(std::size_t) const { return true; }
    [[nodiscard]] double length_to(std::size_t i) const {
        const VertexId v = star_.boundary[i];
        if (r_.mesh.is_at_infinity(v)) return length_to_infinity;
        return edge_length(request_.metric.measure, r_.vertices.metrics[v].measure, r_.mesh.points[v] - request_.place);
    }
    void begin_elements() {}
    void judge_elements() {}
    /// The sign of the element's volume is exact. In standalone surface meshes, `OperationRunner::judge_facets` checks
    /// the orientation instead.
    [[nodiscard]] ElementState element(std::size_t joined) const {
        const ElementFace& open = star_.joined[joined];
        if constexpr (D == 3)
            if (r_.mesh.is_surface()) return triangle(open);
        const auto corners = corners_of(r_, open, request_.place);
        if (!(signed_volume<D>(corners) > 0)) return {};
        Mat<D> sides;
        for (int i = 0; i < D; ++i) sides.column[i] = corners[i + 1] - corners[0];
        if (!is_above_rounding<D>(std::abs(det(sides)), corners)) return {true, true, 0, false};
        return {true, false,
                shape_with(r_, open.element, static_cast<int>(open.opposite), request_.place, request_.metric.measure),
                false};
    }
    [[nodiscard]] bool correct(RejectionReason) { return false; }
    void approach() {}
    void set_edges(Patch<D>&) const {}
    [[nodiscard]] int optimisation_problems() const { return 0; }
    [[nodiscard]] bool has_relaxed() const { return false; }

  private:
    [[nodiscard]] ElementState triangle(const ElementFace& open) const
        requires(D == 3)
    {
        const auto [a, b, c, infinity] = corners_of(r_, open, request_.place);
        if (is_flat(std::array{a, b, c})) return {true, true, 0, false};
        return {true, false,
                shape_with(r_, open.element, static_cast<int>(open.opposite), request_.place, request_.metric.measure),
                false};
    }

    const Adaptation<D>& r_;
    const CavityRequest<D>& request_;
    const Star<D>& star_;
};

}  // namespace

template <int D, class Nodes>
class OperationRunner {
  public:
    OperationRunner(const Adaptation<D>& r, const AdaptationGoal<D>& goal, const CavityRequest<D>& request,
                    const PatchLimits& limits, OperationWorkspace<D>& workspace, JudgedPatch<D>& out)
        : r_(r), goal_(goal), request_(request), limits_(limits), w_(workspace), judged_(out), out_(out.patch_) {}

    [[nodiscard]] OperationResult run() {
        out_.removed = request_.cavity;
        out_.nodes.clear();
        out_.following.clear();
        out_.reshaped.clear();
        w_.curved.bent.clear();
        if (!find_star()) return result_;
        if (Nodes::degree == 2) result_.straight_inverted = !is_straight_positive();
        out_.planned_for = r_.mesh.stamp;
        out_.point = {request_.point, {}, request_.reference};
        if (!request_.point.valid() || moves()) out_.point.place = request_.place;
        judged_.vertex_ = {request_.metric, request_.geometry_position, request_.gradient};
        judged_.is_short_ = request_.share < 1;
        result_.rejected = judge_patch();
        return result_;
    }

  private:
    [[nodiscard]] bool find_star() {
        for (;; ++result_.corrections) {
            const StarFailure failure = star(r_.mesh, out_.removed, request_.point, w_.star, out_.star);
            const bool may_continue = result_.corrections < limits_.corrections;
            if (failure != StarFailure::none) {
                result_.rejected = reason_of(failure);
                if (!may_continue || !shrink()) return false;
                continue;
            }
            const StarDefect defect = judge_star();
            result_.rejected = defect.reason;
            if (defect.reason == RejectionReason::none) return true;
            // The cause may be elements that do not contain the point, so the cavity may be too large.
            const bool is_too_large = defect.reason == RejectionReason::length ||
                                      (defect.reason == RejectionReason::geometry && r_.mesh.is_surface());
            if (is_too_large && may_continue && shrink()) continue;
            if (!may_continue || !correct(defect)) {
                result_.straight_positive =
                    Nodes::degree == 2 && defect.reason == RejectionReason::volume && is_straight_positive();
                return false;
            }
        }
    }
    [[nodiscard]] StarDefect judge_star() {
        if (const RejectionReason reason = judge_facets(); reason != RejectionReason::none) return {reason, no_face};
        if (!may_move()) return {RejectionReason::required, no_face};
        QualityCriterion<D> bar(r_, limits_, out_.removed.elements);
        Nodes nodes({r_, goal_, request_, limits_}, w_, out_, bar);
        // Lengths are checked first: they cause most rejections, are cheap to compute, and change little in
        // corrections.
        nodes.place_inner();
        if (!has_fitting_lengths(nodes)) return {RejectionReason::length, no_face};
        if (nodes.place_others() && !has_fitting_lengths(nodes)) return {RejectionReason::length, no_face};
        nodes.begin_elements();
        StarDefect defect = judge_elements(nodes, bar);
        w_.defective_before = w_.defective;
        bool is_corrected = false;
        while (defect.reason != RejectionReason::none && nodes.correct(defect.reason)) {
            is_corrected = true;
            defect = judge_elements(nodes, bar);
        }
        if (defect.reason == RejectionReason::none) nodes.approach();
        result_.optimisation_problems += nodes.optimisation_problems();
        if (defect.reason != RejectionReason::none) {
            // Excludes elements that became faulty only when the nodes of others were corrected.
            if (is_corrected) std::erase_if(w_.defective, [&](std::size_t j) { return !was_defective(j); });
            if (w_.defective.empty()) w_.defective.push_back(defect.joined);
            return defect;
        }
        if (is_corrected && !has_fitting_lengths(nodes)) return {RejectionReason::length, no_face};
        nodes.set_edges(out_);
        take_known(nodes);
        result_.relaxed = nodes.has_relaxed();
        result_.bends_around = !out_.following.empty();
        result_.worst_shape = defect.worst_shape;
        return {};
    }
    [[nodiscard]] bool was_defective(std::size_t joined) const {
        return std::ranges::find(w_.defective_before, joined) != w_.defective_before.end();
    }
    void take_known(const Nodes& nodes) {
        judged_.lengths_.clear();
        if constexpr (Nodes::degree == 1) {
            judged_.shapes_ = w_.shapes;
        } else {
            constexpr double unknown = -1;
            judged_.shapes_.assign(out_.reshaped.size(), unknown);
            for (std::size_t j = 0; j < out_.star.joined.size(); ++j) {
                const ElementState element = nodes.element(j);
                judged_.shapes_.push_back(element.is_valid ? element.shape : unknown);
            }
            for (std::size_t s = 0; s < out_.star.boundary.size(); ++s) judged_.lengths_.push_back(nodes.length_to(s));
        }
    }
    [[nodiscard]] bool has_fitting_lengths(const Nodes& nodes) const {
        return lengths_fit(std::span(std::as_const(w_.star.to_point)), moves(), limits_, nodes);
    }
    [[nodiscard]] StarDefect judge_elements(Nodes& nodes, QualityCriterion<D>& bar) const {
        nodes.judge_elements();
        return find_defects<D>(out_.star.joined.size(), nodes, bar, w_.defective, w_.shapes);
    }
    [[nodiscard]] RejectionReason judge_patch() {
        if (limits_.two_facet_elements == TwoFacetElements::refused && adds_two_facet_elements(r_, goal_, out_))
            return RejectionReason::wall;
        if (!goal_.distance_bounds.empty() && !meets_distance_bounds(r_, goal_, out_)) return RejectionReason::geometry;
        if (limits_.facet_distance < std::numeric_limits<double>::infinity()) {
            const FacetDistance facets = distance_from_geometry(r_, goal_, out_, limits_.facet_distance);
            result_.farthest_facet = facets.largest;
            if (!facets.is_near) return RejectionReason::geometry;
        }
        if (limits_.node_gain == NodeGain::requested && !moves_noticeably(r_, goal_, out_))
            return RejectionReason::gain;
        return is_free_of_crossings() ? RejectionReason::none : RejectionReason::crossing;
    }
    /// True if the new facets cross no facet. If elements may stay invalid, `preserves_planes` proves nothing, because
    /// their facets can be folded.
    [[nodiscard]] bool is_free_of_crossings() const {
        if (out_.star.facets.empty()) return true;
        const auto added_facets = new_facets(r_.mesh, out_);
        if (added_facets.empty()) return true;
        const bool are_valid = limits_.invalid_replacement == InvalidReplacement::refused;
        return (are_valid && preserves_planes<D>(r_.mesh, out_, added_facets)) ||
               are_facets_clear<D>(r_, out_, added_facets);
    }

    [[nodiscard]] bool moves() const {
        return request_.point.valid() && request_.place != r_.mesh.points[request_.point];
    }
    [[nodiscard]] bool may_move() const {
        if (!moves()) return true;
        const VertexState& state = r_.mesh.states[request_.point];
        return out_.star.preserved.empty() && state.place != VertexPlace::corner && !state.marks.has(Mark::required);
    }
    /// Precondition in degree 2: the curved elements were checked before.
    [[nodiscard]] bool is_straight_positive() const {
        for (std::size_t j = 0; j < out_.star.joined.size(); ++j)
            if (!w_.curved.cones[j].is_surely_straight_positive &&
                !(signed_volume<D>(corners_of(r_, out_.star.joined[j], request_.place)) > 0))
                return false;
        return true;
    }

    [[nodiscard]] bool is_smooth_across(FacetId f, FacetId g) const {
        const auto& of_f = r_.mesh.facets.vertices[f];
        const auto& of_g = r_.mesh.facets.vertices[g];
        std::array<VertexId, D> shared;
        int count = 0;
        for (const VertexId v : of_f)
            if (local_vertex(of_g, v) >= 0) shared[count++] = v;
        if (count != D - 1 || r_.mesh.facets.references[f] != r_.mesh.facets.references[g]) return false;
        if constexpr (D == 2) return r_.mesh.states[shared[0]].place != VertexPlace::corner;
        const ElementId e = r_.mesh.sides[f][0];
        const auto& vertices = r_.mesh.elements.vertices[e];
        const int k = edge_between<D>[local_vertex(vertices, shared[0])][local_vertex(vertices, shared[D - 2])];
        return !r_.mesh.breaks_at(r_.mesh.edges_of[e][k]);
    }
    /// Divides the removed facets into smooth pieces. The index of a piece is the index of its first facet.
    void find_pieces() const {
        const auto& facets = out_.removed.facets;
        w_.pieces.resize(facets.size());
        std::iota(w_.pieces.begin(), w_.pieces.end(), std::size_t{0});
        for (bool grows = true; grows;) {
            grows = false;
            for (std::size_t i = 0; i < facets.size(); ++i)
                for (std::size_t j = 0; j < i; ++j) {
                    if (w_.pieces[i] == w_.pieces[j] || !is_smooth_across(facets[i], facets[j])) continue;
                    w_.pieces[i] = w_.pieces[j] = std::min(w_.pieces[i], w_.pieces[j]);
                    grows = true;
                }
        }
    }

    [[nodiscard]] RejectionReason judge_facets() const {
        if (!out_.star.facets.empty()) find_pieces();
        const auto& removed = out_.removed.facets;
        for (const auto& [facet, opposite] : out_.star.facets) {
            if (r_.mesh.is_at_infinity(facet)) continue;
            const auto piece = w_.pieces[std::ranges::find(removed, facet) - removed.begin()];
            std::array<Vec<D>, D> p = corners_of(r_.mesh, facet);
            const Vec<D> own = facet_normal(p);
            p[opposite] = request_.place;
            const Vec<D> now = facet_normal(p);
            for (std::size_t i = 0; i < removed.size(); ++i) {
                if (w_.pieces[i] != piece) continue;
                const FacetId f = removed[i];
                const Vec<D> n = facet_normal(corners_of(r_.mesh, f));
                const double turned = dot(n, own) < 0 ? -dot(n, now) : dot(n, now);  // the orientation of facets is
                                                                                     // arbitrary
                if (!(turned > limits_.facet_cosine * norm(n) * norm(now))) return RejectionReason::geometry;
            }
        }
        return RejectionReason::none;
    }
    /// Removes half of the elements that may leave the cavity: those added last. Returns false if none may leave.
    [[nodiscard]] bool shrink() {
        auto& elements = out_.removed.elements;
        if (request_.fixed_element_count == 0 || elements.size() <= request_.fixed_element_count) return false;
        const std::size_t preserved =
            request_.fixed_element_count + (elements.size() - request_.fixed_element_count) / 2;
        while (elements.size() > preserved) leave(elements.size() - 1);
        return true;
    }
    [[nodiscard]] bool correct(const StarDefect& defect) {
        if (defect.joined == no_face) return false;
        if (remove_defective()) return true;
        const auto [element, opposite] = out_.star.joined[defect.joined];
        const FaceNeighbour across = r_.mesh.face_neighbours[element][static_cast<int>(opposite)];
        if (!across.valid() || !across.is_element()) return false;
        join(r_.mesh, out_.removed, across.element());
        return true;
    }
    [[nodiscard]] bool remove_defective() {
        auto& elements = out_.removed.elements;
        if (request_.fixed_element_count == 0) return false;
        const std::size_t before = elements.size();
        for (const std::size_t j : w_.defective) {
            const auto at = std::ranges::find(elements, out_.star.joined[j].element) - elements.begin();
            if (at < std::ssize(elements) && static_cast<std::size_t>(at) >= request_.fixed_element_count)
                leave(static_cast<std::size_t>(at));
        }
        return elements.size() < before;
    }
    void leave(std::size_t at) {
        auto& [elements, facets, lines] = out_.removed;
        if constexpr (D == 3)
            if (r_.mesh.is_surface()) std::erase(facets, facet_of(r_.mesh, elements[at]));
        elements.erase(elements.begin() + static_cast<std::ptrdiff_t>(at));
    }

    const Adaptation<D>& r_;
    const AdaptationGoal<D>& goal_;
    const CavityRequest<D>& request_;
    const PatchLimits& limits_;
    OperationWorkspace<D>& w_;
    JudgedPatch<D>& judged_;
    Patch<D>& out_;
    OperationResult result_;
};

template <int D>
OperationResult operate(const Adaptation<D>& r, const AdaptationGoal<D>& goal, const CavityRequest<D>& request,
                        const PatchLimits& limits, OperationWorkspace<D>& workspace, JudgedPatch<D>& out) {
    if (r.mesh.is_curved()) return OperationRunner<D, CurvedNodes<D>>(r, goal, request, limits, workspace, out).run();
    return OperationRunner<D, StraightNodes<D>>(r, goal, request, limits, workspace, out).run();
}

namespace {

struct Known {
    std::vector<double> shapes;
    std::vector<double> lengths;
    std::vector<EdgeId> bent;  ///< existing edges whose nodes changed
};

template <int D>
void follow_shapes(Adaptation<D>& state, std::span<const ElementId> created, std::span<const double> judged) {
    if (state.shapes.empty()) return;
    auto shapes = take(std::move(state.shapes));
    shapes.resize(state.mesh.elements.size(), -1.0);
    for (std::size_t i = 0; i < created.size(); ++i) shapes[created[i].index()] = judged[i];
    state.shapes = std::move(shapes);
}
template <int D>
void follow_lengths(Adaptation<D>& state, std::span<const EdgeId> spokes, std::span<const double> judged,
                    std::span<const EdgeId> bent) {
    if (!state.mesh.is_curved()) return;
    auto lengths = take(std::move(state.lengths));
    lengths.resize(state.mesh.edges.size());
    for (std::size_t i = 0; i < spokes.size(); ++i) lengths[spokes[i].index()] = judged[i];
    for (const EdgeId edge : bent) lengths[edge.index()] = measured_length(state, edge);
    state.lengths = std::move(lengths);
}

}  // namespace

template <int D>
Outcome<CommittedState<D>> commit(Adaptation<D> state, std::vector<JudgedPatch<D>> judged) {
    return guarded([&]() -> Outcome<CommittedState<D>> {
        std::vector<VertexRow<D>> rows;
        std::vector<bool> are_short;
        Known known;
        std::vector<Patch<D>> patches;
        for (JudgedPatch<D>& patch : judged) {
            rows.push_back(patch.vertex());
            are_short.push_back(patch.is_short_of_geometry());
            known.shapes.insert(known.shapes.end(), patch.shapes().begin(), patch.shapes().end());
            known.lengths.insert(known.lengths.end(), patch.lengths().begin(), patch.lengths().end());
            for (const FollowingNode<D>& edge : patch.patch().following) known.bent.push_back(edge.edge);
            patches.push_back(std::move(patch).take_patch());
        }
        auto changed = replace_cavities<D>(std::move(state.mesh), patches);
        if (!changed) return fail(changed.error());
        auto& [mesh, changes] = *changed;
        state.mesh = std::move(mesh);
        state.vertices.put(changes.points, rows, state.mesh.points.size());
        auto off_geometry = take(std::move(state.off_geometry));
        for (std::size_t i = 0; i < rows.size(); ++i)
            if (are_short[i]) off_geometry.push_back(changes.points[i]);
        state.off_geometry = std::move(off_geometry);
        state.rejection_cache.follow(state.mesh, std::span(std::as_const(changes.elements.created)));
        follow_shapes<D>(state, changes.elements.created, known.shapes);
        follow_lengths<D>(state, changes.spokes, known.lengths, known.bent);
        update_facet_grid(state.walls, state.mesh, changes.facets);
        return CommittedState<D>{std::move(state), std::move(changes)};
    });
}

template <int D>
Adaptation<D> commit(Adaptation<D> state, std::span<const JudgedNode<D>> judged) {
    if (judged.empty()) return state;
    auto nodes = take(std::move(state.mesh.nodes));
    for (const JudgedNode<D>& node : judged) nodes[node.edge().index()] = node.node();
    state.mesh.nodes = std::move(nodes);
    std::vector<EdgeId> bent;
    bent.reserve(judged.size());
    for (const JudgedNode<D>& node : judged) bent.push_back(node.edge());
    follow_lengths<D>(state, {}, {}, bent);
    state.mesh.stamp = new_stamp();
    state.rejection_cache.forget();
    state.shapes = {};
    return state;
}

#define CAMBER_INSTANTIATE(D)                                                                                    \
    template OperationResult operate<D>(const Adaptation<D>&, const AdaptationGoal<D>&, const CavityRequest<D>&, \
                                        const PatchLimits&, OperationWorkspace<D>&, JudgedPatch<D>&);            \
    template Outcome<CommittedState<D>> commit<D>(Adaptation<D>, std::vector<JudgedPatch<D>>);                   \
    template Adaptation<D> commit<D>(Adaptation<D>, std::span<const JudgedNode<D>>);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
