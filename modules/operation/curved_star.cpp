module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>
module camber.operation;
import camber.core;
import camber.bezier;
import camber.crossing;
import camber.metric;
import camber.cavity;
import camber.optimisation;
import camber.surface;
import camber.validity;

namespace camber {

namespace {

/// Not a vertex of the star's boundary.
constexpr std::uint32_t no_spoke = std::numeric_limits<std::uint32_t>::max();

template <int D>
class CurvingStar {
  public:
    CurvingStar(const Adaptation<D>& r, const AdaptationGoal<D>& goal, const CavityRequest<D>& request,
                const PatchLimits& limits, OperationWorkspace<D>& workspace, Patch<D>& patch)
        : r_(r),
          goal_(goal),
          request_(request),
          limits_(limits),
          star_(workspace.star),
          w_(workspace.curved),
          out_(patch),
          bar_(r, limits, patch.removed.elements) {}

    [[nodiscard]] StarFault run(double& worst) {
        begin_spokes();
        put_extended(old_elements_of(r_, out_.removed.elements, w_.pieces));
        put_on_geometry();
        put_wanted();
        // Most that is refused is so by lengths, which are cheap, and hardly change as nodes are drawn back.
        if (judge_lengths() != RejectionReason::none) return {RejectionReason::length};
        begin_cones();
        bound_ = limits_.min_jacobian;
        w_.programmes = 0;
        StarFault fault = judge();
        while (fault.reason != RejectionReason::none && draw_back()) fault = judge();
        if (fault.reason == RejectionReason::volume && raise()) fault = judge();
        if (fault.reason != RejectionReason::none) return fault;
        approach();
        if (const RejectionReason reason = judge_lengths(); reason != RejectionReason::none) return {reason};
        out_.nodes.clear();
        for (const Spoke<D>& spoke : w_.spokes) out_.nodes.push_back({spoke.node});
        worst = std::numeric_limits<double>::infinity();
        for (const Cone<D>& cone : w_.cones) worst = std::min(worst, cone.shape);
        return {};
    }

  private:
    [[nodiscard]] VertexId vertex(std::size_t spoke) const { return out_.star.boundary[spoke]; }
    [[nodiscard]] const Vec<D>& end(std::size_t spoke) const { return r_.mesh.points[vertex(spoke)]; }
    [[nodiscard]] Vec<D> middle(std::size_t spoke) const { return midpoint(request_.place, end(spoke)); }

