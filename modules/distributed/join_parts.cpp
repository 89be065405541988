module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.cavity;
import :adaptation_rows;
import :cut_parts;

namespace camber {

namespace {

/// Simplices that several parts may have, each once.
template <std::size_t N>
class Shared {
  public:
    /// Whether it is the first of its vertices.
    [[nodiscard]] bool is_first(std::array<VertexId, N> simplex) {
        std::ranges::sort(simplex);
        return seen_.insert(simplex).second;
    }

  private:
    std::set<std::array<VertexId, N>> seen_;
};

template <int D>
class Joining {
  public:
    explicit Joining(std::size_t numbered) : by_number_(numbered, VertexId{}) {}

    void take(const AdaptationRows<D>& part) {
        ids_.clear();
        is_shared_.clear();
        for (const AdaptedVertex<D>& vertex : part.vertices) put_vertex(vertex);
        for (auto simplex : part.elements) {
            simplex.vertices = named(simplex.vertices);
            out_.elements.push_back(simplex);
        }
        for (auto simplex : part.facets) {
            const bool is_between = simplex.marks.has(Mark::frozen);
            simplex.vertices = named(simplex.vertices);
            if (is_between && !facets_.is_first(simplex.vertices)) continue;
            if (is_between) simplex.marks = thawed(simplex.marks);
            out_.facets.push_back(simplex);
        }
        for (auto simplex : part.lines) {
            const bool may_be_between =
                std::ranges::all_of(simplex.vertices, [&](VertexId v) { return is_shared_[v.index()] != 0; });
            simplex.vertices = named(simplex.vertices);
            if (!may_be_between || lines_.is_first(simplex.vertices)) out_.lines.push_back(simplex);
        }
    }
    [[nodiscard]] JoinedMesh<D> mesh() && { return {std::move(out_), std::move(on_rim_)}; }

  private:
    void put_vertex(const AdaptedVertex<D>& vertex) {
        VertexId id = vertex.number.valid() ? by_number_[vertex.number.index()] : VertexId{};
        if (!id.valid()) {
            id = VertexId(out_.vertices.size());
            out_.vertices.push_back(vertex);
            out_.vertices.back().number = id;
            on_rim_.push_back(vertex.number.valid() ? 1 : 0);
            if (vertex.number.valid()) by_number_[vertex.number.index()] = id;
        }
        ids_.push_back(id);
        is_shared_.push_back(vertex.number.valid() ? 1 : 0);
    }
    template <std::size_t N>
    [[nodiscard]] std::array<VertexId, N> named(std::array<VertexId, N> simplex) const {
        for (VertexId& v : simplex) v = ids_[v.index()];
        return simplex;
    }
    /// Of facets no other mark than these is known.
    [[nodiscard]] static Marks thawed(Marks marks) {
        Marks out;
        for (const Mark mark : {Mark::required, Mark::ridge})
            if (marks.has(mark)) out |= mark;
        return out;
    }

    AdaptationRows<D> out_;
    Buffer<std::uint8_t> on_rim_;
    Buffer<VertexId> by_number_;  ///< the new id of each number
    Buffer<VertexId> ids_;        ///< of the part's vertices
    Buffer<std::uint8_t> is_shared_;
    Shared<D> facets_;
    Shared<2> lines_;
};

template <int D>
std::size_t numbers_end(const CutMesh<D>& cut) {
    std::size_t end = 0;
    const auto see = [&](const AdaptationRows<D>& part) {
        for (const AdaptedVertex<D>& v : part.vertices)
            if (v.number.valid()) end = std::max(end, v.number.index() + 1);
    };
    std::ranges::for_each(cut.parts, see);
    see(cut.aside);
    return end;
}

}  // namespace

template <int D>
Outcome<JoinedMesh<D>> joined(const CutMesh<D>& cut) {
    return guarded([&]() -> Outcome<JoinedMesh<D>> {
        Joining<D> joining(numbers_end(cut));
        for (const AdaptationRows<D>& part : cut.parts) joining.take(part);
        joining.take(cut.aside);
        return std::move(joining).mesh();
    });
}

#define CAMBER_INSTANTIATE(D) template Outcome<JoinedMesh<D>> joined<D>(const CutMesh<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
