// Random operations, two and three dimensions: whatever is done, the mesh is one, and the domain's. A million of them,
// in three minutes: RC_PARAMS="max_success=1500 seed=77" build/bin/test_dynamic -tc="random*,a star*,patches"
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "domains.hpp"
#include "dynamic_measures.hpp"
#include "property.hpp"

import camber.core;
import camber.dynamic;

using namespace camber;
using namespace camber::testing;

namespace {

enum class Kind : std::uint8_t { split, insert, insert_on_face, collapse, swap_edge, swap_face, reinsert, move, any };
constexpr std::size_t kinds = 9;

/// D! times a simplex's volume, (D − 1)! times its area: its size, for a given reference.
double size_of(const std::array<Vec<2>, 2>& p) { return distance(p[0], p[1]); }
double size_of(const std::array<Vec<3>, 3>& p) { return norm(cross(p[1] - p[0], p[2] - p[0])); }
double size_of(const std::array<Vec<3>, 2>& p) { return distance(p[0], p[1]); }

/// The elements of a star are not inverted, and it fills what was taken out, reference by reference.
template <int D>
bool fills(const DynamicMesh<D>& mesh, const TopologyPatch<D>& patch) {
    const VertexId p = patch.point.vertex;
    const Vec<D> place = patch.point.place ? *patch.point.place : mesh.points[p];
    Sizes sums;
    const auto add = [&](const auto& vertices, Reference reference, VertexId replaced, double sign) {
        constexpr std::size_t n = std::tuple_size_v<std::remove_cvref_t<decltype(vertices)>>;
        std::array<Vec<D>, n> q;
        for (std::size_t i = 0; i < n; ++i) {
            const bool at_point = vertices[i] == replaced || (sign > 0 && vertices[i] == p);
            q[i] = at_point ? place : mesh.points[vertices[i]];
        }
        double size = 0;
        if constexpr (n == D + 1)
            size = orientation(q);
        else
            size = size_of(q);
        sums[{static_cast<int>(n), reference}] += sign * size;
        return size;
    };
    for (const ElementId e : patch.removed.elements)
        add(mesh.elements.vertices[e], mesh.elements.references[e], VertexId(max_entities), -1);
    for (const ElementFace& open : patch.star.joined) {
        const auto& v = mesh.elements.vertices[open.element];
        if (!(add(v, mesh.elements.references[open.element], v[open.opposite], 1) > 1e-7)) return false;
    }
    for (const FacetId f : patch.removed.facets)
        add(mesh.facets.vertices[f], mesh.facets.references[f], VertexId(max_entities), -1);
    for (const auto& [f, opposite] : patch.star.facets)
        add(mesh.facets.vertices[f], mesh.facets.references[f], mesh.facets.vertices[f][opposite], 1);
    if constexpr (D == 3) {
        for (const LineId l : patch.removed.lines)
            add(mesh.edges[mesh.lines[l]], mesh.line_references[l], VertexId(max_entities), -1);
        for (const auto& [l, opposite] : patch.star.lines)
            add(mesh.edges[mesh.lines[l]], mesh.line_references[l], mesh.edges[mesh.lines[l]][opposite], 1);
    }
    return std::ranges::all_of(sums, [](const auto& sum) { return std::abs(sum.second) < 1e-10; });
}

template <int D>
ElementId any_element(const DynamicMesh<D>& mesh, Dice& dice) {
    for (;;)
        if (const ElementId e(dice.below(mesh.elements.size())); !mesh.is_free(e)) return e;
}

template <int D>
Vec<D> inner_point(const DynamicMesh<D>& mesh, const std::vector<VertexId>& vertices, Dice& dice) {
    Vec<D> sum;
    double all = 0;
    for (const VertexId v : vertices) {
        const double w = dice.uniform(0.3, 1);
        sum += w * mesh.points[v];
        all += w;
    }
    return sum / all;
}

/// Elements, each across a face of one before, with some of their facets and lines.
template <int D>
void grow(const DynamicMesh<D>& mesh, ElementId first, Dice& dice, CavityParts<D>& out) {
    out.elements = {first};
    for (std::size_t n = 1 + dice.below(20); n > 0; --n) {
        const ElementId from = out.elements[dice.below(out.elements.size())];
        const ElementId next = element_across(mesh, from, static_cast<int>(dice.below(D + 1)));
        if (next.valid() && std::ranges::find(out.elements, next) == out.elements.end()) out.elements.push_back(next);
    }
    for (const ElementId e : out.elements) {
        for (int i = 0; i <= D; ++i)
            if (const FacetId f = facet_at(mesh, e, i); f.valid() && dice.below(2) == 0) out.facets.push_back(f);
        for (const EdgeId edge : mesh.edges_of[e])
            if (const LineId l = mesh.line_at(edge); l.valid() && dice.below(3) == 0) out.lines.push_back(l);
    }
    const auto once = [](auto& ids) {
        std::ranges::sort(ids);
        ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    };
    once(out.facets);
    once(out.lines);
}

/// A patch of that kind somewhere; none where that place does not allow it.
template <int D>
std::optional<TopologyPatch<D>> starred(const DynamicMesh<D>& mesh, Kind kind, Dice& dice, StarWorkspace<D>& w) {
    TopologyPatch<D> patch{mesh.stamp, {}, {}, {}};
    auto& [stamp, point, cavity, star_of] = patch;
    const ElementId e = any_element(mesh, dice);
    const auto& v = mesh.elements.vertices[e];
    const int k = static_cast<int>(dice.below(edges_per_simplex<D>));
    const VertexId a = v[local_edges<D>[k][0]];
    const VertexId b = v[local_edges<D>[k][1]];
    switch (kind) {
        case Kind::split:
            cavity_of_edge(mesh, e, k, cavity);
            point.place = inner_point<D>(mesh, {a, b}, dice);
            break;
        case Kind::insert:
            cavity.elements.push_back(e);
            point.place = inner_point<D>(mesh, {v.begin(), v.end()}, dice);
            break;
        case Kind::insert_on_face:
            cavity_of_face(mesh, e, k % (D + 1), cavity);
            point.place = inner_point<D>(
                mesh,
                [&] {
                    std::vector<VertexId> face(v.begin(), v.end());
                    face.erase(face.begin() + k % (D + 1));
                    return face;
                }(),
                dice);
            break;
        case Kind::collapse:
            cavity_of_vertex(mesh, a, cavity);
            if (!may_collapse(mesh, cavity, a, b)) return {};
            point.vertex = b;
            break;
        case Kind::swap_edge: {
            cavity_of_edge(mesh, e, k, cavity);
            if (!cavity.lines.empty()) return {};
            std::vector<VertexId> ring;
            if (cavity.facets.empty()) {
                for (const ElementId s : cavity.elements)
                    for (const VertexId x : mesh.elements.vertices[s])
                        if (x != a && x != b) ring.push_back(x);
            } else {
                for (const FacetId f : cavity.facets)
                    for (const VertexId x : mesh.facets.vertices[f])
                        if (x != a && x != b) ring.push_back(x);
            }
            if (ring.empty()) return {};
            point.vertex = ring[dice.below(ring.size())];
            break;
        }
        case Kind::swap_face:
            cavity_of_face(mesh, e, k % (D + 1), cavity);
            if (!cavity.facets.empty()) return {};
            point.vertex = v[k % (D + 1)];
            break;
        case Kind::reinsert:
            cavity_of_vertex(mesh, a, cavity);
            point.vertex = a;
            break;
        case Kind::move:
            cavity_of_vertex(mesh, a, cavity);
            if (mesh.states[a].place != VertexPlace::inside) return {};
            point.vertex = a;
            point.place = mesh.points[a] + 0.2 * dice.vector<D>();
            break;
        case Kind::any:
            grow(mesh, e, dice, cavity);
            if (dice.below(2) == 0)
                point.vertex = a;
            else
                point.place = inner_point<D>(mesh, {v.begin(), v.end()}, dice);
            break;
    }
    if (star(mesh, cavity, point.vertex, w, star_of) != StarFailure::none) return {};
    return patch;
}
template <int D>
std::optional<TopologyPatch<D>> planned(const DynamicMesh<D>& mesh, Kind kind, Dice& dice, StarWorkspace<D>& w) {
    auto patch = starred(mesh, kind, dice, w);
    if (patch && !fills(mesh, *patch)) patch.reset();
    return patch;
}

/// V − E + F − T of the elements.
template <int D>
std::ptrdiff_t euler(const DynamicMesh<D>& mesh) {
    std::size_t faces = 0;
    std::size_t vertices = 0;
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
        if (!mesh.is_free(ElementId(e)))
            for (int i = 0; i <= D; ++i) {
                const ElementId other = element_across(mesh, ElementId(e), i);
                faces += !other.valid() || other.index() > e ? 1 : 0;
            }
    for (std::size_t v = 0; v < mesh.points.size(); ++v) vertices += mesh.element_of[v].valid() ? 1 : 0;
    const auto n = [](std::size_t count) { return static_cast<std::ptrdiff_t>(count); };
    if (D == 2) return n(vertices) - n(faces) + n(mesh.element_count());
    return n(vertices) - n(mesh.edge_count()) + n(faces) - n(mesh.element_count());
}

template <int D>
void expect_measures(const DynamicMesh<D>& mesh, const Sizes& expected) {
    const auto now = measures(mesh);
    RC_ASSERT(now.size() == expected.size());
    for (const auto& [key, value] : expected) RC_ASSERT(std::abs(now.at(key) - value) < 1e-8);
}

template <int D>
void expect_sound(const DynamicMesh<D>& mesh) {
    const auto consistent = check_consistency(mesh, alone);
    if (!consistent) RC_FAIL(describe(consistent.error()));
}

/// Kept up to date, and made anew from the simplices alone, it is the same.
template <int D>
void expect_as_made_anew(const DynamicMesh<D>& mesh) {
    const auto [compact, edges, maps] = must(compacted(mesh, alone));
    const DynamicMesh<D> anew = must(make_dynamic(compact, edges, {}, alone));
    RC_ASSERT(anew.edge_count() == mesh.edge_count());
    RC_ASSERT(by_places(anew) == by_places(mesh));
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
        if (const VertexId now = maps.vertices[VertexId(v)]; now.valid())
            RC_ASSERT(anew.states[now].place == mesh.states[v].place);
    for (std::size_t e = 0; e < mesh.edges.size(); ++e)
        if (const EdgeId now = maps.edges[EdgeId(e)]; now.valid()) {
            const auto& [a, b] = mesh.edges[e];
            const std::array ends{maps.vertices[a], maps.vertices[b]};
            RC_ASSERT(anew.edges[now] == (std::array{std::min(ends[0], ends[1]), std::max(ends[0], ends[1])}));
            RC_ASSERT(anew.line_at(now).valid() == mesh.line_at(EdgeId(e)).valid());
        }
}

/// Changes as they are told, against what is there before and after.
template <int D>
void expect_told(const DynamicMesh<D>& before, const DynamicMesh<D>& after, const TopologyChanges& changes) {
    const auto n = [](const auto& ids) { return static_cast<std::ptrdiff_t>(ids.size()); };
    const auto told = [&](const auto& ids) { return n(ids.created) - n(ids.removed); };
    const auto counted = [](std::size_t now, std::size_t then) {
        return static_cast<std::ptrdiff_t>(now) - static_cast<std::ptrdiff_t>(then);
    };
    RC_ASSERT(told(changes.vertices) == counted(after.vertex_count(), before.vertex_count()));
    RC_ASSERT(told(changes.edges) == counted(after.edge_count(), before.edge_count()));
    RC_ASSERT(told(changes.lines) == counted(after.line_count(), before.line_count()));
    RC_ASSERT(told(changes.facets) == counted(after.facet_count(), before.facet_count()));
    RC_ASSERT(told(changes.elements) == counted(after.element_count(), before.element_count()));
    std::vector<std::uint8_t> touched(after.elements.size(), 0);
    for (const ElementId e : changes.elements.removed) touched[e.index()] = 1;
    for (const ElementId e : changes.elements.created) touched[e.index()] = 1;
    for (std::size_t e = 0; e < before.elements.size(); ++e)
        if (touched[e] == 0) RC_ASSERT(before.elements.vertices[e] == after.elements.vertices[e]);
}

template <int D>
void random_operations(std::uint64_t seed, std::size_t steps, std::array<std::size_t, kinds>& accepted) {
    Dice dice(seed);
    DynamicMesh<D> mesh = dynamic_of(random_domain<D>(seed));
    const auto expected = measures(mesh);
    const std::ptrdiff_t characteristic = euler(mesh);
    StarWorkspace<D> workspace;
    for (std::size_t step = 0; step < steps; ++step) {
        // Small meshes grow, large ones shrink.
        const bool large = mesh.element_count() > (D == 2 ? 200U : 600U);
        auto kind = static_cast<Kind>(dice.below(kinds));
        if (large && kind <= Kind::insert_on_face) kind = Kind::collapse;
        const auto patch = planned(mesh, kind, dice, workspace);
        if (!patch) continue;
        const DynamicMesh<D> before = mesh;
        auto [after, changes] = must(commit<D>(std::move(mesh), {&*patch, 1}));
        ++accepted[static_cast<std::size_t>(kind)];
        if (step % 8 == 0) expect_told(before, after, changes);
        mesh = std::move(after);
        if (step % 16 == 0) expect_sound(mesh);
    }
    expect_sound(mesh);
    expect_measures(mesh, expected);
    RC_ASSERT(euler(mesh) == characteristic);
    expect_as_made_anew(mesh);
}

}  // namespace

