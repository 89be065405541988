// Soundness: defects added to a sound mesh are found, counted and removed. Faces are counted a second time by sorting.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <random>
#include <set>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;
import camber.soundness;

#include "generators.hpp"

using namespace camber;
using namespace generators;
using camber::testing::property;

namespace {

const Execution one_thread{.threads = 1};

template <class M>
struct PreparedSimplices {
    M mesh;
    std::vector<std::string> notices;
};
template <class M>
Outcome<PreparedSimplices<M>> prepare_simplices(const M& mesh, const Execution& execution) {
    auto prepared = prepare(as_mesh(mesh), execution);
    if (!prepared) return fail(prepared.error());
    if constexpr (std::is_same_v<M, LinearMesh<M::dimension>>)
        return PreparedSimplices<M>{*as_linear(prepared->mesh), prepared->notices};
    else
        return PreparedSimplices<M>{*as_quadratic(prepared->mesh), prepared->notices};
}

/// A lattice of several references with slightly displaced points.
template <int D>
LinearMesh<D> sound_mesh(std::mt19937_64& random, int n = 3) {
    LinearMesh<D> mesh = lattice_mesh<D>(n);
    auto points = take(std::move(mesh.points));
    for (auto& p : points)
        for (int c = 0; c < D; ++c)
            if (p[c] > 0 && p[c] < n) p[c] += uniform(random, -0.1, 0.1);
    mesh.points = std::move(points);
    Buffer<Reference> facets(mesh.facets.size());
    for (std::size_t f = 0; f < facets.size(); ++f) facets[f] = static_cast<Reference>(1 + f % 4);
    mesh.facets.references = std::move(facets);
    return mesh;
}

template <std::size_t N>
std::array<VertexId, N> sorted(std::array<VertexId, N> v) {
    std::sort(v.begin(), v.end());
    return v;
}

template <std::size_t N>
std::multiset<std::array<VertexId, N>> as_sets(const Column<std::array<VertexId, N>>& simplices) {
    std::multiset<std::array<VertexId, N>> sets;
    for (const auto& s : simplices) sets.insert(sorted(s));
    return sets;
}

/// Selects some of n items, at least one and not all.
std::vector<bool> some(std::mt19937_64& random, std::size_t n, std::size_t one_in) {
    std::vector<bool> chosen(n, false);
    for (std::size_t i = 0; i + 1 < n; ++i) chosen[i] = random() % one_in == 0;
    chosen[random() % (n - 1)] = true;
    return chosen;
}

template <int D>
void turn(LinearMesh<D>& mesh, const std::vector<bool>& chosen, std::mt19937_64& random) {
    auto elements = take(std::move(mesh.elements.vertices));
    for (std::size_t e = 0; e < elements.size(); ++e)
        if (chosen[e]) {
            const std::size_t i = random() % (D + 1);
            std::swap(elements[e][i], elements[e][(i + 1 + random() % D) % (D + 1)]);
        }
    mesh.elements.vertices = std::move(elements);
}

template <int D>
void drop_facets(LinearMesh<D>& mesh, const std::vector<bool>& chosen) {
    Buffer<SimplexVertices<D - 1>> remaining;
    Buffer<Reference> references;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        if (!chosen[f]) {
            remaining.push_back(mesh.facets.vertices[f]);
            references.push_back(mesh.facets.references[f]);
        }
    mesh.facets.vertices = std::move(remaining);
    mesh.facets.references = std::move(references);
}

/// Lists the chosen items again, with their vertices in another order.
template <int K>
void repeat(Simplices<K>& simplices, const std::vector<bool>& chosen, std::mt19937_64& random) {
    auto vertices = take(std::move(simplices.vertices));
    auto references = take(std::move(simplices.references));
    for (std::size_t i = 0; i < chosen.size(); ++i)
        if (chosen[i]) {
            auto again = vertices[i];
            std::shuffle(again.begin(), again.end(), random);
            vertices.push_back(again);
            references.push_back(references[i]);
        }
    simplices.vertices = std::move(vertices);
    simplices.references = std::move(references);
}

std::size_t number(const std::vector<bool>& chosen) {
    return static_cast<std::size_t>(std::count(chosen.begin(), chosen.end(), true));
}
std::size_t first(const std::vector<bool>& chosen) {
    return static_cast<std::size_t>(std::find(chosen.begin(), chosen.end(), true) - chosen.begin()) + 1;
}

template <int D>
LinearMesh<D> broken(std::mt19937_64& random) {
    auto mesh = sound_mesh<D>(random);
    turn(mesh, some(random, mesh.elements.size(), 5), random);
    drop_facets(mesh, some(random, mesh.facets.size(), 4));
    auto references = take(std::move(mesh.elements.references));
    for (std::size_t e = 0; e < references.size() / 2; ++e) references[e] = 2;
    mesh.elements.references = std::move(references);
    repeat(mesh.elements, some(random, mesh.elements.size(), 9), random);
    repeat(mesh.facets, some(random, mesh.facets.size(), 9), random);
    return mesh;
}

template <int D>
void test_defects() {
    const std::string in = ", " + std::to_string(D) + "D";
    property("a sound mesh has no findings and is not changed" + in,
             [] {
                 auto random = random_source();
                 const auto mesh = sound_mesh<D>(random);
                 const auto found = *examine(as_mesh(mesh), one_thread);
                 RC_ASSERT(found.sound());
                 for (const Finding& f : found.findings) RC_ASSERT(f == Finding{});
                 const auto prepared = *prepare_simplices(mesh, one_thread);
                 RC_ASSERT(prepared.mesh == mesh);
                 RC_ASSERT(prepared.notices.empty());
             },
             {.count = 10});

    property("reversed elements are counted and reoriented" + in,
             [] {
                 auto random = random_source();
                 auto mesh = sound_mesh<D>(random);
                 const auto whole = mesh;
                 // More than half may be chosen: then the others are fewer, but the sign of the volume decides.
                 const auto chosen = some(random, mesh.elements.size(), 1 + random() % 4);
                 turn(mesh, chosen, random);
                 const auto found = *examine(as_mesh(mesh), one_thread);
                 RC_ASSERT(found[Defect::reversed_element] == (Finding{number(chosen), first(chosen), 0}));
                 RC_ASSERT(found[Defect::tangled_element].count == 0U);
                 RC_ASSERT(!found.sound());
                 const auto prepared = *prepare_simplices(mesh, one_thread);
                 RC_ASSERT(prepared.notices.size() == 1U);
                 RC_ASSERT(as_sets(prepared.mesh.elements.vertices) == as_sets(whole.elements.vertices));
                 RC_ASSERT(validate(*elevate(prepared.mesh, one_thread), 0, one_thread)->all_valid());
             },
             {.count = 20});

    property("missing facets are added outwards with a new reference" + in,
             [] {
                 auto random = random_source();
                 auto mesh = sound_mesh<D>(random);
                 const auto whole = mesh;
                 drop_facets(mesh, some(random, mesh.facets.size(), 1 + random() % 5));
                 RC_ASSERT(examine(as_mesh(mesh), one_thread)->sound() == false);
                 const auto prepared = *prepare_simplices(mesh, one_thread);
                 RC_ASSERT(as_sets(prepared.mesh.facets.vertices) == as_sets(whole.facets.vertices));
                 for (std::size_t f = 0; f < prepared.mesh.facets.size(); ++f)
                     RC_ASSERT((f >= mesh.facets.size()) == (prepared.mesh.facets.references[f] == 5));
                 RC_ASSERT(examine(as_mesh(prepared.mesh), one_thread)->sound());
             },
             {.count = 20});

    property(
        "added facets have a reference without name" + in,
        [] {
            auto random = random_source();
            auto mesh = sound_mesh<D>(random);
            Buffer<Group> groups;
            for (std::size_t n = random() % 6; n > 0; --n)
                groups.push_back({static_cast<int>(1 + random() % 3), static_cast<Reference>(random() % 9), "name"});
            mesh.groups = groups;
            drop_facets(mesh, some(random, mesh.facets.size(), 1 + random() % 5));
            const auto prepared = *prepare_simplices(mesh, one_thread);
            for (std::size_t f = mesh.facets.size(); f < prepared.mesh.facets.size(); ++f)
                for (const Group& group : groups)
                    RC_ASSERT((group.dimension != D - 1 || group.reference != prepared.mesh.facets.references[f]));
            RC_ASSERT(prepared.mesh.groups == mesh.groups);
        },
        {.count = 20});

    property("repeated elements and facets are counted and removed" + in,
             [] {
                 auto random = random_source();
                 auto mesh = sound_mesh<D>(random);
                 const auto whole = mesh;
                 const auto elements = some(random, mesh.elements.size(), 6),
                            facets = some(random, mesh.facets.size(), 3);
                 repeat(mesh.elements, elements, random);
                 repeat(mesh.facets, facets, random);
                 const auto found = *examine(as_mesh(mesh), one_thread);
                 RC_ASSERT(found[Defect::repeated_element] ==
                           (Finding{number(elements), whole.elements.size() + 1, first(elements)}));
                 RC_ASSERT(found[Defect::repeated_facet] ==
                           (Finding{number(facets), whole.facets.size() + 1, first(facets)}));
                 RC_ASSERT(prepare_simplices(mesh, one_thread)->mesh == whole);
             },
             {.count = 20});

    property("prepare commutes with elevation, is idempotent and independent of threads" + in,
             [] {
                 auto random = random_source();
                 const auto mesh = broken<D>(random);
                 const auto prepared = *prepare_simplices(mesh, one_thread);
                 RC_ASSERT(prepare_simplices(*elevate(mesh, one_thread), one_thread)->mesh ==
                           *elevate(prepared.mesh, one_thread));
                 RC_ASSERT(prepare_simplices(prepared.mesh, one_thread)->mesh == prepared.mesh);
                 for (const int threads : {2, 0}) {
                     RC_ASSERT(*examine(as_mesh(mesh), {.threads = threads}) == *examine(as_mesh(mesh), one_thread));
                     RC_ASSERT(prepare_simplices(mesh, {.threads = threads})->mesh == prepared.mesh);
                 }
             },
             {.count = 15});

    property("faces between references are listed once" + in,
             [] {
                 auto random = random_source();
                 auto mesh = sound_mesh<D>(random);
                 auto references = take(std::move(mesh.elements.references));
                 for (auto& r : references) r = static_cast<Reference>(random() % 3);
                 mesh.elements.references = std::move(references);
                 const auto next = *neighbours(mesh, *balls(mesh, one_thread), one_thread);
                 std::size_t faces = 0;
                 for (std::size_t e = 0; e < next.size(); ++e)
                     for (const ElementId other : next[e])
                         faces += other.valid() && other.index() > e &&
                                  mesh.elements.references[e] != mesh.elements.references[other];
                 const auto prepared = *prepare_simplices(mesh, one_thread);
                 RC_ASSERT(prepared.mesh.facets.size() == mesh.facets.size() + faces);
                 RC_ASSERT(examine(as_mesh(prepared.mesh), one_thread)->findings == Soundness{}.findings);
             },
             {.count = 10});

    property("a displaced inner vertex makes exactly the negative elements tangled" + in,
             [] {
                 auto random = random_source();
                 auto mesh = sound_mesh<D>(random);
                 auto points = take(std::move(mesh.points));
                 std::size_t v = 0;
                 const auto inner = [&](const Vec<D>& p) {
                     return std::all_of(p.c.begin(), p.c.end(), [](double x) { return x > 0.5 && x < 2.5; });
                 };
                 while (!inner(points[v])) ++v;
                 points[v][0] += uniform(random, 1.5, 1.9);
                 mesh.points = std::move(points);
                 const auto verdict = *validate(*elevate(mesh, one_thread), 0, one_thread);
                 const auto found = *examine(as_mesh(mesh), one_thread);
                 RC_ASSERT(found[Defect::tangled_element].count + found[Defect::flat_element].count == verdict.invalid);
                 RC_ASSERT(found[Defect::tangled_element].count > 0U);
                 RC_ASSERT(found[Defect::reversed_element].count == 0U);
                 RC_ASSERT(prepare_simplices(mesh, one_thread)->mesh.elements == mesh.elements);
             },
             {.count = 20});
}

/// Random simplices on few vertices.
template <int D>
LinearMesh<D> random_simplices(std::mt19937_64& random) {
    constexpr std::size_t vertices = 7;
    const auto simplex = [&]<int K>(SimplexVertices<K>& s) {
        std::array<std::size_t, vertices> all{0, 1, 2, 3, 4, 5, 6};
        std::shuffle(all.begin(), all.end(), random);
        for (int i = 0; i <= K; ++i) s[i] = VertexId(all[i]);
    };
    LinearMesh<D> mesh;
    Buffer<Vec<D>> points(vertices);
    for (auto& p : points)
        for (int c = 0; c < D; ++c) p[c] = uniform(random, 0, 1);
    Buffer<SimplexVertices<D>> elements(random() % 12);
    for (auto& e : elements) simplex.template operator()<D>(e);
    Buffer<SimplexVertices<D - 1>> facets(random() % 12);
    for (auto& f : facets) simplex.template operator()<D - 1>(f);
    Buffer<Reference> of_elements(elements.size()), of_facets(facets.size()), of_points(vertices);
    for (auto& r : of_elements) r = static_cast<Reference>(random() % 2);
    for (auto& r : of_facets) r = static_cast<Reference>(random() % 2);
    std::fill(of_points.begin(), of_points.end(), 0);
    mesh.points = std::move(points);
    mesh.point_references = std::move(of_points);
    mesh.elements = {std::move(elements), std::move(of_elements), {}};
    mesh.facets = {std::move(facets), std::move(of_facets), {}};
    return mesh;
}

template <int D>
void test_random_simplices() {
    property(
        "examine counts the defects that sorting of faces counts, " + std::to_string(D) + "D",
        [] {
            auto random = random_source();
            const auto mesh = random_simplices<D>(random);
            const auto found = *examine(as_mesh(mesh), one_thread);
            std::map<SimplexVertices<D>, std::vector<std::size_t>> elements;
            for (std::size_t e = 0; e < mesh.elements.size(); ++e)
                elements[sorted(mesh.elements.vertices[e])].push_back(e);
            std::map<SimplexVertices<D - 1>, std::set<std::size_t>> faces;
            std::map<SimplexVertices<D - 1>, std::vector<std::size_t>> facets;
            std::size_t repeated = 0, contradicting = 0, crowded = 0, stray = 0;
            for (const auto& [vertices, list] : elements) {
                for (int i = 0; i <= D; ++i) {
                    SimplexVertices<D - 1> face;
                    for (int k = 0, n = 0; k <= D; ++k)
                        if (k != i) face[n++] = vertices[k];
                    faces[face].insert(list[0]);
                }
                for (const std::size_t e : list) {
                    const bool same = mesh.elements.references[e] == mesh.elements.references[list[0]];
                    repeated += e != list[0] && same;
                    contradicting += e != list[0] && !same;
                }
            }
            std::set<std::size_t> in_crowd;
            for (const auto& [face, list] : faces)
                if (list.size() > 2) in_crowd.insert(list.begin(), list.end());
            crowded = in_crowd.size();
            for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
                auto& list = facets[sorted(mesh.facets.vertices[f])];
                list.push_back(f);
                stray += list.size() == 1 && !elements.empty() && !faces.contains(sorted(mesh.facets.vertices[f]));
            }
            RC_ASSERT(found[Defect::repeated_element].count == repeated);
            RC_ASSERT(found[Defect::contradicting_element].count == contradicting);
            RC_ASSERT(found[Defect::crowded_face].count == crowded);
            RC_ASSERT(found[Defect::isolated_facet].count == stray);
            std::set<std::size_t> open;
            for (const auto& [face, list] : faces)
                if (list.size() == 1 && !facets.contains(face)) open.insert(*list.begin());
            RC_ASSERT(found[mesh.facets.size() == 0 ? Defect::no_facets : Defect::missing_facet].count == open.size());
            RC_ASSERT(found.empty == (mesh.elements.size() + mesh.facets.size() == 0));
            // The mesh is rejected by name, or sound afterwards except for elements that no numbering corrects.
            const auto prepared = prepare_simplices(mesh, one_thread);
            if (!prepared) {
                RC_ASSERT(prepared.error().kind == ErrorKind::input);
                RC_ASSERT(found.empty || prepared.error().entity.has_value());
            } else {
                const auto after = *examine(as_mesh(prepared->mesh), one_thread);
                for (const Defect d : {Defect::repeated_element, Defect::repeated_facet, Defect::reversed_element,
                                       Defect::missing_facet, Defect::no_facets, Defect::missing_interface})
                    RC_ASSERT(after[d].count == 0U);
                RC_ASSERT(after[Defect::isolated_facet].count == 0U);
                // In a piece whose volumes cancel the inverted elements are not determined.
                if (stray == 0) RC_ASSERT(after[Defect::tangled_element].count == found[Defect::tangled_element].count);
            }
        },
        {.count = 400});
}

}  // namespace

