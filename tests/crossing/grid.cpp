// A grid of boxes against looking at them all.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "facets.hpp"
#include "property.hpp"

import camber.core;
import camber.box_tree;
import camber.bezier;
import camber.crossing;

using namespace camber;
using camber::testing::property;
using namespace camber::testing;

namespace {

template <int D>
Box<D> random_box(Engine& engine) {
    Box<D> box;
    const Vec<D> corner = random_vector<D>(engine);
    box.include(corner);
    if (uniform(engine, 0, 1) > 0.1) {
        Vec<D> other = corner;
        for (double& x : other.c) x += std::pow(10, uniform(engine, -6, 0));
        box.include(other);
    }
    return box;
}

template <int D>
void law_of_grids() {
    property(D == 2 ? "2D: as all boxes say" : "3D: as all boxes say", [] {
        Engine engine(*rc::gen::arbitrary<std::uint64_t>());
        FacetGrid<D> grid;
        std::vector<Box<D>> boxes(60);
        std::vector<char> there(60, 0);
        std::vector<FacetId> found;
        for (int step = 0; step < 300; ++step) {
            const auto f = static_cast<std::size_t>(uniform(engine, 0, 59.99));
            if (uniform(engine, 0, 1) < 0.6) {
                boxes[f] = random_box<D>(engine);
                grid.insert(FacetId(f), boxes[f]);
                there[f] = 1;
            } else {
                grid.remove(FacetId(f));
                there[f] = 0;
            }
            if (step % 10 != 0) continue;
            const Box<D> asked = random_box<D>(engine);
            grid.meeting(asked, found);
            std::vector<FacetId> all;
            std::size_t size = 0;
            for (std::size_t g = 0; g < boxes.size(); ++g) {
                size += there[g] != 0 ? 1 : 0;
                RC_ASSERT(grid.contains(FacetId(g)) == (there[g] != 0));
                if (there[g] != 0 && boxes[g].meets(asked)) all.push_back(FacetId(g));
            }
            RC_ASSERT(grid.size() == size);
            RC_ASSERT(found == all);
        }
    });
}

}  // namespace

TEST_CASE("grids in the plane") { law_of_grids<2>(); }
TEST_CASE("grids in space") { law_of_grids<3>(); }

TEST_CASE("a tree of boxes, asked what meets a box, leaves none out") {
    property("tree", [] {
        Engine engine(*rc::gen::arbitrary<std::uint64_t>());
        std::vector<Box<3>> boxes(100);
        for (auto& box : boxes) box = random_box<3>(engine);
        const BoxTree<3> tree(boxes);
        const Box<3> asked = random_box<3>(engine);
        std::vector<int> seen(boxes.size(), 0);
        tree.meeting(asked, [&](std::size_t i) { ++seen[i]; });
        for (std::size_t i = 0; i < boxes.size(); ++i) {
            RC_ASSERT(seen[i] <= 1);
            RC_ASSERT(seen[i] == 1 || !boxes[i].meets(asked));
        }
    });
}
