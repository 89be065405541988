// Order of nodal values: fields in the order of the nodes are plausible, permuted fields are detected.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "dice.hpp"
#include "fields.hpp"

import camber.core;
import camber.bezier;
import camber.recovery;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
struct FieldCase {
    std::string name;
    std::function<double(const Vec<D>&)> value;
    bool is_detectable = true;  ///< permutations can be detected
};

template <int D>
double wave(const Vec<D>& x, double length, bool is_product) {
    constexpr double turn = 6.283185307179586;
    if (!is_product) return std::sin(turn * (0.8 * x[0] + 0.6 * x[1]) / length + 0.7);
    double value = 1;
    for (int i = 0; i < D; ++i) value *= std::sin(turn * x[i] / length + 0.7);
    return value;
}

/// Fields on the unit square or cube with cells of size h.
template <int D>
std::vector<FieldCase<D>> fields(double h, Dice& dice) {
    const auto radius = [](const Vec<D>& x) { return norm(x); };
    std::vector<FieldCase<D>> all{
        {"smooth", [](const Vec<D>& x) { return std::sin(3 * x[0]) * std::exp(x[1]); }},
        {"linear", [](const Vec<D>& x) { return x[0] - 2 * x[1]; }},
        {"front", [=](const Vec<D>& x) { return std::tanh((radius(x) - 0.5) / 0.05); }},
        {"thin front", [=](const Vec<D>& x) { return std::tanh((radius(x) - 0.5) / 1e-5); }},
        {"crossing fronts",
         [](const Vec<D>& x) { return std::tanh((x[0] - x[1]) / 0.01) * std::tanh((x[0] + x[1] - 1) / 0.02); }},
        {"shock", [](const Vec<D>& x) { return x[0] + 0.3 * x[1] > 0.6 ? 1.0 : 0.0; }},
        {"corner", [=](const Vec<D>& x) { return std::pow(radius(x), 0.6); }},
        {"noisy", [&](const Vec<D>& x) { return std::sin(3 * x[0]) + 1e-6 * dice.uniform(-1, 1); }},
        {"noisy shock", [&](const Vec<D>& x) { return (x[0] > 0.6 ? 1.0 : 0.0) + 1e-6 * dice.uniform(-1, 1); }},
        {"noisy bump",
         [=, &dice](const Vec<D>& x) { return std::exp(-norm_squared(x) / (h * h)) + 1e-6 * dice.uniform(-1, 1); },
         false},
        {"noisy constant", [&](const Vec<D>&) { return 1 + 1e-6 * dice.uniform(-1, 1); }, false},
        {"constant", [](const Vec<D>&) { return 3.0; }, false},
        {"pole", [](const Vec<D>& x) { return 1 / (1e-6 + norm_squared(x)); }, false}};
    for (const double elements : {2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0})
        for (const bool is_product : {false, true})
            all.push_back({(is_product ? "product of waves of " : "wave of ") + std::to_string(elements),
                           [=](const Vec<D>& x) { return wave<D>(x, elements * h, is_product); },
                           elements > (is_product ? 6 : 5)});
    return all;
}

/// The unit square or cube.
template <int D>
QuadraticMesh<D> unit_mesh(int n, double jitter, double bend) {
    Frame<D> frame;
    const double h = 1.0 / n;
    for (double& c : frame.stretch.c) c = h;
    return bent_mesh<D>(cells_of<D>(n), 4, jitter, bend, frame);
}

void permute(Buffer<double>& values, std::size_t begin, Dice& dice) {
    for (std::size_t i = values.size(); i > begin + 1; --i)
        std::swap(values[i - 1],
                  values[begin + static_cast<std::size_t>(dice.uniform(0, 1) * static_cast<double>(i - begin))]);
}

/// Edge rows in the order of a solver that numbers edges element by element.
template <int D>
Buffer<double> by_first_element(const QuadraticMesh<D>& mesh, const Column<double>& u) {
    const std::size_t vertices = mesh.linear.points.size();
    Buffer<double> out(u.begin(), u.begin() + static_cast<std::ptrdiff_t>(vertices));
    std::vector<bool> is_named(mesh.edges.size());
    for (const auto& edges : mesh.edges.of_elements)
        for (const EdgeId e : edges) {
            if (!is_named[e.index()]) out.push_back(u[vertices + e.index()]);
            is_named[e.index()] = true;
        }
    return out;
}

template <int D>
NodeOrder order_of(const QuadraticMesh<D>& mesh, const Column<double>& values) {
    return must(check_node_order(mesh, values, one_thread)).order;
}

template <int D>
void check_fields(int n, double jitter) {
    Dice dice(7);
    const auto straight = unit_mesh<D>(n, jitter, 0);
    std::size_t detected = 0, all = 0;
    for (const auto& [name, value, is_detectable] : fields<D>(1.0 / n, dice)) {
        CAPTURE(name);
        for (const int degree : {1, 2}) {
            CAPTURE(degree);
            const auto u = values_of<D>(straight, degree, value);
            CHECK(order_of(straight, u) == NodeOrder::plausible);
            Buffer<double> any(u.begin(), u.end());
            permute(any, 0, dice);
            const NodeOrder found = order_of(straight, Column<double>(std::move(any)));
            // Detection is not certain: a field that the mesh does not resolve looks like a permuted one.
            CHECK((found == NodeOrder::plausible || found == NodeOrder::unrelated));
            if (!is_detectable) continue;
            ++all;
            detected += found == NodeOrder::unrelated ? 1 : 0;
            if (degree == 1) continue;
            Buffer<double> mid(u.begin(), u.end());
            permute(mid, straight.linear.points.size(), dice);
            CHECK(order_of(straight, Column<double>(std::move(mid))) == NodeOrder::unrelated_mid_nodes);
            CHECK(order_of(straight, Column<double>(by_first_element(straight, u))) == NodeOrder::by_first_element);
        }
    }
    CHECK(static_cast<double>(detected) >= 0.7 * static_cast<double>(all));
}

