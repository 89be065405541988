module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <ranges>
#include <span>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.cavity;
import camber.ordering;
import :adaptation_rows;
import :block_weights;
import :cut_parts;

namespace camber {

namespace {

using PartNumber = std::uint32_t;

template <int D>
Outcome<PointBox<D>> grid(const AdaptationRows<D>& whole, double shift, const Execution& execution) {
    Buffer<Vec<D>> points(whole.vertices.size());
    for (std::size_t v = 0; v < points.size(); ++v) points[v] = whole.vertices[v].point;
    return box_of_points(Column<Vec<D>>(std::move(points)), execution).map([&](const PointBox<D>& box) {
        // Twice as wide, so that it holds the mesh for all shifts; halves, since an extent may overflow.
        PointBox<D> wide;
        for (int c = 0; c < D; ++c) {
            const double half = 0.5 * box.high[c] - 0.5 * box.low[c];
            wide.low[c] = box.low[c] - 2 * shift * half;
            wide.high[c] = wide.low[c] + 4 * half;
        }
        return wide;
    });
}

/// Of each vertex its turn along the curve.
template <int D>
Outcome<Buffer<std::uint32_t>> turns_along_curve(const AdaptationRows<D>& whole, double shift,
                                                 const Execution& execution) {
    const auto box = grid(whole, shift, execution);
    if (!box) return fail(box.error());
    struct Placed {
        std::uint64_t key = 0;
        std::uint32_t vertex = 0;
        auto operator<=>(const Placed&) const = default;
    };
    auto placed = map_each(execution, whole.vertices.size(), [&](std::size_t v) {
        return Placed{morton_key(whole.vertices[v].point, *box), static_cast<std::uint32_t>(v)};
    });
    if (!placed) return fail(placed.error());
    std::ranges::sort(*placed);
    Buffer<std::uint32_t> turns(placed->size());
    for (std::size_t i = 0; i < placed->size(); ++i) turns[(*placed)[i].vertex] = static_cast<std::uint32_t>(i);
    return turns;
}

/// The elements in the order of their first vertices on the curve, equal ones in their own.
template <int D>
Buffer<std::uint32_t> elements_along_curve(const AdaptationRows<D>& whole, const Buffer<std::uint32_t>& turns) {
    Buffer<std::uint32_t> begin(turns.size() + 1, 0U);
    Buffer<std::uint32_t> first(whole.elements.size());
    for (std::size_t e = 0; e < first.size(); ++e) {
        std::uint32_t least = turns[whole.elements[e].vertices[0].index()];
        for (const VertexId v : whole.elements[e].vertices) least = std::min(least, turns[v.index()]);
        first[e] = least;
        ++begin[least + 1];
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    Buffer<std::uint32_t> sorted(first.size());
    for (std::size_t e = 0; e < first.size(); ++e) sorted[begin[first[e]]++] = static_cast<std::uint32_t>(e);
    return sorted;
}

/// The part of each element, and how many there are: runs of about the same weight, none of them empty.
struct Runs {
    Buffer<PartNumber> part_of;
    std::size_t count = 0;
};
Runs runs_of(const Buffer<std::uint32_t>& sorted, const ElementWeights& weights, std::size_t in_a_part) {
    const double wanted = weights.elements() / static_cast<double>(std::max<std::size_t>(in_a_part, 1));
    const auto parts = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::llround(wanted)));
    Runs runs{Buffer<PartNumber>(sorted.size()), 0};
    // Weights are divided by the size of a part, and not multiplied by the number of parts, which 64 bits may not hold.
    const std::uint64_t size = (weights.sum + parts - 1) / parts;
    std::uint64_t before = 0;
    std::uint64_t run = 0;
    for (const std::uint32_t e : sorted) {
        const std::uint64_t here = before / size;
        if (runs.count == 0 || here != run) ++runs.count;
        run = here;
        runs.part_of[e] = static_cast<PartNumber>(runs.count - 1);
        before += weights.weights[e];
    }
    return runs;
}

/// Which elements are at a vertex: those of the whole, by their part.
template <int D>
Outcome<Incidence<ElementId>> elements_around(const AdaptationRows<D>& whole, const Execution& execution) {
    LinearMesh<D> mesh;
    mesh.points = Buffer<Vec<D>>(whole.vertices.size(), Vec<D>{});
    Buffer<SimplexVertices<D>> vertices(whole.elements.size());
    for (std::size_t e = 0; e < vertices.size(); ++e) vertices[e] = whole.elements[e].vertices;
    mesh.elements.vertices = std::move(vertices);
    return balls(mesh, execution);
}

/// The parts of the elements that have all of these vertices, rising, each once.
template <int D, std::size_t N>
void parts_with(const AdaptationRows<D>& whole, const Incidence<ElementId>& around, const Buffer<PartNumber>& part_of,
                const std::array<VertexId, N>& simplex, std::vector<PartNumber>& found) {
    found.clear();
    for (const ElementId e : around[simplex[0]])
        if (std::ranges::all_of(simplex,
                                [&](VertexId v) { return local_vertex(whole.elements[e.index()].vertices, v) >= 0; }))
            found.push_back(part_of[e.index()]);
    std::ranges::sort(found);
    found.erase(std::ranges::unique(found).begin(), found.end());
}

template <int D>
void put_elements(const AdaptationRows<D>& whole, const Buffer<std::uint32_t>& sorted,
                  const Buffer<PartNumber>& part_of, CutMesh<D>& cut) {
    for (const std::uint32_t e : sorted) cut.parts[part_of[e]].elements.push_back(whole.elements[e]);
}
template <int D>
void put_facets(const AdaptationRows<D>& whole, const Incidence<ElementId>& around, const Buffer<PartNumber>& part_of,
                CutMesh<D>& cut) {
    std::vector<PartNumber> found;
    for (const AdaptedSimplex<D - 1>& facet : whole.facets) {
        parts_with(whole, around, part_of, facet.vertices, found);
        AdaptedSimplex<D - 1> held = facet;
        if (found.size() > 1) held.marks |= Mark::frozen;
        for (const PartNumber p : found) cut.parts[p].facets.push_back(held);
        if (found.empty()) cut.aside.facets.push_back(facet);
    }
}
template <int D>
void put_lines(const AdaptationRows<D>& whole, const Incidence<ElementId>& around, const Buffer<PartNumber>& part_of,
               CutMesh<D>& cut) {
    std::vector<PartNumber> found;
    for (const AdaptedSimplex<1>& line : whole.lines) {
        parts_with(whole, around, part_of, line.vertices, found);
        for (const PartNumber p : found) cut.parts[p].lines.push_back(line);
        if (found.empty()) cut.aside.lines.push_back(line);
    }
}

/// Gives a part the vertices that its simplices name, and those of `more`, in the order of `turns`; simplices name them
/// by their own rows then.
template <int D>
void put_vertices(const AdaptationRows<D>& whole, const Buffer<std::uint32_t>& turns, std::vector<VertexId> named,
                  Buffer<VertexId>& ids, AdaptationRows<D>& part) {
    const auto name = [&](const auto& simplices) {
        for (const auto& simplex : simplices)
            named.insert(named.end(), simplex.vertices.begin(), simplex.vertices.end());
    };
    name(part.elements);
    name(part.facets);
    name(part.lines);
    std::ranges::sort(named, {}, [&](VertexId v) { return turns[v.index()]; });
    named.erase(std::ranges::unique(named).begin(), named.end());
    part.vertices.reserve(named.size());
    for (const VertexId v : named) {
        ids[v.index()] = VertexId(part.vertices.size());
        part.vertices.push_back(whole.vertices[v.index()]);
    }
    const auto rename = [&](auto& simplices) {
        for (auto& simplex : simplices)
            for (VertexId& v : simplex.vertices) v = ids[v.index()];
    };
    rename(part.elements);
    rename(part.facets);
    rename(part.lines);
}

}  // namespace

