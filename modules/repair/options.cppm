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

/// How nodes find a place at which the elements around them are valid.
enum class RepairMethod : std::uint8_t {
    /// Towards the boundary's displacement extended, by as few halvings as the elements need, the last step exactly
    /// there; what that leaves as by `cavity`. Then nodes return towards where they are wanted.
    extension,
    /// By programmes over cavities, nearest to where nodes are wanted: several nodes together; then one; then the
    /// boundary's displacement extended; then larger cavities, vertices and, last, surface nodes.
    cavity,
    edge,  ///< by programmes of one volume node at a time alone
    /// Node by node, as little as needed: each moves on the segment to the middle of its chord to the farthest place
    /// where the elements of its shell hold, by a linear programme; steps by theta only for what that cannot repair;
    /// nodes are put back as far as they may at the end.
    segment,
    /// The paper's (§3.2): P_11 ← θ P_11 + (1 − θ) M for all volume edges of an element that is not valid, then for its
    /// surface edges, until it is; elements that break by it are next.
    backtracking,
};
[[nodiscard]] constexpr auto words(RepairMethod) {
    return words_of(Word{RepairMethod::extension, "extension"}, Word{RepairMethod::cavity, "cavity"},
                    Word{RepairMethod::edge, "edge"}, Word{RepairMethod::segment, "segment"},
                    Word{RepairMethod::backtracking, "backtracking"});
}

/// Whether a method ends with cavities, which may move vertices and surface nodes.
[[nodiscard]] constexpr bool has_cavities(RepairMethod method) {
    return method == RepairMethod::extension || method == RepairMethod::cavity;
}

/// Whether a method weighs places by models, one an edge; the others take none.
[[nodiscard]] constexpr bool needs_models(RepairMethod method) {
    return has_cavities(method) || method == RepairMethod::edge;
}

enum class VertexMoves : std::uint8_t { allowed, never };
[[nodiscard]] constexpr auto words(VertexMoves) {
    return words_of(Word{VertexMoves::allowed, "move"}, Word{VertexMoves::never, "keep"});
}

/// What is asked of the elements, and what may be done for it.
struct RepairOptions {
    JacobianBound min_scaled_jacobian = {};
    JacobianBound target = {};
    RepairMethod method = RepairMethod::extension;
    double boundary_tolerance = 0;
    VertexMoves vertices = VertexMoves::allowed;
    /// A step of a programme with ten unknown points counts 1, others with the square of their number. So repair ends
    /// where what is asked cannot be had; counts, not seconds, so that the result is the same on any machine.
    double effort = 500;
    double restore_effort = 0.05;  ///< the same, of the programmes by which nodes return where they went home
    double theta = 0.75;
    int max_corrections = 40;
    double max_work = std::numeric_limits<double>::infinity();  ///< what may be spent in all, beside `effort`

    /// What repaired elements are to reach where they can.
    [[nodiscard]] constexpr double aim() const { return std::max(target.value, min_scaled_jacobian.value); }

    [[nodiscard]] static constexpr auto options() {
        using S = RepairOptions;
        return std::tuple(
            option("method", &S::method,
                   "extension: the nodes of an element that is not good enough go back towards the boundary's "
                   "displacement extended, then as near to their places as they may; what is left as by cavity; "
                   "cavity: the nodes of an element together, else one edge, then larger cavities, then vertices; "
                   "edge: one node at a time, nearest to where it is wanted; segment: the same towards the middle of "
                   "the chord, each as little as its elements need; backtracking: each edge of an invalid element by "
                   "theta, "
                   "as in the paper"),
            option(
                "target", &S::target,
                "scaled Jacobian of repaired elements where it can be reached; by extension, all elements are raised "
                "to it as far as nodes inside can. null: 0.6 where curve follows the mesh alone, 0.1 with a metric "
                "or a solution")
                .at_least(0)
                .below(1),
            option("boundary_tolerance", &S::boundary_tolerance,
                   "of a mesh that was read with its curves: how far the node of a boundary edge may move where "
                   "nothing else helps; 0: the boundary stays as it is. After curve, such nodes may always go back to "
                   "their chords")
                .unit("model units")
                .at_least(0),
            option("vertices", &S::vertices,
                   "move: vertices go where nodes alone do not repair an element, those of the boundary along a "
                   "prescribed geometry; keep: all stay. Required ones and corners never move"),
            option(
                "effort", &S::effort,
                "work that cavity and edge may spend for each element that is not good enough, in steps of "
                "programmes of ten nodes; easily repaired ones leave theirs to others, and what is not repaired when "
                "it is spent is listed")
                .at_least(0),
            option("restore_effort", &S::restore_effort,
                   "by extension: work that programmes may spend, for each element that was not good enough, to bring "
                   "nodes nearer to their places, beside that of a hundred such programmes; 1 or more wins back a "
                   "little more")
                .at_least(0),
            option("theta", &S::theta, "what a correction leaves of a node's offset")
                .unit("shares of the offset")
                .above(0)
                .below(1),
            option("max_corrections", &S::max_corrections, "corrections before a node goes to the middle of its chord")
                .at_least(1)
                .at_most(10000),
            bound_option<S>());
    }
    friend bool operator==(const RepairOptions&, const RepairOptions&) = default;
};

