module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.bezier;
import camber.curving;
import camber.metric;
import camber.recipes;
import camber.repair;
import camber.surface;
import camber.validity;
import :block_state;
import :blocks;
import :check_blocks;
import :curve_blocks;
import :halo;
import :ranks;
import :repair_blocks;
import :rows;
import :split;
import :whole_surface;

namespace camber {

namespace {

/// What all blocks are curved by.
template <int D>
struct CurvingBy {
    WholeSurface<D> surface;
    CurveOptions edges;
};

template <int D>
class BlockCurving {
  public:
    BlockCurving(const BlocksGoal<D>& goal, const CurveBlocksOptions& options, Ranks& ranks, const Around& around)
        : goal_(goal), options_(options), ranks_(ranks), around_(around) {}

    Outcome<CurvedBlocks<D>> run(const MeshRows<D>& rows) {
        out_.counts = rows.counts();
        using Step = Outcome<Done> (BlockCurving::*)(const MeshRows<D>&, const Execution&);
        const std::vector<std::pair<std::string_view, Step>> steps{
            {"split", &BlockCurving::split_up},       {"elevate", &BlockCurving::elevate_blocks},
            {"surface", &BlockCurving::find_surface}, {"extension", &BlockCurving::extend},
            {"metric", &BlockCurving::make_metric},   {"curve", &BlockCurving::curve_all},
            {"validate", &BlockCurving::judge},       {"relax", &BlockCurving::relax}};
        for (const auto& [name, step] : steps)
            if (auto done = run_step(around_, name, [&](const Execution& e) { return (this->*step)(rows, e); }); !done)
                return fail(done.error());
        return finish();
    }

  private:
    /// f of each block here.
    Outcome<Done> each_block(const Execution& execution, const auto& f) {
        for (std::size_t b = 0; b < states_.size(); ++b) {
            auto done = f(states_[b], out_.blocks.own[b]);
            if (!done) return fail(done.error());
            if (options_.after_block) options_.after_block();
            report_progress(execution, b + 1, states_.size());
        }
        return Done{};
    }

    Outcome<Done> split_up(const MeshRows<D>& rows, const Execution& execution) {
        auto blocks = split(rows, options_.blocks, ranks_, execution);
        if (!blocks) return fail(blocks.error());
        out_.blocks = std::move(*blocks);
        return check_blocks(out_.blocks, without_progress(execution));
    }

    Outcome<Done> elevate_blocks(const MeshRows<D>&, const Execution& execution) {
        states_.resize(out_.blocks.own.size());
        auto done = each_block(execution, [&](BlockState<D>& state, Block<D>& block) -> Outcome<Done> {
            auto mesh = elevate(block.mesh, without_progress(execution));
            if (!mesh) return fail(mesh.error());
            state.mesh = std::move(*mesh);
            auto around = shells(state.mesh.edges, without_progress(execution));
            if (!around) return fail(around.error());
            state.shells = std::move(*around);
            state.owned = {block.first, block.last};
            const auto& ends = state.mesh.edges.vertices;
            const auto begin_of = [&](VertexId v) {
                const auto at = std::ranges::lower_bound(ends, v, {}, [](const auto& e) { return e[0]; });
                return EdgeId(static_cast<std::size_t>(at - ends.begin()));
            };
            state.first_edge = begin_of(block.first);
            state.last_edge = begin_of(block.last);
            return Done{};
        });
        if (!done) return done;
        return connect();
    }

    /// Who has whose edges and vertices, and how edges are numbered.
    Outcome<Done> connect() {
        std::vector<EdgeSet<D>> edges;
        std::vector<GlobalNumber> counts;
        for (const BlockState<D>& state : states_) {
            edges.push_back(state.mesh.edges);
            counts.push_back(state.last_edge.index() - state.first_edge.index());
        }
        const auto all = gather_all(ranks_, Outcome<std::vector<GlobalNumber>>(counts));
        if (!all) return fail(all.error());
        out_.first_edges.push_back(0);
        for (const GlobalNumber n : *all) out_.first_edges.push_back(out_.first_edges.back() + n);
        auto of_edges = edge_halo<D>(out_.blocks, edges, ranks_);
        if (!of_edges) return fail(of_edges.error());
        edges_ = std::move(*of_edges);
        auto of_vertices = vertex_halo(out_.blocks, ranks_);
        if (!of_vertices) return fail(of_vertices.error());
        vertices_ = std::move(*of_vertices);
        between_.emplace(ranks_, edges_, states_.size());
        return Done{};
    }