TEST_CASE("random operations leave a sound mesh of the same domain") {
    std::array<std::size_t, kinds> flat{}, solid{};
    property("2D", [&](std::uint64_t seed) { random_operations<2>(seed, 300, flat); }, {.count = 60});
    property("3D", [&](std::uint64_t seed) { random_operations<3>(seed, 400, solid); }, {.count = 40});
    for (std::size_t k = 0; k < kinds; ++k) {
        INFO("kind " << k << ": " << flat[k] << " in 2D, " << solid[k] << " in 3D");
        CHECK(flat[k] > 20);
        CHECK(solid[k] > 20);
    }
}

namespace {

/// Whatever the places of the vertices: elements may be inverted here.
template <int D>
void topology_alone(std::uint64_t seed, std::array<std::size_t, kinds>& accepted) {
    Dice dice(seed);
    DynamicMesh<D> mesh = dynamic_of(random_domain<D>(seed));
    const std::ptrdiff_t characteristic = euler(mesh);
    StarWorkspace<D> workspace;
    for (std::size_t step = 0; step < 200; ++step) {
        auto kind = static_cast<Kind>(dice.below(kinds));
        if (mesh.element_count() > 300) kind = Kind::collapse;
        const auto patch = starred(mesh, kind, dice, workspace);
        if (!patch) continue;
        mesh = must(commit<D>(std::move(mesh), {&*patch, 1})).mesh;
        ++accepted[static_cast<std::size_t>(kind)];
        if (step % 4 == 0) expect_sound(mesh);
        RC_ASSERT(euler(mesh) == characteristic);
    }
    expect_as_made_anew(mesh);
}

}  // namespace

