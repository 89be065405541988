#include "mesh_checks.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <set>
#include <stop_token>
#include <type_traits>

#include "property.hpp"

using namespace camber;
using namespace camber::testing;

TEST_CASE("a box is a valid mesh for any size, cut and jitter") {
    property("box 2D", [] {
        const BoxOptions<2> options{.cells = {*rc::gen::inRange(1, 7), *rc::gen::inRange(1, 7)},
                                    .jitter = 0.1 * *rc::gen::inRange(0, 6),
                                    .seed = *rc::gen::arbitrary<std::uint64_t>()};
        const auto mesh = generate(options);
        RC_ASSERT(mesh.has_value());
        check_valid_mesh(*mesh, 1, {1, 2, 3, 4});
        RC_ASSERT(mesh->corners.size() == 4U);
        RC_ASSERT(std::abs(total_volume(*mesh) - 1) < 1e-12);
    });
    property("box 3D",
             [] {
                 const BoxOptions<3> options{
                     .cells = {*rc::gen::inRange(1, 5), *rc::gen::inRange(1, 5), *rc::gen::inRange(1, 5)},
                     .jitter = 0.1 * *rc::gen::inRange(0, 6),
                     .seed = *rc::gen::arbitrary<std::uint64_t>()};
                 const auto mesh = generate(options);
                 RC_ASSERT(mesh.has_value());
                 check_valid_mesh(*mesh, 1, {1, 2, 3, 4, 5, 6});
                 RC_ASSERT(mesh->corners.size() == 8U);
                 const auto& n = options.cells;
                 RC_ASSERT(mesh->edges.size() == static_cast<std::size_t>(4 * (n[0] + n[1] + n[2])));
                 RC_ASSERT(mesh->ridges.size() == mesh->edges.size());
                 RC_ASSERT(std::abs(total_volume(*mesh) - 1) < 1e-12);
             },
             {.count = 30});
}

TEST_CASE("the sides of a box are planes to the last bit") {
    const auto mesh = generate(BoxOptions<3>{.low = {{-0.1, 0.3, 7}}, .high = {{0.7, 1.9, 7.7}}, .cells = {3, 5, 7}});
    REQUIRE(mesh.has_value());
    const double sides[] = {-0.1, 0.7, 0.3, 1.9, 7, 7.7};
    for (std::size_t f = 0; f < mesh->facets.size(); ++f) {
        const int side = mesh->facets.references[f] - 1;
        for (const VertexId v : mesh->facets.vertices[f]) CHECK(mesh->points[v][side / 2] == sides[side]);
    }
}

TEST_CASE("a graded and warped box is a valid mesh and keeps its sides") {
    const auto mapped = [](auto options) {
        constexpr int D = sizeof options.cells / sizeof(int);
        for (int i = 0; i < D; ++i) {
            options.cells[i] = *rc::gen::inRange(1, D == 2 ? 9 : 5);
            options.grading[i] = std::pow(10.0, 0.1 * *rc::gen::inRange(-20, 21));
            options.high[i] = *rc::gen::inRange(1, 9);
        }
        options.warp = 0.005 * *rc::gen::inRange(-10, 11);
        options.jitter = 0.1 * *rc::gen::inRange(0, 6);
        const auto mesh = generate(options);
        RC_ASSERT(mesh.has_value());
        double box = 1;
        for (int i = 0; i < D; ++i) box *= options.high[i];
        check_valid_mesh(*mesh, 1, D == 2 ? std::set<Reference>{1, 2, 3, 4} : std::set<Reference>{1, 2, 3, 4, 5, 6});
        RC_ASSERT(std::abs(total_volume(*mesh) / box - 1) < 1e-12);
    };
    property("mapped 2D", [&] { mapped(BoxOptions<2>{}); });
    property("mapped 3D", [&] { mapped(BoxOptions<3>{}); }, {.count = 30});
}

TEST_CASE("cell sizes are a geometric series with the requested ratio") {
    const auto mesh = generate(BoxOptions<2>{.cells = {4, 1}, .grading = {27, 1}, .jitter = 0});
    REQUIRE(mesh.has_value());
    for (int k = 0; k <= 4; ++k) CHECK(mesh->points[k][0] == doctest::Approx((std::pow(3, k) - 1) / 80));
}

