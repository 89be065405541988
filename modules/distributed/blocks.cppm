// Curving by blocks: goals, the state of a run, regions, the whole surface, curved parts as rows of a file.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>
export module camber.distributed:blocks;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.validity;
import camber.crossing;
import camber.io;
import camber.surface;
import camber.extension;
import camber.curving;
import camber.repair;
import camber.stages;
import :parts;
import :ranks;

namespace camber {

/// The middle of a chord; a straight mesh need not keep them.
template <int D>
[[nodiscard]] LagrangeNode<D> straight_node(const QuadraticMesh<D>& mesh, EdgeId e) {
    const auto& [a, b] = mesh.edges.vertices[e];
    return {midpoint(mesh.linear.points[a], mesh.linear.points[b])};
}
template <int D>
[[nodiscard]] Buffer<LagrangeNode<D>> straight_nodes(const QuadraticMesh<D>& mesh) {
    Buffer<LagrangeNode<D>> nodes(mesh.edges.size());
    for (std::size_t e = 0; e < nodes.size(); ++e) nodes[e] = straight_node(mesh, EdgeId(e));
    return nodes;
}

/// Nodes of a mesh's edges of which most are in the middles of their chords: the others.
template <int D>
class MovedNodes {
  public:
    MovedNodes() = default;  ///< none are known
    MovedNodes(const QuadraticMesh<D>& mesh, const Buffer<LagrangeNode<D>>& nodes) : is_known_(true) {
        for (std::size_t e = 0; e < nodes.size(); ++e)
            if (nodes[e] != straight_node(mesh, EdgeId(e))) edges_.emplace_back(e), nodes_.push_back(nodes[e]);
        edges_.shrink_to_fit();
        nodes_.shrink_to_fit();
    }

    [[nodiscard]] bool is_known() const { return is_known_; }
    [[nodiscard]] LagrangeNode<D> at(const QuadraticMesh<D>& mesh, EdgeId e) const {
        const auto found = std::ranges::lower_bound(edges_, e);
        return found != edges_.end() && *found == e ? nodes_[static_cast<std::size_t>(found - edges_.begin())]
                                                    : straight_node(mesh, e);
    }
    /// One an edge.
    [[nodiscard]] Buffer<LagrangeNode<D>> all(const QuadraticMesh<D>& mesh) const {
        Buffer<LagrangeNode<D>> nodes = straight_nodes(mesh);
        for (std::size_t i = 0; i < edges_.size(); ++i) nodes[edges_[i].index()] = nodes_[i];
        return nodes;
    }

    void each_array(const auto& visit) {
        visit(edges_);
        visit(nodes_);
    }

  private:
    bool is_known_ = false;
    Buffer<EdgeId> edges_;  ///< rising
    Buffer<LagrangeNode<D>> nodes_;
};

/// What is known of a part between two steps: rows of its vertices and unique edges, those in its rings as their
/// owners have them.
template <int D>
struct PartState {
    QuadraticMesh<D> mesh;  ///< straight, without nodes
    Incidence<ElementId> shells;
    OwnVertices owned;
    EdgeId first_edge, last_edge;
    Column<EdgeKind> kinds;
    Column<EdgeKind> kinds_that_follow;  ///< see kinds_that_follow; empty: the same
    Column<EdgeId> on_surface;           ///< the edge of the whole surface that each is; invalid: of the volume
    Buffer<LagrangeNode<D>> base;        ///< where nodes start, while that is of use
    MovedNodes<D> extended;              ///< not known: nothing is displaced
    Buffer<LogMetric<D>> log_metrics;    ///< none: a field with a mesh of its own
    MovedNodes<D> back_nodes;            ///< of the field's mesh; not known: straight
    Buffer<Vec<D>> slides, offsets;      ///< none: nothing moves
    Buffer<LagrangeNode<D>> nodes;