TEST_CASE("a star is sound by its topology alone") {
    std::array<std::size_t, kinds> flat{}, solid{};
    property("2D", [&](std::uint64_t seed) { topology_alone<2>(seed, flat); }, {.count = 60});
    property("3D", [&](std::uint64_t seed) { topology_alone<3>(seed, solid); }, {.count = 40});
    topology_alone<3>(113241,
                      solid);  // an edge where the mesh touches itself went from one side and not from the other
    for (std::size_t k = 0; k < kinds; ++k) {
        INFO("kind " << k << ": " << flat[k] << " in 2D, " << solid[k] << " in 3D");
        CHECK(flat[k] > 20);
        CHECK(solid[k] > 20);
    }
}

namespace {

/// Patches that claim no element and make no edge twice.
template <int D>
std::vector<TopologyPatch<D>> disjoint_patches(const DynamicMesh<D>& mesh, Dice& dice, std::size_t tries) {
    StarWorkspace<D> workspace;
    std::vector<TopologyPatch<D>> patches;
    std::vector<std::uint8_t> claimed(mesh.points.size(), 0);
    for (std::size_t t = 0; t < tries; ++t) {
        auto patch = planned(mesh, static_cast<Kind>(dice.below(kinds)), dice, workspace);
        if (!patch) continue;
        std::vector<VertexId> vertices;
        for (const ElementId e : patch->removed.elements)
            for (const VertexId v : mesh.elements.vertices[e]) vertices.push_back(v);
        if (std::ranges::any_of(vertices, [&](VertexId v) { return claimed[v.index()] != 0; })) continue;
        for (const VertexId v : vertices) claimed[v.index()] = 1;
        patches.push_back(std::move(*patch));
    }
    return patches;
}

template <int D>
void commuting(std::uint64_t seed) {
    Dice dice(seed);
    const DynamicMesh<D> mesh = dynamic_of(random_domain<D>(seed));
    auto patches = disjoint_patches(mesh, dice, 60);
    const auto once = must(commit<D>(mesh, patches)).mesh;
    expect_sound(once);
    std::reverse(patches.begin(), patches.end());
    RC_ASSERT(by_places(must(commit<D>(mesh, patches)).mesh) == by_places(once));
}

}  // namespace