    Outcome<Done> find_surface(const MeshRows<D>& rows, const Execution& execution) {
        auto surface = whole_surface(rows, goal_, part_of(execution, 0, 0.8));
        if (!surface) return fail(surface.error());
        by_.emplace(CurvingBy<D>{std::move(*surface), edges_by()});
        return each_block(part_of(execution, 0.8, 1),
                          [&](BlockState<D>& state, Block<D>& block) { return take_boundary(state, block); });
    }

    /// Kinds and nodes of edges on the boundary, from the surface; others are the volume's, and straight.
    Outcome<Done> take_boundary(BlockState<D>& state, const Block<D>& block) const {
        const WholeSurface<D>& surface = by_->surface;
        const auto& ends = state.mesh.edges.vertices;
        Buffer<EdgeKind> kinds(ends.size(), EdgeKind::volume);
        Buffer<EdgeId> on_surface(ends.size(), EdgeId{});
        state.base = Buffer<LagrangeNode<D>>(state.mesh.mid_nodes.begin(), state.mesh.mid_nodes.end());
        const std::vector<VertexId> vertices = surface.places_of(block.vertices.view());
        for (std::size_t e = 0; e < ends.size(); ++e) {
            const VertexId a = vertices[ends[e][0].index()], b = vertices[ends[e][1].index()];
            if (!a.valid() || !b.valid()) continue;
            const EdgeId at = find_edge(surface.mesh.edges, a, b);
            if (!at.valid()) continue;
            on_surface[e] = at;
            kinds[e] = surface.input.kinds[at];
            state.base[e] = surface.input.base[at];
        }
        state.kinds = std::move(kinds);
        state.on_surface = std::move(on_surface);
        return Done{};
    }

    Outcome<Done> extend(const MeshRows<D>&, const Execution& execution) {
        const auto straight = [&]() {
            const WholeSurface<D>& s = by_->surface;
            for (std::size_t e = 0; e < s.mesh.edges.size(); ++e)
                if (s.input.kinds[e] != EdgeKind::volume && s.input.base[e] != s.mesh.mid_nodes[e]) return false;
            return true;
        };
        if (straight()) return Done{};
        if (D == 3)
            if (auto done = extend_in_planes(part_of(execution, 0, 0.5)); !done) return done;
        if (options_.curving.curve.back_mesh != BackMeshKind::curved) return Done{};
        is_displaced_ = true;
        auto nodes = extended(&BlockState<D>::kinds, part_of(execution, 0.5, 1));
        if (!nodes) return fail(nodes.error());
        for (std::size_t b = 0; b < states_.size(); ++b) states_[b].extended = std::move((*nodes)[b]);
        return bring_all<LagrangeNode<D>>(edges_, ranks_, columns_of(states_, &BlockState<D>::extended));
    }

    /// The displacement of what is not of the volume by these kinds, extended.
    Outcome<std::vector<Buffer<LagrangeNode<D>>>> extended(Column<EdgeKind> BlockState<D>::* kinds,
                                                           const Execution& execution) {
        std::vector<ExtensionPart<D>> parts;
        std::vector<Column<LagrangeNode<D>>> bases;
        bases.reserve(states_.size());
        auto begun = each_block(without_progress(execution), [&](BlockState<D>& state, Block<D>&) -> Outcome<Done> {
            bases.emplace_back(Buffer<LagrangeNode<D>>(state.base));
            auto part = ExtensionPart<D>::make(state.mesh, state.*kinds, bases.back(), state.shells, state.owned,
                                               without_progress(execution));
            if (!part) return fail(part.error());
            parts.push_back(std::move(*part));
            return Done{};
        });
        if (!begun) return fail(begun.error());
        const auto solved = solve_extension<D>(parts, *between_, {}, execution);
        if (!solved) return fail(solved.error());
        out_.iterations = std::max(out_.iterations, static_cast<std::size_t>(solved->iterations));
        std::vector<Buffer<LagrangeNode<D>>> nodes;
        for (ExtensionPart<D>& part : parts) nodes.push_back(std::move(part).nodes());
        return nodes;
    }

