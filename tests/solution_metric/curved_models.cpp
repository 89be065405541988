// Models of curved elements contain only the error that the curvature of the element does not remove.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "dice.hpp"
#include "layers.hpp"
#include "property.hpp"
#include "restarts.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.solution_metric;

using namespace camber;
using namespace camber::testing;

namespace {

/// y ↦ y + c x² for the last coordinate. The map is quadratic, so elements of degree 2 represent it exactly.
template <int D>
Vec<D> bent(Vec<D> p, double c) {
    p[D - 1] += c * p[0] * p[0];
    return p;
}

/// u = f(y − c x²) with f = s³ depends on one reference coordinate. The members are its derivatives at a point.
template <int D>
struct Layer {
    double c = 0;
    [[nodiscard]] double s(const Vec<D>& p) const { return p[D - 1] - c * p[0] * p[0]; }
    [[nodiscard]] Vec<D> slope(const Vec<D>& p) const {
        Vec<D> g;
        g[D - 1] = 1;
        g[0] = -2 * c * p[0];
        return g;
    }
    /// From the derivatives f', f'' and f''' by s: H = f'' g gᵀ + f' s_ij, T = f''' g g g + f'' (s_ij g_k + …).
    [[nodiscard]] Sym<D> hessian(const Vec<D>& p, double f1, double f2) const {
        const Vec<D> g = slope(p);
        Sym<D> h;
        for (int i = 0; i < D; ++i)
            for (int j = 0; j <= i; ++j) h(i, j) = f2 * g[i] * g[j];
        h(0, 0) += -2 * c * f1;
        return h;
    }
    [[nodiscard]] CubicForm<D> third(const Vec<D>& p, double f2, double f3) const {
        const Vec<D> g = slope(p);
        const auto s_of = [&](int i, int j) { return i == 0 && j == 0 ? -2 * c : 0.0; };
        CubicForm<D> t;
        for (int i = 0; i < D; ++i)
            for (int j = 0; j <= i; ++j)
                for (int k = 0; k <= j; ++k)
                    t(i, j, k) =
                        f3 * g[i] * g[j] * g[k] + f2 * (s_of(i, j) * g[k] + s_of(j, k) * g[i] + s_of(k, i) * g[j]);
        return t;
    }
};

template <int D>
Vec<D> centroid(const QuadraticMesh<D>& mesh, std::size_t e) {
    Barycentric<D> xi;
    xi.fill(1.0 / (D + 1));
    return element_of(mesh, ElementId(e)).point(xi);
}

template <int D>
void check_layer() {
    constexpr double c = 0.4;
    const Layer<D> layer{c};
    const auto mesh = mapped(box_with_facets<D>(3, 5, 0.1), [](const Vec<D>& p) { return bent<D>(p, c); });
    Buffer<Vec<D>> gradients;
    Buffer<Sym<D>> hessians, of_s;
    Buffer<CubicForm<D>> thirds;
    for (std::size_t e = 0; e < mesh.linear.elements.size(); ++e) {
        const Vec<D> p = centroid(mesh, e);
        const double s = layer.s(p);
        gradients.push_back(layer.slope(p));
        of_s.push_back(layer.hessian(p, 1, 0));
        hessians.push_back(layer.hessian(p, 3 * s * s, 6 * s));
        thirds.push_back(layer.third(p, 6 * s, 6));
    }
    // u = s is linear on the reference elements, though its Hessian in space is not 0.
    const auto linear =
        must(curved_hessian_models(mesh, Column<Vec<D>>(gradients), Column<Sym<D>>(of_s), {}, one_thread));
    // u = s³: on the reference elements a form of one direction, |6 s_v³|^{2/3}.
    const auto cubic =
        must(curved_cubic_models(mesh, Column<Sym<D>>(hessians), Column<CubicForm<D>>(thirds), {}, one_thread));
    const auto straight = must(cubic_models(Column<CubicForm<D>>(thirds), {}, one_thread));
    std::size_t better = 0;
    for (std::size_t e = 0; e < mesh.linear.elements.size(); ++e) {
        const auto& zero = linear.rows[e];
        for (const double x : zero.logs.values.c) CHECK((zero.kind == ModelKind::zero || x < std::log(1e-12)));
        const auto system = cubic.rows[e].logs;
        const Vec<D> g = layer.slope(centroid(mesh, e));
        int top = 0;
        for (int i = 1; i < D; ++i)
            if (system.values[i] > system.values[top]) top = i;
        CHECK(system.values[top] == doctest::Approx(2.0 / 3 * std::log(6) + std::log(norm_squared(g))).epsilon(0.02));
        CHECK(std::abs(dot(system.vectors.column[top], normalised(g))) > 1 - 1e-6);
        CHECK(cubic.rows[e].kind == ModelKind::floored);
        better += log_det(system) < log_det(straight.rows[e].logs) - 1 ? 1 : 0;
    }
    CHECK(better > mesh.linear.elements.size() / 2);
}

template <int D>
void check_straight_elements() {
    property(
        "curved models of straight elements equal the models in space",
        [](std::uint64_t seed) {
            Dice dice(seed);
            auto mesh = must(elevate(box_with_facets<D>(1, seed + 1, 0.1), one_thread));
            const std::size_t n = mesh.linear.elements.size();
            const Buffer<Sym<D>> h(n, dice.symmetric<D>());
            CubicForm<D> t;
            for (double& x : t.c) x = dice.uniform(-1, 1);
            const Buffer<CubicForm<D>> thirds(n, t);
            const ModelOptions options{.max_anisotropy = 1e9};
            const auto curved = must(curved_hessian_models(mesh, Column<Vec<D>>(Buffer<Vec<D>>(n, dice.vector<D>())),
                                                           Column<Sym<D>>(h), options, one_thread));
            const auto plain = must(hessian_models(Column<Sym<D>>(h), options, one_thread));
            const auto curved_cubic =
                must(curved_cubic_models(mesh, Column<Sym<D>>(h), Column<CubicForm<D>>(thirds), options, one_thread));
            const auto plain_cubic = must(cubic_models(Column<CubicForm<D>>(thirds), options, one_thread));
            for (std::size_t e = 0; e < n; ++e) {
                // |H| is independent of coordinates only if H is definite.
                const auto eigen = eigen_system(h[e]).values.c;
                bool definite = true;
                for (const double x : eigen) definite = definite && x * eigen[0] > 0;
                if (definite) RC_ASSERT(norm(composed(curved.rows[e].logs) - composed(plain.rows[e].logs)) < 1e-6);
                RC_ASSERT(std::abs(log_det(curved_cubic.rows[e].logs) - log_det(plain_cubic.rows[e].logs)) < 0.1);
            }
        },
        {.count = 20});
}

}  // namespace

TEST_CASE("a layer that follows the elements gets a model of one direction") {
    check_layer<2>();
    check_layer<3>();
}
TEST_CASE("models of straight curved elements equal those in space") {
    check_straight_elements<2>();
    check_straight_elements<3>();
}
TEST_CASE("element_means returns the means of the vertex rows") {
    const auto mesh = box_with_facets<2>(2, 0, 0);
    Buffer<Vec<2>> rows(mesh.points.begin(), mesh.points.end());
    const auto means = must(element_means<Vec<2>, 2>(mesh, Column<Vec<2>>(std::move(rows)), one_thread));
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
        const auto p = corners(mesh, e);
        CHECK(distance(means[e], (p[0] + p[1] + p[2]) / 3) < 1e-15);
    }
}

TEST_CASE("element_means and curved_cubic_models reject rows of another mesh") {
    const auto mesh = box_with_facets<2>(2, 0, 0);
    CHECK(!element_means<Vec<2>, 2>(mesh, {}, one_thread));
    CHECK(!curved_cubic_models<2>(must(elevate(LinearMesh<2>(mesh), one_thread)), {}, {}, {}, one_thread));
}