TEST_CASE("examine counts defects, and prepare removes them") {
    test_defects<2>();
    test_defects<3>();
}

TEST_CASE("examine agrees with counts of faces by sorting") {
    test_random_simplices<2>();
    test_random_simplices<3>();
}

namespace {

template <int D>
LinearMesh<D> scaled(LinearMesh<D> mesh, int exponent) {
    auto points = take(std::move(mesh.points));
    for (auto& p : points)
        for (double& x : p.c) x = std::ldexp(x, exponent);
    mesh.points = std::move(points);
    return mesh;
}

template <int D>
void test_scales() {
    property("the findings do not depend on the unit of length, " + std::to_string(D) + "D",
             [] {
                 auto random = random_source();
                 auto mesh = broken<D>(random);
                 const auto found = *examine(as_mesh(mesh), one_thread);
                 for (const int exponent : {-195, 195})  // 2e-59, 5e58
                     RC_ASSERT(*examine(as_mesh(scaled(mesh, exponent)), one_thread) == found);
                 // Sound meshes without listed faces have no hanging vertex, up to the limit of coordinates.
                 auto sound = sound_mesh<D>(random);
                 sound.facets = {};
                 for (const int exponent : {-300, 230, 260, 300, 330})
                     RC_ASSERT((*examine(as_mesh(scaled(sound, exponent)), one_thread))[Defect::hanging_vertex] ==
                               Finding{});
             },
             {.count = 10});
}

/// True if all coordinate differences of a simplex are below the range.
template <int D, std::size_t N>
bool is_tiny(const LinearMesh<D>& mesh, const std::array<VertexId, N>& simplex) {
    double extent = 0;
    for (const VertexId a : simplex)
        for (const VertexId b : simplex)
            for (int c = 0; c < D; ++c) extent = std::fmax(extent, mesh.points[a][c] - mesh.points[b][c]);
    return extent < 1e-60;
}

template <int D>
void test_range() {
    property("lengths out of range are counted and rejected, " + std::to_string(D) + "D",
             [] {
                 auto random = random_source();
                 // A part of the mesh is out of range.
                 auto mesh = sound_mesh<D>(random);
                 auto points = take(std::move(mesh.points));
                 const bool far = random() % 2 == 0;
                 const double unit = far ? 0.5e60 : 1e-60;
                 for (auto& p : points)
                     for (double& x : p.c) x *= unit * (far ? 1 : uniform(random, 0.9, 1));
                 mesh.points = std::move(points);
                 std::size_t distant = 0, elements = 0, facets = 0;
                 for (const auto& p : mesh.points)
                     distant += std::any_of(p.c.begin(), p.c.end(), [](double x) { return std::abs(x) > 1e60; });
                 for (const auto& e : mesh.elements.vertices) elements += is_tiny(mesh, e);
                 for (const auto& f : mesh.facets.vertices) facets += is_tiny(mesh, f);
                 RC_ASSERT((distant > 0) == far);
                 const auto found = *examine(as_mesh(mesh), one_thread);
                 RC_ASSERT(found[Defect::distant_vertex].count == distant);
                 RC_ASSERT(found[Defect::tiny_element].count == elements);
                 RC_ASSERT(found[Defect::tiny_facet].count == facets);
                 RC_ASSERT(prepare_simplices(mesh, one_thread).has_value() == (distant + elements + facets == 0));
             },
             {.count = 20});
}

}  // namespace