TEST_CASE("a shell is a valid mesh with and without layers") {
    for (const auto structure : {ShellStructure::unstructured, ShellStructure::prisms})
        for (const int layers : {0, 3})
            for (const std::uint64_t seed : {1, 2}) {
                CAPTURE(static_cast<int>(structure));
                CAPTURE(layers);
                ShellOptions<3> options{.centre = {{0.5, -1, 2}}, .inner_size = 0.8, .outer_size = 2};
                options.structure = structure;
                options.seed = seed;
                options.inner_layer.count = layers;
                options.outer_layer = {.count = layers / 2, .first_height = 0.05, .growth = 1.3};
                const auto mesh = generate(options);
                REQUIRE(mesh.has_value());
                check_valid_mesh(*mesh, 2, {1, 2});
                check_on_sphere(*mesh, 1, options.centre, options.outer_radius);
                check_on_sphere(*mesh, 2, options.centre, options.inner_radius);
                CHECK(mesh->edges.size() == 0);
                CHECK(mesh->corners.empty());
            }
}

TEST_CASE("an unstructured shell has no flat elements and the sizes of the paper's cases") {
    const auto worst = [](const LinearMesh<3>& mesh) {
        double least = 1;
        const auto& p = mesh.points;
        for (const auto& [a, b, c, d] : mesh.elements.vertices)
            least = std::min(least, quality(p[a], p[b], p[c], p[d]));
        return least;
    };
    const auto coarse = generate(ShellOptions<3>{.inner_size = 0.9, .outer_size = 2.0});
    REQUIRE(coarse.has_value());
    CHECK(worst(*coarse) > 0.1);
    CHECK(coarse->points.size() == doctest::Approx(270).epsilon(0.15));
    const auto fine = generate(ShellOptions<3>{.inner_size = 0.55, .outer_size = 0.65});
    REQUIRE(fine.has_value());
    CHECK(worst(*fine) > 0.1);
    CHECK(fine->elements.size() == doctest::Approx(18517).epsilon(0.15));
}

TEST_CASE("layers have the requested heights") {
    const BoundaryLayer layer{.count = 4, .first_height = 0.02, .growth = 1.5};
    const auto mesh = generate(ShellOptions<3>{.inner_size = 0.8, .outer_size = 2, .inner_layer = layer});
    REQUIRE(mesh.has_value());
    std::set<long> radii;  // in 1e-9
    for (const Vec<3>& p : mesh->points)
        if (norm(p) < 1 + thickness(layer) + 1e-9) radii.insert(std::lround(norm(p) * 1e9));
    CHECK(radii == std::set<long>{1000000000, 1020000000, 1050000000, 1095000000, 1162500000});
}

TEST_CASE("an annulus is a valid mesh with and without layers") {
    for (const auto structure : {ShellStructure::unstructured, ShellStructure::prisms})
        for (const int layers : {0, 5}) {
            ShellOptions<2> options{.inner_size = 0.3, .outer_size = 0.6};
            options.structure = structure;
            options.inner_layer.count = options.outer_layer.count = layers;
            const auto mesh = generate(options);
            REQUIRE(mesh.has_value());
            check_valid_mesh(*mesh, 0, {1, 2});
            check_on_sphere(*mesh, 1, {}, 5.0);
            check_on_sphere(*mesh, 2, {}, 1.0);
        }
}

TEST_CASE("a channel is a valid mesh and its floor is the bump") {
    for (const int layers : {0, 6}) {
        BumpOptions options;
        options.floor_layer.count = layers;
        const auto mesh = generate(options);
        REQUIRE(mesh.has_value());
        check_valid_mesh(*mesh, 1, {1, 2, 3, 4});
        CHECK(mesh->corners.size() == 4);
        for (std::size_t f = 0; f < mesh->facets.size(); ++f)
            for (const VertexId v : mesh->facets.vertices[f]) {
                const Vec<2>& p = mesh->points[v];
                if (mesh->facets.references[f] == 3) CHECK(p[1] == floor_height(options, p[0]));
                if (mesh->facets.references[f] == 4) CHECK(p[1] == options.height);
            }
    }
}