    /// Which edges keep their nodes, and which are of the boundary.
    void begin_spokes() {
        w_.spokes.assign(out_.star.boundary.size(), {});
        w_.facets.clear();
        w_.of_facets.clear();
        for (const auto& [facet, opposite] : out_.star.facets) {
            const auto& vertices = r_.mesh.facets.vertices[facet];
            FacetSite<D> site = site_of(r_.mesh, facet);
            site.corners[opposite] = request_.place;
            for (std::uint32_t i = 0; i < D; ++i) {
                if (i == opposite) continue;
                const std::uint32_t at = star_.vertices.find(vertices[i]);
                w_.spokes[at].kind = EdgeKind::surface;
                w_.of_facets.push_back({at, static_cast<std::uint32_t>(w_.facets.size())});
            }
            w_.facets.push_back(site);
        }
        if constexpr (D == 3)
            for (const auto& [line, opposite] : out_.star.lines) {
                Spoke<D>& spoke = w_.spokes[star_.vertices.find(r_.mesh.edges[r_.mesh.lines[line]][1 - opposite])];
                spoke.kind = EdgeKind::ridge;
                spoke.line = line;
            }
        for (const ElementFace& face : out_.star.kept) {
            const auto& vertices = r_.mesh.elements.vertices[face.element];
            const int held = local_vertex(vertices, request_.point);
            for (int i = 0; i <= D; ++i) {
                if (i == held || i == static_cast<int>(face.opposite)) continue;
                const std::uint32_t at = star_.vertices.find(vertices[i]);
                if (at == no_spoke) continue;
                w_.spokes[at].kind = EdgeKind::fixed;
                w_.spokes[at].node = r_.mesh.nodes[r_.mesh.edges_of[face.element][edge_between<D>[i][held]]].point;
            }
        }
    }
    /// x(X) of a place between the origin and v, or of the origin: in an element that holds the point and has v, of
    /// which X is a part whatever else lies there too, as where straight shapes are inverted. The largest: the others
    /// may be all but flat. Where there is none, wherever X is.
    [[nodiscard]] Vec<D> old_place_of(const Vec<D>& p, VertexId v) const {
        const auto holders = std::span(out_.removed.elements).first(request_.holders);
        const OldElement<D>* best = nullptr;
        for (const OldElement<D>& piece : w_.pieces) {
            if (best != nullptr && !(piece.size > best->size)) continue;
            if (v.valid() && local_vertex(r_.mesh.elements.vertices[piece.element], v) < 0) continue;
            if (std::ranges::find(holders, piece.element) != holders.end()) best = &piece;
        }
        return best == nullptr ? old_map(w_.pieces, p) : old_map(*best, p);
    }
    /// The edge from the point to v that the cavity has already; invalid: none.
    [[nodiscard]] EdgeId edge_there(VertexId v) const {
        if (!request_.point.valid()) return {};
        for (const ElementId e : out_.removed.elements) {
            const auto& vertices = r_.mesh.elements.vertices[e];
            const int from = local_vertex(vertices, request_.point);
            const int to = local_vertex(vertices, v);
            if (from >= 0 && to >= 0) return r_.mesh.edges_of[e][edge_between<D>[from][to]];
        }
        return {};
    }
    /// The node of the edge that a vertex which stays where it is has to v in the cavity already.
    [[nodiscard]] std::optional<Vec<D>> node_there(const Vec<D>& origin, VertexId v) const {
        if (!request_.point.valid() || origin != r_.mesh.points[request_.point]) return {};
        const EdgeId edge = edge_there(v);
        return edge.valid() ? std::optional(r_.mesh.nodes[edge].point) : std::nullopt;
    }
    /// Half of what the point is off the cavity's old curves goes along, as where it ends.
    void put_extended(bool is_bent) {
        const Vec<D> origin = request_.origin.value_or(request_.place);
        const Vec<D> shift = 0.5 * (request_.place - old_place_of(origin, {}));
        for (std::size_t s = 0; s < w_.spokes.size(); ++s) {
            Spoke<D>& spoke = w_.spokes[s];
            if (spoke.kind == EdgeKind::fixed) continue;
            const Vec<D> half = midpoint(origin, end(s));
            if (const auto node = node_there(origin, vertex(s)))
                spoke.extended = *node;
            else if (!is_bent)
                spoke.extended = middle(s);
            else if (spoke.kind == EdgeKind::volume)
                spoke.extended = old_place_of(half, vertex(s)) + shift;
            else
                spoke.extended = old_place_on_sides(s, half) + 0.5 * (request_.place - old_place_on_sides(s, origin));
            spoke.wanted = spoke.node = spoke.extended;
        }
    }
    /// x(X) of a place on the boundary: by the removed facets of the spoke's surfaces, on a line by its removed edges.
    /// Elements would do where their straight shapes are sound, but a surface must not leave itself.
    [[nodiscard]] Vec<D> old_place_on_sides(std::size_t s, const Vec<D>& p) const {
        OldPlace<D> best{p};
        const auto [a, b] = request_.halves;
        // What has the spoke's end, and the edge that is split, has X whatever else lies there too.
        const auto rank = [&](const auto& simplex) {
            const bool is_split = a.valid() && local_vertex(simplex, a) >= 0 && local_vertex(simplex, b) >= 0;
            return (local_vertex(simplex, vertex(s)) >= 0 ? 1 : 0) + (is_split ? 2 : 0);
        };
        if constexpr (D == 3)
            if (w_.spokes[s].kind == EdgeKind::ridge) {
                for (const LineId line : out_.removed.lines) {
                    const EdgeId edge = r_.mesh.lines[line];
                    const auto& [from, to] = r_.mesh.edges[edge];
                    look_at<D, 1>({r_.mesh.points[from], r_.mesh.points[to]}, {r_.mesh.nodes[edge].point}, p,
                                  rank(r_.mesh.edges[edge]), best);
                }
                return best.point;
            }
        for (const FacetId f : out_.removed.facets) {
            const auto is_of = [&](const auto& of) {
                return of[0] == s && w_.facets[of[1]].reference == r_.mesh.facets.references[f];
            };
            if (std::ranges::none_of(w_.of_facets, is_of)) continue;
            const NodalFacet<D> facet = nodal_facet(r_.mesh, f);
            std::array<Vec<D>, D> corners;
            std::array<Vec<D>, edges_per_simplex<D - 1>> nodes;
            std::copy_n(facet.nodes.begin(), D, corners.begin());
            std::copy_n(facet.nodes.begin() + D, nodes.size(), nodes.begin());
            look_at<D, D - 1>(corners, nodes, p, rank(r_.mesh.facets.vertices[f]), best);
        }
        return best.point;
    }
    void put_on_geometry() {
        if (!goal_.geometry && goal_.wanted.empty()) return;
        for (std::size_t s = 0; s < w_.spokes.size(); ++s) {
            Spoke<D>& spoke = w_.spokes[s];
            if (spoke.kind != EdgeKind::surface && spoke.kind != EdgeKind::ridge) continue;
            const std::optional<Vec<D>> target = target_on_geometry(s);
            if (!target) continue;
            if (request_.share == 1 && !goal_.wanted.empty())
                spoke.extended = *target;  // to the bit
            else
                spoke.extended += request_.share * (*target - spoke.extended);
            spoke.wanted = spoke.node = spoke.extended;
        }
    }
    /// Nothing where the geometry has no surface at the spoke, but for embedded lines: these have their curve.
    [[nodiscard]] std::optional<Vec<D>> target_on_geometry(std::size_t s) const {
        if (!goal_.wanted.empty()) return goal_.wanted[edge_there(vertex(s))].point;
        const auto& geometry = *goal_.geometry;
        const LineId line = w_.spokes[s].line;
        EdgeSite<D> site{{}, w_.spokes[s].kind, {request_.place, end(s)}, {}};
        bool has_surface = false;
        for (const auto& [of, facet] : w_.of_facets) {
            if (of != s) continue;
            site.facets.push_back(w_.facets[facet]);
            has_surface |= geometry->has_surface_at(w_.facets[facet]);
        }
        if (r_.mesh.is_embedded(line))
            return on_embedded_curve(goal_, site, r_.mesh.line_references[line], site.middle()).point;
        return has_surface ? std::optional(geometry->middle_of(site)) : std::nullopt;
    }
    void put_wanted() {
        w_.free.clear();
        for (std::uint32_t s = 0; s < w_.spokes.size(); ++s)
            if (w_.spokes[s].kind == EdgeKind::volume) w_.free.push_back(s);
        w_.offsets.resize(w_.free.size());
        if (!goal_.wanted.empty()) return take_wanted();
        if (goal_.search)
            search_offsets();
        else
            find_accurate_offsets();
        for (std::size_t i = 0; i < w_.free.size(); ++i) {
            Spoke<D>& spoke = w_.spokes[w_.free[i]];
            if (!is_free(w_.free[i])) continue;
            spoke.wanted = spoke.node = middle(w_.free[i]) + w_.offsets[i];
        }
    }
    void take_wanted() {
        for (const std::uint32_t s : w_.free)
            w_.spokes[s].wanted = w_.spokes[s].node = goal_.wanted[edge_there(vertex(s))].point;
    }
    void find_accurate_offsets() {
        w_.chords.clear();
        w_.ends.clear();
        for (const std::uint32_t s : w_.free) {
            const VertexId v = vertex(s);
            w_.chords.push_back(end(s) - request_.place);
            w_.ends.push_back({{request_.metric.log_metric, request_.gradient}, {r_.metrics[v].log_metric, r_.gradients[v]}});
        }
        accurate_offsets<D>(w_.chords, w_.ends, goal_.accuracy, w_.offsets);
    }
    void search_offsets() {
        const auto& [options, rules] = *goal_.search;
        w_.searched.clear();
        for (const std::uint32_t s : w_.free) {
            // From the lower end by coordinates, whichever is the point: where minima are several an edge has one
            // target.
            const VertexId v = vertex(s);
            const BackVertex<D> point{request_.place, request_.metric.log_metric};
            const BackVertex<D> other{end(s), r_.metrics[v].log_metric};
            if (request_.place.c < end(s).c)
                w_.searched.push_back({point, other, request_.metric.back});
            else
                w_.searched.push_back({other, point, r_.metrics[v].back});
        }
        w_.found.resize(w_.free.size());
        minimise_edges<D>(goal_.field, w_.searched, rules, options, w_.found);
        for (std::size_t i = 0; i < w_.free.size(); ++i) w_.offsets[i] = w_.found[i].node.point - middle(w_.free[i]);
    }

