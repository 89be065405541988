module;
#include <array>
#include <cstddef>
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

}  // namespace

template <int D>
void move_points(Buffer<Vec<D>>& points, std::span<const Vec<D>> moved, std::span<const SimplexVertices<D>> elements,
                 double least) {
    constexpr int halvings = 12;
    std::vector<double> part(points.size(), 1.0);
    Buffer<Vec<D>> at(moved.begin(), moved.end());
    for (int round = 0; round < halvings; ++round) {
        std::vector<bool> halve(points.size(), false);
        bool any = false;
        for (const auto& element : elements) {
            if (volume(at, element) >= least * volume(points, element)) continue;
            any = true;
            for (const VertexId v : element) halve[v.index()] = true;
        }
        if (!any) break;
        for (std::size_t v = 0; v < points.size(); ++v) {
            if (!halve[v]) continue;
            part[v] = round + 1 == halvings ? 0.0 : part[v] / 2;
            at[v] = points[v] + part[v] * (moved[v] - points[v]);
        }
    }
    points = std::move(at);
}

template void move_points<2>(Buffer<Vec<2>>&, std::span<const Vec<2>>, std::span<const SimplexVertices<2>>, double);
template void move_points<3>(Buffer<Vec<3>>&, std::span<const Vec<3>>, std::span<const SimplexVertices<3>>, double);

}  // namespace camber
