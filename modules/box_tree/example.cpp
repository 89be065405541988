// Example of camber.box_tree: finds the nearest of many points with a few distance computations.
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <span>
#include <vector>

import camber.core;
import camber.box_tree;

using namespace camber;

int main() {
    // Points on a spiral, each with its own box.
    std::vector<Vec<2>> points;
    std::vector<Box<2>> boxes;
    for (int i = 0; i < 10000; ++i) {
        const double angle = 0.05 * i;
        points.push_back({{angle * camber::cos(angle), angle * camber::sin(angle)}});
        boxes.emplace_back().include(points.back());
    }
    const BoxTree<2> tree{std::span<const Box<2>>(boxes)};
    const Vec<2> p{{100, 50}};
    std::size_t looked = 0;
    const auto nearest = tree.nearest(p, [&](std::size_t i) {
        ++looked;
        return norm_squared(points[i] - p);
    });
    std::printf("of %zu points number %zu is nearest, %.3f away; %zu were looked at\n", tree.size(), nearest.item,
                std::sqrt(nearest.distance_squared), looked);
    return nearest.item < points.size() && looked < points.size() / 10 ? 0 : 1;
}