    /// See extended_in_planes of camber.recipes: nodes of edges within planes go as the displacement of all others.
    Outcome<Done> extend_in_planes(const Execution& execution) {
        WholeSurface<D>& surface = by_->surface;
        const auto inside = edges_in_planes(surface.mesh, surface.boundary.features, surface.boundary.geometry,
                                            without_progress(execution));
        if (!inside) return fail(inside.error());
        const auto goes_along = [&](EdgeId at) {
            return at.valid() && (*inside)[at.index()] != 0 && surface.input.kinds[at] == EdgeKind::surface;
        };
        bool any = false;
        for (std::size_t e = 0; e < surface.mesh.edges.size(); ++e) any |= goes_along(EdgeId(e));
        if (!any) return Done{};
        for (BlockState<D>& state : states_) {
            Buffer<EdgeKind> kinds(state.kinds.begin(), state.kinds.end());
            for (std::size_t e = 0; e < kinds.size(); ++e)
                if (goes_along(state.on_surface[e])) kinds[e] = EdgeKind::volume;
            state.kinds_outside_planes = std::move(kinds);
        }
        const auto nodes = extended(&BlockState<D>::kinds_outside_planes, execution);
        if (!nodes) return fail(nodes.error());
        Buffer<Vec<D>> shifts(surface.mesh.edges.size(), Vec<D>{});
        auto gathered = gather_on_surface(shifts, [&](std::size_t b, EdgeId e, EdgeId at) -> std::optional<Vec<D>> {
            if (!goes_along(at)) return std::nullopt;
            return (*nodes)[b][e.index()].point - states_[b].base[e.index()].point;
        });
        if (!gathered) return gathered;
        for (BlockState<D>& state : states_) state.kinds_outside_planes = {};
        auto slid = slid_nodes<D>(surface.mesh, surface.input.base, shifts, surface.boundary.features,
                                  surface.boundary.geometry, without_progress(execution));
        if (!slid) return fail(slid.error());
        surface.input.base = std::move(*slid);
        return each_block(without_progress(execution), [&](BlockState<D>& state, Block<D>&) -> Outcome<Done> {
            take_base(state);
            return Done{};
        });
    }

    /// Nodes of the surface's edges as the surface has them.
    void take_base(BlockState<D>& state) const {
        for (std::size_t e = 0; e < state.base.size(); ++e)
            if (const EdgeId at = state.on_surface[e]; at.valid()) state.base[e] = by_->surface.input.base[at];
    }

    /// Rows of edges of the surface from the blocks that own them: value_of(block, edge, edge of the surface), if any.
    Outcome<Done> gather_on_surface(std::span<Vec<D>> rows, const auto& value_of) {
        struct Found {
            std::uint64_t at = 0;
            Vec<D> value;
        };
        std::vector<Found> found;
        for (std::size_t b = 0; b < states_.size(); ++b)
            for (EdgeId e = states_[b].first_edge; e < states_[b].last_edge; e = EdgeId(e.index() + 1)) {
                const EdgeId at = states_[b].on_surface[e];
                if (!at.valid()) continue;
                if (const std::optional<Vec<D>> value = value_of(b, e, at)) found.push_back({at.index(), *value});
            }
        const auto all = gather_all(ranks_, Outcome<std::vector<Found>>(std::move(found)));
        if (!all) return fail(all.error());
        for (const Found& f : *all) rows[f.at] = f.value;
        return Done{};
    }