    [[nodiscard]] bool owns(EdgeId e) const { return e >= first_edge && e < last_edge; }
    /// Kinds by which only its own edges of the volume are looked for.
    [[nodiscard]] Column<EdgeKind> own_kinds() const {
        Buffer<EdgeKind> own(kinds.begin(), kinds.end());
        for (std::size_t e = 0; e < own.size(); ++e)
            if (!owns(EdgeId(e))) own[e] = EdgeKind::fixed;
        return own;
    }
};

/// visit(array) of all that grow with the part.
template <int D>
void each_array(PartState<D>& state, const auto& visit) {
    visit(state.mesh.edges.vertices);
    visit(state.mesh.edges.of_elements);
    visit(state.mesh.edges.of_facets);
    visit(state.mesh.edges.of_edges);
    visit(state.shells.offsets);
    visit(state.shells.items);
    visit(state.kinds);
    visit(state.kinds_that_follow);
    visit(state.on_surface);
    visit(state.base);
    state.extended.each_array(visit);
    visit(state.log_metrics);
    state.back_nodes.each_array(visit);
    visit(state.slides);
    visit(state.offsets);
    visit(state.nodes);
}

/// A column of each state, to be brought.
template <int D, class T>
[[nodiscard]] std::vector<std::span<T>> columns_of(std::vector<PartState<D>>& states, Buffer<T> PartState<D>::* of) {
    std::vector<std::span<T>> columns;
    for (PartState<D>& state : states) columns.emplace_back(state.*of);
    return columns;
}

/// Some elements of a mesh in blocks with all within some rings around them, on one rank.
template <int D>
struct Region {
    QuadraticMesh<D> mesh;  ///< without facets; nodes as the parts have them
    std::vector<GlobalNumber> vertices, elements;
    Buffer<std::uint8_t> outer;  ///< vertices not all of whose elements are here
    Buffer<LogMetric<D>> log_metrics;
    Column<EdgeKind> kinds;
    Buffer<LagrangeNode<D>> extended, back_nodes;  ///< empty where the parts have none
};

/// Around these elements, of all ranks: regions that have no vertex in common, each on the rank that has the lowest of
/// its elements among these. Which regions there are does not depend on the ranks. Errors: of any rank.
template <int D>
[[nodiscard]] Outcome<std::vector<Region<D>>> regions_around(const RingedParts<D>& parts,
                                                             const std::vector<PartState<D>>& states,
                                                             const std::vector<GlobalNumber>& elements, int rings,
                                                             Ranks& ranks, const Execution& execution);

}  // namespace camber

export namespace camber {

/// What blocks are curved by.
template <int D>
struct BlocksGoal {
    /// The features and the shape of the boundary, which is given as a mesh without elements. Null: smooth surfaces
    /// through its vertices.
    std::function<Outcome<Boundary<D>>(const LinearMesh<D>&, const EdgeSet<D>&, const Execution&)> boundary = {};
    /// The metric at the vertices of a part, of which the numbers in the whole mesh are given too. Null: the mesh's
    /// own.
    std::function<Outcome<Column<LogMetric<D>>>(const LinearMesh<D>&, std::span<const GlobalNumber>, const Execution&)>
        metric = {};
};

/// By blocks of how many elements a mesh is curved, as a stage's options say it.
struct CurveByBlocks {
    int blocks = 0;
    double memory = 0;

    [[nodiscard]] static constexpr auto options() {
        using S = CurveByBlocks;
        return std::tuple(
            option(
                "blocks", &S::blocks,
                "elements in a block: the mesh is curved by blocks and written by parts; 0: as a whole, but on several "
                "ranks, and within a memory, by blocks of 262144")
                .at_least(0)
                .unit("elements"),
            option("memory", &S::memory,
                   "about as much memory may be taken: what blocks have lies in files without names beside the output, "
                   "and leaves memory when they have been gone through; 0: it stays there")
                .at_least(0)
                .unit("bytes"));
    }
    friend bool operator==(const CurveByBlocks&, const CurveByBlocks&) = default;
};

struct CurveBlocksOptions {
    BlockOptions blocks = {};
    CurveMeshOptions curving = {};
    BoundaryTolerance tolerance = {};  ///< of the boundary's deviation from its geometry
};

/// Verdicts of a mesh in blocks, of all ranks.
struct BlocksValidation {
    std::size_t invalid = 0, undecided = 0;  ///< elements without a certificate of det J > 0
    std::size_t below_bound = 0;             ///< other elements that do not reach the bound
    double smallest = 1;                     ///< smallest scaled Jacobian
    GlobalNumber worst = 0;                  ///< the element that has it, if there are elements

