// Repair of standalone surface meshes, and repair within a boundary tolerance.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>
#include <fmt/format.h>
module camber.repair;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;

namespace camber {

namespace {

constexpr int max_sweeps = 60;
constexpr int max_slides = 6;
constexpr int return_sweeps = 2;
constexpr double farthest_share = 0.4;  ///< maximum displacement, as a share of the chord

struct Freedom {
    std::array<Vec<3>, 3> basis{};
    int size = 0;
};
constexpr Freedom all_of_space{{Vec<3>{{1, 0, 0}}, Vec<3>{{0, 1, 0}}, Vec<3>{{0, 0, 1}}}, 3};

/// Returns a basis of the tangential directions; empty for a node that must not slide.
Freedom along_geometry(const Sym<3>& normal_projector) {
    const double rank = trace(normal_projector);
    if (rank > 2.5) return {};
    const bool is_curve = rank > 1.5;
    const Sym<3> projector = is_curve ? Sym<3>::identity() - normal_projector : normal_projector;
    int axis = 0;
    for (int i = 1; i < 3; ++i)
        if (projector(i, i) > projector(axis, axis)) axis = i;
    const Vec<3> direction = normalised(Vec<3>{{projector(0, axis), projector(1, axis), projector(2, axis)}});
    if (is_curve) return {{direction}, 1};
    Vec<3> other;
    other[(axis + 1) % 3] = 1;
    const Vec<3> first = normalised(cross(direction, other));
    return {{first, cross(direction, first)}, 2};
}

struct Move {
    EdgeId edge;
    Vec<3> point;
    double share = 0;
};

class Surface {
  public:
    Surface(const JudgedProposal<3>& input, const RepairGuide<3>& guide, const RepairOptions& options,
            const SurfaceLimits& leave, Incidence<FacetId> triangles)
        : mesh_(input.mesh()),
          before_(input.proposal()),
          nodes_(before_.mid_nodes.begin(), before_.mid_nodes.end()),
          onto_(guide.onto),
          options_(options),
          leave_(leave),
          triangles_(std::move(triangles)),
          verdicts_(input.validation().verdicts.begin(), input.validation().verdicts.end()) {
        for (std::size_t t = 0; t < verdicts_.size(); ++t)
            if (verdicts_[t] != Verdict::valid) bad_.push_back(t);
        mesh_.linear.points = before_.points;
    }

    Outcome<Done> repair(const Execution& execution) {
        for (int turn = 0; turn < max_sweeps && !bad_.empty(); ++turn) {
            if (is_stopped(execution)) return fail(ErrorKind::stopped, "stopped");
            std::vector<std::size_t> looked_at;
            std::swap(looked_at, bad_);
            for (const std::size_t t : looked_at)
                if (verdicts_[t] != Verdict::valid) correct(t);
            sort_unique(bad_);
            std::erase_if(bad_, [&](std::size_t t) { return verdicts_[t] == Verdict::valid; });
        }
        for (int turn = 0; turn < return_sweeps && options_.method != RepairMethod::backtracking; ++turn)
            for (const EdgeId edge : pulled_) restore_move(edge);
        return Done{};
    }

    [[nodiscard]] Column<LagrangeNode<3>> nodes() const {
        return Buffer<LagrangeNode<3>>(nodes_.begin(), nodes_.end());
    }
    [[nodiscard]] double work() const { return work_; }

  private:
    static bool is_stopped(const Execution& execution) { return execution.stop.stop_requested(); }
    static void sort_unique(std::vector<std::size_t>& list) {
        std::ranges::sort(list);
        list.erase(std::ranges::unique(list).begin(), list.end());
    }

    [[nodiscard]] double bound() const { return options_.min_scaled_jacobian; }
    [[nodiscard]] double hard_bound() const { return options_.min_scaled_jacobian.is_explicit ? bound() : min_bound; }

