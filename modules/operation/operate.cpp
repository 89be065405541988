module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.operation;
import camber.core;
import camber.metric;
import camber.cavity;
import camber.validity;

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

}  // namespace

/// A request under way; `Nodes` are those of the degree (StraightNodes, CurvedNodes).
template <int D, class Nodes>
class Operating {
  public:
    Operating(const Adaptation<D>& r, const AdaptationGoal<D>& goal, const CavityRequest<D>& request,
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
        judged_.vertex_ = {request_.metric, request_.lies, request_.gradient};
        judged_.is_short_ = request_.share < 1;
        result_.rejected = judge_patch();
        return result_;
    }

  private:
    /// Joined, judged, and corrected until nothing is wrong with it; false where that does not come about.
    [[nodiscard]] bool find_star() {
        for (;; ++result_.corrections) {
            const StarFailure failure = star(r_.mesh, out_.removed, request_.point, w_.star, out_.star);
            const bool may_go_on = result_.corrections < limits_.corrections;
            if (failure != StarFailure::none) {
                result_.rejected = reason_of(failure);
                if (!may_go_on || !shrink()) return false;
                continue;
            }
            const StarFault fault = judge_star();
            result_.rejected = fault.reason;
            if (fault.reason == RejectionReason::none) return true;
            // What was grown beyond the point's own elements may hold what is in the way, on a surface what turns away.
            const bool is_too_large = fault.reason == RejectionReason::length ||
                                      (fault.reason == RejectionReason::geometry && r_.mesh.is_surface());
            if (is_too_large && may_go_on && shrink()) continue;
            if (!may_go_on || !correct(fault)) {
                result_.straight_positive =
                    Nodes::degree == 2 && fault.reason == RejectionReason::volume && is_straight_positive();
                return false;
            }
        }
    }
    [[nodiscard]] StarFault judge_star() {
        if (const RejectionReason reason = judge_facets(); reason != RejectionReason::none) return {reason, no_face};
        if (!may_move()) return {RejectionReason::required, no_face};
        QualityBar<D> bar(r_, limits_, out_.removed.elements);
        Nodes nodes(r_, goal_, request_, limits_, w_, out_, bar);
        // Most that is refused is so by lengths, which are cheap, and hardly change as nodes are corrected.
        nodes.place_inner();
        if (!has_fitting_lengths(nodes)) return {RejectionReason::length, no_face};
        if (nodes.place_others() && !has_fitting_lengths(nodes)) return {RejectionReason::length, no_face};
        nodes.begin_elements();
        StarFault fault = judge_elements(nodes, bar);
        w_.faulty_before = w_.faulty;
        bool is_corrected = false;
        while (fault.reason != RejectionReason::none && nodes.correct(fault.reason)) {
            is_corrected = true;
            fault = judge_elements(nodes, bar);
        }
        if (fault.reason == RejectionReason::none) nodes.approach();
        result_.programmes += nodes.programmes();
        if (fault.reason != RejectionReason::none) {
            // What is at fault since nodes were corrected is so for the sake of others.
            if (is_corrected) std::erase_if(w_.faulty, [&](std::size_t j) { return !was_faulty(j); });
            if (w_.faulty.empty()) w_.faulty.push_back(fault.joined);
            return fault;
        }
        if (is_corrected && !has_fitting_lengths(nodes)) return {RejectionReason::length, no_face};
        nodes.give(out_);
        take_known(nodes);
        result_.drawn_back = nodes.has_drawn_back();
        result_.bends_around = !out_.following.empty();
        result_.worst_shape = fault.worst_shape;
        return {};
    }
    [[nodiscard]] bool was_faulty(std::size_t joined) const {
        return std::ranges::find(w_.faulty_before, joined) != w_.faulty_before.end();
    }
    /// Shapes and lengths as they were judged.
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
    [[nodiscard]] StarFault judge_elements(Nodes& nodes, QualityBar<D>& bar) const {
        nodes.judge_elements();
        return find_faults<D>(out_.star.joined.size(), nodes, bar, w_.faulty, w_.shapes);
    }
    /// What is asked of the patch as a whole: it makes the star no better to ask for it earlier.
    [[nodiscard]] RejectionReason judge_patch() {
        if (limits_.wall_elements == WallElements::refused && adds_wall_elements(r_, goal_, out_))
            return RejectionReason::wall;
        if (limits_.facet_distance < std::numeric_limits<double>::infinity()) {
            const FacetDistance facets = distance_from_geometry(r_, goal_, out_, limits_.facet_distance);
            result_.farthest_facet = facets.largest;
            if (!facets.is_near) return RejectionReason::geometry;
        }
        if (!goal_.distance_bounds.empty() && !keeps_distance_bounds(r_, goal_, out_)) return RejectionReason::geometry;
        if (limits_.node_gain == NodeGain::asked && !gains(r_, goal_, out_)) return RejectionReason::gain;
        return keeps_walls() ? RejectionReason::none : RejectionReason::crossing;
    }
    /// Of elements that may stay invalid facets may be folded: then all is proved.
    [[nodiscard]] bool keeps_walls() const {
        if (out_.star.facets.empty()) return true;
        const auto made = new_facets(r_.mesh, out_);
        if (made.empty()) return true;
        const bool are_valid = limits_.invalid_before == InvalidBefore::refused;
        return (are_valid && keeps_its_planes<D>(r_.mesh, out_, made)) || are_walls_clear<D>(r_, out_, made);
    }

