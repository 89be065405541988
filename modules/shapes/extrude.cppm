module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
export module camber.shapes:extrude;
import camber.core;
import :random;

export namespace camber {

/// One row of prisms over simplices of dimension D − 1, cut to the D-simplices `elements`, D for each. Base vertex v
/// becomes bottom(v) below and top(v) above; a base simplex is oriented such that (its edges, the way from bottom to
/// top) is a positive frame.
///
/// Vertices have a random order by `ranks`, drawn for the row, and each quadrilateral is cut from its lesser vertex
/// below to its greater one above: neighbours agree, no prism gets the cyclic cut that has no tetrahedra, and no
/// pattern shows. Errors: stopped.
template <int D, class Bottom, class Top>
[[nodiscard]] Outcome<Done> extrude(std::span<const SimplexVertices<D - 1>> base, std::span<const std::uint64_t> ranks,
                                    Bottom&& bottom, Top&& top, std::span<SimplexVertices<D>> elements,
                                    const Execution& execution) {
    const auto precedes = [&](VertexId a, VertexId b) {
        return std::pair(ranks[a.index()], a) < std::pair(ranks[b.index()], b);
    };
    return each(execution, base.size(), [&](std::size_t k) {
        SimplexVertices<D - 1> s = base[k];
        bool odd = false;
        for (int i = 1; i < D; ++i)
            for (int j = i; j > 0 && precedes(s[j], s[j - 1]); --j) {
                std::swap(s[j], s[j - 1]);
                odd = !odd;
            }
        for (int step = 0; step < D; ++step) {  // goes up at vertex `step`
            SimplexVertices<D> element;
            for (int i = 0; i <= step; ++i) element[i] = bottom(s[i]);
            for (int i = step; i < D; ++i) element[i + 1] = top(s[i]);
            if (odd != ((D - 1 - step) % 2 == 1)) std::swap(element[0], element[1]);
            elements[D * k + step] = element;
        }
    });
}

/// Rows of prisms, one on the other, over `rows` + 1 copies of the base's `count` vertices: copy k of vertex v is
/// v + k count. Row k is cut by noise.stream(first_stream + k). Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Done> extrude_rows(std::span<const SimplexVertices<D - 1>> base, std::size_t count,
                                         std::size_t rows, const Noise& noise, std::uint64_t first_stream,
                                         std::span<SimplexVertices<D>> elements, const Execution& execution) {
    const Execution quiet = without_progress(execution);  // each row is a loop of its own
    Buffer<std::uint64_t> ranks(count);
    for (std::size_t k = 0; k < rows; ++k) {
        const Noise of_row = noise.stream(first_stream + k);
        auto drawn = each(quiet, count, [&](std::size_t v) { ranks[v] = of_row.bits(v); });
        if (!drawn) return drawn;
        auto done = extrude<D>(
            base, ranks, [&](VertexId v) { return VertexId(k * count + v.index()); },
            [&](VertexId v) { return VertexId((k + 1) * count + v.index()); },
            elements.subspan(k * D * base.size(), D * base.size()), quiet);
        if (!done) return done;
    }
    return Done{};
}

}  // namespace camber
