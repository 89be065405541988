module;
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
module camber.io;
import camber.core;
import camber.bezier;
import :assembly;

/// Which mid node belongs to which edge, and whether the simplices of a file agree about it.
namespace camber::listing {

namespace {

template <class T>
void atomic_min(T& target, T value) {
    const std::atomic_ref<T> shared(target);
    T seen = shared.load(std::memory_order_relaxed);
    while (value < seen && !shared.compare_exchange_weak(seen, value, std::memory_order_relaxed)) {
    }
}

/// The edge of the set on local edge k of simplex i.
template <int K, int D>
EdgeId edge_at(const EdgeSet<D>& edges, std::size_t i, int k) {
    if constexpr (K == D)
        return edges.of_elements[i][k];
    else if constexpr (K == D - 1)
        return edges.of_facets[i][k];
    else
        return edges.of_edges[i];
}

/// f(edge, mid node, simplex number) → Done for each local edge of each simplex of degree 2.
template <int K, int D, class F>
Outcome<Done> for_each_mid_node(const Simplices<K>& kind, const EdgeSet<D>& edges, const Execution& execution, F&& f) {
    return each(
        execution, kind.curved.size(),
        [&](std::size_t i) {
            for (int k = 0; k < edges_per_simplex<K>; ++k)
                f(edge_at<K, D>(edges, i, k), kind.curved.nodes[i][K + 1 + k], i);
        },
        row_grain);
}

template <int D>
Outcome<MidNodes> lowest_mid_nodes(const Mesh<D>& raw, const EdgeSet<D>& edges, const Execution& execution) {
    MidNodes mid{Buffer<std::uint32_t>(edges.size()), Buffer<std::uint32_t>(raw.points.size())};
    for (std::uint32_t& v : mid.of_edge) v = none;
    for (std::uint32_t& e : mid.edge_of) e = none;
    auto listed = for_each_dimension(raw, [&]<int K>(const Simplices<K>& kind) {
        return for_each_mid_node<K, D>(kind, edges, execution, [&](EdgeId e, VertexId v, std::size_t) {
            atomic_min(mid.of_edge[e.index()], v.value);
            atomic_min(mid.edge_of[v.index()], e.value);
        });
    });
    if (!listed) return fail(std::move(listed.error()));
    return mid;
}

/// The error of the first simplex that disagrees with the lowest candidates.
template <int K, int D>
auto disagreement(const Mesh<D>& raw, const Simplices<K>& kind, const EdgeSet<D>& edges, const MidNodes& mid,
                  const Renumbering& numbers, std::size_t i) {
    const Simplex here{&kind.curved.origin, i};
    const Entity entity{simplex_name<K>, here.origin->number_of(i)};
    const auto number = [&](std::size_t index) { return std::to_string(raw.number_of(VertexId(index))); };
    std::string text;
    for (int k = 0; k < edges_per_simplex<K> && text.empty(); ++k) {
        const EdgeId e = edge_at<K, D>(edges, i, k);
        const VertexId v = kind.curved.nodes[i][K + 1 + k];
        const VertexId first(std::size_t{mid.of_edge[e.index()]});
        const bool two_nodes = first != v;
        if (!two_nodes && mid.edge_of[v.index()] == e.value) continue;
        const EdgeId shown = two_nodes ? e : EdgeId(std::size_t{mid.edge_of[v.index()]});
        const VertexId other_node = two_nodes ? first : v;
        const Simplex other = find_simplex(raw, [&]<int L>(const auto& nodes) {
            for (std::size_t n = L + 1; n < nodes.size(); ++n) {
                const auto& [a, b] = local_edges<L>[n - L - 1];
                if (nodes[n] != other_node) continue;
                const std::uint32_t p = numbers.to_mesh[nodes[a].index()], q = numbers.to_mesh[nodes[b].index()];
                const auto& [low, high] = edges.vertices[shown];
                if ((p == low.value && q == high.value) || (q == low.value && p == high.value)) return true;
            }
            return false;
        });
        const auto& [low, high] = edges.vertices[e];
        const std::string edge = "the edge between vertices " + number(numbers.to_file[low.index()]) + " and " +
                                 number(numbers.to_file[high.index()]);
        text = two_nodes
                   ? edge + " has mid node " + number(v.index()) + " here and " + number(first.index()) + " in " +
                         other.text()
                   : "mid node " + number(v.index()) + " of " + edge + " is that of another edge in " + other.text();
    }
    return fail(ErrorKind::input, text, here.where(raw.name), entity, "the file is damaged, or joined of two");
}

template <int D>
Outcome<Done> check_agreement(const Mesh<D>& raw, const EdgeSet<D>& edges, const MidNodes& mid,
                              const Renumbering& numbers, const Execution& execution) {
    return for_each_dimension(raw, [&]<int K>(const Simplices<K>& kind) -> Outcome<Done> {
        FirstFault first;
        auto seen = for_each_mid_node<K, D>(kind, edges, execution, [&](EdgeId e, VertexId v, std::size_t i) {
            if (mid.of_edge[e.index()] != v.value || mid.edge_of[v.index()] != e.value) first.note(i);
        });
        if (!seen || !first.any()) return seen;
        return disagreement<K, D>(raw, kind, edges, mid, numbers, first.row());
    });
}

}  // namespace

template <int D>
Outcome<MidNodes> mid_nodes_of(const Mesh<D>& raw, const EdgeSet<D>& edges, const Renumbering& numbers,
                               const Execution& execution) {
    auto mid = lowest_mid_nodes(raw, edges, execution);
    if (!mid) return mid;
    auto agreed = check_agreement(raw, edges, *mid, numbers, execution);
    if (!agreed) return fail(std::move(agreed.error()));
    return mid;
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<MidNodes> mid_nodes_of<D>(const Mesh<D>&, const EdgeSet<D>&, const Renumbering&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::listing