    [[nodiscard]] bool is_free(EdgeId e) const {
        return before_.kinds[e] != EdgeKind::fixed && before_.kinds[e] != EdgeKind::volume;
    }
    [[nodiscard]] double chord(EdgeId e) const {
        const auto& [a, b] = mesh_.edges.vertices[e];
        return distance(mesh_.linear.points[a], mesh_.linear.points[b]);
    }
    [[nodiscard]] Vec<3> middle(EdgeId e) const {
        const auto& [a, b] = mesh_.edges.vertices[e];
        return midpoint(mesh_.linear.points[a], mesh_.linear.points[b]);
    }
    [[nodiscard]] bool may_move_to(EdgeId e, const Vec<3>& p) const {
        if (!is_finite(p)) return false;
        return !(leave_.most > 0) || distance(p, before_.mid_nodes[e].point) <= leave_.most;
    }

    [[nodiscard]] SurfaceTriangle triangle(std::size_t t) const { return surface_triangle(mesh_, nodes_, t); }
    [[nodiscard]] SurfaceTriangle triangle(std::size_t t, EdgeId edge, const Vec<3>& p) const {
        SurfaceTriangle s = triangle(t);
        for (int k = 0; k < 3; ++k)
            if (mesh_.edges.of_facets[t][k] == edge) s.nodes[3 + k] = p;
        return s;
    }
    static std::array<double, 6> scaled(const SurfaceTriangle& s) {
        const BoundedJacobian<2> j = bounded_jacobian(s);
        std::array<double, 6> c{};
        for (int i = 0; i < 6; ++i) c[i] = j.coefficients[i] / j.straight;
        return c;
    }
    static double lowest(const SurfaceTriangle& s) { return std::ranges::min(scaled(s)); }

    [[nodiscard]] bool helps(std::size_t of, EdgeId edge, const Vec<3>& p, double least) const {
        for (const FacetId f : triangles_[edge]) {
            const std::size_t t = f.index();
            const SurfaceTriangle moved = triangle(t, edge, p);
            if (t == of || verdicts_[t] == Verdict::valid) {
                if (decide(moved, t == of ? least : bound()) != Verdict::valid) return false;
            } else if (lowest(moved) < lowest(triangle(t))) {
                return false;
            }
        }
        return true;
    }

    void put(EdgeId edge, const Vec<3>& p) {
        nodes_[edge.index()].point = p;
        for (const FacetId f : triangles_[edge]) {
            verdicts_[f.index()] = decide(triangle(f.index()), bound());
            if (verdicts_[f.index()] != Verdict::valid) bad_.push_back(f.index());
        }
    }

    /// Returns the minimum displacement of a node from `at` that raises the minimum of triangle `of` to `floor`.
    /// Adjacent triangles stay above `floor` or their own minimum.
    template <int M>
    [[nodiscard]] std::optional<Vec<3>> min_displacement(std::size_t of, EdgeId edge, const Vec<3>& at,
                                                         const Freedom& freedom, double floor) {
        const double unit = chord(edge);
        std::vector<AffineFunction<M>> functions;
        functions.reserve(12);
        for (const FacetId f : triangles_[edge]) {
            const auto here = scaled(triangle(f.index(), edge, at));
            const double preserved = f.index() == of ? floor : std::min(floor, std::ranges::min(here));
            std::array<std::array<double, 6>, M> there{};
            for (int m = 0; m < M; ++m) there[m] = scaled(triangle(f.index(), edge, at + unit * freedom.basis[m]));
            for (int i = 0; i < 6; ++i) {
                AffineFunction<M> function{{}, here[i] - preserved};
                for (int m = 0; m < M; ++m) function.gradient[m] = there[m][i] - here[i];
                if (!std::isfinite(function.offset) || !is_finite(function.gradient)) return std::nullopt;
                functions.push_back(function);
            }
        }
        work_ += M * M * 0.01;
        const NearestPoint<M> nearest = nearest_point<M>(QuadraticModel<M>{}, functions);
        if (!nearest.feasible || !(norm(nearest.x) <= farthest_share)) return std::nullopt;
        Vec<3> displacement;
        for (int m = 0; m < M; ++m) displacement += unit * nearest.x[m] * freedom.basis[m];
        return displacement;
    }
    [[nodiscard]] std::optional<Vec<3>> min_displacement(std::size_t of, EdgeId edge, const Vec<3>& at,
                                                         const Freedom& freedom, double floor) {
        switch (freedom.size) {
            case 1: return min_displacement<1>(of, edge, at, freedom, floor);
            case 2: return min_displacement<2>(of, edge, at, freedom, floor);
            case 3: return min_displacement<3>(of, edge, at, freedom, floor);
            default: return std::nullopt;
        }
    }

