// Materials: derivatives are one-sided, stencils do not cross interfaces, and rows exist by vertex and material.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <set>
#include <utility>

#include "fields.hpp"
#include "property.hpp"

import camber.core;
import camber.recovery;

using namespace camber;
using namespace camber::testing;

namespace {

/// A lattice of two materials, 1 below and 2 above the plane x_0 = cells/2.
template <int D>
QuadraticMesh<D> layered(int cells, std::uint64_t seed) {
    LatticeOptions<D> options;
    options.cells.fill(cells);
    options.jitter = 0.1;
    options.seed = seed;
    options.place = [](const Vec<D>& p) { return p; };
    auto linear = lattice_mesh<D>(options);
    const double middle = cells / 2;
    auto points = take(std::move(linear.points));
    for (auto& p : points)
        if (std::abs(p[0] - middle) < 0.2) p[0] = middle;
    Buffer<Reference> materials(linear.elements.size());
    for (std::size_t e = 0; e < materials.size(); ++e) {
        double centre = 0;
        for (const VertexId v : linear.elements.vertices[e]) centre += points[v.index()][0] / (D + 1);
        materials[e] = centre < middle ? 1 : 2;
    }
    linear.points = std::move(points);
    linear.elements.references = std::move(materials);
    return must(elevate(std::move(linear), one_thread));
}

template <int D>
void check_sides() {
    property("each side of an interface has exactly its own polynomial",
             [](std::uint64_t seed) {
                 const int cells = 8;
                 const auto mesh = layered<D>(D == 2 ? cells : 6, seed);
                 const double middle = D == 2 ? 4 : 3;
                 Dice dice(seed);
                 const RandomPolynomial<D> p(4, dice), q(3, dice);
                 // Continuous with a kink in the plane: p below, p + (x_0 − middle) q above.
                 const auto above = [&](const Vec<D>& x, std::initializer_list<int> axes = {}) {
                     double value = p(x, axes) + (x[0] - middle) * q(x, axes);
                     // Leibniz rule: each derivative by x_0 applies to the factor once.
                     for (auto it = axes.begin(); it != axes.end(); ++it) {
                         if (*it != 0) continue;
                         std::array<int, 3> others{};
                         std::size_t n = 0;
                         for (auto other = axes.begin(); other != axes.end(); ++other)
                             if (other != it) others[n++] = *other;
                         value += n == 0 ? q(x) : n == 1 ? q(x, {others[0]}) : q(x, {others[0], others[1]});
                     }
                     return value;
                 };
                 const auto out = recovered<D>(
                     mesh, {values_of<D>(mesh, 2, [&](const Vec<D>& x) { return x[0] <= middle ? p(x) : above(x); })});
                 RC_ASSERT(out.lower_degree == 0U);
                 const auto around = must(balls(mesh.linear, one_thread));
                 const auto boundary = must(boundary_rows(mesh.linear, around, out.rows, one_thread));
                 for (std::size_t v = 0; v < mesh.linear.points.size(); ++v)
                     for (std::size_t r = out.rows.first(VertexId(v)); r < out.rows.materials.offsets[v + 1]; ++r) {
                         // Rows at the interface average inner fits of their material, like other boundary rows.
                         RC_ASSERT((out.sources[r] == RowSource::inner_fits) == (boundary[r] == 1));
                         if (mesh.linear.points[v][0] == middle) RC_ASSERT(boundary[r] == 1);
                     }
                 const auto u = values_of<D>(
                     mesh, 2, [&](const Vec<D>& x) { return std::max(std::abs(p(x)), std::abs(above(x))); });
                 const double largest = *std::max_element(u.begin(), u.end());
                 for (std::size_t e = 0; e < mesh.linear.elements.size(); ++e)
                     for (int i = 0; i <= D; ++i) {
                         const std::size_t row = row_of(out.rows, mesh.linear, ElementId(e), i);
                         const Vec<D>& x = mesh.linear.points[mesh.linear.elements.vertices[e][i]];
                         const double error = mesh.linear.elements.references[e] == 1
                                                  ? error_at<D>(out.fields[0], row, {}, x, p)
                                                  : error_at<D>(out.fields[0], row, {}, x, above);
                         RC_ASSERT(error < 1e-10 * largest);
                     }
             },
             {.count = D == 2 ? 10 : 3});
}

/// Values beyond the interface have no effect.
template <int D>
void check_no_crossing() {
    const auto mesh = layered<D>(D == 2 ? 8 : 6, 3);
    const double middle = D == 2 ? 4 : 3;
    Dice dice(1);
    const auto noise = values_of<D>(mesh, 2, [&](const Vec<D>&) { return dice.uniform(-1, 1); });
    const auto u = [](const Vec<D>& x) { return std::sin(x[0] + 0.3 * x[1]); };
    const auto plain = values_of<D>(mesh, 2, u);
    Buffer<double> mixed(plain.begin(), plain.end());
    const std::size_t vertices = mesh.linear.points.size();
    for (std::size_t n = 0; n < mixed.size(); ++n) {
        const Vec<D>& x = n < vertices ? mesh.linear.points[n] : mesh.mid_nodes[n - vertices].point;
        if (x[0] > middle) mixed[n] = noise[n];
    }
    const auto out = recovered<D>(mesh, {plain, Column<double>(std::move(mixed))});
    bool equal = true, differs = false;
    for (std::size_t v = 0; v < vertices; ++v)
        for (std::size_t r = out.rows.first(VertexId(v)); r < out.rows.materials.offsets[v + 1]; ++r) {
            const bool same = out.fields[0].thirds[r] == out.fields[1].thirds[r];
            (out.rows.materials.items[r] == 1 ? equal : differs) =
                out.rows.materials.items[r] == 1 ? equal && same : differs || !same;
        }
    CHECK(equal);
    CHECK(differs);
}

}  // namespace