    [[nodiscard]] std::size_t not_valid() const { return invalid + undecided + below_bound; }
};

/// A part that was curved: nodes of its unique edges, those in its rings as their owners have them.
template <int D>
struct CurvedPart {
    QuadraticMesh<D> mesh;
    EdgeId first_edge, last_edge;  ///< its own are [first_edge, last_edge)
};

/// Walls of a mesh in blocks that cross in the end; facets as the whole mesh numbers them.
template <int D>
struct WallsOfBlocks {
    Crossings crossings;
    std::size_t crossing_before = 0;       ///< pairs of the straight mesh that cross, where any cross in the end
    std::array<Box<D>, 2> first_crossing;  ///< boxes of the first pair that crosses, where there is one
    MovedBack<D> moved;                    ///< nodes that were moved back until no walls crossed
};

/// Deviation of the whole boundary from its geometry in the end, and its worst entities as the whole mesh has them.
template <int D>
struct DeviationOfBlocks {
    BoundaryDeviation found;             ///< the ids are those of a mesh of the boundary alone
    std::array<GlobalNumber, 2> edge{};  ///< ends of the edge with the worst node, where there is one
    Vec<D> node{};                       ///< that node
    GlobalNumber vertex = 0;             ///< the worst vertex, where there is one
    Vec<D> point{};                      ///< its position
};

/// What a rank has of a curved mesh in blocks, and what all have found.
template <int D>
struct CurvedBlocks {
    RingedParts<D> parts;
    std::vector<CurvedPart<D>> curved;      ///< one a part of this rank
    std::vector<GlobalNumber> first_edges;  ///< of each part of all; then the number of edges
    RowCounts counts;                       ///< of the mesh
    CurveStatistics statistics;             ///< of all ranks
    BlocksValidation before, after;
    RepairStatistics repair;
    WallsOfBlocks<D> walls;
    DeviationOfBlocks<D> deviation;
    std::size_t iterations = 0;  ///< of the extension
};

/// The boundary of a mesh in blocks, which each rank has as a whole: features, patches and the surfaces through it are
/// not found by looking around, and it is small beside what it encloses. A mesh without elements, in the order of the
/// whole one.
template <int D>
struct WholeSurface {
    QuadraticMesh<D> mesh;               ///< facets and feature edges, with the nodes of `elevate`
    std::vector<GlobalNumber> vertices;  ///< of each of its own, rising
    Boundary<D> boundary;
    CurveInput<D> input;  ///< of its edges, see curve_input

    /// Of some vertices, rising, which of its own each is; an invalid id: none.
    [[nodiscard]] std::vector<VertexId> places_of(std::span<const GlobalNumber> numbers) const;
    /// The edge between two vertices, or an invalid id.
    [[nodiscard]] EdgeId find(GlobalNumber a, GlobalNumber b) const;
};

/// From the rows. Errors: those of the rows, of find_boundary and curve_input; required elements on the boundary, which
/// are not known here (unsupported).
template <int D>
[[nodiscard]] Outcome<WholeSurface<D>> whole_surface(const MeshRows<D>& rows, const BlocksGoal<D>& goal,
                                                     const Execution& execution);

}  // namespace camber

namespace camber {

/// What all parts are curved by.
template <int D>
struct CurvingBy {
    WholeSurface<D> surface;
    CurveOptions edges;
};

/// State of a rank between two steps.
template <int D>
struct BlockRun {
    const MeshRows<D>& rows;
    const BlocksGoal<D>& goal;
    CurveBlocksOptions options;  ///< of the steps so far
    Ranks& ranks;
    CurvedBlocks<D> out = {};
    std::vector<PartState<D>> states = {};  ///< one a part here
    Halo edges = {}, vertices = {};
    std::optional<BetweenRingedParts<D>> between = {};
    std::optional<CurvingBy<D>> by = {};
    std::optional<RepairOptions> judged_for = {};  ///< options of the last verdicts
    std::vector<GlobalNumber> to_repair = {};  ///< elements of this rank that are not valid or below the target, rising
    bool is_displaced = false;                 ///< so that there is an extension, of whichever parts

