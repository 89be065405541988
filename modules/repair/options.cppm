// Options, guide, statistics and results of a repair.
module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <tuple>
#include <utility>
#include <vector>
export module camber.repair:options;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.curving;

export namespace camber {

enum class RepairMethod : std::uint8_t {
    /// Moves nodes to the extension of the boundary displacement in a few halving steps, the last one exact. Repairs
    /// the remaining elements as `cavity` does. Then moves nodes back towards their targets.
    extension,
    /// Minimises the distance of nodes from their targets. Moves in turn: all nodes of a cavity; one node; local
    /// extension of the boundary displacement; larger cavities; vertices; surface nodes.
    cavity,
    edge,
    /// Moves each node towards its chord midpoint by the minimum distance (a linear program). Multiplies offsets by θ
    /// in the remaining elements. Finally moves nodes back as far as possible.
    segment,
    /// Paper §3.2: P_11 ← θ P_11 + (1 − θ) M, with the chord midpoint M, for all volume edges of an invalid element,
    /// then for its surface edges. Elements that become invalid are treated too.
    backtracking,
};
[[nodiscard]] constexpr auto words(RepairMethod) {
    return words_of(Word{RepairMethod::extension, "extension"}, Word{RepairMethod::cavity, "cavity"},
                    Word{RepairMethod::edge, "edge"}, Word{RepairMethod::segment, "segment"},
                    Word{RepairMethod::backtracking, "backtracking"});
}

/// True if the method includes cavities, which may move vertices and surface nodes.
[[nodiscard]] constexpr bool has_cavities(RepairMethod method) {
    return method == RepairMethod::extension || method == RepairMethod::cavity;
}

[[nodiscard]] constexpr bool needs_models(RepairMethod method) {
    return has_cavities(method) || method == RepairMethod::edge;
}

enum class VertexMoves : std::uint8_t { allowed, never };
[[nodiscard]] constexpr auto words(VertexMoves) {
    return words_of(Word{VertexMoves::allowed, "move"}, Word{VertexMoves::never, "keep"});
}

struct RepairOptions {
    JacobianBound min_scaled_jacobian = {};
    JacobianBound target = {};
    RepairMethod method = RepairMethod::extension;
    double boundary_tolerance = 0;
    VertexMoves vertices = VertexMoves::allowed;
    /// Work limit per element. An optimisation step with n unknown points counts (n/10)². Unlike seconds, such counts
    /// give the same result on any machine.
    double effort = 500;
    double restore_effort = 0.05;  ///< same unit; for moves back to the targets after `extension`
    double theta = 0.75;
    int max_corrections = 40;
    double max_work = std::numeric_limits<double>::infinity();  ///< absolute limit besides `effort`

    /// Scaled Jacobian that repaired elements should reach.
    [[nodiscard]] constexpr double effective_target() const {
        return std::max(target.value, min_scaled_jacobian.value);
    }

