// Curves a mesh by blocks, checks its parts, and outputs curved parts as file rows.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.bezier;
import camber.extension;
import camber.metric;
import camber.validity;
import camber.io;
import camber.surface;
import camber.curving;
import camber.repair;
import camber.stages;

namespace camber {

namespace {

auto unsound(const std::string& what, const char* kind, GlobalNumber row) {
    return fail(ErrorKind::input, what, {}, Entity{kind, row + 1},
                "blocks are not repaired; repair the whole mesh first: camber convert IN -o OUT");
}

constexpr std::size_t none = static_cast<std::size_t>(-1);

template <int D>
Outcome<std::size_t> first_not_positive(const RingedPart<D>& part, const Execution& execution) {
    return reduce_each(
        execution, part.mesh.elements.size(), none,
        [&](std::size_t& first, std::size_t e) {
            const auto& vertices = part.mesh.elements.vertices[e];
            if (!part.owns(vertices)) return;
            std::array<Vec<D>, D + 1> corners;
            for (std::size_t i = 0; i <= D; ++i) corners[i] = part.mesh.points[vertices[i]];
            if (!(signed_volume<D>(corners) > 0)) first = std::min(first, e);
        },
        [](std::size_t a, std::size_t b) { return std::min(a, b); });
}

template <std::size_t N>
std::array<VertexId, N> sorted(std::array<VertexId, N> simplex) {
    std::ranges::sort(simplex);
    return simplex;
}

template <int D>
std::vector<std::array<VertexId, D>> sorted_facets(const RingedPart<D>& part) {
    std::vector<std::array<VertexId, D>> facets;
    for (const auto& facet : part.mesh.facets.vertices) facets.push_back(sorted(facet));
    std::ranges::sort(facets);
    return facets;
}

/// Checks the guarantees of `prepare` of camber.soundness: elements are positive, at most two share a face, and facets
/// exist on the boundary and between references. Errors (input): the first bad element, by file number from 1.
template <int D>
Outcome<Done> check_part(const RingedPart<D>& part, const Execution& execution) {
    const auto inverted = first_not_positive(part, execution);
    if (!inverted) return fail(inverted.error());
    if (*inverted != none) return unsound("is flat or inverted", simplex_name<D>, part.elements[*inverted]);
    const auto around = balls(part.mesh, execution);
    if (!around) return fail(around.error());
    const auto facets = sorted_facets(part);
    std::vector<FaceAround<D>> faces;
    for (VertexId v = part.first; v < part.last; v = VertexId(v.index() + 1)) {
        faces_around<D>(part.mesh, *around, v, faces);
        for (std::size_t first = 0, last = 0; first < faces.size(); first = last) {
            while (last < faces.size() && faces[last].others == faces[first].others) ++last;
            const GlobalNumber element = part.elements[faces[first].face.element];
            if (last - first > 2) return unsound("has a face that three elements share", simplex_name<D>, element);
            const auto reference_of = [&](std::size_t at) {
                return part.mesh.elements.references[faces[at].face.element];
            };
            const bool is_boundary = last - first == 1;
            if (!is_boundary && reference_of(first) == reference_of(first + 1)) continue;
            std::array<VertexId, D> facet;
            facet[0] = v;
            std::ranges::copy(faces[first].others, facet.begin() + 1);
            if (!std::ranges::binary_search(facets, sorted(facet)))
                return unsound(is_boundary ? "has a face on the boundary for which the mesh lists no facet"
                                           : "has a face towards another material for which the mesh lists no facet",
                               simplex_name<D>, element);
        }
    }
    return Done{};
}

constexpr std::size_t elements_of_piece = std::size_t{1} << 18U;

template <int D, int K>
std::span<const GlobalNumber> numbers_of(const RingedPart<D>& part) {
    if constexpr (K == D)
        return part.elements.view();
    else if constexpr (K == D - 1)
        return part.facets.view();
    else
        return part.edges.view();
}
template <int D, int K>
std::array<EdgeId, edges_per_simplex<K>> edges_of(const EdgeSet<D>& edges, std::size_t row) {
    if constexpr (K == D)
        return edges.of_elements[row];
    else if constexpr (K == D - 1)
        return edges.of_facets[row];
    else
        return {edges.of_edges[row]};
}

}  // namespace

template <int D>
Outcome<QuadraticParts<D>> QuadraticParts<D>::make(const MeshRows<D>& rows, const CurvedBlocks<D>& mesh, Ranks& ranks) {
    return guarded([&]() -> Outcome<QuadraticParts> {
        QuadraticParts parts(rows, mesh, ranks);
        const PartLayout& layout = mesh.parts.layout;
        std::vector<EdgeSet<D>> edges;
        std::vector<std::span<GlobalNumber>> columns;
        for (std::size_t b = 0; b < mesh.curved.size(); ++b) {
            const CurvedPart<D>& part = mesh.curved[b];
            const GlobalNumber first = mesh.first_edges[layout.begin_of(ranks.rank()) + b];
            Buffer<GlobalNumber> numbers(part.mesh.edges.size(), GlobalNumber{0});
            for (EdgeId e = part.first_edge; e < part.last_edge; e = EdgeId(e.index() + 1))
                numbers[e.index()] = first + (e.index() - part.first_edge.index());
            parts.edge_numbers_.push_back(std::move(numbers));
            edges.push_back(part.mesh.edges);
        }
        columns.reserve(parts.edge_numbers_.size());
        for (Buffer<GlobalNumber>& numbers : parts.edge_numbers_) columns.emplace_back(numbers);
        const auto halo = edge_halo<D>(mesh.parts, edges, ranks);
        if (!halo) return fail(halo.error());
        if (auto updated = update_ghost_rows<GlobalNumber>(*halo, ranks, columns); !updated)
            return fail(updated.error());
        std::size_t most = 0;
        for (std::size_t r = 0; r < ranks.size(); ++r) most = std::max(most, layout.end_of(r) - layout.begin_of(r));
        parts.pieces_of_part_ = most == 0 ? 1 : mesh.counts.elements / (ranks.size() * most * elements_of_piece) + 1;
        parts.pieces_ = most * parts.pieces_of_part_;
        return parts;
    });
}

template <int D>
PartTotals QuadraticParts<D>::totals() const {
    const RowCounts& counts = mesh_->counts;
    return {counts.points, mesh_->first_edges.back(), counts.elements, counts.facets, counts.edges};
}

template <int D>
template <int K>
Outcome<SimplexRun<K, 2>> QuadraticParts<D>::simplices(std::size_t begin, SimplexRows<K> rows_of_part) const {
    using Edges = std::array<GlobalNumber, edges_per_simplex<K>>;
    const PartLayout& layout = mesh_->parts.layout;
    std::vector<ToPart<GlobalNumber>> questions;
    questions.reserve(rows_of_part.vertices.size());
    for (std::size_t i = 0; i < rows_of_part.vertices.size(); ++i)
        questions.push_back({layout.part_with(std::ranges::min(rows_of_part.vertices[i]).value), begin + i});
    const auto edges = query<Edges>(*ranks_, layout, questions, [&](std::size_t b, GlobalNumber number) {
        const auto numbers = numbers_of<D, K>(mesh_->parts.own[b]);
        const auto row = static_cast<std::size_t>(std::ranges::lower_bound(numbers, number) - numbers.begin());
        Edges out{};
        const auto of_row = edges_of<D, K>(mesh_->curved[b].mesh.edges, row);
        for (std::size_t k = 0; k < out.size(); ++k) out[k] = edge_numbers_[b][of_row[k].index()];
        return out;
    });
    if (!edges) return fail(edges.error());
    SimplexRun<K, 2> run{begin, {}, std::move(rows_of_part.references)};
    run.nodes.reserve(rows_of_part.vertices.size());
    for (std::size_t i = 0; i < rows_of_part.vertices.size(); ++i) {
        auto& nodes = run.nodes.emplace_back();
        for (std::size_t v = 0; v <= K; ++v) nodes[v] = rows_of_part.vertices[i][v].value;
        for (std::size_t k = 0; k < edges_per_simplex<K>; ++k) nodes[K + 1 + k] = mesh_->counts.points + (*edges)[i][k];
    }
    return run;
}

template <int D>
Outcome<FilePart<D, 2>> QuadraticParts<D>::piece(std::size_t piece) const {
    return guarded([&]() -> Outcome<FilePart<D, 2>> {
        const RowCounts& counts = mesh_->counts;
        const auto own = [&](std::size_t n) {
            return part_of(part_of({0, n}, ranks_->rank(), ranks_->size()), piece, pieces_);
        };
        FilePart<D, 2> part;
        if (const std::size_t p = piece / pieces_of_part_; p < mesh_->curved.size()) {
            const std::size_t at = mesh_->parts.layout.begin_of(ranks_->rank()) + p;
            const auto piece_of = [&](std::size_t begin, std::size_t end) {
                return part_of({begin, end}, piece % pieces_of_part_, pieces_of_part_);
            };
            const RingedPart<D>& of = mesh_->parts.own[p];
            const CurvedPart<D>& curved = mesh_->curved[p];
            const LinearMesh<D>& linear = curved.mesh.linear;
            const Run vertices = piece_of(of.first.index(), of.last.index());
            part.vertices.first = mesh_->parts.layout.first_vertices[at] + (vertices.begin - of.first.index());
            for (std::size_t v = vertices.begin; v < vertices.end; ++v) {
                part.vertices.points.push_back(linear.points[VertexId(v)]);
                part.vertices.references.push_back(linear.point_references[VertexId(v)]);
            }
            const Run nodes = piece_of(curved.first_edge.index(), curved.last_edge.index());
            part.mid_nodes.first = mesh_->first_edges[at] + (nodes.begin - curved.first_edge.index());
            for (std::size_t e = nodes.begin; e < nodes.end; ++e) {
                part.mid_nodes.points.push_back(curved.mesh.mid_nodes[EdgeId(e)].point);
                part.mid_nodes.references.push_back(0);
            }
        }
        const Run elements = own(counts.elements), facets = own(counts.facets), edges = own(counts.edges);
        auto of_elements = rows_->elements(elements.begin, elements.end);
        if (!of_elements) return fail(of_elements.error());
        auto with_nodes = simplices<D>(elements.begin, std::move(*of_elements));
        if (!with_nodes) return fail(with_nodes.error());
        part.elements = std::move(*with_nodes);
        auto of_facets = rows_->facets(facets.begin, facets.end);
        if (!of_facets) return fail(of_facets.error());
        auto facets_with_nodes = simplices<D - 1>(facets.begin, std::move(*of_facets));
        if (!facets_with_nodes) return fail(facets_with_nodes.error());
        part.facets = std::move(*facets_with_nodes);
        if constexpr (D == 3) {
            auto of_edges = rows_->edges(edges.begin, edges.end);
            if (!of_edges) return fail(of_edges.error());
            auto edges_with_nodes = simplices<1>(edges.begin, std::move(*of_edges));
            if (!edges_with_nodes) return fail(edges_with_nodes.error());
            part.edges = std::move(*edges_with_nodes);
        }
        return part;
    });
}

template <int D>
Outcome<QuadraticMesh<D>> joined(const CurvedBlocks<D>& of, LinearMesh<D> linear, const Execution& execution) {
    return guarded([&]() -> Outcome<QuadraticMesh<D>> {
        Buffer<Vec<D>> points = take(std::move(linear.points));
        Buffer<LagrangeNode<D>> nodes(of.first_edges.back());
        for (std::size_t b = 0; b < of.curved.size(); ++b) {
            const RingedPart<D>& part = of.parts.own[b];
            const CurvedPart<D>& curved = of.curved[b];
            std::copy(curved.mesh.linear.points.begin() + part.first.index(),
                      curved.mesh.linear.points.begin() + part.last.index(),
                      points.begin() + static_cast<std::ptrdiff_t>(of.parts.layout.first_vertices[b]));
            std::copy(curved.mesh.mid_nodes.begin() + curved.first_edge.index(),
                      curved.mesh.mid_nodes.begin() + curved.last_edge.index(),
                      nodes.begin() + static_cast<std::ptrdiff_t>(of.first_edges[b]));
        }
        linear.points = std::move(points);
        auto edges = unique_edges(linear, execution);
        if (!edges) return fail(edges.error());
        return QuadraticMesh<D>{std::move(linear), std::move(*edges), std::move(nodes)};
    });
}

namespace {

template <int D>
Outcome<Done> split_up(BlockRun<D>& run, const Execution& execution) {
    auto parts = split(run.rows, run.options.blocks, run.ranks, execution);
    if (!parts) return fail(parts.error());
    run.out.parts = std::move(*parts);
    run.states.resize(run.out.parts.own.size());
    return Done{};
}

template <int D>
Outcome<Done> connect(BlockRun<D>& run) {
    std::vector<EdgeSet<D>> edges;
    std::vector<GlobalNumber> counts;
    for (const PartState<D>& state : run.states) {
        edges.push_back(state.mesh.edges);
        counts.push_back(state.last_edge.index() - state.first_edge.index());
    }
    const auto all = gather_all(run.ranks, Outcome<std::vector<GlobalNumber>>(counts));
    if (!all) return fail(all.error());
    run.out.first_edges.push_back(0);
    for (const GlobalNumber n : *all) run.out.first_edges.push_back(run.out.first_edges.back() + n);
    auto of_edges = edge_halo<D>(run.out.parts, edges, run.ranks);
    if (!of_edges) return fail(of_edges.error());
    run.edges = std::move(*of_edges);
    auto of_vertices = vertex_halo(run.out.parts, run.ranks);
    if (!of_vertices) return fail(of_vertices.error());
    run.vertices = std::move(*of_vertices);
    run.between.emplace(run.ranks, run.edges, run.states.size());
    return Done{};
}

template <int D>
OwnVertices owned_of(const PartLayout& layout, const RingedPart<D>& part) {
    OwnVertices owned{part.first, part.last};
    if (part.first == part.last) return owned;
    const GlobalNumber first = part.vertices[part.first];
    for (const GlobalNumber v : layout.later_blocks(layout.part_with(first)))
        owned.later_runs.emplace_back(part.first.index() + (v - first));
    return owned;
}

template <int D>
Outcome<Done> elevate_blocks(BlockRun<D>& run, const Execution& execution) {
    auto done = run.each_part(execution, [&](PartState<D>& state, RingedPart<D>& part) -> Outcome<Done> {
        if (auto sound = check_part(part, without_progress(execution)); !sound) return sound;
        auto edges = unique_edges(part.mesh, without_progress(execution));
        if (!edges) return fail(edges.error());
        state.mesh = {part.mesh, std::move(*edges), {}};
        auto around = shells(state.mesh.edges, without_progress(execution));
        if (!around) return fail(around.error());
        state.shells = std::move(*around);
        state.owned = owned_of(run.out.parts.layout, part);
        const auto& ends = state.mesh.edges.vertices;
        const auto begin_of = [&](VertexId v) {
            const auto at = std::ranges::lower_bound(ends, v, {}, [](const auto& e) { return e[0]; });
            return EdgeId(static_cast<std::size_t>(at - ends.begin()));
        };
        state.first_edge = begin_of(part.first);
        state.last_edge = begin_of(part.last);
        return Done{};
    });
    if (!done) return done;
    return connect(run);
}

Outcome<Done> check_supported(const ProposeOptions& options) {
    if (!has_field(options.objective))
        return fail(ErrorKind::unsupported, "curving by blocks does not support the objectives shape and solution", {},
                    {}, "use another objective, or curve the mesh as a whole");
    if (options.boundary_nodes != BoundaryNodeAim::projection)
        return fail(ErrorKind::unsupported, "curving by blocks supports only boundary_nodes projection", {}, {},
                    "omit boundary_nodes, or curve the mesh as a whole");
    return check_limits(static_cast<const CurveOptions&>(options));
}

}  // namespace

template <int D>
BlockSteps<D>::BlockSteps(const MeshRows<D>& rows, const BlocksGoal<D>& goal, const BlockOptions& blocks, Ranks& ranks)
    : run_(new BlockRun<D>{rows, goal, {blocks}, ranks}) {
    run_->out.counts = rows.counts();
}
template <int D>
BlockSteps<D>::BlockSteps(BlockSteps&&) noexcept = default;
template <int D>
BlockSteps<D>& BlockSteps<D>::operator=(BlockSteps&&) noexcept = default;
template <int D>
BlockSteps<D>::~BlockSteps() = default;

template <int D>
Outcome<Done> BlockSteps<D>::step(const StepWrapper& around, std::string_view name, const auto& function) {
    return run_step(around, name, [&](const Execution& e) { return function(*run_, e); });
}

template <int D>
RepairOptions BlockSteps<D>::with_own_target(const RepairOptions& repair) const {
    return with_target(repair, recommended_target(run_->by->edges));
}

template <int D>
Outcome<Done> BlockSteps<D>::elevate(const StepWrapper& around) {
    if (auto done = step(around, "split", split_up<D>); !done) return done;
    return step(around, "elevate", elevate_blocks<D>);
}

template <int D>
Outcome<Done> BlockSteps<D>::curve(const ProposeOptions& options, const StepWrapper& around) {
    if (auto supported = check_supported(options); !supported) return supported;
    run_->options.curving.curve = options;
    auto done = step(around, "surface", find_surface<D>);
    if (done) done = step(around, "extension", extend_blocks<D>);
    if (done) done = step(around, "metric", make_metric<D>);
    return done ? step(around, "curve", curve_nodes<D>) : done;
}

template <int D>
Outcome<Done> BlockSteps<D>::validate(const RepairOptions& repair, const StepWrapper& around) {
    run_->options.curving.repair = with_own_target(repair);
    run_->judged_for = run_->options.curving.repair;
    return step(around, "validate", validate_blocks<D>);
}

template <int D>
Outcome<Done> BlockSteps<D>::relax(const RepairOptions& options, const StepWrapper& around) {
    if (run_->judged_for != with_own_target(options))
        if (auto done = validate(options, around); !done) return done;
    if (auto done = step(around, "relax", relax_blocks<D>); !done) return done;
    return step(around, "uncross", uncross_blocks<D>);
}

template <int D>
Outcome<Done> BlockSteps<D>::measure(const BoundaryTolerance& tolerance, const StepWrapper& around) {
    run_->options.tolerance = tolerance;
    return step(around, "measure", measure_blocks<D>);
}

template <int D>
Outcome<CurvedBlocks<D>> BlockSteps<D>::finish() && {
    const auto of_ranks = gather_all(run_->ranks, Outcome<std::vector<CurveStatistics>>({run_->out.statistics}));
    if (!of_ranks) return fail(of_ranks.error());
    run_->out.statistics = {};
    for (const CurveStatistics& s : *of_ranks) run_->out.statistics += s;
    for (PartState<D>& state : run_->states) {
        state.mesh.mid_nodes = std::move(state.nodes);
        run_->out.curved.push_back({std::move(state.mesh), state.first_edge, state.last_edge});
    }
    return std::move(run_->out);
}

#define CAMBER_INSTANTIATE(D)         \
    template class QuadraticParts<D>; \
    template class BlockSteps<D>;     \
    template Outcome<QuadraticMesh<D>> joined<D>(const CurvedBlocks<D>&, LinearMesh<D>, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
