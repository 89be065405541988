module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <utility>
module camber.io:mfem_curves;
import camber.core;
import :listing;
import :mfem_order;

/// Degree 2: nodes of edges, which MFEM numbers as the elements name them.
namespace camber::mfem {

/// MFEM's numbers of edges, by their ends.
class EdgeNumbers {
  public:
    void add(VertexId a, VertexId b) { numbers_.try_emplace(key(a, b), static_cast<std::uint32_t>(numbers_.size())); }
    [[nodiscard]] std::optional<std::size_t> find(VertexId a, VertexId b) const {
        const auto found = numbers_.find(key(a, b));
        if (found == numbers_.end()) return std::nullopt;
        return found->second;
    }
    [[nodiscard]] std::size_t size() const { return numbers_.size(); }

  private:
    static std::uint64_t key(VertexId a, VertexId b) {
        return std::uint64_t{std::min(a.value, b.value)} << 32U | std::max(a.value, b.value);
    }
    std::unordered_map<std::uint64_t, std::uint32_t> numbers_;
};

template <int K>
[[nodiscard]] EdgeNumbers number_edges(const listing::Rows<K + 1>& elements) {
    EdgeNumbers numbers;
    for (const auto& element : elements.nodes)
        for (const int k : edge_order<K>) numbers.add(element[local_edges<K>[k][0]], element[local_edges<K>[k][1]]);
    return numbers;
}

/// Leaves out simplices of the boundary with an edge of no element, for which there are no nodes. How many they are.
template <int K>
std::size_t drop_strays(listing::Rows<K + 1>& rows, const EdgeNumbers& numbers) {
    std::size_t kept = 0;
    const std::size_t before = rows.size();
    for (std::size_t i = 0; i < before; ++i) {
        const auto& simplex = rows.nodes[i];
        const bool known = std::all_of(local_edges<K>.begin(), local_edges<K>.end(), [&](const auto& ends) {
            return numbers.find(simplex[ends[0]], simplex[ends[1]]).has_value();
        });
        if (!known) continue;
        rows.nodes[kept] = simplex;
        rows.references[kept++] = rows.references[i];
    }
    rows.nodes.resize(kept);
    rows.references.resize(kept);
    return before - kept;
}

/// The simplices of degree 1 with the nodes of their edges.
template <int K>
Outcome<Done> curve(listing::Simplices<K>& simplices, const EdgeNumbers& numbers, std::size_t vertices) {
    simplices.curved.references = std::move(simplices.straight.references);
    simplices.curved.origin = simplices.straight.origin;
    simplices.curved.nodes.resize(simplices.straight.size());
    for (std::size_t i = 0; i < simplices.straight.size(); ++i) {
        const auto& corners = simplices.straight.nodes[i];
        auto& nodes = simplices.curved.nodes[i];
        std::copy(corners.begin(), corners.end(), nodes.begin());
        for (std::size_t k = 0; k < edges_per_simplex<K>; ++k) {
            const auto number = numbers.find(corners[local_edges<K>[k][0]], corners[local_edges<K>[k][1]]);
            const auto& origin = simplices.curved.origin;
            if (!number)
                return fail(ErrorKind::input, "one of its edges is none of an element's", origin.place(i),
                            Entity{origin.noun, origin.number_of(i)}, "MFEM has no node for it: remove it");
            nodes[K + 1 + k] = VertexId(vertices + *number);
        }
    }
    simplices.straight = {};
    return Done{};
}

}  // namespace camber::mfem