TEST_CASE("examine does not depend on the unit of length") {
    test_scales<2>();
    test_scales<3>();
}

TEST_CASE("lengths out of range are counted and rejected") {
    test_range<2>();
    test_range<3>();
}

TEST_CASE("prepare rejects meshes out of range with one message, linear or quadratic") {
    auto random = std::mt19937_64(3);
    const auto mesh = sound_mesh<3>(random, 2);
    const auto message = [](const auto& m) {
        const auto prepared = prepare_simplices(m, one_thread);
        return prepared ? std::string() : describe(prepared.error());
    };
    for (const int exponent : {-1000, -300, -203}) {
        const auto small = scaled(mesh, exponent);
        CHECK(message(small) == "tetrahedron 1: is smaller than 1e-60, the first of 48 (use another unit of length)");
        CHECK(message(*elevate(small, one_thread)) == message(small));
    }
    for (const int exponent : {201, 300, 1000}) {
        const auto large = scaled(mesh, exponent);
        CHECK(message(large).find("is more than 1e60 away from the origin") != std::string::npos);
        CHECK(message(*elevate(large, one_thread)) == message(large));
    }
    auto surface = scaled(mesh, -300);
    surface.elements = {};
    CHECK(message(surface) == "triangle 1: is smaller than 1e-60, the first of 48 (use another unit of length)");
}