    /// f of each part here: of what it makes the part's state is kept.
    Outcome<Done> each_part(const Execution& execution, const auto& f) {
        if (!options.blocks.memory.before) return each_part_keeping(execution, f);
        return each_part_keeping(execution, [&](PartState<D>& state, RingedPart<D>& part) -> Outcome<Done> {
            const std::vector<const void*> before = arrays_of(state);
            options.blocks.memory.before();
            auto done = f(state, part);
            options.blocks.memory.after();
            if (done) made_anew(state, before);
            return done;
        });
    }
    /// f of each part here, which makes what is kept beside the states.
    Outcome<Done> each_part_keeping(const Execution& execution, const auto& f) {
        for (std::size_t p = 0; p < states.size(); ++p) {
            auto done = f(states[p], out.parts.own[p]);
            if (!done) return fail(done.error());
            if (options.blocks.memory.leave) options.blocks.memory.leave();
            report_progress(execution, p + 1, states.size());
        }
        return Done{};
    }

    /// Rows of edges of the surface from the parts that own them: value_of(part, edge, edge of the surface), if any.
    Outcome<Done> gather_on_surface(std::span<Vec<D>> values, const auto& value_of) {
        struct Found {
            std::uint64_t at = 0;
            Vec<D> value;
        };
        std::vector<Found> found;
        for (std::size_t b = 0; b < states.size(); ++b)
            for (EdgeId e = states[b].first_edge; e < states[b].last_edge; e = EdgeId(e.index() + 1)) {
                const EdgeId at = states[b].on_surface[e];
                if (!at.valid()) continue;
                if (const std::optional<Vec<D>> value = value_of(b, e, at)) found.push_back({at.index(), *value});
            }
        const auto all = gather_all(ranks, Outcome<std::vector<Found>>(std::move(found)));
        if (!all) return fail(all.error());
        for (const Found& f : *all) values[f.at] = f.value;
        return Done{};
    }
};

/// The surface, and what each part has of it.
template <int D>
[[nodiscard]] Outcome<Done> find_surface(BlockRun<D>& run, const Execution& execution);

/// Extends the displacement of the boundary's curves over its faces (extend_over_faces), then that of the faces into
/// the volume (extend_boundary).
template <int D>
[[nodiscard]] Outcome<Done> extend_blocks(BlockRun<D>& run, const Execution& execution);

/// The metric at the vertices, and the nodes of the mesh that it is read in.
template <int D>
[[nodiscard]] Outcome<Done> make_metric(BlockRun<D>& run, const Execution& execution);

/// Where edges start: those of the volume at these nodes, others where the surface has them.
template <int D>
[[nodiscard]] Buffer<LagrangeNode<D>> starting_at(const PartState<D>& state, const WholeSurface<D>& surface,
                                                  const MovedNodes<D>& nodes);

/// The field on a part of the mesh, of which some of its vertices and edges are; on a part.
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> field_on(const QuadraticMesh<D>& mesh, Buffer<LagrangeNode<D>> back_nodes,
                                            const Buffer<LogMetric<D>>& log_metrics, KeptGradients kept,
                                            const Execution& execution);
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> field_of(const PartState<D>& state, KeptGradients kept, const Execution& execution);

/// Nodes of all edges.
template <int D>
[[nodiscard]] Outcome<Done> curve_nodes(BlockRun<D>& run, const Execution& execution);

/// Verdicts of all elements; those that are not valid are repaired.
template <int D>
[[nodiscard]] Outcome<Done> judge_blocks(BlockRun<D>& run, const Execution& execution);
template <int D>
[[nodiscard]] Outcome<Done> relax_blocks(BlockRun<D>& run, const Execution& execution);

/// Moves nodes of the boundary back until no walls cross, as `uncross_walls` does; each rank looks at the whole
/// surface.
template <int D>
[[nodiscard]] Outcome<Done> uncross_blocks(BlockRun<D>& run, const Execution& execution);

/// Measures the deviation of the boundary from its geometry; each rank that of the whole surface.
template <int D>
[[nodiscard]] Outcome<Done> measure_blocks(BlockRun<D>& run, const Execution& execution);

}  // namespace camber