    [[nodiscard]] Move move_to(EdgeId edge, const Vec<3>& p) const {
        return {edge, p, distance(p, nodes_[edge.index()].point) / chord(edge)};
    }

    [[nodiscard]] std::array<double, 2> floors(double least) const {
        return {std::max(options_.target.value, least), least + 1e-3 * (1 - least)};
    }

    [[nodiscard]] std::optional<Move> slide(std::size_t t, EdgeId edge, double floor) {
        if (!onto_) return std::nullopt;
        const Vec<3>& present = nodes_[edge.index()].point;
        GeometryFoot<3> foot = onto_(edge, present);
        for (int step = 0; step < max_slides; ++step) {
            const auto displacement =
                min_displacement(t, edge, foot.point, along_geometry(foot.normal_projector), floor);
            if (!displacement) return std::nullopt;
            foot = onto_(edge, foot.point + *displacement);
            if (!may_move_to(edge, foot.point) || distance(foot.point, present) > farthest_share * chord(edge))
                return std::nullopt;
            if (helps(t, edge, foot.point, bound())) return move_to(edge, foot.point);
        }
        return std::nullopt;
    }

    [[nodiscard]] std::optional<Move> restoring_move(std::size_t t, EdgeId edge) const {
        if (!onto_) return std::nullopt;
        const GeometryFoot<3> foot = onto_(edge, middle(edge));
        const bool slides = along_geometry(foot.normal_projector).size > 0;
        if (!slides || !is_finite(foot.point) || !helps(t, edge, foot.point, bound())) return std::nullopt;
        return move_to(edge, foot.point);
    }

    [[nodiscard]] std::optional<Move> departure(std::size_t t, EdgeId edge, double floor) {
        const Vec<3>& present = nodes_[edge.index()].point;
        const auto displacement = min_displacement(t, edge, present, all_of_space, floor);
        if (!displacement) return std::nullopt;
        const Vec<3> p = present + *displacement;
        if (!may_move_to(edge, p) || !helps(t, edge, p, hard_bound())) return std::nullopt;
        return move_to(edge, p);
    }

    bool by_shortest(std::size_t t, const auto& way) {
        std::optional<Move> best;
        for (const EdgeId edge : mesh_.edges.of_facets[t]) {
            if (!is_free(edge)) continue;
            const std::optional<Move> move = way(edge);
            if (move && (!best || move->share < best->share)) best = move;
        }
        if (best) put(best->edge, best->point);
        return best.has_value();
    }

    bool straighten(std::size_t t) {
        const auto& edges = mesh_.edges.of_facets[t];
        for (int correction = 0; correction <= options_.max_corrections; ++correction) {
            if (correction > 0 && decide(triangle(t), hard_bound()) == Verdict::valid) break;
            const double preserved = correction == options_.max_corrections ? 0 : options_.theta;
            for (const EdgeId edge : edges) {
                if (!is_free(edge)) continue;
                const Vec<3> m = middle(edge);
                const Vec<3> p = preserved == 0 ? m : m + preserved * (nodes_[edge.index()].point - m);
                if (may_move_to(edge, p)) nodes_[edge.index()].point = p;
            }
        }
        for (const EdgeId edge : edges) {
            if (!is_free(edge) || nodes_[edge.index()] == before_.mid_nodes[edge]) continue;
            put(edge, nodes_[edge.index()].point);
            pulled_.push_back(edge);
        }
        return decide(triangle(t), hard_bound()) == Verdict::valid;
    }

