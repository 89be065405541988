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

/// Of the balls that touch a block of elements, those whose first element of the block is `e`: add(v, other, corner)
/// for each of their elements in the block, by rising number; v is corner `corner` of `other`.
template <int D>
void add_balls_of(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls, ElementId e, std::size_t first,
                  std::size_t last, const auto& add) {
    const auto& corners = mesh.elements.vertices[e];
    for (int k = 0; k <= D; ++k) {
        const VertexId v = corners[k];
        const auto ball = balls[v];
        auto other = ball.begin();
        if (other->index() < first) other = std::lower_bound(ball.begin(), ball.end(), ElementId(first));
        if (*other != e || std::find(corners.begin(), corners.begin() + k, v) != corners.begin() + k) continue;
        for (; other != ball.end() && other->index() < last; ++other) {
            const auto& of = mesh.elements.vertices[*other];
            add(v, *other, static_cast<std::size_t>(std::find(of.begin(), of.end(), v) - of.begin()));
        }
    }
}

/// Sums over the balls of vertices: make(begin, end, parts) says what the elements [begin, end) have to add at each of
/// their corners, and add(v, part) adds one part to the sum of vertex v, by rising element; of one vertex by one thread
/// at a time. Block by block, so that what all elements have to add is never in memory.
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
                    add_balls_of(
                        mesh, balls, ElementId(first + i), first, last,
                        [&](VertexId v, ElementId e, std::size_t corner) { add(v, parts[e.index() - first][corner]); });
                },
                grain);
            if (!added) return added;
        }
        return Done{};
    });
}

}  // namespace camber