TEST_CASE("patches") {
    property("that are disjoint commute, 2D", [](std::uint64_t seed) { commuting<2>(seed); });
    property("that are disjoint commute, 3D", [](std::uint64_t seed) { commuting<3>(seed); }, {.count = 40});
}

TEST_CASE("a commit of nothing is nothing; what does not fit is refused, and nothing is changed") {
    const DynamicMesh<3> mesh = dynamic_of(random_domain<3>(7));
    const auto same = must(commit<3>(mesh, {}));
    CHECK(same.mesh.elements == mesh.elements);
    CHECK(same.mesh.stamp == mesh.stamp);
    CHECK(same.changes == TopologyChanges{});

    StarWorkspace<3> workspace;
    Dice dice(1);
    const auto patch = planned(mesh, Kind::insert, dice, workspace).value();
    const std::array twice{patch, patch};
    const auto overlap = commit<3>(mesh, twice);
    REQUIRE(!overlap.has_value());
    CHECK(overlap.error().what == "two patches remove one element");
    const auto changed = must(commit<3>(mesh, {&patch, 1})).mesh;
    const auto late = commit<3>(changed, {&patch, 1});
    REQUIRE(!late.has_value());
    CHECK(late.error().what == "a patch was planned for another mesh");
    CHECK(check_consistency(mesh, alone).has_value());
}