    void restore_move(EdgeId edge) {
        const Vec<3> from = nodes_[edge.index()].point;
        const Vec<3> to = before_.mid_nodes[edge].point;
        double share = 1;
        for (const FacetId f : triangles_[edge]) {
            const auto here = scaled(triangle(f.index()));
            const auto there = scaled(triangle(f.index(), edge, to));
            const double floor = std::min(floors(hard_bound())[0], std::ranges::min(here));
            for (int i = 0; i < 6; ++i)
                if (there[i] < floor) share = std::min(share, (here[i] - floor) / (here[i] - there[i]));
        }
        if (!(share > 1e-6)) return;
        const Vec<3> p = share < 1 ? from + 0.999 * share * (to - from) : to;
        for (const FacetId f : triangles_[edge]) {
            const double least = verdicts_[f.index()] == Verdict::valid ? bound() : hard_bound();
            if (decide(triangle(f.index()), least) == Verdict::valid &&
                decide(triangle(f.index(), edge, p), least) != Verdict::valid)
                return;
        }
        put(edge, p);
    }

    bool correct(std::size_t t) {
        const bool by_chords = !needs_models(options_.method);
        if (!by_chords) {
            for (const double floor : floors(bound()))
                if (by_shortest(t, [&](EdgeId e) { return slide(t, e, floor); })) return true;
            if (by_shortest(t, [&](EdgeId e) { return restoring_move(t, e); })) return true;
        }
        if (!leave_.may_leave || decide(triangle(t), hard_bound()) == Verdict::valid) return false;
        if (!by_chords)
            for (const double floor : floors(hard_bound()))
                if (by_shortest(t, [&](EdgeId e) { return departure(t, e, floor); })) return true;
        return straighten(t);
    }