TEST_CASE("prepare rejects a mid node out of range") {
    auto random = std::mt19937_64(3);
    auto mesh = *elevate(sound_mesh<2>(random, 2), one_thread);
    auto nodes = take(std::move(mesh.mid_nodes));
    nodes[1].point[0] = -1e61;
    mesh.mid_nodes = std::move(nodes);
    const std::size_t number = mesh.linear.points.size() + 2;
    CHECK((*examine(as_mesh(mesh), one_thread))[Defect::distant_node] == Finding{1, number, 0});
    CHECK(describe(prepare_simplices(mesh, one_thread).error()) ==
          "node " + std::to_string(number) + ": is more than 1e60 away from the origin (use another unit of length)");
}

TEST_CASE("an element with coincident vertices has duplicate vertices and is not tiny") {
    auto random = std::mt19937_64(3);
    const auto found = *examine(as_mesh(scaled(sound_mesh<2>(random, 2), -2000)), one_thread);
    CHECK(found[Defect::tiny_element] == Finding{});
    CHECK(found[Defect::tiny_facet] == Finding{});
    CHECK(found[Defect::duplicate_vertex].count > 0);
}

TEST_CASE("required and ridge marks follow their items") {
    auto random = std::mt19937_64(3);
    auto mesh = sound_mesh<2>(random, 2);
    const std::size_t n = mesh.facets.size();
    repeat(mesh.facets, std::vector<bool>(n, true), random);
    mesh.facets.required = Buffer<std::uint32_t>{1, static_cast<std::uint32_t>(n + 1), static_cast<std::uint32_t>(n)};
    mesh.ridges = Buffer<std::uint32_t>{static_cast<std::uint32_t>(n + 2)};
    const auto prepared = prepare_simplices(mesh, one_thread);
    REQUIRE(prepared.has_value());
    CHECK(prepared->mesh.facets.required == Column<std::uint32_t>(Buffer<std::uint32_t>{0, 1}));
    CHECK(prepared->mesh.ridges == Column<std::uint32_t>(Buffer<std::uint32_t>{2}));
}