TEST_CASE("layers of another material have their own elements and interface facets") {
    ShellOptions<3> shell{.inner_size = 0.8, .outer_size = 2};
    shell.inner_layer = {.count = 2, .first_height = 0.1, .growth = 1.5, .material = 2, .interface = 7};
    shell.outer_layer = {.count = 1, .first_height = 0.2, .growth = 1, .material = 3, .interface = 8};
    const auto mesh = generate(shell);
    REQUIRE(mesh.has_value());
    check_on_sphere(*mesh, 7, {}, 1 + thickness(shell.inner_layer));
    check_on_sphere(*mesh, 8, {}, 5 - thickness(shell.outer_layer));
    std::map<Reference, std::size_t> facets, elements;
    for (const Reference r : mesh->facets.references) ++facets[r];
    for (const Reference r : mesh->elements.references) ++elements[r];
    CHECK(facets[7] == facets[2]);
    CHECK(facets[8] == facets[1]);
    CHECK(elements[2] == 2 * 3 * facets[2]);
    CHECK(elements[3] == 3 * facets[1]);

    BumpOptions bump;
    bump.floor_layer.count = 3;
    bump.floor_layer.material = 5;
    const auto channel = generate(bump);
    REQUIRE(channel.has_value());
    CHECK(std::ranges::count(channel->facets.references, bump.floor_layer.interface) == bump.cells[0]);
    CHECK(std::ranges::count(channel->elements.references, 5) == 2 * 3 * bump.cells[0]);
}

TEST_CASE("the same options give the same mesh, another seed gives another mesh") {
    const auto same = [](auto options) {
        const auto first = generate(options), second = generate(options);
        options.seed += 1;
        const auto other = generate(options);
        REQUIRE(first.has_value());
        REQUIRE(other.has_value());
        CHECK(*first == *second);
        CHECK_FALSE(*first == *other);
    };
    same(BoxOptions<2>{});
    same(BoxOptions<3>{});
    same(BumpOptions{});
    same(ShellOptions<2>{.inner_size = 0.3, .outer_size = 0.6});
    same(ShellOptions<3>{.inner_size = 0.8, .outer_size = 2});
}

namespace {

/// Calls f with small shapes of every kind, with layers and interfaces.
template <class F>
void each_kind(F&& f) {
    const BoundaryLayer layer{.count = 3, .first_height = 0.01, .growth = 1.5, .material = 2};
    for (const auto structure : {ShellStructure::unstructured, ShellStructure::prisms}) {
        f(ShellOptions<2>{.inner_size = 0.3, .outer_size = 0.6, .inner_layer = layer, .structure = structure});
        f(ShellOptions<3>{.centre = {{1, 2, 3}},
                          .inner_size = 0.7,
                          .outer_size = 2,
                          .inner_layer = layer,
                          .outer_layer = {.count = 2, .material = 4},
                          .structure = structure});
    }
    f(BoxOptions<2>{.cells = {30, 40}, .jitter = 0.5});
    f(BoxOptions<3>{.cells = {9, 7, 8}, .warp = 0.05, .jitter = 0.5});
    f(BumpOptions{.cells = {40, 10}, .floor_layer = layer, .jitter = 0.5});
}

}  // namespace

TEST_CASE("generated meshes do not depend on the number of threads") {
    each_kind([](const auto& options) {
        const auto one = generate(options, Execution{.threads = 1});
        REQUIRE(one.has_value());
        for (const int threads : {2, 3}) CHECK(*generate(options, Execution{.threads = threads}) == *one);
    });
}