    QuadraticMesh<3> mesh_;
    const Proposal<3>& before_;
    std::vector<LagrangeNode<3>> nodes_;
    const FootOnGeometry<3>& onto_;
    const RepairOptions& options_;
    SurfaceLimits leave_;
    Incidence<FacetId> triangles_;
    std::vector<Verdict> verdicts_;
    std::vector<std::size_t> bad_;
    std::vector<EdgeId> pulled_;
    double work_ = 0;
};

}  // namespace

Outcome<Repaired<3>> repair_surface(const JudgedProposal<3>& input, const RepairGuide<3>& guide,
                                    const RepairOptions& options, const SurfaceLimits& leave,
                                    const Execution& execution) {
    if (auto fits = check_limits(options); !fits) return fail(fits.error());
    const double bound = options.min_scaled_jacobian;
    if (input.validation().bound != bound) {
        const auto again = validate(input.mesh(), input.proposal(), bound, without_progress(execution));
        if (!again) return fail(again.error());
        return repair_surface(*again, guide, options, leave, execution);
    }
    if (input.validation().all_valid()) return Repaired<3>{input};
    auto triangles = facet_shells(input.mesh().edges, without_progress(execution));
    if (!triangles) return fail(triangles.error());
    return guarded([&]() -> Outcome<Repaired<3>> {
        Surface surface(input, guide, options, leave, std::move(*triangles));
        if (auto done = surface.repair(execution); !done) return fail(done.error());
        Proposal<3> proposal = input.proposal();
        proposal.mid_nodes = surface.nodes();
        proposal.changes = changes_after(input.mesh(), input.proposal(), proposal.points, proposal.mid_nodes);
        auto judged = validate(input.mesh(), std::move(proposal), bound, without_progress(execution));
        if (!judged) return fail(judged.error());
        Repaired<3> repaired{std::move(*judged)};
        repaired.statistics.work = surface.work();
        return with_all_changes(input, std::move(repaired));
    });
}

std::vector<RemainingElement> remaining_triangles(const Repaired<3>& repaired) {
    const Proposal<3>& proposal = repaired.judged.proposal();
    const QuadraticMesh<3> mesh = apply_proposal(repaired.judged.mesh(), proposal);
    const auto& verdicts = repaired.judged.validation().verdicts;
    std::vector<RemainingElement> all;
    for (std::size_t t = 0; t < verdicts.size(); ++t) {
        if (verdicts[t] == Verdict::valid) continue;
        const auto& v = mesh.linear.facets.vertices[t];
        const Vec<3>& p = mesh.linear.points[v[0]];
        const Vec<3> normal = cross(mesh.linear.points[v[1]] - p, mesh.linear.points[v[2]] - p);
        std::size_t fixed = 0;
        for (const EdgeId edge : mesh.edges.of_facets[t]) fixed += proposal.kinds[edge] == EdgeKind::fixed;
        std::string reason = "no valid position was found for the nodes of its edges";
        if (!(norm(normal) > 0))
            reason = "its vertices alone make it flat";
        else if (fixed > 0)
            reason = fmt::format("{} of its 3 edges cannot move", fixed);
        all.push_back({ElementId(t), std::move(reason)});
    }
    return all;
}

namespace {

constexpr int max_rounds = 12;

Column<EdgeKind> with_fixed_edges(const Column<EdgeKind>& kinds, const std::vector<std::uint8_t>& is_fixed) {
    Buffer<EdgeKind> all(kinds.begin(), kinds.end());
    for (std::size_t e = 0; e < all.size(); ++e)
        if (all[e] != EdgeKind::volume && is_fixed[e] != 0) all[e] = EdgeKind::fixed;
    return all;
}

template <int D>
bool fix_beyond_tolerance(const Proposal<D>& before, const Proposal<D>& after, double tolerance,
                          std::vector<std::uint8_t>& is_fixed) {
    bool any = false;
    for (std::size_t e = 0; e < is_fixed.size(); ++e) {
        if (before.kinds[e] == EdgeKind::volume) continue;
        if (!(norm(after.mid_nodes[e].point - before.mid_nodes[e].point) > tolerance)) continue;
        is_fixed[e] = 1;
        any = true;
    }
    return any;
}

template <int D>
struct Within {
    const JudgedProposal<D>& input;
    const RepairGuide<D>& guide;
    RepairOptions options;
    double work_left = 0;
    const Execution& execution;

