module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.bezier;
import camber.io;
import :ringed_parts;
import :curve_blocks;
import :halo;
import :quadratic_parts;
import :ranks;
import :routing;
import :row_runs;
import :rows;

namespace camber {

namespace {

/// About so many elements are made at a time.
constexpr std::size_t elements_of_piece = std::size_t{1} << 18U;

/// Rows of a part by their numbers in the file, and the edges of each.
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
        if (auto brought = bring_all<GlobalNumber>(*halo, ranks, columns); !brought) return fail(brought.error());
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
Outcome<SimplexRun<K, 2>> QuadraticParts<D>::simplices(std::size_t begin, SimplexRows<K> given) const {
    using Edges = std::array<GlobalNumber, edges_per_simplex<K>>;
    const PartLayout& layout = mesh_->parts.layout;
    std::vector<ToPart<GlobalNumber>> questions;
    questions.reserve(given.vertices.size());
    for (std::size_t i = 0; i < given.vertices.size(); ++i)
        questions.push_back({layout.part_with(std::ranges::min(given.vertices[i]).value), begin + i});
    const auto edges = ask<Edges>(*ranks_, layout, questions, [&](std::size_t b, GlobalNumber number) {
        const auto numbers = numbers_of<D, K>(mesh_->parts.own[b]);
        const auto row = static_cast<std::size_t>(std::ranges::lower_bound(numbers, number) - numbers.begin());
        Edges out{};
        const auto of_row = edges_of<D, K>(mesh_->curved[b].mesh.edges, row);
        for (std::size_t k = 0; k < out.size(); ++k) out[k] = edge_numbers_[b][of_row[k].index()];
        return out;
    });
    if (!edges) return fail(edges.error());
    SimplexRun<K, 2> run{begin, {}, std::move(given.references)};
    run.nodes.reserve(given.vertices.size());
    for (std::size_t i = 0; i < given.vertices.size(); ++i) {
        auto& nodes = run.nodes.emplace_back();
        for (std::size_t v = 0; v <= K; ++v) nodes[v] = given.vertices[i][v].value;
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

#define CAMBER_INSTANTIATE(D)         \
    template class QuadraticParts<D>; \
    template Outcome<QuadraticMesh<D>> joined<D>(const CurvedBlocks<D>&, LinearMesh<D>, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
