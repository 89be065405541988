// Curving by blocks: its goals, the state of a run, regions, the whole surface, and curved parts as file rows.
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

/// Edge nodes, stored only where they differ from the chord midpoint.
template <int D>
class MovedNodes {
  public:
    MovedNodes() = default;  ///< the nodes are unknown
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
    Buffer<EdgeId> edges_;
    Buffer<LagrangeNode<D>> nodes_;
};

/// State of a part between two steps. The data of entities in its rings is copied from the parts that own them.
template <int D>
struct PartState {
    QuadraticMesh<D> mesh;  ///< straight; its edge nodes are not stored
    Incidence<ElementId> shells;
    OwnVertices owned;
    EdgeId first_edge, last_edge;
    Column<EdgeKind> kinds;
    Column<EdgeKind> kinds_with_following;  ///< empty: equal to `kinds`
    Column<EdgeId> on_surface;              ///< edge of the whole surface, or invalid
    Buffer<LagrangeNode<D>> base;
    MovedNodes<D> extended;            ///< unknown if there is no displacement
    Buffer<LogMetric<D>> log_metrics;  ///< empty: the field has its own mesh
    MovedNodes<D> back_nodes;          ///< edge nodes of the field's mesh; unknown: the mesh is straight
    Buffer<Vec<D>> slides, offsets;    ///< empty: nodes do not move
    Buffer<LagrangeNode<D>> nodes;

    [[nodiscard]] bool owns(EdgeId e) const { return e >= first_edge && e < last_edge; }
    /// Returns the edge kinds, where edges that other parts own are `fixed`.
    [[nodiscard]] Column<EdgeKind> own_kinds() const {
        Buffer<EdgeKind> own(kinds.begin(), kinds.end());
        for (std::size_t e = 0; e < own.size(); ++e)
            if (!owns(EdgeId(e))) own[e] = EdgeKind::fixed;
        return own;
    }
};

template <int D>
void each_array(PartState<D>& state, const auto& visit) {
    visit(state.mesh.edges.vertices);
    visit(state.mesh.edges.of_elements);
    visit(state.mesh.edges.of_facets);
    visit(state.mesh.edges.of_edges);
    visit(state.shells.offsets);
    visit(state.shells.items);
    visit(state.kinds);
    visit(state.kinds_with_following);
    visit(state.on_surface);
    visit(state.base);
    state.extended.each_array(visit);
    visit(state.log_metrics);
    state.back_nodes.each_array(visit);
    visit(state.slides);
    visit(state.offsets);
    visit(state.nodes);
}

template <int D, class T>
[[nodiscard]] std::vector<std::span<T>> columns_of(std::vector<PartState<D>>& states, Buffer<T> PartState<D>::* of) {
    std::vector<std::span<T>> columns;
    for (PartState<D>& state : states) columns.emplace_back(state.*of);
    return columns;
}

/// Some elements and the rings around them, collected on one rank.
template <int D>
struct Region {
    QuadraticMesh<D> mesh;  ///< without facets
    std::vector<GlobalNumber> vertices, elements;
    Buffer<std::uint8_t> outer;  ///< 1 for a vertex with elements outside the region
    Buffer<LogMetric<D>> log_metrics;
    Column<EdgeKind> kinds;
    Buffer<LagrangeNode<D>> extended, back_nodes;  ///< empty if the parts have no such nodes
};

/// Collects the regions around the `elements` of all ranks. Regions have no common vertices. Each region is on the rank
/// of the lowest of its `elements`. Regions do not depend on the number of ranks.
template <int D>
[[nodiscard]] Outcome<std::vector<Region<D>>> regions_around(const RingedParts<D>& parts,
                                                             const std::vector<PartState<D>>& states,
                                                             const std::vector<GlobalNumber>& elements, int rings,
                                                             Ranks& ranks, const Execution& execution);

}  // namespace camber