    void begin_cones() {
        w_.cones.resize(out_.star.joined.size());
        for (std::size_t j = 0; j < w_.cones.size(); ++j) {
            const auto& [element, opposite] = out_.star.joined[j];
            Cone<D>& cone = w_.cones[j];
            cone = {};
            cone.nodes = nodes_of(r_.mesh, element);
            cone.point = static_cast<int>(opposite);
            cone.nodes[opposite] = request_.place;
            const auto& vertices = r_.mesh.elements.vertices[element];
            for (int i = 0; i <= D; ++i) {
                const bool is_point = i == cone.point;
                cone.metrics[i] = is_point ? request_.metric.log_metric : r_.metrics[vertices[i]].log_metric;
                if (!is_point) cone.spokes[i] = star_.vertices.find(vertices[i]);
            }
        }
    }
    void refresh(Cone<D>& cone) const {
        for (int i = 0; i <= D; ++i)
            if (i != cone.point) cone.nodes[D + 1 + edge_between<D>[i][cone.point]] = w_.spokes[cone.spokes[i]].node;
        const NodalSimplex<D> element{cone.nodes};
        const BoundedJacobian<D> jacobian = bounded_jacobian(element);
        cone.verdict = decide_by_coefficients(jacobian, bound_);
        if (cone.verdict == Verdict::undecided) cone.verdict = decide(element, bound_);
        cone.is_flat = cone.verdict == Verdict::valid && is_flat(element, jacobian);
        cone.shape = cone.verdict == Verdict::valid ? curved_shape(cone.nodes, cone.metrics) : 0;
        cone.is_stale = false;
    }
    /// As of degree 1: somewhere so low, det J by the largest face, that coordinates, which are known to their rounding
    /// only, do not tell on which side its vertices are.
    [[nodiscard]] bool is_flat(const NodalSimplex<D>& element, const BoundedJacobian<D>& jacobian) const {
        std::array<Vec<D>, D + 1> corners;
        std::copy_n(element.nodes.begin(), D + 1, corners.begin());
        const double floor = rounding_of(corners) * largest_face<D>(corners);
        if (std::ranges::min(jacobian.coefficients) - jacobian.error > floor) return false;
        return decide(element, std::max(bound_, floor / std::abs(jacobian.straight))) != Verdict::valid;
    }
    [[nodiscard]] StarFault judge() {
        for (Cone<D>& cone : w_.cones)
            if (cone.is_stale) refresh(cone);
        for (std::size_t j = 0; j < w_.cones.size(); ++j)
            if (w_.cones[j].verdict != Verdict::valid) {
                if (bound_ == limits_.lowest_jacobian && may_stay_invalid(j)) continue;
                if (bound_ == limits_.lowest_jacobian || !replaces_worse()) return {RejectionReason::volume, j};
                bound_ = limits_.lowest_jacobian;
                for (Cone<D>& cone : w_.cones) cone.is_stale = cone.verdict != Verdict::valid;
                return judge();
            }
        for (std::size_t j = 0; j < w_.cones.size(); ++j)
            if (w_.cones[j].is_flat) return {RejectionReason::height, j};
        for (std::size_t j = 0; j < w_.cones.size(); ++j)
            if (w_.cones[j].verdict == Verdict::valid && !is_good(w_.cones[j])) return {RejectionReason::quality, j};
        return {};
    }
    /// Of the element with the same vertices, which the joined face is of.
    [[nodiscard]] bool may_stay_invalid(std::size_t joined) const {
        return limits_.invalid_before == InvalidBefore::may_stay &&
               decide(NodalSimplex<D>{nodes_of(r_.mesh, out_.star.joined[joined].element)}, bound_) != Verdict::valid;
    }
    [[nodiscard]] bool is_good(const Cone<D>& cone) {
        return cone.verdict == Verdict::valid && !cone.is_flat && bar_.is_met(cone.shape);
    }
    /// Whether an element that is removed is below the bound itself.
    [[nodiscard]] bool replaces_worse() const {
        return std::ranges::any_of(out_.removed.elements, [&](ElementId e) {
            return decide(NodalSimplex<D>{nodes_of(r_.mesh, e)}, limits_.min_jacobian) != Verdict::valid;
        });
    }
    /// False where no node of a bad element has any way left.
    [[nodiscard]] bool draw_back() {
        bool drawn = false;
        for (Cone<D>& cone : w_.cones) {
            if (is_good(cone)) continue;
            for (int i = 0; i <= D; ++i) {
                if (i == cone.point) continue;
                Spoke<D>& spoke = w_.spokes[cone.spokes[i]];
                if (spoke.kind != EdgeKind::volume || spoke.share == 0 || spoke.wanted == spoke.extended) continue;
                spoke.share = spoke.share > 0.5 ? 0.5 : 0;
                spoke.node = spoke.extended + spoke.share * (spoke.wanted - spoke.extended);
                drawn = true;
            }
        }
        if (drawn) mark_stale();
        return drawn;
    }
    void mark_stale() {
        for (Cone<D>& cone : w_.cones)
            for (int i = 0; i <= D; ++i)
                if (i != cone.point)
                    cone.is_stale |=
                        cone.nodes[D + 1 + edge_between<D>[i][cone.point]] != w_.spokes[cone.spokes[i]].node;
    }
    /// Halves of an edge that is split keep its curve.
    [[nodiscard]] bool is_free(std::uint32_t s) const {
        return w_.spokes[s].kind == EdgeKind::volume && vertex(s) != request_.halves[0] && vertex(s) != request_.halves[1];
    }
    /// Whether the cavity may do without the element that a new one comes of: cheaper than a programme.
    [[nodiscard]] bool may_leave(std::ptrdiff_t joined) const {
        const auto& elements = out_.removed.elements;
        const auto at = std::ranges::find(elements, out_.star.joined[joined].element) - elements.begin();
        return request_.holders > 0 && static_cast<std::size_t>(at) >= request_.holders;
    }
    /// Whether all elements are valid in the end.
    [[nodiscard]] bool raise() {
        const auto is_broken = [](const Cone<D>& cone) { return cone.verdict != Verdict::valid; };
        for (;;) {
            const auto broken = std::ranges::find_if(w_.cones, is_broken);
            if (broken == w_.cones.end()) return true;
            if (may_leave(broken - w_.cones.begin())) return false;
            bool raised = false;
            for (int i = 0; i <= D && is_broken(*broken); ++i) {
                if (i == broken->point || !is_free(broken->spokes[i])) continue;
                if (w_.programmes == limits_.programmes) return false;
                ++w_.programmes;
                raised |= raise(broken->spokes[i]);
            }
            if (!raised) return false;
        }
    }
    [[nodiscard]] EdgeShell<D> shell_of(std::uint32_t s) const {
        EdgeShell<D> shell{{w_.spokes[s].node}, {}};
        for (const Cone<D>& cone : w_.cones)
            for (int i = 0; i <= D; ++i)
                if (i != cone.point && cone.spokes[i] == s)
                    shell.elements.push_back({{cone.nodes}, edge_between<D>[i][cone.point], {}});
        return shell;
    }
    void put(std::uint32_t s, const Vec<D>& node) {
        w_.spokes[s].node = node;
        mark_stale();
        for (Cone<D>& cone : w_.cones)
            if (cone.is_stale) refresh(cone);
    }
    /// Nodes that were drawn back go as near to where they are wanted as their elements stay good, one after the other:
    /// a quadratic programme each.
    void approach() {
        QuadraticModel<D> model;
        for (int i = 0; i < D; ++i)
            for (int j = 0; j <= i; ++j) {
                model.hessian(i, j) = 0;
                for (const Vec<D>& row : request_.metric.measure.rows) model.hessian(i, j) += row[i] * row[j];
            }
        for (std::uint32_t s = 0; s < w_.spokes.size() && w_.programmes < limits_.approaches; ++s) {
            const Spoke<D>& spoke = w_.spokes[s];
            if (spoke.share == 1 || !is_free(s) || spoke.node == spoke.wanted) continue;
            ++w_.programmes;
            model.centre = spoke.wanted;
            const Vec<D> before = spoke.node;
            const auto nearest = nearest_node(shell_of(s), model, bound_, {.max_cuts = 8});
            if (!nearest || !(model(nearest->node.point) < model(before))) continue;
            put(s, nearest->node.point);
            if (judge().reason != RejectionReason::none) put(s, before);
        }
    }
    [[nodiscard]] bool raise(std::uint32_t s) {
        const EdgeShell<D> shell = shell_of(s);
        constexpr double worthwhile = 1e-3;
        const double before = smallest_scaled_jacobian(shell, shell.node, bound_);
        const auto highest = highest_node(shell, {.max_cuts = 0, .enough = 2 * bound_, .least = before + worthwhile});
        if (!highest) return false;
        w_.spokes[s].share = 0;
        put(s, highest->node.point);
        return true;
    }
    [[nodiscard]] RejectionReason judge_lengths() const {
        const bool moves = request_.point.valid() && request_.place != r_.mesh.points[request_.point];
        for (std::size_t s = 0; s < w_.spokes.size(); ++s) {
            if (star_.to_point[s].is_there && !moves) continue;
            const double length = edge_length<D>(request_.metric.log_metric, r_.metrics[vertex(s)].log_metric,
                                                 {request_.place, {w_.spokes[s].node}, end(s)});
            if (!(length >= limits_.shortest && length <= limits_.longest)) return RejectionReason::length;
        }
        return RejectionReason::none;
    }

    const Adaptation<D>& r_;
    const AdaptationGoal<D>& goal_;
    const CavityRequest<D>& request_;
    const PatchLimits& limits_;
    const StarWorkspace<D>& star_;
    CurvedWorkspace<D>& w_;
    Patch<D>& out_;
    double bound_ = 0;
    QualityBar<D> bar_;
};

}  // namespace

template <int D>
StarFault curve_star(const Adaptation<D>& r, const AdaptationGoal<D>& goal, const CavityRequest<D>& request,
                     const PatchLimits& limits, OperationWorkspace<D>& workspace, Patch<D>& patch, double& worst) {
    return CurvingStar<D>(r, goal, request, limits, workspace, patch).run(worst);
}

template StarFault curve_star<2>(const Adaptation<2>&, const AdaptationGoal<2>&, const CavityRequest<2>&, const PatchLimits&,
                                 OperationWorkspace<2>&, Patch<2>&, double&);
template StarFault curve_star<3>(const Adaptation<3>&, const AdaptationGoal<3>&, const CavityRequest<3>&, const PatchLimits&,
                                 OperationWorkspace<3>&, Patch<3>&, double&);

}  // namespace camber