TEST_CASE("a point that is put in and taken out again leaves the mesh as it was") {
    property("3D", [](std::uint64_t seed) {
        const DynamicMesh<3> mesh = dynamic_of(random_domain<3>(seed));
        Dice dice(seed);
        StarWorkspace<3> workspace;
        const auto in = planned(mesh, static_cast<Kind>(dice.below(3)), dice, workspace);
        RC_PRE(in.has_value());
        auto [with, changes] = must(commit<3>(mesh, {&*in, 1}));
        const VertexId point = changes.points.front();
        // Back into each vertex around it that allows it: one of them gives the same elements again.
        TopologyPatch<3> out{with.stamp, {}, {}, {}};
        cavity_of_vertex(with, point, out.removed);
        bool found = false;
        for (const VertexId v : in->star.boundary) {
            out.point.vertex = v;
            if (!may_collapse(with, out.removed, point, v)) continue;
            if (star(with, out.removed, v, workspace, out.star) != StarFailure::none || !fills(with, out)) continue;
            const auto back = must(commit<3>(with, {&out, 1})).mesh;
            expect_sound(back);
            RC_ASSERT(back.vertex_count() == mesh.vertex_count());
            found = found || by_places(back) == by_places(mesh);
        }
        RC_ASSERT(found);
    });
}

TEST_CASE("what must stay stays") {
    LinearMesh<3> mesh = random_domain<3>(3);
    mesh.required_vertices = Buffer<VertexId>{VertexId(0)};
    mesh.elements.required = Buffer<std::uint32_t>{2};
    const DynamicMesh<3> dynamic = dynamic_of(mesh);
    StarWorkspace<3> workspace;
    Star<3> made;
    CavityParts<3> cavity;
    cavity_of_vertex(dynamic, VertexId(0), cavity);
    CHECK(star(dynamic, cavity, mesh.elements.vertices[cavity.elements[0]][1], workspace, made) != StarFailure::none);
    cavity = {{ElementId(2)}, {}, {}};
    CHECK(star(dynamic, cavity, VertexId{}, workspace, made) == StarFailure::required);
    // A cavity that is no ball: two elements that share at most an edge.
    cavity = {{ElementId(0)}, {}, {}};
    for (std::size_t e = 3; e < mesh.elements.size(); ++e) {
        cavity.elements = {ElementId(0), ElementId(e)};
        if (std::ranges::find(dynamic.across[0], Across(ElementId(e))) == dynamic.across[0].end()) break;
    }
    CHECK(star(dynamic, cavity, VertexId{}, workspace, made) == StarFailure::ball);
}

