// Meshes that are made by rows are those that are made as a whole.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "property.hpp"

import camber.core;
import camber.shapes;

using namespace camber;
using namespace camber::testing;

namespace {

/// Rising places at which the rows are cut, from the first to the end.
std::vector<std::size_t> cuts_of(std::size_t rows) {
    std::vector<std::size_t> cuts{0, rows};
    for (int k = *rc::gen::inRange(0, 5); k > 0; --k) cuts.push_back(*rc::gen::inRange<std::size_t>(0, rows + 1));
    std::ranges::sort(cuts);
    return cuts;
}

template <class T>
void append(Buffer<T>& to, const Buffer<T>& more) {
    to.insert(to.end(), more.begin(), more.end());
}

/// The mesh of runs that follow each other; each begins where the last has ended.
template <int D>
LinearMesh<D> joined(const ShapeRows<D>& shape, const std::vector<std::size_t>& cuts) {
    ShapeRun<D> all;
    for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
        const auto run = shape.run(cuts[k], cuts[k + 1], {});
        RC_ASSERT(run.has_value());
        if (cuts[k] == cuts[k + 1]) continue;
        RC_ASSERT(run->first_vertex == all.points.size());
        RC_ASSERT(run->first_element == all.elements.size());
        RC_ASSERT(run->first_facet == all.facets.size());
        append(all.points, run->points);
        append(all.point_references, run->point_references);
        append(all.elements, run->elements);
        append(all.materials, run->materials);
        append(all.facets, run->facets);
        append(all.facet_references, run->facet_references);
    }
    LinearMesh<D> mesh = *shape.lists();
    const ShapeCounts counts = shape.counts();
    RC_ASSERT(counts.vertices == all.points.size());
    RC_ASSERT(counts.elements == all.elements.size());
    RC_ASSERT(counts.facets == all.facets.size());
    RC_ASSERT(counts.edges == mesh.edges.size());
    mesh.points = std::move(all.points);
    mesh.point_references = std::move(all.point_references);
    mesh.elements = {std::move(all.elements), std::move(all.materials), {}};
    mesh.facets = {std::move(all.facets), std::move(all.facet_references), {}};
    return mesh;
}

template <class Options>
void check_rows(const Options& options) {
    const auto whole = generate(options);
    const auto rows = rows_of_shape(options);
    RC_ASSERT(whole.has_value() == rows.has_value());
    if (!rows) return;
    const auto mesh = joined(**rows, cuts_of((*rows)->rows()));
    RC_ASSERT(mesh.points == whole->points);
    RC_ASSERT(mesh.elements == whole->elements);
    RC_ASSERT(mesh.facets == whole->facets);
    RC_ASSERT(mesh.edges == whole->edges);
    RC_ASSERT(mesh == *whole);
}

template <int D>
BoxOptions<D> any_box(int most, int most_rows) {
    BoxOptions<D> options;
    for (int i = 0; i < D; ++i) {
        options.cells[i] = *rc::gen::inRange(1, i + 1 == D ? most_rows : most);
        options.grading[i] = std::pow(10.0, 0.1 * *rc::gen::inRange(-20, 21));
        options.high[i] = *rc::gen::inRange(1, 9);
    }
    options.warp = *rc::gen::element(0.0, 0.02, -0.05);
    options.jitter = 0.1 * *rc::gen::inRange(0, 6);
    options.seed = *rc::gen::arbitrary<std::uint64_t>();
    return options;
}

BoundaryLayer any_layer(Reference interface) {
    return {.count = *rc::gen::inRange(0, 4),
            .first_height = 0.02,
            .growth = 1.3,
            .material = *rc::gen::inRange(0, 3),
            .interface = interface};
}

template <int D>
ShellOptions<D> any_shell(double smallest) {
    ShellOptions<D> options;
    options.centre[0] = 0.5;
    options.outer_radius = *rc::gen::element(1.5, 3.0, 8.0);
    options.inner_size = smallest * *rc::gen::inRange(1, 4);
    options.inner_layer = any_layer(7);
    options.outer_layer = any_layer(8);
    options.structure = ShellStructure::prisms;
    options.jitter = *rc::gen::element(0.0, 0.15, 0.3);
    options.seed = *rc::gen::arbitrary<std::uint64_t>();
    return options;
}

}  // namespace

TEST_CASE("rows of a box, run after run, are the box") {
    property("rows of a box in 2D", [] { check_rows(any_box<2>(9, 70)); });
    property("rows of a box in 3D", [] { check_rows(any_box<3>(6, 60)); }, {.count = 30});
}

TEST_CASE("rows of a shell of prisms, run after run, are the shell") {
    property("rows of an annulus", [] { check_rows(any_shell<2>(0.06)); });
    property("rows of a shell", [] { check_rows(any_shell<3>(0.25)); }, {.count = 30});
}

TEST_CASE("what is not made by rows is refused, and what cannot be made") {
    const auto unstructured = rows_of_shape(ShellOptions<3>{});
    REQUIRE_FALSE(unstructured.has_value());
    CHECK(unstructured.error().kind == ErrorKind::unsupported);
    CHECK(rows_of_shape(BoxOptions<2>{.cells = {0, 3}}).error().kind == ErrorKind::usage);
    // Layers that are thinner than rounding have no volume.
    ShellOptions<3> flat{.inner_layer = {.count = 2, .first_height = 1e-17}, .structure = ShellStructure::prisms};
    const auto whole = generate(flat);
    const auto rows = rows_of_shape(flat);
    REQUIRE(rows.has_value());
    const auto run = (*rows)->run(0, (*rows)->rows(), {});
    REQUIRE_FALSE(whole.has_value());
    REQUIRE_FALSE(run.has_value());
    CHECK(describe(run.error()) == describe(whole.error()));
}
