module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <optional>
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

/// The least distance of a vertex from the face opposite: volume by the largest face, both times (D − 1)! D.
template <int D>
double min_height(const std::array<Vec<D>, D + 1>& p) {
    Mat<D> sides;
    for (int i = 0; i < D; ++i) sides.column[i] = p[i + 1] - p[0];
    return std::abs(det(sides)) / largest_face<D>(p);
}

template <int D>
class Operating {
  public:
    Operating(const Adaptation<D>& r, const AdaptationGoal<D>& goal, const CavityRequest<D>& request, const PatchLimits& limits,
             OperationWorkspace<D>& workspace, Patch<D>& out)
        : r_(r), goal_(goal), request_(request), limits_(limits), w_(workspace), out_(out) {}

    [[nodiscard]] OperationResult run() {
        OperationResult result = decided();
        result.programmes = programmes_;
        return result;
    }

  private:
    [[nodiscard]] OperationResult decided() {
        OperationResult result;
        out_.removed = request_.cavity;
        out_.nodes.clear();
        for (;; ++result.corrections) {
            const StarFailure failure = star(r_.mesh, out_.removed, request_.point, w_.star, out_.star);
            if (failure != StarFailure::none) {
                result.rejected = reason_of(failure);
                if (result.corrections == limits_.corrections || !shrink()) return result;
                continue;
            }
            const StarFault fault = judge(result.worst_shape);
            result.rejected = fault.reason;
            // What was grown beyond the point's own elements may hold what is in the way.
            if (fault.reason == RejectionReason::length && result.corrections < limits_.corrections && shrink())
                continue;
            if (fault.reason == RejectionReason::none) break;
            if (result.corrections == limits_.corrections || !correct(fault)) {
                result.straight_positive =
                    r_.mesh.is_curved() && fault.reason == RejectionReason::volume && is_straight_positive();
                return result;
            }
        }
        if (r_.mesh.is_curved()) {
            result.straight_inverted = !is_straight_positive();
            result.drawn_back = std::ranges::any_of(w_.curved.spokes, [](const Spoke<D>& s) { return s.share < 1; });
        }
        out_.planned_for = r_.mesh.stamp;
        out_.point = {request_.point, {}, request_.reference};
        if (!request_.point.valid() || request_.place != r_.mesh.points[request_.point]) out_.point.place = request_.place;
        return result;
    }
    [[nodiscard]] StarFault judge(double& worst) {
        if (const RejectionReason reason = judge_facets(); reason != RejectionReason::none) return {reason, no_face};
        if (!may_move()) return {RejectionReason::required, no_face};
        if (r_.mesh.is_curved()) {
            const StarFault fault = curve_star(r_, goal_, request_, limits_, w_, out_, worst);
            programmes_ += w_.curved.programmes;
            return fault;
        }
        for (std::size_t i = 0; i < out_.star.boundary.size(); ++i) {
            if (w_.star.to_point[i].is_there && !moves()) continue;  // no edge that is made
            const VertexId v = out_.star.boundary[i];
            const double length =
                edge_length(request_.metric.measure, r_.metrics[v].measure, r_.mesh.points[v] - request_.place);
            if (!(length >= limits_.shortest && length <= limits_.longest)) return {RejectionReason::length, no_face};
        }
        QualityBar<D> bar(r_, limits_, out_.removed.elements);
        worst = std::numeric_limits<double>::infinity();
        for (std::size_t j = 0; j < out_.star.joined.size(); ++j) {
            const auto& [element, opposite] = out_.star.joined[j];
            const double shape = shape_with(r_, element, static_cast<int>(opposite), request_.place, request_.metric.measure);
            if (!(signed_volume<D>(corners(out_.star.joined[j])) > 0)) return {RejectionReason::volume, j};
            if (is_flat(corners(out_.star.joined[j]))) return {RejectionReason::height, j};
            if (!bar.is_met(shape)) return {RejectionReason::quality, j};
            worst = std::min(worst, shape);
        }
        return {};
    }
    static constexpr std::size_t no_face = static_cast<std::size_t>(-1);

    [[nodiscard]] bool moves() const { return request_.point.valid() && request_.place != r_.mesh.points[request_.point]; }
    /// A vertex moves with all of its elements, and if it may.
    [[nodiscard]] bool may_move() const {
        if (!moves()) return true;
        const VertexState& state = r_.mesh.states[request_.point];
        return out_.star.kept.empty() && state.place != VertexPlace::corner && !state.marks.has(Mark::required);
    }
    [[nodiscard]] std::array<Vec<D>, D + 1> corners(const ElementFace& open) const {
        std::array<Vec<D>, D + 1> p;
        for (int i = 0; i <= D; ++i)
            p[i] = i == static_cast<int>(open.opposite) ? request_.place
                                                        : r_.mesh.points[r_.mesh.elements.vertices[open.element][i]];
        return p;
    }

    [[nodiscard]] bool is_straight_positive() const {
        return std::ranges::all_of(out_.star.joined,
                                   [&](const ElementFace& face) { return signed_volume<D>(corners(face)) > 0; });
    }
    /// So low that coordinates, which are known to their rounding only, do not tell on which side a vertex is; or below
    /// min_height as the point's metric sees it.
    [[nodiscard]] bool is_flat(const std::array<Vec<D>, D + 1>& p) const {
        if (!(min_height<D>(p) > rounding_of(p))) return true;
        if (!(limits_.min_height > 0)) return false;
        std::array<Vec<D>, D + 1> seen;
        for (int i = 0; i <= D; ++i)
            for (int k = 0; k < D; ++k) seen[i][k] = dot(request_.metric.measure.rows[k], p[i] - request_.place);
        return !(min_height<D>(seen) >= limits_.min_height);
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
        elements.resize(request_.holders + (elements.size() - request_.holders) / 2);
        return true;
    }
    /// The cavity made to fit; false where it cannot be.
    [[nodiscard]] bool correct(const StarFault& fault) {
        if (fault.joined == no_face) return false;
        const auto [element, opposite] = out_.star.joined[fault.joined];
        auto& elements = out_.removed.elements;
        const auto at = std::ranges::find(elements, element);
        if (request_.holders > 0 && static_cast<std::size_t>(at - elements.begin()) >= request_.holders) {
            elements.erase(at);
            return true;
        }
        const FaceNeighbour across = r_.mesh.face_neighbours[element][static_cast<int>(opposite)];
        if (!across.valid() || !across.is_element()) return false;
        elements.push_back(across.element());
        return true;
    }

    const Adaptation<D>& r_;
    const AdaptationGoal<D>& goal_;
    const CavityRequest<D>& request_;
    const PatchLimits& limits_;
    OperationWorkspace<D>& w_;
    Patch<D>& out_;
    int programmes_ = 0;
};

}  // namespace

template <int D>
OperationResult operate(const Adaptation<D>& r, const AdaptationGoal<D>& goal, const CavityRequest<D>& request,
                const PatchLimits& limits, OperationWorkspace<D>& workspace, Patch<D>& out) {
    return Operating<D>(r, goal, request, limits, workspace, out).run();
}

template OperationResult operate<2>(const Adaptation<2>&, const AdaptationGoal<2>&, const CavityRequest<2>&, const PatchLimits&,
                            OperationWorkspace<2>&, Patch<2>&);
template OperationResult operate<3>(const Adaptation<3>&, const AdaptationGoal<3>&, const CavityRequest<3>&, const PatchLimits&,
                            OperationWorkspace<3>&, Patch<3>&);

}  // namespace camber