    Outcome<Repaired<D>> tried(const JudgedProposal<D>& start, const std::vector<std::uint8_t>& is_fixed,
                               SurfaceMoves surface = SurfaceMoves::off_geometry) {
        options.max_work = work_left;
        RepairGuide<D> by = guide;
        by.surface = surface;
        auto repaired =
            repair(start.with_kinds(with_fixed_edges(input.proposal().kinds, is_fixed)), by, options, execution);
        if (repaired) work_left -= repaired->statistics.work;
        return repaired;
    }
};

/// Slides nodes in planes, then repairs. Returns `preserved` unless the result has fewer invalid elements.
Outcome<Repaired<3>> repair_after_slide(Within<3>& within, Repaired<3> preserved,
                                        const std::vector<std::uint8_t>& is_fixed, double tolerance,
                                        SurfaceMoves surface) {
    // Restores the edge kinds of the input, because fixed edges would not slide.
    auto slid = slid_in_planes(preserved.judged.with_kinds(within.input.proposal().kinds), tolerance, within.execution);
    if (!slid) return fail(slid.error());
    const auto start =
        validate(preserved.judged.mesh(), std::move(*slid), preserved.judged.validation().bound, within.execution);
    if (!start) return fail(start.error());
    auto repaired = within.tried(*start, is_fixed, surface);
    if (!repaired || repaired->judged.validation().not_valid() < preserved.judged.validation().not_valid())
        return repaired;
    return preserved;
}

template <int D>
Outcome<Repaired<D>> repair_on_geometry(Within<D>& within, Repaired<D> preserved) {
    const std::vector<std::uint8_t> none(within.input.proposal().kinds.size(), 0);
    if constexpr (D == 3) {
        constexpr double unbounded = std::numeric_limits<double>::infinity();
        auto slid = repair_after_slide(within, preserved, none, unbounded, SurfaceMoves::on_geometry);
        if (!slid || slid->judged.validation().all_valid()) return slid;
        auto direct = within.tried(preserved.judged, none, SurfaceMoves::on_geometry);
        if (!direct || direct->judged.validation().not_valid() <= slid->judged.validation().not_valid()) return direct;
        return slid;
    } else {
        return within.tried(preserved.judged, none, SurfaceMoves::on_geometry);
    }
}

template <int D>
Outcome<Repaired<D>> repair_to_bound(Within<D>& within) {
    const Proposal<D>& proposal = within.input.proposal();
    const double tolerance = within.options.boundary_tolerance;
    std::vector<std::uint8_t> is_fixed(proposal.kinds.size(), 1);
    auto preserved = within.tried(within.input, is_fixed);
    if (!preserved) return preserved;
    const auto done = [&] { return preserved->judged.validation().all_valid() || tolerance == 0; };
    if (within.guide.onto && !preserved->judged.validation().all_valid()) {
        preserved = repair_on_geometry(within, std::move(*preserved));
        if (!preserved) return preserved;
    }
    if (done()) return with_all_changes(within.input, std::move(*preserved));
    if constexpr (D == 3) {
        auto better =
            repair_after_slide(within, std::move(*preserved), is_fixed, tolerance, SurfaceMoves::off_geometry);
        if (!better) return better;
        preserved = std::move(better);
        if (done()) return with_all_changes(within.input, std::move(*preserved));
    }
    std::ranges::fill(is_fixed, std::uint8_t{0});
    for (int round = 0; round < max_rounds; ++round) {
        auto freed = within.tried(preserved->judged, is_fixed);
        if (!freed) return freed;
        if (!fix_beyond_tolerance(proposal, freed->judged.proposal(), tolerance, is_fixed))
            return with_all_changes(within.input, std::move(*freed));
    }
    return with_all_changes(within.input, std::move(*preserved));
}

}  // namespace

template <int D>
Outcome<Repaired<D>> repair_within(const JudgedProposal<D>& input, const RepairGuide<D>& guide,
                                   const RepairOptions& options, const Execution& execution) {
    if constexpr (D == 3)
        if (is_standalone_surface(input.mesh().linear)) {
            const double most = options.boundary_tolerance;
            if (guide.onto || most > 0) return repair_surface(input, guide, options, {most > 0, most}, execution);
            return Repaired<D>{input};
        }
    if (raises(options))
        return repair_then_raise(input, guide, options, execution, [&](const RepairOptions& by, const Execution& e) {
            return repair_within(input, guide, by, e);
        });
    const auto to = [&](const JudgedProposal<D>& judged, const RepairOptions& by) -> Outcome<Repaired<D>> {
        const auto start = validate(judged.mesh(), judged.proposal(), by.min_scaled_jacobian, execution);
        if (!start) return fail(start.error());
        Within<D> within{*start, guide, by, allowed_work(start->validation().not_valid(), by.effort), execution};
        return repair_to_bound(within);
    };
    auto preserved = min_invalid(input, to(input, options), options, execution, to);
    if (!preserved) return preserved;
    RepairOptions demanded = options;
    // Boundary nodes slide on the geometry only for validity (`min_bound`).
    if (guide.onto && options.min_scaled_jacobian > min_bound) demanded.min_scaled_jacobian = min_bound;
    return restore_input(input, std::move(*preserved), demanded, without_progress(execution));
}

#define CAMBER_INSTANTIATE(D)                                                                       \
    template Outcome<Repaired<D>> repair_within<D>(const JudgedProposal<D>&, const RepairGuide<D>&, \
                                                   const RepairOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