    [[nodiscard]] static constexpr auto options() {
        using S = RepairOptions;
        return std::tuple(
            option("method", &S::method,
                   "repair method for elements that are not good enough. extension: nodes move towards an extension "
                   "of the boundary displacement, then back as near to their targets as possible, and cavity repairs "
                   "the remaining elements; cavity: optimises all nodes of an element, else one edge, then larger "
                   "cavities, then vertices; edge: optimises one node at a time, as near to its target as possible; "
                   "segment: moves nodes towards the middle of their chords, as little as their elements need; "
                   "backtracking: multiplies the offsets of the edges of an invalid element by theta, as in the paper"),
            option(
                "target", &S::target,
                "scaled Jacobian that repaired elements should reach. With extension, all elements are raised to it "
                "as far as inner nodes allow. null: 0.6 if curve uses only the mesh, 0.1 with a metric or a solution")
                .at_least(0)
                .below(1),
            option("boundary_tolerance", &S::boundary_tolerance,
                   "curved input only: largest displacement of a node of a boundary edge, if no other repair "
                   "succeeds. 0: the boundary does not move. After curve, these nodes may always move back towards "
                   "their chords")
                .unit("model units")
                .at_least(0),
            option("vertices", &S::vertices,
                   "move: vertices move if nodes alone do not repair an element, boundary vertices only along a "
                   "prescribed geometry; keep: no vertex moves. Required vertices and corners never move"),
            option(
                "effort", &S::effort,
                "work limit of cavity and edge for each element that is not good enough. Unit: one optimisation step "
                "with ten nodes. Work that one element does not need is available to others. Elements that are not "
                "repaired within the limit are listed")
                .at_least(0),
            option("restore_effort", &S::restore_effort,
                   "extension only: work limit for moving nodes back towards their targets, for each element that was "
                   "not good enough. The work of a hundred such elements is added. Unit: that of effort. 1 or more "
                   "moves nodes slightly nearer")
                .at_least(0),
            option("theta", &S::theta, "share of a node's offset that remains after a correction")
                .unit("shares of the offset")
                .above(0)
                .below(1),
            option("max_corrections", &S::max_corrections,
                   "number of corrections before a node moves to the middle "
                   "of its chord")
                .at_least(1)
                .at_most(10000),
            bound_option<S>());
    }
    friend bool operator==(const RepairOptions&, const RepairOptions&) = default;
};

/// The constant allows more work per element if few are invalid.
[[nodiscard]] constexpr double allowed_work(std::size_t elements, double effort) {
    return (200 + static_cast<double>(elements)) * effort;
}

[[nodiscard]] constexpr double allowed_return_work(std::size_t elements, const RepairOptions& options) {
    return 100 + static_cast<double>(elements) * options.restore_effort;
}

/// A point on the geometry, and the projector onto the directions off it: n nᵀ on a surface with normal n, I − t tᵀ on
/// a curve with tangent t, I if the point must not slide.
template <int D>
struct GeometryFoot {
    Vec<D> point;
    Sym<D> normal_projector;
};
/// Projects a point onto the geometry of a boundary edge. Must be pure, because several threads call it.
template <int D>
using FootOnGeometry = std::function<GeometryFoot<D>(EdgeId, const Vec<D>&)>;
template <int D>
using VertexOnGeometry = std::function<GeometryFoot<D>(VertexId, const Vec<D>&)>;

enum class SurfaceMoves : std::uint8_t { off_geometry, on_geometry };

template <int D>
struct RepairGuide {
    Incidence<ElementId> shells;
    /// Target position of an edge's node, for the original vertices. Called for edges near invalid elements. Null for
    /// methods without models (`needs_models`).
    std::function<LagrangeNode<D>(EdgeId)> target_node = {};
    EdgeModels<D> models = {};
    /// Extension of the boundary displacement (`extend_boundary`), one node per edge. Empty: it is computed locally.
    Column<LagrangeNode<D>> global_extension = {};
    /// Projects boundary nodes, which slide before any node leaves the geometry; null: no slides.
    FootOnGeometry<D> onto = {};
    /// Projects boundary vertices, which take the nodes of their edges along; null: no moves.
    VertexOnGeometry<D> vertices_onto = {};
    SurfaceMoves surface = SurfaceMoves::off_geometry;
};

struct RepairStatistics {
    std::size_t corrected_elements = 0;
    std::size_t raised_elements = 0;  ///< from below `RepairOptions::target` to at least the target
    std::size_t moved_volume_nodes = 0;
    std::size_t moved_surface_nodes = 0;  ///< nodes of surface and ridge edges, possibly off the geometry
    std::size_t moved_vertices = 0;
    double work = 0;  ///< unit of `RepairOptions::effort`
    std::size_t by_edges = 0, by_cavities = 0, by_extension = 0, by_vertices = 0, by_slides = 0,
                by_surface = 0;  ///< elements repaired by each kind of move
};

template <int D>
struct Repaired {
    JudgedProposal<D> judged;
    RepairStatistics statistics = {};
    std::vector<ElementId> unresolved = {};  ///< invalid when the work limit was reached; ascending
};

/// Counts changed elements, nodes and vertices. The edge kinds of `before` classify the nodes.
template <int D>
[[nodiscard]] RepairStatistics changes_between(const JudgedProposal<D>& before, const JudgedProposal<D>& after);

/// Returns `after` with the edge kinds of `before` and statistics of all changes since `before`; the work is that of
/// `after`.
template <int D>
[[nodiscard]] Repaired<D> with_all_changes(const JudgedProposal<D>& before, Repaired<D> after);

/// Returns the elements whose verdict is not `valid`, in ascending order.
template <int D>
[[nodiscard]] std::vector<ElementId> elements_not_valid(const Validation<D>& validation);

/// Marks moved nodes as straightened (at the chord midpoint) or relaxed.
template <int D>
[[nodiscard]] Column<EdgeChange> changes_after(const QuadraticMesh<D>& mesh, const Proposal<D>& before,
                                               const Column<Vec<D>>& points, const Column<LagrangeNode<D>>& mid_nodes);

/// Sets the target to the recommended value if the user set none and the method is `extension`.
[[nodiscard]] inline RepairOptions with_target(RepairOptions options, const JacobianBound& recommended) {
    if (!options.target.is_explicit && options.method == RepairMethod::extension) options.target = recommended;
    return options;
}

}  // namespace camber