TEST_CASE("a surface that would be gone is not gone: a hole stays a hole, an inclusion an inclusion") {
    for (const bool is_hole : {true, false}) {
        LatticeOptions<2> options;
        options.cells = {3, 3};
        if (is_hole) options.keep = [](const Cell<2>& c) { return c != Cell<2>{1, 1}; };
        LinearMesh<2> mesh = lattice_mesh(options);
        Buffer<Reference> materials(mesh.elements.size(), 1);
        for (std::size_t e = 0; e < materials.size(); ++e) {
            const Vec<2> m = middle_of(mesh, mesh.elements.vertices[e]);
            if (m[0] > 1 && m[0] < 2 && m[1] > 1 && m[1] < 2) materials[e] = 2;
        }
        mesh.elements.references = materials;
        Buffer<SimplexVertices<1>> facets;
        Buffer<Reference> references;
        const auto edges = must(unique_edges(mesh, alone));
        const auto around = must(shells(edges, alone));
        for (std::size_t e = 0; e < edges.size(); ++e) {
            const bool between =
                around[e].size() == 2 && materials[around[e][0].index()] != materials[around[e][1].index()];
            if (around[e].size() == 2 && !between) continue;
            facets.push_back({edges.vertices[e][0], edges.vertices[e][1]});
            const Vec<2> m = midpoint(mesh.points[facets.back()[0]], mesh.points[facets.back()[1]]);
            references.push_back(m[0] > 0.5 && m[0] < 2.5 && m[1] > 0.5 && m[1] < 2.5 ? 7 : 1);
        }
        mesh.facets = {std::move(facets), std::move(references), {}};
        const auto dynamic = dynamic_of(mesh);
        CavityParts<2> cavity;
        for (std::size_t e = 0; e < mesh.elements.size(); ++e) cavity.elements.emplace_back(e);
        for (std::size_t f = 0; f < mesh.facets.size(); ++f)
            if (mesh.facets.references[f] == 7) cavity.facets.emplace_back(f);
        StarWorkspace<2> workspace;
        Star<2> made;
        CHECK(star(dynamic, cavity, VertexId{}, workspace, made) == StarFailure::surface);
    }
}

TEST_CASE("along a curve inside of the volume vertices go into one another, and others into them") {
    LatticeOptions<3> options;
    options.cells = {4, 2, 2};
    LinearMesh<3> mesh = with_references<3>(lattice_mesh(options), options.cells, false);
    mesh.elements.references = Buffer<Reference>(mesh.elements.size(), 1);
    Buffer<SimplexVertices<2>> outer;
    Buffer<Reference> references;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        if (mesh.facets.references[f] < 20) {
            outer.push_back(mesh.facets.vertices[f]);
            references.push_back(mesh.facets.references[f]);
        }
    mesh.facets = {std::move(outer), std::move(references), {}};
    const auto at = [&](double x, double y, double z) {
        std::size_t v = 0;
        while (mesh.points[v] != Vec<3>{{x, y, z}}) ++v;
        return VertexId(v);
    };
    mesh.edges = {Buffer<SimplexVertices<1>>{{at(1, 1, 1), at(2, 1, 1)}, {at(2, 1, 1), at(3, 1, 1)}},
                  Buffer<Reference>(2, 5),
                  {}};
    const auto dynamic = dynamic_of(mesh);
    CHECK(dynamic.states[at(2, 1, 1)].place == VertexPlace::line);
    CHECK(dynamic.states[at(1, 1, 1)].place == VertexPlace::corner);
    StarWorkspace<3> workspace;
    TopologyPatch<3> patch{dynamic.stamp, {at(1, 1, 1)}, {}, {}};
    cavity_of_vertex(dynamic, at(2, 1, 1), patch.removed);
    CHECK(may_collapse(dynamic, patch.removed, at(2, 1, 1), at(1, 1, 1)));
    REQUIRE(star(dynamic, patch.removed, at(1, 1, 1), workspace, patch.star) == StarFailure::none);
    const auto along = must(commit<3>(dynamic, {&patch, 1})).mesh;
    CHECK(check_consistency(along, alone).has_value());
    CHECK(along.line_count() == dynamic.line_count() - 1);
    // The vertex of the line reinserted.
    patch.point.vertex = at(2, 1, 1);
    CHECK(star(dynamic, patch.removed, at(2, 1, 1), workspace, patch.star) == StarFailure::none);
}
