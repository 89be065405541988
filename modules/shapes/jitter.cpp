module;
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
module camber.shapes;
import camber.core;

namespace camber {

namespace {

double volume(const Buffer<Vec<2>>& p, const SimplexVertices<2>& s) {
    return det(p[s[1].index()] - p[s[0].index()], p[s[2].index()] - p[s[0].index()]);
}
double volume(const Buffer<Vec<3>>& p, const SimplexVertices<3>& s) {
    return det(p[s[1].index()] - p[s[0].index()], p[s[2].index()] - p[s[0].index()], p[s[3].index()] - p[s[0].index()]);
}

/// Vertices marked from any thread, all to the same value.
using Marks = std::vector<std::uint8_t>;

/// Marks the vertices of elements that lost too much, among those with a vertex that has just moved; whether there are
/// any.
template <int D>
Outcome<bool> mark_complaints(const Buffer<Vec<D>>& points, const Buffer<Vec<D>>& at,
                              std::span<const SimplexVertices<D>> elements, double least, const Marks& just_moved,
                              Marks& halve, const Execution& execution) {
    std::atomic<bool> any = false;
    auto done = each(execution, elements.size(), [&](std::size_t e) {
        const auto& element = elements[e];
        if (std::none_of(element.begin(), element.end(), [&](VertexId v) { return just_moved[v.index()] != 0; }))
            return;
        if (volume(at, element) >= least * volume(points, element)) return;
        any.store(true, std::memory_order_relaxed);
        for (const VertexId v : element) std::atomic_ref(halve[v.index()]).store(1, std::memory_order_relaxed);
    });
    if (!done) return fail(done.error());
    return any.load();
}

}  // namespace

template <int D>
Outcome<Done> move_points(Buffer<Vec<D>>& points, const Moved<D>& moved, const ElementRuns<D>& runs, double least,
                          const Execution& execution) {
    constexpr int halvings = 12;
    static_assert(halvings == rings_of_move);
    auto made = map_each(execution, points.size(), [&](std::size_t v) { return moved(v); });
    if (!made) return fail(made.error());
    Buffer<Vec<D>> at = std::move(*made);
    Marks halved(points.size(), 0);  // how often
    Marks just_moved(points.size(), 1);
    for (int round = 0; round < halvings; ++round) {
        Marks halve(points.size(), 0);
        bool any = false;
        auto looked = runs(just_moved, [&](std::span<const SimplexVertices<D>> elements) -> Outcome<Done> {
            const auto some = mark_complaints<D>(points, at, elements, least, just_moved, halve, execution);
            if (!some) return fail(some.error());
            any |= *some;
            return Done{};
        });
        if (!looked) return looked;
        if (!any) break;
        auto done = each(execution, points.size(), [&](std::size_t v) {
            if (halve[v] == 0) return;
            const double part = round + 1 == halvings ? 0.0 : std::ldexp(1.0, -++halved[v]);
            at[v] = points[v] + part * (moved(v) - points[v]);
        });
        if (!done) return done;
        just_moved = std::move(halve);
    }
    points = std::move(at);
    return Done{};
}

template <int D>
Outcome<Done> move_points(Buffer<Vec<D>>& points, std::span<const Vec<D>> moved,
                          std::span<const SimplexVertices<D>> elements, double least, const Execution& execution) {
    return move_points<D>(
        points, [&](std::size_t v) { return moved[v]; },
        [&](std::span<const std::uint8_t>, const auto& look) { return look(elements); }, least, execution);
}

#define CAMBER_INSTANTIATE(D)                                                                              \
    template Outcome<Done> move_points<D>(Buffer<Vec<D>>&, const Moved<D>&, const ElementRuns<D>&, double, \
                                          const Execution&);                                               \
    template Outcome<Done> move_points<D>(Buffer<Vec<D>>&, std::span<const Vec<D>>,                        \
                                          std::span<const SimplexVertices<D>>, double, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