/// The work that a repair of so many elements that are not good enough may take: effort · (200 + elements). Where there
/// are few, one may take more.
[[nodiscard]] constexpr double allowed_work(std::size_t elements, double effort) {
    return (200 + static_cast<double>(elements)) * effort;
}

/// What of it may be spent on returns of nodes that went home: 100 + restore_effort · elements.
[[nodiscard]] constexpr double allowed_return_work(std::size_t elements, const RepairOptions& options) {
    return 100 + static_cast<double>(elements) * options.restore_effort;
}

/// A place of the geometry for a point of the boundary, and the projector onto the directions that lead off it there:
/// n nᵀ on a surface, I − t tᵀ on a curve, I where the point is not to slide.
template <int D>
struct GeometryFoot {
    Vec<D> point;
    Sym<D> across;
};
/// The foot near a point on what an edge of the boundary lies on: a pure function, asked from several threads.
template <int D>
using FootOnGeometry = std::function<GeometryFoot<D>(EdgeId, const Vec<D>&)>;
/// The same for a vertex of the boundary.
template <int D>
using VertexOnGeometry = std::function<GeometryFoot<D>(VertexId, const Vec<D>&)>;

/// Where nodes of boundary edges that may move end in the worst case.
enum class SurfaceMoves : std::uint8_t { off_geometry, on_geometry };

/// What repair goes by, beside the places and the options.
template <int D>
struct RepairGuide {
    Incidence<ElementId> shells;  ///< elements around each edge
    /// Where an edge's node is wanted while its vertices are where the mesh has them, and what it costs to have it
    /// elsewhere; asked of edges near elements that are not valid. Null for methods that need none (`needs_models`).
    std::function<LagrangeNode<D>(EdgeId)> wanted = {};
    EdgeModels<D> models = {};
    /// Where nodes go back to in elements that are not valid, one an edge: the extension of the boundary's displacement
    /// (`extend_boundary`). Empty: one is made around these elements alone.
    Column<LagrangeNode<D>> home = {};
    /// Where nodes of boundary edges slide before any of them leaves the geometry; null: they do not slide.
    FootOnGeometry<D> onto = {};
    /// Where vertices of the boundary slide, with the nodes of their edges; null: they stay.
    VertexOnGeometry<D> vertices_onto = {};
    SurfaceMoves surface = SurfaceMoves::off_geometry;
};

/// What a repair changed.
struct RepairStatistics {
    std::size_t corrected_elements = 0;   ///< not valid before, valid now
    std::size_t raised_elements = 0;      ///< valid before but below `RepairOptions::target`, not below it now
    std::size_t moved_volume_nodes = 0;   ///< edges whose node is not where it was
    std::size_t moved_surface_nodes = 0;  ///< the same, of surface and ridge edges: they may have left the geometry
    std::size_t moved_vertices = 0;       ///< in the volume
    double work = 0;                      ///< of its programmes, as `RepairOptions::effort` counts it
    std::size_t by_edges = 0, by_cavities = 0, by_extension = 0, by_vertices = 0, by_slides = 0,
                by_surface = 0;  ///< elements
};

/// A proposal after a repair, and what that changed.
template <int D>
struct Repaired {
    JudgedProposal<D> judged;
    RepairStatistics statistics = {};
    std::vector<ElementId> given_up = {};  ///< not valid when the work that may be spent was spent; rising
};

/// What is otherwise in a later judgement of the same mesh: elements, and nodes and vertices, by the kinds of `before`.
template <int D>
[[nodiscard]] RepairStatistics changes_between(const JudgedProposal<D>& before, const JudgedProposal<D>& after);

/// The later state with all that changed since `before` counted, and with its kinds; the work is that of `after`.
template <int D>
[[nodiscard]] Repaired<D> with_all_changes(const JudgedProposal<D>& before, Repaired<D> after);

/// The elements that are not valid, rising.
template <int D>
[[nodiscard]] std::vector<ElementId> elements_not_valid(const Validation<D>& validation);

/// The changes with those of edges whose node is not where it was: straightened, where it is in the middle now, else
/// relaxed.
template <int D>
[[nodiscard]] Column<EdgeChange> changes_after(const QuadraticMesh<D>& mesh, const Proposal<D>& before,
                                               const Column<Vec<D>>& points, const Column<LagrangeNode<D>>& mid_nodes);