export namespace camber {

template <int D>
struct BlocksGoal {
    /// Boundary features and geometry of a mesh without elements. Null: the surfaces are smooth and interpolate its
    /// vertices.
    std::function<Outcome<Boundary<D>>(const LinearMesh<D>&, const EdgeSet<D>&, const Execution&)> boundary = {};
    /// Returns the metric at the vertices of a part, given their global numbers. Null: the metric of the mesh is used.
    std::function<Outcome<Column<LogMetric<D>>>(const LinearMesh<D>&, std::span<const GlobalNumber>, const Execution&)>
        metric = {};
};

struct CurveByBlocks {
    int blocks = 0;
    double memory = 0;

    [[nodiscard]] static constexpr auto options() {
        using S = CurveByBlocks;
        return std::tuple(
            option("blocks", &S::blocks,
                   "number of elements in a block. The mesh is curved block by block and written in parts. 0: as a "
                   "whole, or in blocks of 262144 on several ranks or with a memory limit")
                .at_least(0)
                .unit("elements"),
            option("memory", &S::memory,
                   "approximate memory limit. Data of blocks that are not processed is stored in temporary files in "
                   "the folder of the output. 0: all data stays in memory")
                .at_least(0)
                .unit("bytes"));
    }
    friend bool operator==(const CurveByBlocks&, const CurveByBlocks&) = default;
};

struct CurveBlocksOptions {
    BlockOptions blocks = {};
    CurveMeshOptions curving = {};
    BoundaryTolerance tolerance = {};
};

struct BlocksValidation {
    std::size_t invalid = 0, undecided = 0;  ///< elements without a certificate of det J > 0
    std::size_t below_bound = 0;             ///< elements with this certificate, but below the required bound
    double smallest = 1;                     ///< minimum scaled Jacobian
    GlobalNumber worst = 0;                  ///< element with this minimum

    [[nodiscard]] std::size_t not_valid() const { return invalid + undecided + below_bound; }
};

/// A curved part. Nodes in its rings are copies from owner parts.
template <int D>
struct CurvedPart {
    QuadraticMesh<D> mesh;
    EdgeId first_edge, last_edge;  ///< own edges are [first_edge, last_edge)
};

/// Boundary crossings at the end of a run, with global facet numbers.
template <int D>
struct WallsOfBlocks {
    Crossings crossings;
    std::size_t crossing_before = 0;  ///< crossing pairs of the straight mesh, computed if crossings remain
    std::array<Box<D>, 2> first_crossing;
    MoveBackStatistics<D> moved;
};

/// Final deviation of the whole boundary from its geometry, with global numbers.
template <int D>
struct DeviationOfBlocks {
    BoundaryDeviation found;  ///< with ids of the boundary mesh
    std::array<GlobalNumber, 2> edge{};
    Vec<D> node{};
    GlobalNumber vertex = 0;
    Vec<D> point{};
};

/// The curved parts of this rank, and results of all ranks.
template <int D>
struct CurvedBlocks {
    RingedParts<D> parts;
    std::vector<CurvedPart<D>> curved;
    std::vector<GlobalNumber> first_edges;  ///< first edge of each part, and the total
    RowCounts counts;
    CurveStatistics statistics;
    BlocksValidation before, after;
    RepairStatistics repair;
    WallsOfBlocks<D> walls;
    DeviationOfBlocks<D> deviation;
    std::size_t iterations = 0;
};

/// Boundary of a mesh in blocks. It is complete on each rank, because features, patches and surfaces are not local. It
/// has no elements, and its entities are in the order of the whole mesh.
template <int D>
struct WholeSurface {
    QuadraticMesh<D> mesh;
    std::vector<GlobalNumber> vertices;  ///< ascending global numbers
    Boundary<D> boundary;
    CurveInput<D> input;