TEST_CASE("bounded_mesh finds the same facets without a selection of vertices") {
    each_kind([]<class Options>(const Options& options) {
        const auto mesh = generate(options);
        REQUIRE(mesh.has_value());
        constexpr int D = std::remove_cvref_t<decltype(*mesh)>::dimension;
        std::map<SimplexVertices<D - 1>, Reference> references;
        for (std::size_t f = 0; f < mesh->facets.size(); ++f)
            references[mesh->facets.vertices[f]] = mesh->facets.references[f];
        const auto again =
            bounded_mesh<D>(take(mesh->points), take(mesh->elements.vertices), take(mesh->elements.references),
                            [&](const SimplexVertices<D - 1>& facet) { return references.at(facet); });
        REQUIRE(again.has_value());
        CHECK(*again == *mesh);
    });
}

TEST_CASE("expected_elements predicts the number of elements") {
    each_kind([]<class Options>(const Options& options) {
        const auto mesh = generate(options);
        REQUIRE(mesh.has_value());
        const auto count = static_cast<double>(mesh->elements.size());
        bool exact = true;
        if constexpr (requires { options.structure; }) exact = options.structure == ShellStructure::prisms;
        if (exact)
            CHECK(expected_elements(options) == count);
        else
            CHECK(expected_elements(options) == doctest::Approx(count).epsilon(0.2));
    });
}

TEST_CASE("with_elements meets the requested number of elements within 20 %") {
    property("the expected number of elements is within 20 % of the request", [] {
        const double count = std::pow(10, 0.01 * *rc::gen::inRange(350, 900));
        const auto near = [&](const auto& options, double requested) {
            const double off = std::log(expected_elements(with_elements(options, requested)) / requested);
            RC_ASSERT(std::abs(off) < std::log(1.2));
        };
        near(BoxOptions<2>{}, count);
        near(BoxOptions<3>{.cells = {*rc::gen::inRange(1, 9), 3, 2}}, count);
        near(BumpOptions{.floor_layer = {.count = *rc::gen::inRange(0, 9)}}, count);
        near(ShellOptions<2>{}, count);
        near(ShellOptions<3>{.outer_radius = *rc::gen::inRange(2, 9) + 0.0}, count);
        near(ShellOptions<2>{.structure = ShellStructure::prisms}, count);
        near(ShellOptions<3>{.structure = ShellStructure::prisms}, 10 * count);
    });
}

TEST_CASE("with_elements keeps layers and the ratio of sizes") {
    const auto shell = with_elements(ShellOptions<3>{.inner_layer = {.count = 3}}, 3000);
    CHECK(shell.inner_layer == ShellOptions<3>{.inner_layer = {.count = 3}}.inner_layer);
    CHECK(shell.outer_size / shell.inner_size == doctest::Approx(3));
    const auto mesh = generate(shell);
    REQUIRE(mesh.has_value());
    CHECK(mesh->elements.size() == doctest::Approx(3000).epsilon(0.2));
}

TEST_CASE("generation stops on request") {
    std::stop_source source;
    source.request_stop();
    each_kind([&](const auto& options) {
        const auto mesh = generate(options, Execution{.stop = source.get_token()});
        REQUIRE_FALSE(mesh.has_value());
        CHECK(mesh.error().kind == ErrorKind::stopped);
    });
}

TEST_CASE("inconsistent sizes are rejected") {
    const auto check_rejected = [](const auto& options) {
        const auto mesh = generate(options);
        REQUIRE_FALSE(mesh.has_value());
        CHECK(mesh.error().kind == ErrorKind::usage);
        CHECK_FALSE(mesh.error().what.empty());
    };
    check_rejected(BoxOptions<3>{.cells = {0, 1, 1}});
    check_rejected(BoxOptions<3>{.cells = {2000000, 2000000, 2000000}});
    check_rejected(BoxOptions<2>{.low = {{0, 1}}});
    check_rejected(ShellOptions<3>{.inner_radius = 5});
    check_rejected(ShellOptions<3>{.inner_size = -1});
    check_rejected(ShellOptions<3>{.inner_size = 1e-9});
    check_rejected(ShellOptions<2>{.inner_size = 1e-12, .outer_size = 1e-12});
    check_rejected(ShellOptions<3>{.inner_layer = {.count = 100, .first_height = 1, .growth = 1}});
    check_rejected(BumpOptions{.bump_height = 2});
    check_rejected(BumpOptions{.cells = {2000000, 2000000}});
}