    /// The metric at the vertices, and the nodes of the mesh that it is read in.
    Outcome<Done> make_metric(const MeshRows<D>&, const Execution& execution) {
        auto done = each_block(part_of(execution, 0, 0.6), [&](BlockState<D>& state, Block<D>& block) {
            return metric_of(state, block, without_progress(execution));
        });
        if (!done) return done;
        if (auto brought = bring_all<LogMetric<D>>(vertices_, ranks_, columns_of(states_, &BlockState<D>::log_metrics));
            !brought)
            return brought;
        if (!is_displaced_) return Done{};
        done = each_block(part_of(execution, 0.6, 0.8), [&](BlockState<D>& state, Block<D>&) -> Outcome<Done> {
            const Column<LogMetric<D>> logs(Buffer<LogMetric<D>>(state.log_metrics));
            auto nodes = noticeable_nodes<D>(state.mesh, state.extended, logs, without_progress(execution));
            if (!nodes) return fail(nodes.error());
            state.back_nodes = std::move(*nodes);
            return Done{};
        });
        if (!done) return done;
        // Searches begin where the back mesh has their edges; nodes for accuracy follow walls that hardly sag, too.
        for (BlockState<D>& state : states_)
            start_at(state, by_->edges.aim == CurvingAim::accuracy ? state.extended : state.back_nodes);
        std::vector<PartNodes<D>> parts;
        for (BlockState<D>& state : states_) parts.push_back({state.mesh, state.shells, state.owned, state.back_nodes});
        return limit_to_back_mesh<D>(parts, *between_, part_of(execution, 0.8, 1));
    }

    static void start_at(BlockState<D>& state, const Buffer<LagrangeNode<D>>& nodes) {
        for (std::size_t e = 0; e < nodes.size(); ++e)
            if (state.kinds[e] == EdgeKind::volume) state.base[e] = nodes[e];
    }

    [[nodiscard]] CurveOptions edges_by() const {
        CurveOptions edges = edge_options(options_.curving.curve);
        static_cast<EdgeAccuracyOptions&>(edges) =
            accuracy_for(goal_.metric ? MetricOrigin::given : MetricOrigin::natural, edges);
        return edges;
    }

    Outcome<Done> metric_of(BlockState<D>& state, const Block<D>& block, const Execution& execution) const {
        if (goal_.metric) {
            auto made = goal_.metric(state.mesh.linear, block.vertices.view(), execution);
            if (!made) return fail(made.error());
            state.log_metrics = take(std::move(*made));
            return Done{};
        }
        const auto around = balls(state.mesh.linear, execution);
        if (!around) return fail(around.error());
        if (state.extended.empty()) {
            auto made = natural_log_metrics(state.mesh.linear, *around, execution);
            if (!made) return fail(made.error());
            state.log_metrics = std::move(*made);
            return Done{};
        }
        QuadraticMesh<D> bent = state.mesh;
        bent.mid_nodes = Buffer<LagrangeNode<D>>(state.extended);
        auto made = curved_natural_log_metrics(bent, *around, execution);
        if (!made) return fail(made.error());
        state.log_metrics = std::move(made->curved);
        return Done{};
    }

    Outcome<BackMesh<D>> field_of(const BlockState<D>& state, KeptGradients kept, const Execution& execution) const {
        return field_on(state.mesh, state.back_nodes, state.log_metrics, kept, execution);
    }
    /// The field on a part of the mesh, of which some of its vertices and edges are.
    Outcome<BackMesh<D>> field_on(const QuadraticMesh<D>& mesh, const Buffer<LagrangeNode<D>>& back_nodes,
                                  const Buffer<LogMetric<D>>& log_metrics, KeptGradients kept,
                                  const Execution& execution) const {
        const auto around = balls(mesh.linear, execution);
        if (!around) return fail(around.error());
        Column<LogMetric<D>> logs(Buffer<LogMetric<D>>{log_metrics});
        if (back_nodes.empty()) return make_back_mesh(mesh.linear, *around, std::move(logs), execution);
        QuadraticMesh<D> bent = mesh;
        bent.mid_nodes = Buffer<LagrangeNode<D>>(back_nodes);
        return make_curved_back_mesh(std::move(bent), *around, std::move(logs), execution, kept);
    }