    /// Returns the local id of each of the ascending numbers, or an invalid id.
    [[nodiscard]] std::vector<VertexId> places_of(std::span<const GlobalNumber> numbers) const;
    [[nodiscard]] EdgeId find(GlobalNumber a, GlobalNumber b) const;
};

/// Errors (unsupported): required elements.
template <int D>
[[nodiscard]] Outcome<WholeSurface<D>> whole_surface(const MeshRows<D>& rows, const BlocksGoal<D>& goal,
                                                     const Execution& execution);

}  // namespace camber

namespace camber {

template <int D>
struct CurvingContext {
    WholeSurface<D> surface;
    CurveOptions edges;
};

/// State of a rank between two steps.
template <int D>
struct BlockRun {
    const MeshRows<D>& rows;
    const BlocksGoal<D>& goal;
    CurveBlocksOptions options;
    Ranks& ranks;
    CurvedBlocks<D> out = {};
    std::vector<PartState<D>> states = {};
    Halo edges = {}, vertices = {};
    std::optional<BetweenRingedParts<D>> between = {};
    std::optional<CurvingContext<D>> by = {};
    std::optional<RepairOptions> judged_for = {};
    std::vector<GlobalNumber> to_repair = {};  ///< own elements that are invalid or below the target, ascending
    bool is_displaced = false;                 ///< an extended displacement exists on some rank

    /// Calls f for own parts. Arrays that f creates in a state are copied to persistent memory (PartMemory).
    Outcome<Done> each_part(const Execution& execution, const auto& f) {
        if (!options.blocks.memory.before) return each_resident_part(execution, f);
        return each_resident_part(execution, [&](PartState<D>& state, RingedPart<D>& part) -> Outcome<Done> {
            const std::vector<const void*> before = arrays_of(state);
            options.blocks.memory.before();
            auto done = f(state, part);
            options.blocks.memory.after();
            if (done) copy_new_arrays(state, before);
            return done;
        });
    }
    /// Calls f for own parts, where f may store results outside the states.
    Outcome<Done> each_resident_part(const Execution& execution, const auto& f) {
        for (std::size_t p = 0; p < states.size(); ++p) {
            auto done = f(states[p], out.parts.own[p]);
            if (!done) return fail(done.error());
            if (options.blocks.memory.leave) options.blocks.memory.leave();
            report_progress(execution, p + 1, states.size());
        }
        return Done{};
    }

    /// Calls value_of(part, edge, surface edge) for own edges on the surface, and stores the values of all ranks.
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

template <int D>
[[nodiscard]] Outcome<Done> find_surface(BlockRun<D>& run, const Execution& execution);

/// Extends the displacement of boundary curves over faces (extend_over_faces), then the displacement of faces into the
/// volume (extend_boundary).
template <int D>
[[nodiscard]] Outcome<Done> extend_blocks(BlockRun<D>& run, const Execution& execution);

template <int D>
[[nodiscard]] Outcome<Done> make_metric(BlockRun<D>& run, const Execution& execution);

/// Returns initial nodes: `nodes` for volume edges, surface nodes for the others.
template <int D>
[[nodiscard]] Buffer<LagrangeNode<D>> starting_at(const PartState<D>& state, const WholeSurface<D>& surface,
                                                  const MovedNodes<D>& nodes);

template <int D>
[[nodiscard]] Outcome<BackMesh<D>> field_on(const QuadraticMesh<D>& mesh, Buffer<LagrangeNode<D>> back_nodes,
                                            const Buffer<LogMetric<D>>& log_metrics, StoredGradients stored,
                                            const Execution& execution);
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> field_of(const PartState<D>& state, StoredGradients stored,
                                            const Execution& execution);

template <int D>
[[nodiscard]] Outcome<Done> curve_nodes(BlockRun<D>& run, const Execution& execution);

template <int D>
[[nodiscard]] Outcome<Done> validate_blocks(BlockRun<D>& run, const Execution& execution);
template <int D>
[[nodiscard]] Outcome<Done> relax_blocks(BlockRun<D>& run, const Execution& execution);

/// Moves boundary nodes back where facets cross (`uncross_walls`). Each rank checks the whole surface.
template <int D>
[[nodiscard]] Outcome<Done> uncross_blocks(BlockRun<D>& run, const Execution& execution);

template <int D>
[[nodiscard]] Outcome<Done> measure_blocks(BlockRun<D>& run, const Execution& execution);

}  // namespace camber

export namespace camber {

/// Steps of the curving pipeline in blocks. Each rank works on its parts with two rings of elements, and exchanges rows
/// after each step. Nodes equal those of a run on the whole mesh, up to rounding in sums over the mesh. All ranks call
/// all steps in the order of declaration. The mesh must be sound (check_part). Errors: those of the steps on a whole
/// mesh.
template <int D>
class BlockSteps {
  public:
    /// The arguments must outlive the object.
    BlockSteps(const MeshRows<D>& rows, const BlocksGoal<D>& goal, const BlockOptions& blocks, Ranks& ranks);
    BlockSteps(BlockSteps&&) noexcept;
    BlockSteps& operator=(BlockSteps&&) noexcept;
    ~BlockSteps();