/// Correlations of edge nodes with edge ends where neighbouring vertices are correlated (above 0.3), and numbers of
/// verdicts.
struct Figures {
    double least_in_order = 1, largest_permuted = 0;
    std::size_t fields = 0, noted = 0, refused = 0, by_element = 0, false_alarms = 0;
};
template <int D>
void add_figures(int n, double jitter, Figures& figures) {
    Dice dice(11);
    const auto mesh = unit_mesh<D>(n, jitter, 0);
    for (const auto& [name, value, is_detectable] : fields<D>(1.0 / n, dice)) {
        const auto u = values_of<D>(mesh, 2, value);
        const auto check = [&](const Column<double>& values) {
            return must(check_node_order(mesh, values, one_thread));
        };
        const NodeOrderCheck in_order = check(u);
        Buffer<double> any(u.begin(), u.end()), mid(u.begin(), u.end());
        permute(any, 0, dice);
        permute(mid, mesh.linear.points.size(), dice);
        const NodeOrderCheck permuted = check(Column<double>(std::move(mid)));
        ++figures.fields;
        figures.false_alarms += in_order.order != NodeOrder::plausible ? 1 : 0;
        figures.noted += check(Column<double>(std::move(any))).order == NodeOrder::unrelated ? 1 : 0;
        figures.refused += permuted.order == NodeOrder::unrelated_mid_nodes ? 1 : 0;
        figures.by_element +=
            check(Column<double>(by_first_element(mesh, u))).order == NodeOrder::by_first_element ? 1 : 0;
        if (in_order.between_vertices < 0.3 || in_order.between_vertices == 1) continue;
        figures.least_in_order = std::min(figures.least_in_order, in_order.between_ends_and_middle);
        figures.largest_permuted = std::max(figures.largest_permuted, std::abs(permuted.between_ends_and_middle));
    }
}

}  // namespace

TEST_CASE("check_node_order accepts ordered fields and detects permuted ones") {
    SUBCASE("2D, regular") { check_fields<2>(20, 0); }
    SUBCASE("2D, irregular") { check_fields<2>(24, 0.25); }
    SUBCASE("3D, regular") { check_fields<3>(8, 0); }
    SUBCASE("3D, irregular") { check_fields<3>(9, 0.2); }
}

TEST_CASE("the node order check does not depend on the unit or offset of a field") {
    const auto mesh = unit_mesh<2>(16, 0.2, 0.05);
    Dice dice(3);
    const auto u = values_of<2>(mesh, 2, [](const Vec<2>& x) { return std::sin(3 * x[0]) * std::exp(x[1]); });
    for (const double unit : {1e-200, 1.0, -1e200})
        for (const double offset : {0.0, 100.0}) {
            Buffer<double> ordered, permuted;
            for (const double x : u) ordered.push_back(unit * (x + offset));
            permuted = ordered;
            permute(permuted, mesh.linear.points.size(), dice);
            CHECK(order_of(mesh, Column<double>(std::move(ordered))) == NodeOrder::plausible);
            CHECK(order_of(mesh, Column<double>(std::move(permuted))) == NodeOrder::unrelated_mid_nodes);
        }
}

TEST_CASE("check_node_order returns plausible for small meshes") {
    const auto mesh = unit_mesh<2>(2, 0, 0);
    Dice dice(3);
    Buffer<double> values;
    for (std::size_t i = 0; i < mesh.linear.points.size() + mesh.edges.size(); ++i)
        values.push_back(dice.uniform(0, 1));
    CHECK(order_of(mesh, Column<double>(values)) == NodeOrder::plausible);
}

TEST_CASE("check_node_order rejects a number of values that does not fit the mesh") {
    const auto mesh = unit_mesh<2>(2, 0, 0);
    Dice dice(3);
    Buffer<double> values;
    for (std::size_t i = 0; i <= mesh.linear.points.size() + mesh.edges.size(); ++i)
        values.push_back(dice.uniform(0, 1));
    CHECK(!check_node_order(mesh, Column<double>(values), one_thread));
}

TEST_CASE("figures of fields and their permutations are printed" * doctest::skip()) {
    Figures figures;
    add_figures<2>(20, 0, figures);
    add_figures<2>(24, 0.25, figures);
    add_figures<2>(40, 0.25, figures);
    add_figures<3>(8, 0, figures);
    add_figures<3>(10, 0.2, figures);
    MESSAGE("fields ", figures.fields, ", false alarms ", figures.false_alarms, "; noted ", figures.noted, ", refused ",
            figures.refused, ", by element ", figures.by_element, "; correlation in order at least ",
            figures.least_in_order, ", permuted at most ", figures.largest_permuted);
}