    Outcome<Done> curve_all(const MeshRows<D>&, const Execution& execution) {
        return by_->edges.aim == CurvingAim::accuracy ? curve_accurately(execution) : search_all(execution);
    }

    /// Each edge by itself.
    Outcome<Done> search_all(const Execution& execution) {
        auto done = each_block(execution, [&](BlockState<D>& state, Block<D>&) -> Outcome<Done> {
            const Execution quiet = without_progress(execution);
            const auto field = field_of(state, KeptGradients::recovered, quiet);
            if (!field) return fail(field.error());
            CurveOptions edges = by_->edges;
            edges.measured = MeasuredEdges::none;
            auto curved = camber::curve(state.mesh, state.own_kinds(),
                                        Column<LagrangeNode<D>>(Buffer<LagrangeNode<D>>(state.base)), state.shells,
                                        *field, edges, quiet);
            if (!curved) return fail(curved.error());
            add(curved->statistics);
            state.nodes = take(std::move(curved->proposal.mid_nodes));
            return Done{};
        });
        if (!done) return done;
        return bring_all<LagrangeNode<D>>(edges_, ranks_, columns_of(states_, &BlockState<D>::nodes));
    }

    void add(const CurveStatistics& s) {
        CurveStatistics& sum = out_.statistics;
        sum.volume_edges += s.volume_edges;
        sum.curved_edges += s.curved_edges;
        sum.polished += s.polished;
        sum.exhausted += s.exhausted;
        sum.shortened += s.shortened;
        sum.outside += s.outside;
        sum.lost += s.lost;
    }

    /// Offsets of all, as smooth functions and their elements bear them: first slides in planes, then the volume's.
    Outcome<Done> curve_accurately(const Execution& execution) {
        auto done = each_block(part_of(execution, 0, 0.6), [&](BlockState<D>& state, Block<D>&) -> Outcome<Done> {
            const Execution quiet = without_progress(execution);
            const auto field = field_of(state, KeptGradients::seen, quiet);
            if (!field) return fail(field.error());
            const Column<EdgeKind> own = state.own_kinds();
            auto slides = accurate_offsets(state.mesh, own, EdgeKind::surface, state.shells, *field, by_->edges, quiet);
            if (!slides) return fail(slides.error());
            state.slides = std::move(*slides);
            auto offsets = accurate_offsets(state.mesh, own, EdgeKind::volume, state.shells, *field, by_->edges, quiet);
            if (!offsets) return fail(offsets.error());
            state.offsets = std::move(*offsets);
            return Done{};
        });
        if (!done) return done;
        if (done = slide(part_of(execution, 0.6, 0.7)); !done) return done;
        if (done = limit(&BlockState<D>::offsets, part_of(execution, 0.7, 0.95)); !done) return done;
        return each_block(part_of(execution, 0.95, 1), [&](BlockState<D>& state, Block<D>&) -> Outcome<Done> {
            place(state);
            return Done{};
        });
    }

    /// Nodes where base and offsets have them; what was found is counted.
    void place(BlockState<D>& state) {
        state.nodes = Buffer<LagrangeNode<D>>(state.base);
        for (std::size_t e = 0; e < state.nodes.size(); ++e) {
            if (state.kinds[e] != EdgeKind::volume) continue;
            state.nodes[e].point = state.base[e].point + state.offsets[e];
            if (!state.owns(EdgeId(e))) continue;
            ++out_.statistics.volume_edges;
            out_.statistics.curved_edges += state.nodes[e] != state.mesh.mid_nodes[e] ? 1 : 0;
        }
        state.offsets = {};
        state.slides = {};
    }

