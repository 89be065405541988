// BoxTree compared with exhaustive search.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "dice.hpp"
#include "property.hpp"

import camber.core;
import camber.box_tree;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
void check_box_tree() {
    property("nearest returns the minimum distance and resolves ties to the lowest item", [](std::uint64_t seed) {
        Dice dice(seed);
        // Points of a coarse grid: many ties, many equal boxes.
        std::vector<Vec<D>> points(1 + dice.below(200));
        std::vector<Box<D>> boxes(points.size());
        for (std::size_t i = 0; i < points.size(); ++i) {
            for (double& x : points[i].c) x = static_cast<double>(dice.below(6));
            boxes[i].include(points[i]);
        }
        const BoxTree<D> tree(boxes);
        RC_ASSERT(tree.size() == points.size());
        for (int k = 0; k < 20; ++k) {
            Vec<D> q = dice.vector<D>(-2, 8);
            if (k % 2 == 0)
                for (double& x : q.c) x = std::floor(x * 2) / 2;
            const auto distance_squared = [&](std::size_t i) { return norm_squared(points[i] - q); };
            std::size_t best = 0;
            for (std::size_t i = 1; i < points.size(); ++i)
                if (distance_squared(i) < distance_squared(best)) best = i;
            const auto found = tree.nearest(q, distance_squared);
            RC_ASSERT(found.item == best);
            RC_ASSERT(found.distance_squared == distance_squared(best));
            if (found.distance_squared > 0)
                RC_ASSERT(tree.nearest(q, distance_squared, 0.99 * found.distance_squared).item ==
                          std::numeric_limits<std::size_t>::max());
        }
    });
    property("first_along returns the first item along a ray, ties to the lowest item", [](std::uint64_t seed) {
        Dice dice(seed);
        // Balls on a coarse grid, and rays along and across it.
        std::vector<Vec<D>> centres(1 + dice.below(100));
        std::vector<Box<D>> boxes(centres.size());
        constexpr double radius = 0.3;
        for (std::size_t i = 0; i < centres.size(); ++i) {
            for (double& x : centres[i].c) x = static_cast<double>(dice.below(6));
            for (const double r : {-1.01 * radius, 1.01 * radius}) {
                Vec<D> corner = centres[i];
                for (double& x : corner.c) x += r;
                boxes[i].include(corner);
            }
        }
        const BoxTree<D> tree(boxes);
        constexpr double never = std::numeric_limits<double>::infinity();
        for (int k = 0; k < 20; ++k) {
            Vec<D> p = dice.vector<D>(-1, 7), d = dice.vector<D>();
            if (k % 2 == 0) {
                p = centres[dice.below(centres.size())];
                d = {};
                d[k % D] = k % 4 == 0 ? 0.5 : -2;
                p -= dice.uniform(0, 3) * d;
            }
            const auto meets = [&](std::size_t i) {
                const Vec<D> c = centres[i] - p;
                const double a = norm_squared(d), b = dot(c, d), rest = b * b - a * (norm_squared(c) - radius * radius);
                return rest < 0 || b < 0 ? never : (b - std::sqrt(rest)) / a;
            };
            std::size_t best = 0;
            for (std::size_t i = 1; i < centres.size(); ++i)
                if (meets(i) < meets(best)) best = i;
            const auto met = tree.first_hit(p, d, meets);
            if (meets(best) == never) {
                RC_ASSERT(met.item == std::numeric_limits<std::size_t>::max());
                continue;
            }
            RC_ASSERT(met.item == best);
            RC_ASSERT(met.distance == meets(best));
            if (met.distance > 0)
                RC_ASSERT(tree.first_hit(p, d, meets, 0.99 * met.distance).item ==
                          std::numeric_limits<std::size_t>::max());
        }
    });
    property("containing visits each box that contains the point once", [](std::uint64_t seed) {
        Dice dice(seed);
        std::vector<Box<D>> boxes(1 + dice.below(100));
        Box<D> all;
        for (auto& box : boxes) {
            const Vec<D> p = dice.vector<D>();
            box.include(p);
            box.include(p + 0.5 * dice.vector<D>());
            all.include(box);
        }
        const BoxTree<D> tree(boxes);
        RC_ASSERT(tree.bounds().low == all.low);
        RC_ASSERT(tree.bounds().high == all.high);
        for (int k = 0; k < 20; ++k) {
            const Vec<D> q = dice.vector<D>();
            std::vector<std::size_t> found;
            tree.containing(q, [&](std::size_t i) { found.push_back(i); });
            // The tree may report items of a leaf whose own box does not contain the point.
            std::sort(found.begin(), found.end());
            RC_ASSERT(std::adjacent_find(found.begin(), found.end()) == found.end());
            for (std::size_t i = 0; i < boxes.size(); ++i)
                if (boxes[i].contains(q)) RC_ASSERT(std::binary_search(found.begin(), found.end(), i));
        }
    });
}

}  // namespace

TEST_CASE("box tree queries equal exhaustive search in 2D") { check_box_tree<2>(); }
TEST_CASE("box tree queries equal exhaustive search in 3D") { check_box_tree<3>(); }

TEST_CASE("an empty box tree finds nothing") {
    const BoxTree<2> tree;
    CHECK(tree.size() == 0);
    const auto none = tree.nearest(Vec<2>{}, [](std::size_t) { return 0.0; });
    CHECK(none.item == std::numeric_limits<std::size_t>::max());
    tree.containing(Vec<2>{}, [](std::size_t) { FAIL("nothing is there"); });
}
