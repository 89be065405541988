// The surface metric of paper §4.1.
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "dice.hpp"
#include "meshes.hpp"
#include "property.hpp"

import camber.core;
import camber.metric;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
VertexNormals<D> normals_of(const std::vector<std::vector<Vec<D>>>& rows) {
    Buffer<std::uint32_t> offsets{0};
    Buffer<Vec<D>> items;
    for (const auto& row : rows) {
        items.insert(items.end(), row.begin(), row.end());
        offsets.push_back(static_cast<std::uint32_t>(items.size()));
    }
    return {Column<std::uint32_t>(std::move(offsets)), Column<Vec<D>>(std::move(items))};
}

template <int D>
void check_surface_metric() {
    property("sizes are small along each normal, large across, isotropic without a normal", [](std::uint64_t seed) {
        Dice dice(seed);
        const double tangent = dice.uniform(0.1, 2);
        const double normal = tangent / dice.uniform(1, 1000);
        const double volume = dice.uniform(0.1, 2);
        const Vec<D> n = dice.direction<D>();
        const Vec<D> m = dice.direction<D>();
        const auto logs = must(surface_log_metrics<D>(normals_of<D>({{}, {n}, {-n}, {n, m}, {m, n}, {Vec<D>{}}}),
                                                      {tangent, normal, volume}, one_thread));
        const auto size = [&](std::size_t v, const Vec<D>& d) {
            return 1 / std::sqrt(SpectralMetric<D>(logs[v]).length_squared(d));
        };
        const Vec<D> any = dice.direction<D>();
        RC_ASSERT(std::abs(size(0, any) / volume - 1) < 1e-12);
        RC_ASSERT(std::abs(size(5, any) / volume - 1) < 1e-12);
        RC_ASSERT(std::abs(size(1, n) / normal - 1) < 1e-9);
        const Vec<D> across = normalised(any - dot(any, n) * n);
        RC_ASSERT(std::abs(size(1, across) / tangent - 1) < 1e-9);
        RC_ASSERT(norm(logs[1].l - logs[2].l) < 1e-12);
        RC_ASSERT(size(3, n) <= normal * (1 + 1e-9));
        RC_ASSERT(size(3, m) <= normal * (1 + 1e-9));
        RC_ASSERT(norm(logs[3].l - logs[4].l) < 1e-9);
    });
}

}  // namespace

TEST_CASE("the surface metric is thin along each normal and wide across it") {
    check_surface_metric<2>();
    check_surface_metric<3>();
}

TEST_CASE("the surface metric of a box is thin in two directions at edges, three at corners") {
    const Vec<3> x{{1, 0, 0}}, y{{0, 1, 0}}, z{{0, 0, 1}};
    const auto logs = must(surface_log_metrics<3>(normals_of<3>({{x, y}, {x, y, z}, {}}), {1, 0.1, {}}, one_thread));
    CHECK(norm(logs[0].l - log_metric_of_sizes(Vec<3>{{0.1, 0.1, 1}}).l) < 1e-12);
    CHECK(norm(logs[1].l - log_metric_of_sizes(Vec<3>{{0.1, 0.1, 0.1}}).l) < 1e-12);
    CHECK(norm(logs[2].l) < 1e-12);
}

TEST_CASE("the surface metric rejects non-positive sizes") {
    const auto normals = normals_of<2>({{}});
    CHECK(surface_log_metrics<2>(normals, {0, 0.1, {}}, one_thread).error().kind == ErrorKind::usage);
    CHECK(surface_log_metrics<2>(normals, {1, -1, {}}, one_thread).error().kind == ErrorKind::usage);
    CHECK(surface_log_metrics<2>(normals, {1, 0.1, 0.0}, one_thread).error().kind == ErrorKind::usage);
}