template <int D>
Outcome<CutMesh<D>> cut_into_parts(const AdaptationRows<D>& whole, const ElementWeights& weights, std::size_t elements,
                                   double shift, const Execution& execution) {
    return guarded([&]() -> Outcome<CutMesh<D>> {
        const auto turns = turns_along_curve(whole, shift, execution);
        if (!turns) return fail(turns.error());
        const auto sorted = elements_along_curve(whole, *turns);
        const auto around = elements_around(whole, execution);
        if (!around) return fail(around.error());
        const auto [part_of, parts] = runs_of(sorted, weights, elements);
        CutMesh<D> cut{std::vector<AdaptationRows<D>>(parts), {}};
        put_elements(whole, sorted, part_of, cut);
        put_facets(whole, *around, part_of, cut);
        put_lines(whole, *around, part_of, cut);
        Buffer<VertexId> ids(whole.vertices.size(), VertexId{});
        for (AdaptationRows<D>& part : cut.parts) put_vertices(whole, *turns, {}, ids, part);
        std::vector<VertexId> strays;
        for (std::size_t v = 0; v < whole.vertices.size(); ++v)
            if ((*around)[v].empty()) strays.emplace_back(v);
        put_vertices(whole, *turns, std::move(strays), ids, cut.aside);
        return cut;
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                    \
    template Outcome<CutMesh<D>> cut_into_parts<D>(const AdaptationRows<D>&, const ElementWeights&, std::size_t, \
                                                   double, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