TEST_CASE("derivatives at a material interface are one-sided, 2D") { check_sides<2>(); }
TEST_CASE("derivatives at a material interface are one-sided, 3D") { check_sides<3>(); }
TEST_CASE("stencils do not cross a material interface") {
    check_no_crossing<2>();
    check_no_crossing<3>();
}

TEST_CASE("each vertex has one row for each reference of its elements") {
    property(
        "each vertex has the references of its elements once, in increasing order",
        [](std::uint64_t seed) {
            Dice dice(seed);
            auto mesh = lattice_mesh<2>({.cells = {4, 3}, .seed = seed});
            Buffer<Reference> materials(mesh.elements.size());
            for (Reference& m : materials) m = static_cast<Reference>(dice.below(4)) - 2;
            mesh.elements.references = std::move(materials);
            const auto around = must(balls(mesh, one_thread));
            const auto rows = must(material_rows(mesh, around, one_thread));
            RC_ASSERT(rows.vertices() == mesh.points.size());
            std::size_t count = 0;
            for (std::size_t v = 0; v < mesh.points.size(); ++v) {
                std::set<Reference> expected;
                for (const ElementId e : around[VertexId(v)]) expected.insert(mesh.elements.references[e]);
                const auto found = rows.materials[VertexId(v)];
                RC_ASSERT(std::equal(found.begin(), found.end(), expected.begin(), expected.end()));
                RC_ASSERT(rows.first(VertexId(v)) == count);
                RC_ASSERT(!rows.row(VertexId(v), 7).has_value());
                count += expected.size();
            }
            RC_ASSERT(rows.size() == count);
            for (std::size_t e = 0; e < mesh.elements.size(); ++e)
                for (int i = 0; i < 3; ++i)
                    RC_ASSERT(rows.materials.items[row_of(rows, mesh, ElementId(e), i)] == mesh.elements.references[e]);
        },
        {.count = 20});
}
