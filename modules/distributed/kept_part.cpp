module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import :kept_part;
import :ringed_parts;
import :row_runs;
import :rows;
import :simplex_row;

namespace camber {

namespace {

/// The vertices of a part: a run of its own, and some of others before and behind.
class LocalVertices {
  public:
    LocalVertices(Run own, std::vector<GlobalNumber> others) : own_(own), others_(std::move(others)) {
        std::ranges::sort(others_);
        others_.erase(std::ranges::unique(others_).begin(), others_.end());
        before_ = static_cast<std::size_t>(std::ranges::lower_bound(others_, own.begin) - others_.begin());
    }
    [[nodiscard]] bool owns(GlobalNumber v) const { return v >= own_.begin && v < own_.end; }
    [[nodiscard]] std::size_t size() const { return count() + others_.size(); }
    [[nodiscard]] VertexId first() const { return VertexId(before_); }
    [[nodiscard]] VertexId last() const { return VertexId(before_ + count()); }
    /// Invalid: it is not among them.
    [[nodiscard]] VertexId find(GlobalNumber v) const {
        if (owns(v)) return VertexId(before_ + (v - own_.begin));
        const auto at = std::ranges::lower_bound(others_, v);
        if (at == others_.end() || *at != v) return VertexId{};
        const auto place = static_cast<std::size_t>(at - others_.begin());
        return VertexId(place < before_ ? place : place + count());
    }
    [[nodiscard]] Buffer<GlobalNumber> numbers() const {
        Buffer<GlobalNumber> all(others_.begin(), others_.begin() + static_cast<std::ptrdiff_t>(before_));
        all.resize(before_ + count());
        std::iota(all.begin() + static_cast<std::ptrdiff_t>(before_), all.end(), GlobalNumber{own_.begin});
        all.insert(all.end(), others_.begin() + static_cast<std::ptrdiff_t>(before_), others_.end());
        return all;
    }

  private:
    [[nodiscard]] std::size_t count() const { return own_.size(); }
    Run own_;
    std::vector<GlobalNumber> others_;  ///< rising
    std::size_t before_ = 0;
};

/// Local simplices of global rows.
template <int K>
struct LocalSimplices {
    Simplices<K> simplices;
    Column<GlobalNumber> numbers;
};
template <int K>
Outcome<LocalSimplices<K>> local_simplices(const Buffer<SimplexRow<K>>& rows, const LocalVertices& vertices,
                                           const Execution& execution) {
    Buffer<SimplexVertices<K>> simplices(rows.size());
    Buffer<Reference> references(rows.size());
    Buffer<GlobalNumber> numbers(rows.size());
    auto done = each(execution, rows.size(), [&](std::size_t i) {
        for (int v = 0; v <= K; ++v) simplices[i][v] = vertices.find(rows[i].vertices[v]);
        references[i] = rows[i].reference;
        numbers[i] = rows[i].row;
    });
    if (!done) return fail(done.error());
    Buffer<std::uint32_t> required;
    for (std::size_t i = 0; i < rows.size(); ++i)
        if (rows[i].required != 0) required.push_back(static_cast<std::uint32_t>(i));
    return LocalSimplices<K>{{std::move(simplices), std::move(references), std::move(required)}, std::move(numbers)};
}

template <int K>
void add_others(const Buffer<SimplexRow<K>>& rows, Run own, std::vector<GlobalNumber>& others) {
    for (const auto& row : rows)
        for (const GlobalNumber v : row.vertices)
            if (v < own.begin || v >= own.end) others.push_back(v);
}

/// A list of vertices, as far as they are local.
Column<VertexId> local_list(const Column<VertexId>& list, const LocalVertices& vertices) {
    Buffer<VertexId> local;
    for (const VertexId v : list)
        if (const VertexId at = vertices.find(v.value); at.valid()) local.push_back(at);
    return local;
}

/// All of a part but the points of others.
template <int D>
Outcome<RingedPart<D>> part_of_rows(const PartRows<D>& of, Run own, const MeshRows<D>& rows, const LinearMesh<D>& lists,
                                    const Execution& execution) {
    std::vector<GlobalNumber> others;
    add_others<D>(of.elements, own, others);
    add_others<D - 1>(of.facets, own, others);
    add_others<1>(of.edges, own, others);
    const LocalVertices vertices(own, std::move(others));
    auto elements = local_simplices<D>(of.elements, vertices, execution);
    if (!elements) return fail(elements.error());
    auto facets = local_simplices<D - 1>(of.facets, vertices, execution);
    if (!facets) return fail(facets.error());
    auto edges = local_simplices<1>(of.edges, vertices, execution);
    if (!edges) return fail(edges.error());
    auto points = rows.points(own.begin, own.end);
    if (!points) return fail(points.error());
    RingedPart<D> part;
    part.first = vertices.first();
    part.last = vertices.last();
    Buffer<Vec<D>> places(vertices.size(), Vec<D>{});
    Buffer<Reference> references(vertices.size(), 0);
    const auto first = static_cast<std::ptrdiff_t>(part.first.index());
    std::ranges::copy(points->points, places.begin() + first);
    std::ranges::copy(points->references, references.begin() + first);
    part.mesh.points = std::move(places);
    part.mesh.point_references = std::move(references);
    part.mesh.corners = local_list(lists.corners, vertices);
    part.mesh.required_vertices = local_list(lists.required_vertices, vertices);
    part.mesh.elements = std::move(elements->simplices);
    part.mesh.facets = std::move(facets->simplices);
    part.mesh.edges = std::move(edges->simplices);
    part.mesh.groups = lists.groups;
    part.elements = std::move(elements->numbers);
    part.facets = std::move(facets->numbers);
    part.edges = std::move(edges->numbers);
    part.vertices = vertices.numbers();
    return part;
}

}  // namespace

template <int D>
Outcome<RingedPart<D>> kept_part(PartRows<D> of, Run own, const MeshRows<D>& rows, const LinearMesh<D>& lists,
                                 const PartMemory& memory, const Execution& execution) {
    if (memory.before) memory.before();
    of = {in_order<D>(of.elements), in_order<D - 1>(of.facets), in_order<1>(of.edges)};
    auto part = part_of_rows<D>(of, own, rows, lists, execution);
    of = {};
    if (memory.after) {
        memory.after();
        RingedPart<D> none;
        if (part) made_anew(*part, arrays_of(none));
    }
    if (memory.leave) memory.leave();
    return part;
}

#define CAMBER_INSTANTIATE(D)                                                                                \
    template Outcome<RingedPart<D>> kept_part<D>(PartRows<D>, Run, const MeshRows<D>&, const LinearMesh<D>&, \
                                                 const PartMemory&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