export namespace camber {

/// The steps of a pipeline that curves, on a mesh in blocks: each rank works on its own parts and their two rings, and
/// rows of other parts are exchanged after each step. The nodes are those of the whole mesh but for rounding of sums
/// over the mesh. All ranks call each step, in the order of the declarations. The mesh must be sound (check_part).
/// Errors of all steps: those of the same step of a whole mesh; of any rank.
template <int D>
class BlockSteps {
  public:
    /// The arguments must outlive it.
    BlockSteps(const MeshRows<D>& rows, const BlocksGoal<D>& goal, const BlockOptions& blocks, Ranks& ranks);
    BlockSteps(BlockSteps&&) noexcept;
    BlockSteps& operator=(BlockSteps&&) noexcept;
    ~BlockSteps();

    /// Steps: split, elevate.
    [[nodiscard]] Outcome<Done> elevate(const Around& around);
    /// Steps: surface, extension, metric, curve. Errors (unsupported): objectives without a metric, other boundary
    /// nodes than projected ones, metrics made of the mesh's own.
    [[nodiscard]] Outcome<Done> curve(const ProposeOptions& options, const Around& around);
    /// Computes the verdicts for the bound of `repair`, and lists the elements that it would repair. Step: validate.
    [[nodiscard]] Outcome<Done> validate(const RepairOptions& repair, const Around& around);
    /// Repairs elements, then moves boundary nodes back where walls cross. Steps: relax, uncross.
    [[nodiscard]] Outcome<Done> relax(const RepairOptions& options, const Around& around);
    /// Measures the deviation of the boundary from its geometry. Step: measure.
    [[nodiscard]] Outcome<Done> measure(const BoundaryTolerance& tolerance, const Around& around);
    /// Ends the run and returns the mesh. Errors: of any rank.
    [[nodiscard]] Outcome<CurvedBlocks<D>> finish() &&;

  private:
    [[nodiscard]] Outcome<Done> step(const Around& around, std::string_view name, const auto& function);
    [[nodiscard]] RepairOptions with_own_target(const RepairOptions& repair) const;

    std::unique_ptr<BlockRun<D>> run_;
};

/// A curved mesh in blocks as the rows of its file, as they are in that of the straight one: each rank has a run of
/// each kind, and makes it in pieces, so that little is held at a time. All is asked for by all
/// ranks, in the same turn.
template <int D>
class QuadraticParts {
  public:
    /// All must outlive it. Errors: of any rank.
    [[nodiscard]] static Outcome<QuadraticParts> make(const MeshRows<D>& rows, const CurvedBlocks<D>& mesh,
                                                      Ranks& ranks);

    [[nodiscard]] PartTotals totals() const;
    [[nodiscard]] std::size_t pieces() const { return pieces_; }  ///< as many on each rank
    /// Errors: those of the rows, of any rank.
    [[nodiscard]] Outcome<FilePart<D, 2>> piece(std::size_t piece) const;

  private:
    QuadraticParts(const MeshRows<D>& rows, const CurvedBlocks<D>& mesh, Ranks& ranks)
        : rows_(&rows), mesh_(&mesh), ranks_(&ranks) {}

    /// The nodes of simplices of the file, from the parts that own them: number(part, row) → numbers of its edges.
    template <int K>
    [[nodiscard]] Outcome<SimplexRun<K, 2>> simplices(std::size_t begin, SimplexRows<K> given) const;

    const MeshRows<D>* rows_;
    const CurvedBlocks<D>* mesh_;
    Ranks* ranks_;
    std::size_t pieces_ = 1, pieces_of_part_ = 1;
    std::vector<Buffer<GlobalNumber>> edge_numbers_;  ///< of each part here, one an edge
};

/// The whole of a mesh that one rank has, in the order of its rows; `linear`: the straight one. Errors: memory,
/// stopped.
template <int D>
[[nodiscard]] Outcome<QuadraticMesh<D>> joined(const CurvedBlocks<D>& of, LinearMesh<D> linear,
                                               const Execution& execution);

}  // namespace camber