namespace camber {

enum class VertexFreedom : std::uint8_t {
    fixed,
    free,
    sliding,
};

template <int D>
[[nodiscard]] inline Buffer<VertexFreedom> vertex_freedoms(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                                           VertexMoves moves, VertexFreedom of_boundary) {
    Buffer<VertexFreedom> freedoms(mesh.linear.points.size());
    std::ranges::fill(freedoms, moves == VertexMoves::never ? VertexFreedom::fixed : VertexFreedom::free);
    if (moves == VertexMoves::never) return freedoms;
    for (const bool is_fixed : {false, true})
        for (std::size_t e = 0; e < kinds.size(); ++e)
            if (kinds[e] != EdgeKind::volume && (kinds[e] == EdgeKind::fixed) == is_fixed)
                for (const VertexId v : mesh.edges.vertices[e])
                    freedoms[v.index()] = is_fixed ? VertexFreedom::fixed : of_boundary;
    const auto required = required_vertices(mesh.linear);
    for (std::size_t v = 0; v < freedoms.size(); ++v)
        if (required[v] != 0) freedoms[v] = VertexFreedom::fixed;
    return freedoms;
}

/// A repair result, judged for the minimum bound and for the requested bound.
template <int D>
struct JudgedForBoth {
    Repaired<D> repaired;
    std::size_t invalid = 0;

    [[nodiscard]] std::pair<std::size_t, std::size_t> left() const {
        return {invalid, repaired.judged.validation().not_valid()};
    }
};

template <int D>
[[nodiscard]] Outcome<JudgedForBoth<D>> judge_for_both(Repaired<D> repaired, double bound, const Execution& execution) {
    const QuadraticMesh<D> mesh = repaired.judged.mesh();
    const Proposal<D> proposal = repaired.judged.proposal();
    const auto least = validate(mesh, proposal, min_bound, execution);
    if (!least) return fail(least.error());
    auto requested = validate(mesh, proposal, bound, execution);
    if (!requested) return fail(requested.error());
    repaired.judged = std::move(*requested);
    return JudgedForBoth<D>{std::move(repaired), least->validation().not_valid()};
}

/// Selects the result for a bound that may be unreachable. Repair passes treat elements below the bound like invalid
/// ones. `requested` is the result for the requested bound. If it has invalid elements, repairs for the minimum bound
/// from `requested` and from `input`, and selects the result with the fewest invalid elements. If that has none, tries
/// the requested bound once more. Errors: those of `repair`, stopped.
template <int D, class Repair>
[[nodiscard]] Outcome<Repaired<D>> min_invalid(const JudgedProposal<D>& input, Outcome<Repaired<D>> requested,
                                               const RepairOptions& options, const Execution& execution,
                                               Repair&& repair) {
    const double bound = options.min_scaled_jacobian;
    if (!requested || requested->judged.validation().all_valid() || bound <= min_bound) return requested;
    auto best = judge_for_both(std::move(*requested), bound, execution);
    if (!best) return fail(best.error());
    RepairOptions from_input = options;
    from_input.min_scaled_jacobian = min_bound;
    RepairOptions from_best = from_input;
    from_best.boundary_tolerance = 0;  // the repair of `requested` has already used the tolerance
    const JudgedProposal<D> there = best->repaired.judged;
    for (const auto& [start, by] : {std::pair(&there, &from_best), std::pair(&input, &from_input)}) {
        if (best->invalid == 0) break;
        auto lower = repair(*start, *by);
        if (!lower) return lower;
        auto tried = judge_for_both(std::move(*lower), bound, execution);
        if (!tried) return fail(tried.error());
        if (tried->left() < best->left()) best = std::move(tried);
    }
    if (best->invalid == 0 && !best->repaired.judged.validation().all_valid()) {
        RepairOptions onwards = options;
        onwards.boundary_tolerance = 0;
        auto higher = repair(best->repaired.judged, onwards);
        if (!higher) return higher;
        auto tried = judge_for_both(std::move(*higher), bound, execution);
        if (!tried) return fail(tried.error());
        if (tried->left() < best->left()) best = std::move(tried);
    }
    return with_all_changes(input, std::move(best->repaired));
}

}  // namespace camber
