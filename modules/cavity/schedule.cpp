module;
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
module camber.cavity;
import camber.core;
import camber.validity;

namespace camber {

namespace {

/// The finaliser of a 64-bit mixer (SplitMix64): neighbours in number are not neighbours in rank.
constexpr std::uint64_t rank_of(VertexId v) {
    std::uint64_t z = (v.index() + 1) * 0x9e3779b97f4a7c15ULL;
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31U);
}

}  // namespace

template <int D>
Outcome<Buffer<VertexId>> independent_vertices(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                               std::span<const VertexId> pending,
                                               std::span<const std::uint8_t> is_pending, const Execution& execution) {
    const auto comes_first = [&](VertexId v) {
        const auto rank = std::pair(rank_of(v), v);
        for (const ElementId e : balls[v])
            for (const VertexId w : mesh.elements.vertices[e])
                if (w != v && is_pending[w.index()] != 0 && std::pair(rank_of(w), w) < rank) return false;
        return true;
    };
    auto first = map_each(execution, pending.size(),
                          [&](std::size_t i) { return static_cast<std::uint8_t>(comes_first(pending[i])); });
    if (!first) return fail(first.error());
    Buffer<VertexId> chosen;
    chosen.reserve(pending.size());
    for (std::size_t i = 0; i < pending.size(); ++i)
        if ((*first)[i] != 0) chosen.push_back(pending[i]);
    return chosen;
}

template Outcome<Buffer<VertexId>> independent_vertices<2>(const LinearMesh<2>&, const Incidence<ElementId>&,
                                                           std::span<const VertexId>, std::span<const std::uint8_t>,
                                                           const Execution&);
template Outcome<Buffer<VertexId>> independent_vertices<3>(const LinearMesh<3>&, const Incidence<ElementId>&,
                                                           std::span<const VertexId>, std::span<const std::uint8_t>,
                                                           const Execution&);

}  // namespace camber