    /// As slid_input of camber.recipes.
    Outcome<Done> slide(const Execution& execution) {
        WholeSurface<D>& surface = by_->surface;
        Buffer<Vec<D>> shifts(surface.mesh.edges.size(), Vec<D>{});
        auto gathered = gather_on_surface(shifts, [&](std::size_t b, EdgeId e, EdgeId) -> std::optional<Vec<D>> {
            const Vec<D>& shift = states_[b].slides[e.index()];
            return shift == Vec<D>{} ? std::nullopt : std::optional(shift);
        });
        if (!gathered) return gathered;
        const QuadraticMesh<D> mesh =
            surface.boundary.required == RequiredBoundary::keep ? surface.mesh : without_required(surface.mesh);
        const auto slid = slid_nodes<D>(mesh, surface.input.base, shifts, surface.boundary.features,
                                        surface.boundary.geometry, without_progress(execution));
        if (!slid) return fail(slid.error());
        for (BlockState<D>& state : states_)
            for (std::size_t e = 0; e < state.slides.size(); ++e) {
                const EdgeId at = state.on_surface[e];
                state.slides[e] = at.valid() ? (*slid)[at.index()].point - surface.input.base[at].point : Vec<D>{};
            }
        if (auto limited = limit(&BlockState<D>::slides, execution); !limited) return limited;
        for (BlockState<D>& state : states_)
            for (std::size_t e = 0; e < state.slides.size(); ++e)
                if (state.on_surface[e].valid()) state.base[e].point += state.slides[e];
        return Done{};
    }

    /// What smooth functions and elements do not bear is taken back.
    Outcome<Done> limit(Buffer<Vec<D>> BlockState<D>::* rows, const Execution& execution) {
        if (by_->edges.metric_kind == MetricKind::natural) {
            std::vector<PartLosses<D>> losses;
            for (BlockState<D>& state : states_) losses.push_back({state.mesh, state.shells, state.owned, state.*rows});
            const auto held = limit_smooth_loss<D>(losses, by_->edges.smooth_loss, *between_, execution);
            if (!held) return fail(held.error());
            out_.statistics.held_back += *held;
        }
        if (auto brought = bring_all<Vec<D>>(edges_, ranks_, columns_of(states_, rows)); !brought) return brought;
        std::vector<PartOffsets<D>> offsets;
        for (BlockState<D>& state : states_)
            offsets.push_back({state.mesh, state.base, state.shells, state.owned, state.*rows});
        const auto drawn = limit_by_jacobian<D>(offsets, by_->edges.min_jacobian, *between_, execution);
        if (!drawn) return fail(drawn.error());
        out_.statistics.drawn_back += *drawn;
        return Done{};
    }

    Outcome<Done> judge(const MeshRows<D>&, const Execution& execution) {
        auto validation = judged(execution);
        if (!validation) return fail(validation.error());
        out_.before = out_.after = std::move(*validation);
        return Done{};
    }

    /// Verdicts of all elements, of all ranks; those that are not valid are kept.
    Outcome<BlocksValidation> judged(const Execution& execution) {
        BlocksValidation own;
        not_valid_.clear();
        auto done = each_block(execution, [&](BlockState<D>& state, Block<D>& block) -> Outcome<Done> {
            return judge_block(state, block, own, without_progress(execution));
        });
        if (!done) return fail(done.error());
        std::ranges::sort(not_valid_);
        const auto all = gather_all(ranks_, Outcome<std::vector<BlocksValidation>>({own}));
        if (!all) return fail(all.error());
        BlocksValidation sum;
        for (const BlocksValidation& v : *all) {
            sum.invalid += v.invalid;
            sum.undecided += v.undecided;
            sum.not_positive += v.not_positive;
            if (v.smallest < sum.smallest) sum.smallest = v.smallest, sum.worst = v.worst;
        }
        return sum;
    }