/// Returns the options with a recommended target if they require none and their method raises elements.
[[nodiscard]] inline RepairOptions with_target(RepairOptions options, const JacobianBound& recommended) {
    if (!options.target.is_asked && options.method == RepairMethod::extension) options.target = recommended;
    return options;
}

}  // namespace camber

namespace camber {

/// How a vertex may move while a mesh is repaired.
enum class VertexFreedom : std::uint8_t {
    held,     ///< it stays
    free,     ///< in the volume
    sliding,  ///< on the boundary: as far as it slides on the geometry
};

/// All vertices are held, or required ones, those at edges that are, and those of the boundary where none slides.
template <int D>
[[nodiscard]] inline Buffer<VertexFreedom> vertex_freedoms(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                                           VertexMoves moves, VertexFreedom of_boundary) {
    Buffer<VertexFreedom> freedoms(mesh.linear.points.size());
    std::ranges::fill(freedoms, moves == VertexMoves::never ? VertexFreedom::held : VertexFreedom::free);
    if (moves == VertexMoves::never) return freedoms;
    for (const bool is_fixed : {false, true})
        for (std::size_t e = 0; e < kinds.size(); ++e)
            if (kinds[e] != EdgeKind::volume && (kinds[e] == EdgeKind::fixed) == is_fixed)
                for (const VertexId v : mesh.edges.vertices[e])
                    freedoms[v.index()] = is_fixed ? VertexFreedom::held : of_boundary;
    const auto required = required_vertices(mesh.linear);
    for (std::size_t v = 0; v < freedoms.size(); ++v)
        if (required[v] != 0) freedoms[v] = VertexFreedom::held;
    return freedoms;
}

/// A repair judged for the least bound and for the one that is asked for.
template <int D>
struct TwiceJudged {
    Repaired<D> repaired;  ///< judged for the latter
    std::size_t invalid = 0;

    /// Fewer invalid ones first, then fewer below the bound.
    [[nodiscard]] std::pair<std::size_t, std::size_t> left() const {
        return {invalid, repaired.judged.validation().not_valid()};
    }
};

template <int D>
[[nodiscard]] Outcome<TwiceJudged<D>> judge_twice(Repaired<D> repaired, double bound, const Execution& execution) {
    const QuadraticMesh<D> mesh = repaired.judged.mesh();
    const Proposal<D> proposal = repaired.judged.proposal();
    const auto least = validate(mesh, proposal, min_bound, execution);
    if (!least) return fail(least.error());
    auto asked = validate(mesh, proposal, bound, execution);
    if (!asked) return fail(asked.error());
    repaired.judged = std::move(*asked);
    return TwiceJudged<D>{std::move(repaired), least->validation().not_valid()};
}

/// To the passes elements below a bound are alike: where it cannot be had, some may have been left invalid that need
/// not be. `asked`: what came of the bound of the options. If that has invalid elements, `repair(start, options)` is
/// asked for the least bound, from there and from what was `wanted`; what leaves fewest invalid is taken; if that is
/// none, the bound is tried once more from there. Errors: those of `repair`, stopped.
template <int D, class Repair>
[[nodiscard]] Outcome<Repaired<D>> min_invalid(const JudgedProposal<D>& wanted, Outcome<Repaired<D>> asked,
                                               const RepairOptions& options, const Execution& execution,
                                               Repair&& repair) {
    const double bound = options.min_scaled_jacobian;
    if (!asked || asked->judged.validation().all_valid() || bound <= min_bound) return asked;
    auto best = judge_twice(std::move(*asked), bound, execution);
    if (!best) return fail(best.error());
    RepairOptions from_wanted = options;
    from_wanted.min_scaled_jacobian = min_bound;
    RepairOptions from_there = from_wanted;
    from_there.boundary_tolerance = 0;  // what it allows was taken
    const JudgedProposal<D> there = best->repaired.judged;
    for (const auto& [start, by] : {std::pair(&there, &from_there), std::pair(&wanted, &from_wanted)}) {
        if (best->invalid == 0) break;
        auto lower = repair(*start, *by);
        if (!lower) return lower;
        auto tried = judge_twice(std::move(*lower), bound, execution);
        if (!tried) return fail(tried.error());
        if (tried->left() < best->left()) best = std::move(tried);
    }
    if (best->invalid == 0 && !best->repaired.judged.validation().all_valid()) {
        RepairOptions onwards = options;
        onwards.boundary_tolerance = 0;
        auto higher = repair(best->repaired.judged, onwards);
        if (!higher) return higher;
        auto tried = judge_twice(std::move(*higher), bound, execution);
        if (!tried) return fail(tried.error());
        if (tried->left() < best->left()) best = std::move(tried);
    }
    return with_all_changes(wanted, std::move(best->repaired));
}

}  // namespace camber