    [[nodiscard]] bool moves() const {
        return request_.point.valid() && request_.place != r_.mesh.points[request_.point];
    }
    /// A vertex moves with all of its elements, and if it may.
    [[nodiscard]] bool may_move() const {
        if (!moves()) return true;
        const VertexState& state = r_.mesh.states[request_.point];
        return out_.star.kept.empty() && state.place != VertexPlace::corner && !state.marks.has(Mark::required);
    }
    /// Of elements of degree 2 that have been judged.
    [[nodiscard]] bool is_straight_positive() const {
        for (std::size_t j = 0; j < out_.star.joined.size(); ++j)
            if (!w_.curved.cones[j].is_surely_straight_positive &&
                !(signed_volume<D>(corners_of(r_, out_.star.joined[j], request_.place)) > 0))
                return false;
        return true;
    }

    /// Whether the surface goes on from one facet to the other, across a side on which it does not break.
    [[nodiscard]] bool goes_on(FacetId f, FacetId g) const {
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
    /// The removed facets by the smooth pieces that they make: the first of its piece, of each.
    void find_pieces() const {
        const auto& facets = out_.removed.facets;
        w_.pieces.resize(facets.size());
        std::iota(w_.pieces.begin(), w_.pieces.end(), std::size_t{0});
        for (bool grows = true; grows;) {
            grows = false;
            for (std::size_t i = 0; i < facets.size(); ++i)
                for (std::size_t j = 0; j < i; ++j) {
                    if (w_.pieces[i] == w_.pieces[j] || !goes_on(facets[i], facets[j])) continue;
                    w_.pieces[i] = w_.pieces[j] = std::min(w_.pieces[i], w_.pieces[j]);
                    grows = true;
                }
        }
    }

    /// New facets look where each of those that they replace looks, on their own side of ridges.
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
                const double turned = dot(n, own) < 0 ? -dot(n, now) : dot(n, now);  // facets are any way round
                if (!(turned > limits_.facet_cosine * norm(n) * norm(now))) return RejectionReason::geometry;
            }
        }
        return RejectionReason::none;
    }
    /// Half of the elements that may leave the cavity do: the later ones are farther off. False where none may.
    [[nodiscard]] bool shrink() {
        auto& elements = out_.removed.elements;
        if (request_.holders == 0 || elements.size() <= request_.holders) return false;
        const std::size_t kept = request_.holders + (elements.size() - request_.holders) / 2;
        while (elements.size() > kept) leave(elements.size() - 1);
        return true;
    }
    /// The cavity made to fit; false where it cannot be.
    [[nodiscard]] bool correct(const StarFault& fault) {
        if (fault.joined == no_face) return false;
        if (faulty_leave()) return true;
        const auto [element, opposite] = out_.star.joined[fault.joined];
        const FaceNeighbour across = r_.mesh.face_neighbours[element][static_cast<int>(opposite)];
        if (!across.valid() || !across.is_element()) return false;
        join(r_.mesh, out_.removed, across.element());
        return true;
    }
    /// Those that the faulty elements of the star come of and that may do so; false where none may.
    [[nodiscard]] bool faulty_leave() {
        auto& elements = out_.removed.elements;
        if (request_.holders == 0) return false;
        const std::size_t before = elements.size();
        for (const std::size_t j : w_.faulty) {
            const auto at = std::ranges::find(elements, out_.star.joined[j].element) - elements.begin();
            if (at < std::ssize(elements) && static_cast<std::size_t>(at) >= request_.holders)
                leave(static_cast<std::size_t>(at));
        }
        return elements.size() < before;
    }
    /// An element leaves the cavity, of a surface alone with its triangle.
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
    Patch<D>& out_;  ///< of it
    OperationResult result_;
};

template <int D>
OperationResult operate(const Adaptation<D>& r, const AdaptationGoal<D>& goal, const CavityRequest<D>& request,
                        const PatchLimits& limits, OperationWorkspace<D>& workspace, JudgedPatch<D>& out) {
    if (r.mesh.is_curved()) return Operating<D, CurvedNodes<D>>(r, goal, request, limits, workspace, out).run();
    return Operating<D, StraightNodes<D>>(r, goal, request, limits, workspace, out).run();
}

#define CAMBER_INSTANTIATE(D)                                                                                    \
    template OperationResult operate<D>(const Adaptation<D>&, const AdaptationGoal<D>&, const CavityRequest<D>&, \
                                        const PatchLimits&, OperationWorkspace<D>&, JudgedPatch<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