    Outcome<Done> judge_block(const BlockState<D>& state, const Block<D>& block, BlocksValidation& own,
                              const Execution& execution) {
        QuadraticMesh<D> mesh = state.mesh;
        mesh.mid_nodes = Buffer<LagrangeNode<D>>(state.nodes);
        const auto validation = validate(mesh, options_.curving.repair.min_scaled_jacobian, execution);
        if (!validation) return fail(validation.error());
        for (std::size_t e = 0; e < mesh.linear.elements.size(); ++e) {
            if (!block.owns(mesh.linear.elements.vertices[e])) continue;
            const Verdict verdict = validation->verdicts[e];
            own.invalid += verdict == Verdict::invalid ? 1 : 0;
            own.undecided += verdict == Verdict::undecided ? 1 : 0;
            if (verdict != Verdict::valid) not_valid_.push_back(block.elements[e]);
            const auto smallest = static_cast<double>(validation->min_scaled_jacobian[e]);
            if (smallest < own.smallest) own.smallest = smallest, own.worst = block.elements[e];
        }
        for (const auto& [e, verdict] : validation->not_positive)
            own.not_positive += block.owns(mesh.linear.elements.vertices[e]) ? 1 : 0;
        return Done{};
    }

    Outcome<Done> relax(const MeshRows<D>&, const Execution& execution) {
        if (out_.before.all_valid()) return Done{};
        const RepairedBlocks<D> of{
            out_.blocks, states_, by_->surface, by_->edges.aim,
            [this](const QuadraticMesh<D>& mesh, const auto& back_nodes, const auto& logs, const Execution& e) {
                return field_on(mesh, back_nodes, logs, KeptGradients::all, e);
            }};
        const auto repaired =
            repair_blocks(of, not_valid_, options_.curving.repair, ranks_, part_of(execution, 0, 0.9));
        if (!repaired) return fail(repaired.error());
        const auto all = gather_all(ranks_, Outcome<std::vector<RepairStatistics>>({*repaired}));
        if (!all) return fail(all.error());
        for (const RepairStatistics& s : *all)
            if (s.corrected_elements + s.moved_volume_nodes + s.moved_surface_nodes > 0 || s.work > 0) out_.repair = s;
        auto validation = judged(part_of(execution, 0.9, 1));
        if (!validation) return fail(validation.error());
        out_.after = std::move(*validation);
        return Done{};
    }

    Outcome<CurvedBlocks<D>> finish() {
        for (BlockState<D>& state : states_) {
            state.mesh.mid_nodes = std::move(state.nodes);
            out_.curved.push_back({std::move(state.mesh), state.first_edge, state.last_edge});
        }
        return std::move(out_);
    }

    const BlocksGoal<D>& goal_;
    const CurveBlocksOptions& options_;
    Ranks& ranks_;
    const Around& around_;
    CurvedBlocks<D> out_ = {};
    std::vector<BlockState<D>> states_ = {};
    Halo edges_ = {}, vertices_ = {};
    std::optional<BetweenBlocks<D>> between_ = {};
    std::optional<CurvingBy<D>> by_ = {};
    std::vector<GlobalNumber> not_valid_ = {};  ///< elements of this rank, rising
    bool is_displaced_ = false;                 ///< so that there is an extension, of whichever blocks
};

Outcome<Done> check_supported(const ProposeOptions& options) {
    if (!has_field(options.objective))
        return fail(ErrorKind::unsupported, "nodes are not found by shape or by a solution by blocks", {}, {},
                    "take another objective, or the mesh as a whole");
    if (options.boundary_nodes != BoundaryNodeAim::projection)
        return fail(ErrorKind::unsupported, "nodes of the boundary are projected alone by blocks", {}, {},
                    "leave boundary_nodes out, or take the mesh as a whole");
    return check_limits(static_cast<const CurveOptions&>(options));
}

}  // namespace

template <int D>
Outcome<CurvedBlocks<D>> curve_blocks(const MeshRows<D>& rows, const BlocksGoal<D>& goal,
                                      const CurveBlocksOptions& options, Ranks& ranks, const Around& around) {
    if (auto supported = check_supported(options.curving.curve); !supported) return fail(supported.error());
    return together(ranks,
                    [&] { return guarded([&] { return BlockCurving<D>(goal, options, ranks, around).run(rows); }); });
}

#define CAMBER_INSTANTIATE(D)                                                                   \
    template Outcome<CurvedBlocks<D>> curve_blocks<D>(const MeshRows<D>&, const BlocksGoal<D>&, \
                                                      const CurveBlocksOptions&, Ranks&, const Around&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
