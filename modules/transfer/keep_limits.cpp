module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
module camber.transfer;
import :key_table;
import :patches;
import :projection;
import :simplex;
import :sums;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// Of each unknown ∫ φ, and the one group that all of its elements are of; `no_group` on interfaces, whose nodes
/// would change two groups at once.
template <int D, int K>
struct Movable {
    Buffer<double> weight;
    Buffer<std::uint32_t> group;
};
template <int D, int K>
Outcome<Movable<D, K>> movable(const typename PatchSearch<D>::Patches& patches, MassMatrix<D, K>& matrix,
                               const Execution& execution) {
    Movable<D, K> out{Buffer<double>(matrix.size()), Buffer<std::uint32_t>(matrix.size(), no_group)};
    const auto part = [&](std::size_t slot) { return matrix.integrals(slot); };
    auto done = matrix.assemble(part, out.weight, execution);
    if (!done) return fail(done.error());
    Buffer<std::uint8_t> is_seen(matrix.size(), 0);
    for (std::size_t slot = 0; slot < patches.group_of_new.size(); ++slot)
        for (const std::uint32_t u : matrix.unknowns(slot)) {
            if (u == none) continue;
            if (is_seen[u] != 0 && out.group[u] != patches.group_of_new[slot])
                out.group[u] = no_group;
            else if (is_seen[u] == 0)
                out.group[u] = patches.group_of_new[slot];
            is_seen[u] = 1;
        }
    return out;
}

}  // namespace

template <int D, int K>
Outcome<Done> keep_limits(const TransferScene<D>& scene, const typename PatchSearch<D>::Patches& patches,
                          Projection<D, K>& projection, const Execution& execution) {
    const std::size_t unknowns = projection.matrix.size(), components = projection.block.components;
    const auto value = [&](std::size_t u, std::size_t c) -> double& {
        return projection.block.values[projection.matrix.node_of()[u] * components + c];
    };
    for (std::size_t u = 0; u < unknowns; ++u)
        for (std::size_t c = 0; c < components; ++c)
            value(u, c) =
                std::clamp(value(u, c), projection.low[u * components + c], projection.high[u * components + c]);
    const auto free = movable<D, K>(patches, projection.matrix, execution);
    if (!free) return fail(free.error());
    // Twice: what rounding leaves of the first is moved by the second.
    for (int round = 0; round < 2; ++round) {
        const auto missing = missing_integrals(scene, patches, projection, execution);
        if (!missing) return fail(missing.error());
        // How far a node may move in the direction that helps.
        const auto room = [&](std::size_t u, std::size_t c) {
            const double gap = (*missing)[free->group[u] * components + c] * free->weight[u];
            if (gap == 0) return 0.0;
            return (gap > 0 ? projection.high : projection.low)[u * components + c] - value(u, c);
        };
        const auto possible = sums_by_group(
            free->group, patches.groups.size(), components,
            [&](std::size_t u, std::span<double> out) {
                for (std::size_t c = 0; c < components; ++c)
                    out[c] = free->group[u] == no_group ? 0 : free->weight[u] * room(u, c);
            },
            execution);
        if (!possible) return fail(possible.error());
        for (std::size_t u = 0; u < unknowns; ++u) {
            if (free->group[u] == no_group) continue;
            for (std::size_t c = 0; c < components; ++c) {
                const std::size_t at = free->group[u] * components + c;
                const double all = (*possible)[at].value();
                if (all == 0) continue;
                value(u, c) += std::min(1.0, (*missing)[at] / all) * room(u, c);
                value(u, c) =
                    std::clamp(value(u, c), projection.low[u * components + c], projection.high[u * components + c]);
            }
        }
    }
    return Done{};
}

#define CAMBER_INSTANTIATE(D, K)                                                                      \
    template Outcome<Done> keep_limits<D, K>(const TransferScene<D>&, const PatchSearch<D>::Patches&, \
                                             Projection<D, K>&, const Execution&);

CAMBER_INSTANTIATE(2, 1)
CAMBER_INSTANTIATE(2, 2)
CAMBER_INSTANTIATE(3, 1)
CAMBER_INSTANTIATE(3, 2)
#undef CAMBER_INSTANTIATE

}  // namespace camber
