// A facet grid compared with a linear search through all boxes.
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
void check_grid() {
    property(D == 2 ? "the grid returns the boxes that a search of all boxes returns, 2D"
                    : "the grid returns the boxes that a search of all boxes returns, 3D",
             [] {
                 Engine engine(*rc::gen::arbitrary<std::uint64_t>());
                 FacetGrid<D> grid;
                 std::vector<Box<D>> boxes(60);
                 std::vector<char> is_inserted(60, 0);
                 std::vector<FacetId> found;
                 for (int step = 0; step < 300; ++step) {
                     const auto f = static_cast<std::size_t>(uniform(engine, 0, 59.99));
                     if (uniform(engine, 0, 1) < 0.6) {
                         boxes[f] = random_box<D>(engine);
                         grid.insert(FacetId(f), boxes[f]);
                         is_inserted[f] = 1;
                     } else {
                         grid.remove(FacetId(f));
                         is_inserted[f] = 0;
                     }
                     if (step % 10 != 0) continue;
                     const Box<D> query = random_box<D>(engine);
                     grid.meeting(query, found);
                     std::vector<FacetId> all;
                     std::size_t size = 0;
                     for (std::size_t g = 0; g < boxes.size(); ++g) {
                         size += is_inserted[g] != 0 ? 1 : 0;
                         RC_ASSERT(grid.contains(FacetId(g)) == (is_inserted[g] != 0));
                         if (is_inserted[g] != 0 && boxes[g].meets(query)) all.push_back(FacetId(g));
                     }
                     RC_ASSERT(grid.size() == size);
                     RC_ASSERT(found == all);
                 }
             });
}

}  // namespace

TEST_CASE("a facet grid returns all boxes that meet a query box, 2D") { check_grid<2>(); }
TEST_CASE("a facet grid returns all boxes that meet a query box, 3D") { check_grid<3>(); }

TEST_CASE("a box tree visits each box that meets a query box once") {
    property("a box tree visits each box that meets the query box once", [] {
        Engine engine(*rc::gen::arbitrary<std::uint64_t>());
        std::vector<Box<3>> boxes(100);
        for (auto& box : boxes) box = random_box<3>(engine);
        const BoxTree<3> tree(boxes);
        const Box<3> query = random_box<3>(engine);
        std::vector<int> visits(boxes.size(), 0);
        tree.meeting(query, [&](std::size_t i) { ++visits[i]; });
        for (std::size_t i = 0; i < boxes.size(); ++i) {
            RC_ASSERT(visits[i] <= 1);
            RC_ASSERT(visits[i] == 1 || !boxes[i].meets(query));
        }
    });
}
