// Patches without free nodes: their integral defects are distributed over other patches.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <utility>
#include <vector>

#include "dice.hpp"
#include "fields.hpp"
#include "meshes.hpp"

import camber.core;
import camber.bezier;
import camber.transfer;

using namespace camber;
using namespace camber::testing;

namespace {

constexpr TransferOptions conserving{.method = TransferMethod::conserve};

/// A bar of 15 × 3 (× 3) cells of side 1/3, along x from 0 to 5.
template <int D>
LinearMesh<D> bar(const std::function<Vec<D>(const Vec<D>&)>& move) {
    LatticeOptions<D> options;
    options.cells.fill(3);
    options.cells[0] = 15;
    options.place = [&](const Vec<D>& p) { return move(p) / 3; };
    return lattice_mesh(options);
}

/// Swaps the diagonal of the square at z = 0 of a cell along the bar. Two elements change, and no vertex belongs only
/// to them.
template <int D>
LinearMesh<D> swapped(const LinearMesh<D>& mesh, int cell) {
    const auto corner = [&](double x, double y) {
        Vec<D> p;
        p[0] = (cell + x) / 3;
        p[1] = (1 + y) / 3;
        return VertexId(node_at(quadratic(LinearMesh<D>(mesh)), p));
    };
    const VertexId o = corner(0, 0), a = corner(1, 0), b = corner(0, 1), across = corner(1, 1);
    auto elements = take(Column<SimplexVertices<D>>(mesh.elements.vertices));
    std::size_t changed = 0;
    for (auto& element : elements) {
        const auto has = [&](VertexId v) { return std::ranges::find(element, v) != element.end(); };
        if (!has(o) || !has(across) || (!has(a) && !has(b))) continue;
        ++changed;
        if (has(a))
            std::ranges::replace(element, across, b);
        else
            std::ranges::replace(element, o, a);
    }
    CHECK(changed == 2);
    auto out = mesh_of<D>(Buffer<Vec<D>>(mesh.points.begin(), mesh.points.end()), std::move(elements));
    out.elements.references = mesh.elements.references;
    return out;
}

/// True for the lattice coordinates of the inner vertex at x, which may move.
template <int D>
bool is_inner_at(const Vec<D>& p, double x) {
    bool is_inner = p[0] == x;
    for (int i = 1; i < D; ++i) is_inner = is_inner && p[i] == 1;
    return is_inner;
}

/// Sets references by thirds of the bar.
template <int D>
LinearMesh<D> painted(LinearMesh<D> mesh, const std::array<Reference, 3>& references) {
    Buffer<Reference> of(mesh.elements.size());
    for (std::size_t e = 0; e < of.size(); ++e) {
        double x = 0;
        for (const Vec<D>& p : corners(mesh, e)) x += p[0] / (D + 1);
        of[e] = references[x < 5.0 / 3 ? 0 : x < 10.0 / 3 ? 1 : 2];
    }
    mesh.elements.references = std::move(of);
    return mesh;
}

/// The largest change of an integral.
inline double worst_defect(const Transferred& out, std::size_t field) {
    double worst = 0;
    for (const MaterialIntegrals& row : out.statistics.integrals[field])
        for (std::size_t c = 0; c < row.before.size(); ++c)
            worst = std::max(worst, std::abs(row.after[c] - row.before[c]));
    return worst;
}

/// All nodes but those that `is_free` selects keep their bits.
template <int D>
void check_bits(const QuadraticMesh<D>& to, const TransferField& before, const TransferField& after,
                const std::function<bool(const Vec<D>&)>& is_free) {
    for (std::size_t n = 0; n < node_count_of(to, 1); ++n)
        for (int c = 0; c < before.components; ++c) {
            const std::size_t i = n * static_cast<std::size_t>(before.components) + static_cast<std::size_t>(c);
            if (!is_free(to.linear.points[VertexId(n)])) CHECK(after.values[i] == before.values[i]);
        }
}

template <int D>
Vec<D> moved_at(const Vec<D>& p, std::initializer_list<double> where, int axis) {
    Vec<D> x = p;
    for (const double at : where)
        if (is_inner_at<D>(p, at)) x[axis] += 0.15;
    return x;
}

/// One swap and two moved vertices. The integral defect of the swap is distributed over the moved vertices.
template <int D>
void check_distribution() {
    const auto initial = bar<D>([](const Vec<D>& p) { return p; });
    const auto with = [&](std::initializer_list<double> where) {
        return bar<D>([&](const Vec<D>& p) { return moved_at<D>(p, where, 0); });
    };
    SUBCASE("the integral defect is distributed over the other patches of a single material") {
        Dice dice(1);
        const auto from = quadratic(LinearMesh<D>(initial)), to = quadratic(swapped(with({6, 12}), 2));
        const std::vector fields{rough_field(node_count_of(from, 1), 1, 2, dice),
                                 rough_field(node_count_of(from, 2), 2, 1, dice)};
        const auto out = transferred<D>(from, fields, to, conserving);
        CHECK(out.statistics.patches == 3);  // one swap and two moved vertices
        CHECK(out.statistics.spread == 1);
        CHECK(out.statistics.unconserved_materials == 0);
        CHECK(worst_defect(out, 0) < 1e-13);
        CHECK(worst_defect(out, 1) < 1e-13);
        check_bits<D>(to, fields[0], out.fields[0],
                      [](const Vec<D>& p) { return std::abs(p[0] - 2.05) < 1e-9 || std::abs(p[0] - 4.05) < 1e-9; });
        // Both moved vertices take a part of the defect.
        const auto without_swap =
            transferred<D>(quadratic(LinearMesh<D>(initial)), fields, quadratic(with({6, 12})), conserving);
        std::size_t differ = 0;
        for (std::size_t n = 0; n < node_count_of(to, 1); ++n)
            differ += out.fields[0].values[2 * n] != without_swap.fields[0].values[2 * n] ? 1 : 0;
        CHECK(differ == 2);
        CHECK(transferred<D>(from, fields, to, conserving, 3).fields == out.fields);
    }
    SUBCASE("each material conserves its integral, and a material without free nodes is counted") {
        Dice dice(2);
        const std::array<Reference, 3> thirds{1, 2, 3};
        const auto from = quadratic(painted(initial, thirds));
        const auto to = quadratic(painted(swapped(swapped(swapped(with({3, 8}), 0), 6), 12), thirds));
        const std::vector fields{rough_field(node_count_of(from, 1), 1, 1, dice)};
        const auto out = transferred<D>(from, fields, to, conserving);
        CHECK(out.statistics.patches == 5);  // three swaps and two moved vertices
        CHECK(out.statistics.spread == 3);
        CHECK(out.statistics.unconserved_materials == 1);
        const auto& rows = out.statistics.integrals[0];
        REQUIRE(rows.size() == 3);
        CHECK(std::abs(rows[0].after[0] - rows[0].before[0]) < 1e-13);
        CHECK(std::abs(rows[1].after[0] - rows[1].before[0]) < 1e-13);
        CHECK(std::abs(rows[2].after[0] - rows[2].before[0]) > 1e-4);
    }
    SUBCASE("a node shared by two materials corrects only one of them") {
        Dice dice(3);
        const std::array<Reference, 3> thirds{1, 2, 3};
        const auto from = quadratic(painted(initial, thirds));
        // The middle vertex moves within the wall between the first two materials. Each material has another free node.
        const auto to = quadratic(
            painted(bar<D>([](const Vec<D>& p) { return moved_at<D>(moved_at<D>(p, {2, 8}, 0), {5}, 1); }), thirds));
        const std::vector fields{rough_field(node_count_of(from, 1), 1, 1, dice)};
        const auto out = transferred<D>(from, fields, to, conserving);
        CHECK(out.statistics.patches == 3);
        CHECK(out.statistics.spread == 2);
        CHECK(out.statistics.unconserved_materials == 0);
        CHECK(worst_defect(out, 0) < 1e-13);
    }
    SUBCASE("limited values distribute the integral defect") {
        Dice dice(4);
        const auto from = quadratic(LinearMesh<D>(initial)), to = quadratic(swapped(with({6, 12}), 2));
        const std::vector fields{field_of<D>(from, 1, {[](const Vec<D>& x) { return x[0] * x[1]; }})};
        auto options = conserving;
        options.bounds = TransferBounds::local;
        const auto out = transferred<D>(from, fields, to, options);
        CHECK(out.statistics.spread == 1);
        CHECK(worst_defect(out, 0) < 1e-13);
    }
}

}  // namespace

TEST_CASE("integral defects of patches without free nodes are distributed, 2D") { check_distribution<2>(); }
TEST_CASE("integral defects of patches without free nodes are distributed, 3D") { check_distribution<3>(); }