TEST_CASE("missing facets get a free reference where the highest one is in use") {
    auto random = std::mt19937_64(3);
    auto mesh = sound_mesh<2>(random, 2);
    auto references = take(std::move(mesh.facets.references));
    references[0] = 0x7fffffff;
    mesh.facets.references = std::move(references);
    std::vector<bool> last(mesh.facets.size(), false);
    last.back() = true;
    drop_facets(mesh, last);
    const auto prepared = prepare_simplices(mesh, one_thread);
    REQUIRE(prepared.has_value());
    CHECK(prepared->mesh.facets.references[prepared->mesh.facets.size() - 1] == 5);
}

TEST_CASE("examine and prepare name unsupported shapes and degrees") {
    const Mesh<2> cubic = *elevate(as_mesh(lattice_mesh<2>(2)), 3, one_thread);
    CHECK(examine(cubic, one_thread).error().kind == ErrorKind::unsupported);
    CHECK(prepare(cubic, one_thread).error().what.find("degree 3") != std::string::npos);
    Mesh<2> quadrilateral;
    quadrilateral.points = Buffer<Vec<2>>{{{0, 0}}, {{1, 0}}, {{1, 1}}, {{0, 1}}};
    quadrilateral.elements.of<Shape::quadrilateral>().vertices =
        Buffer<ShapeVertices<Shape::quadrilateral>>{{VertexId(0U), VertexId(1U), VertexId(2U), VertexId(3U)}};
    quadrilateral.elements.of<Shape::quadrilateral>().references = Buffer<Reference>{1};
    CHECK(examine(quadrilateral, one_thread).error().what.find("1 quadrilateral") != std::string::npos);
}