    /// Runs the steps split and elevate.
    [[nodiscard]] Outcome<Done> elevate(const StepWrapper& around);
    /// Runs the steps surface, extension, metric and curve. Errors (unsupported): objectives without a metric, boundary
    /// nodes that are not projected, metrics derived from the mesh.
    [[nodiscard]] Outcome<Done> curve(const ProposeOptions& options, const StepWrapper& around);
    /// Computes verdicts for the bound of `repair`, and lists the elements to repair. Runs the step validate.
    [[nodiscard]] Outcome<Done> validate(const RepairOptions& repair, const StepWrapper& around);
    /// Repairs elements, then removes crossings of facets. Runs the steps relax and uncross.
    [[nodiscard]] Outcome<Done> relax(const RepairOptions& options, const StepWrapper& around);
    [[nodiscard]] Outcome<Done> measure(const BoundaryTolerance& tolerance, const StepWrapper& around);
    [[nodiscard]] Outcome<CurvedBlocks<D>> finish() &&;

  private:
    [[nodiscard]] Outcome<Done> step(const StepWrapper& around, std::string_view name, const auto& function);
    [[nodiscard]] RepairOptions with_own_target(const RepairOptions& repair) const;

    std::unique_ptr<BlockRun<D>> run_;
};

/// A curved mesh as file rows, in the order of the straight mesh. Each rank makes a run of each kind of rows, in pieces
/// to save memory.
template <int D>
class QuadraticParts {
  public:
    /// The arguments must outlive the object.
    [[nodiscard]] static Outcome<QuadraticParts> make(const MeshRows<D>& rows, const CurvedBlocks<D>& mesh,
                                                      Ranks& ranks);

    [[nodiscard]] PartTotals totals() const;
    [[nodiscard]] std::size_t pieces() const { return pieces_; }
    [[nodiscard]] Outcome<FilePart<D, 2>> piece(std::size_t piece) const;

  private:
    QuadraticParts(const MeshRows<D>& rows, const CurvedBlocks<D>& mesh, Ranks& ranks)
        : rows_(&rows), mesh_(&mesh), ranks_(&ranks) {}

    /// Returns simplices with their edge nodes, which the owner parts send. `begin` is the row of the first simplex.
    template <int K>
    [[nodiscard]] Outcome<SimplexRun<K, 2>> simplices(std::size_t begin, SimplexRows<K> rows_of_part) const;

    const MeshRows<D>* rows_;
    const CurvedBlocks<D>* mesh_;
    Ranks* ranks_;
    std::size_t pieces_ = 1, pieces_of_part_ = 1;
    std::vector<Buffer<GlobalNumber>> edge_numbers_;
};

/// Returns the whole mesh in row order. Requires a single rank. `linear` is the straight mesh. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<QuadraticMesh<D>> joined(const CurvedBlocks<D>& of, LinearMesh<D> linear,
                                               const Execution& execution);

}  // namespace camber
