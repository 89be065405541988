// Allocations of the loops over edges, elements and vertices: far fewer than one per item, since memory is allocated
// once per chunk or call.
#include <cstddef>
#include <string>

#include <doctest/doctest.h>

#include "heap.hpp"
#include "shell.hpp"

import camber.core;
import camber.bezier;
import camber.extension;
import camber.metric;
import camber.edge_optimisation;
import camber.validity;
import camber.curving;

using namespace camber;
using namespace camber::testing;

namespace {

/// Checks that f(), which processes `items` items, makes fewer than `bound` allocations per item.
template <class F>
void check_allocations(const std::string& loop, std::size_t items, double bound, F&& f) {
    const double per_item = static_cast<double>(cost_of(f).allocations) / static_cast<double>(items);
    CAPTURE(loop);
    CHECK(per_item < bound);
}

}  // namespace

TEST_CASE("loops over edges and elements allocate less than once per item") {
    const ShellCase c;
    const auto base = c.on_spheres();
    CurveOptions without_lengths;
    without_lengths.measured = MeasuredEdges::some;
    check_allocations("accurate offsets", c.edges(), 0.3, [&] {
        (void)must(accurate_offsets({c.mesh, c.kinds, c.shell}, EdgeKind::volume, c.back, without_lengths, one_thread));
    });
    check_allocations("curve", c.edges(), 0.3, [&] {
        (void)must(curve({c.mesh, c.kinds, c.shell}, base, c.back, without_lengths, one_thread));
    });
    check_allocations("validate", c.tetrahedra(), 0.001, [&] { (void)must(validate(c.mesh, 0, one_thread)); });
    check_allocations("extension", c.edges(), 0.14,
                      [&] { (void)must(extend_boundary(c.mesh, c.kinds, base, c.shell, {}, one_thread)); });
    check_allocations("natural metric", c.tetrahedra(), 0.02,
                      [&] { (void)must(natural_log_metrics(c.mesh.linear, c.ball, one_thread)); });
    check_allocations("elevate", c.edges(), 0.003, [&] { (void)must(elevate(c.mesh.linear, one_thread)); });
    check_allocations("balls", c.tetrahedra(), 0.0004, [&] { (void)must(balls(c.mesh.linear, one_thread)); });
}
