module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
export module camber.shapes:extrude;
import camber.core;
import :random;

export namespace camber {

/// One row of prisms over simplices of dimension D − 1, cut to D-simplices. Base vertex v becomes bottom[v] below and
/// top[v] above; a base simplex is oriented such that (its edges, the way from bottom to top) is a positive frame.
///
/// Vertices have a random order drawn for the row, and each quadrilateral is cut from its lesser vertex below to its
/// greater one above: neighbours agree, no prism gets the cyclic cut that has no tetrahedra, and no pattern shows.
template <int D>
void extrude(std::span<const SimplexVertices<D - 1>> base, std::span<const VertexId> bottom,
             std::span<const VertexId> top, const Noise& noise, Buffer<SimplexVertices<D>>& elements) {
    const auto precedes = [&](VertexId a, VertexId b) {
        return std::pair(noise.bits(a.index()), a) < std::pair(noise.bits(b.index()), b);
    };
    for (SimplexVertices<D - 1> s : base) {
        bool odd = false;
        for (int i = 1; i < D; ++i)
            for (int j = i; j > 0 && precedes(s[j], s[j - 1]); --j) {
                std::swap(s[j], s[j - 1]);
                odd = !odd;
            }
        for (int step = 0; step < D; ++step) {  // goes up at vertex `step`
            SimplexVertices<D> element;
            for (int i = 0; i <= step; ++i) element[i] = bottom[s[i].index()];
            for (int i = step; i < D; ++i) element[i + 1] = top[s[i].index()];
            if (odd != ((D - 1 - step) % 2 == 1)) std::swap(element[0], element[1]);
            elements.push_back(element);
        }
    }
}

}  // namespace camber
