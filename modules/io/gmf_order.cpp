module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
module camber.io;
import camber.core;
import camber.bezier;

namespace camber::gmf {

namespace {

/// The local node with these barycentric exponents (of sum 2), or −1.
template <int K>
int node_of(const std::array<std::int64_t, K + 1>& exponents) {
    for (int v = 0; v <= K; ++v) {
        std::array<std::int64_t, K + 1> vertex{};
        vertex[v] = 2;
        if (exponents == vertex) return v;
    }
    for (int e = 0; e < edges_per_simplex<K>; ++e) {
        std::array<std::int64_t, K + 1> edge{};
        edge[local_edges<K>[e][0]] = edge[local_edges<K>[e][1]] = 1;
        if (exponents == edge) return K + 1 + e;
    }
    return -1;
}

/// Σ of squared distances of mid nodes from the middles of their chords, the nodes taken in this order.
template <int D>
Outcome<double> offsets(const Buffer<Vec<D>>& points, const Buffer<std::array<VertexId, 10>>& tetrahedra,
                        const listing::NodeOrder<3>& order, const Execution& execution) {
    return reduce_each(
        execution, tetrahedra.size(), 0.0,
        [&](double& sum, std::size_t i) {
            const auto point = [&](int n) { return points[tetrahedra[i][n].index()]; };
            for (int n = 4; n < 10; ++n) {
                const auto& [a, b] = local_edges<3>[order[n] - 4];
                sum += norm_squared(point(n) - midpoint(point(a), point(b)));
            }
        },
        [](double a, double b) { return a + b; });
}

}  // namespace

template <int K>
Outcome<std::optional<listing::NodeOrder<K>>> read_order(const File& file) {
    const Block* const block = file.find(ordering_keyword<K>);
    if (!block || block->count == 0) return std::optional<listing::NodeOrder<K>>{};
    // EdgesP2Ordering gives the exponent of vertex 0 alone.
    constexpr int integers = K == 1 ? 1 : K + 1;
    listing::NodeOrder<K> order;
    order.fill(-1);
    std::array<bool, quadratic_nodes<K>> taken{};
    bool sound = block->count == order.size();
    if (sound) {
        const auto store = [&](std::size_t i, const Row<integers, 0>& row) -> Fault {
            std::array<std::int64_t, K + 1> exponents{};
            for (int v = 0; v < integers; ++v) exponents[v] = row.integer[v];
            if constexpr (K == 1) exponents[1] = std::int64_t{2} - (exponents[0] & 3);
            order[i] = node_of<K>(exponents);
            return {};
        };
        if (auto read = read_rows<Row<integers, 0>>(file, *block, Execution{.threads = 1}, store); !read)
            return fail(std::move(read.error()));
        for (const int node : order) {
            sound = sound && node >= 0 && !taken[node < 0 ? 0 : node];
            if (node >= 0) taken[node] = true;
        }
    }
    if (!sound)
        return fail_at(file, block->start,
                       std::string(block->info->name) + " does not list the " + std::to_string(order.size()) +
                           " nodes of its simplex once each");
    return std::optional(order);
}

template <int D>
Outcome<listing::NodeOrder<3>> likely_order(const Buffer<Vec<D>>& points,
                                            const Buffer<std::array<VertexId, 10>>& tetrahedra,
                                            const Execution& execution) {
    constexpr listing::NodeOrder<3> plain{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}, gmsh{0, 1, 2, 3, 4, 5, 6, 7, 9, 8};
    const auto as_plain = offsets<D>(points, tetrahedra, plain, execution);
    const auto as_gmsh = offsets<D>(points, tetrahedra, gmsh, execution);
    if (!as_plain) return fail(as_plain.error());
    if (!as_gmsh) return fail(as_gmsh.error());
    return *as_gmsh < *as_plain ? gmsh : plain;
}

template Outcome<std::optional<listing::NodeOrder<1>>> read_order<1>(const File&);
template Outcome<std::optional<listing::NodeOrder<2>>> read_order<2>(const File&);
template Outcome<std::optional<listing::NodeOrder<3>>> read_order<3>(const File&);
template Outcome<listing::NodeOrder<3>> likely_order<2>(const Buffer<Vec<2>>&, const Buffer<std::array<VertexId, 10>>&,
                                                        const Execution&);
template Outcome<listing::NodeOrder<3>> likely_order<3>(const Buffer<Vec<3>>&, const Buffer<std::array<VertexId, 10>>&,
                                                        const Execution&);

}  // namespace camber::gmf
