module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
module camber.metric:ball_sums;
import camber.core;

namespace camber {

/// Elements whose parts are in memory at a time: enough for many threads, few enough for a processor's own cache.
inline constexpr std::size_t ball_block = 8192;

/// Of the balls that touch the elements [first, last), those whose first one there is `e`: visit(v, others) with their
/// elements there, by rising number.
template <int D>
void visit_balls_of(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls, ElementId e, std::size_t first,
                    std::size_t last, const auto& visit) {
    const auto& corners = mesh.elements.vertices[e];
    for (int k = 0; k <= D; ++k) {
        const VertexId v = corners[k];
        const auto ball = balls[v];
        auto begin = ball.begin();
        if (begin->index() < first) begin = std::lower_bound(begin, ball.end(), ElementId(first));
        if (*begin != e || std::find(corners.begin(), corners.begin() + k, v) != corners.begin() + k) continue;
        auto end = begin;
        while (end != ball.end() && end->index() < last) ++end;
        visit(v, std::span(begin, end));
    }
}

/// Which corner of an element v is.
template <std::size_t N>
[[nodiscard]] std::size_t corner_of(const std::array<VertexId, N>& corners, VertexId v) {
    return static_cast<std::size_t>(std::find(corners.begin(), corners.end(), v) - corners.begin());
}

/// Sums over the balls of vertices: make(begin, end, parts) says what the elements [begin, end) have to add at each of
/// their corners; add(v, each_part) adds some of them to the sum of vertex v: each_part(f) calls f(part) by rising
/// element, and a vertex is one thread's at a time. Block by block, so that what all elements have to add is never in
/// memory.
template <class Part, int D>
[[nodiscard]] Outcome<Done> sum_over_balls(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                           const Execution& execution, const auto& make, const auto& add) {
    using Parts = std::array<Part, D + 1>;
    constexpr std::size_t grain = 128;
    const Execution silent = without_progress(execution);
    const std::size_t n = mesh.elements.size();
    return guarded([&]() -> Outcome<Done> {
        Buffer<Parts> parts(std::min(n, ball_block));
        for (std::size_t first = 0; first < n; first += ball_block) {
            const std::size_t last = std::min(n, first + ball_block);
            auto made = each_chunk(
                silent, last - first,
                [&](std::size_t begin, std::size_t end) {
                    make(first + begin, first + end, std::span<Parts>(parts).subspan(begin, end - begin));
                },
                grain);
            if (!made) return made;
            auto added = each(
                silent, last - first,
                [&](std::size_t i) {
                    const auto visit = [&](VertexId v, std::span<const ElementId> elements) {
                        add(v, [&](const auto& take) {
                            for (const ElementId e : elements)
                                take(parts[e.index() - first][corner_of(mesh.elements.vertices[e], v)]);
                        });
                    };
                    visit_balls_of(mesh, balls, ElementId(first + i), first, last, visit);
                },
                grain);
            if (!added) return added;
            report_progress(execution, last, n);
        }
        return Done{};
    });
}

}  // namespace camber
