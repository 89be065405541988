// Detection of elements that overlap although no walls cross.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <map>
#include <numbers>
#include <set>
#include <type_traits>
#include <utility>
#include <vector>

#include "facets.hpp"
#include "property.hpp"
#include "sanitized.hpp"

import camber.core;
import camber.bezier;
import camber.crossing;

using namespace camber;
using camber::testing::property;
using namespace camber::testing;

namespace {

/// Bodies of lattice cells, cut into simplices along a diagonal of each cell.
template <int D>
class Bodies {
  public:
    using Cell = std::array<int, D>;

    /// Adds a cell of this size. Vertices at lattice points in `vertices` are shared, all others are new.
    void add(const Cell& low, int size, std::map<Cell, VertexId>& vertices) {
        std::array<int, D> axes;
        for (int i = 0; i < D; ++i) axes[i] = i;
        do {
            SimplexVertices<D> element;
            Cell at = low;
            element[0] = vertex(at, vertices);
            int inversions = 0;
            for (int i = 0; i < D; ++i) {
                at[axes[i]] += size;
                element[i + 1] = vertex(at, vertices);
                for (int j = 0; j < i; ++j) inversions += axes[j] > axes[i] ? 1 : 0;
            }
            if (inversions % 2 == 1) std::swap(element[0], element[1]);
            elements_.push_back(element);
        } while (std::next_permutation(axes.begin(), axes.end()));
    }

    /// Adds all cells of a block except those that `is_left_out` selects.
    template <class Excluded>
    void add_block(const Cell& low, const Cell& cells, int size, Excluded&& is_left_out) {
        std::map<Cell, VertexId> vertices;
        Cell at{};
        const auto add_cells = [&](const auto& self, int axis) -> void {
            if (axis == D) {
                Cell corner;
                for (int c = 0; c < D; ++c) corner[c] = low[c] + size * at[c];
                if (!is_left_out(corner)) add(corner, size, vertices);
                return;
            }
            for (at[axis] = 0; at[axis] < cells[axis]; ++at[axis]) self(self, axis + 1);
        };
        add_cells(add_cells, 0);
    }
    void add_block(const Cell& low, const Cell& cells, int size) {
        add_block(low, cells, size, [](const Cell&) { return false; });
    }

    void add_element(const SimplexVertices<D>& element) { elements_.push_back(element); }
    VertexId add_vertex(const Vec<D>& p) {
        points_.push_back(p);
        return VertexId(points_.size() - 1);
    }

    /// The mesh of degree 2 with all boundary faces listed. `place` maps the lattice points and the middles between
    /// them.
    template <class Place>
    [[nodiscard]] QuadraticMesh<D> mesh(Place&& place) const {
        LinearMesh<D> mesh;
        mesh.points = Buffer<Vec<D>>(points_.begin(), points_.end());
        mesh.point_references = Buffer<Reference>(points_.size(), 0);
        mesh.elements.vertices = Buffer<SimplexVertices<D>>(elements_.begin(), elements_.end());
        mesh.elements.references = Buffer<Reference>(elements_.size(), 0);
        std::map<std::array<VertexId, D>, std::pair<int, std::array<VertexId, D>>> faces;
        for (const auto& element : elements_)
            for (int i = 0; i <= D; ++i) {
                std::array<VertexId, D> face;
                for (int k = 0; k < D; ++k) face[k] = element[face_opposite<D>(i)[k]];
                auto key = face;
                std::sort(key.begin(), key.end());
                auto& [count, listed] = faces[key];
                ++count;
                listed = face;
                if (faces.size() % 2 == 0) std::swap(listed[0], listed[1]);  // files list facets in either orientation
            }
        Buffer<SimplexVertices<D - 1>> facets;
        for (const auto& [key, face] : faces)
            if (face.first == 1) facets.push_back(face.second);
        mesh.facets.references = Buffer<Reference>(facets.size(), 1);
        mesh.facets.vertices = std::move(facets);
        QuadraticMesh<D> curved = elevate(std::move(mesh), Execution{}).value();
        Buffer<LagrangeNode<D>> nodes = take(std::move(curved.mid_nodes));
        for (LagrangeNode<D>& node : nodes) node.point = place(node.point);
        curved.mid_nodes = std::move(nodes);
        Buffer<Vec<D>> points = take(std::move(curved.linear.points));
        for (Vec<D>& p : points) p = place(p);
        curved.linear.points = std::move(points);
        return curved;
    }
    [[nodiscard]] QuadraticMesh<D> mesh() const {
        return mesh([](const Vec<D>& p) { return p; });
    }
    /// The mesh with straight edges between the mapped lattice points.
    template <class Place>
    [[nodiscard]] QuadraticMesh<D> straight_mesh(Place&& place) const {
        Bodies moved = *this;
        for (Vec<D>& p : moved.points_) p = place(p);
        return moved.mesh();
    }

  private:
    VertexId vertex(const Cell& at, std::map<Cell, VertexId>& vertices) {
        const auto [found, is_new] = vertices.try_emplace(at);
        if (is_new) {
            Vec<D> p;
            for (int c = 0; c < D; ++c) p[c] = at[c];
            found->second = add_vertex(p);
        }
        return found->second;
    }

    std::vector<Vec<D>> points_;
    std::vector<SimplexVertices<D>> elements_;
};

template <int D>
Overlaps<D> overlaps_of(const QuadraticMesh<D>& mesh, int threads = 1) {
    const Execution execution{.threads = threads};
    return find_overlaps(mesh, find_crossings(mesh, execution).value(), execution).value();
}

/// True if the point is within the straight element, to rounding.
template <int D>
bool is_within(const QuadraticMesh<D>& mesh, ElementId e, const Vec<D>& p) {
    std::array<Vec<D>, D + 1> corners;
    for (int i = 0; i <= D; ++i) corners[i] = mesh.linear.points[mesh.linear.elements.vertices[e][i]];
    const auto volume = [](const std::array<Vec<D>, D + 1>& c) {
        if constexpr (D == 2)
            return det(c[1] - c[0], c[2] - c[0]);
        else
            return det(c[1] - c[0], c[2] - c[0], c[3] - c[0]);
    };
    const double whole = volume(corners);
    for (int i = 0; i <= D; ++i) {
        auto part = corners;
        part[i] = p;
        if (volume(part) < -1e-9 * whole) return false;
    }
    return true;
}

/// True if each pair consists of two straight elements whose common point is in both.
template <int D>
bool have_common_points(const QuadraticMesh<D>& mesh, const Overlaps<D>& overlaps) {
    return std::all_of(overlaps.found.begin(), overlaps.found.end(), [&](const ElementOverlap<D>& pair) {
        return pair.first < pair.second && is_within(mesh, pair.first, pair.point) &&
               is_within(mesh, pair.second, pair.point);
    });
}

/// A map with small integer entries and a positive determinant: lattice points stay exact, and planes become oblique.
template <int D>
auto oblique(Engine& engine) {
    std::array<Vec<D>, D> columns;
    const auto determinant = [&] {
        if constexpr (D == 2)
            return det(columns[0], columns[1]);
        else
            return det(columns[0], columns[1], columns[2]);
    };
    do {
        for (Vec<D>& column : columns)
            for (double& x : column.c) x = static_cast<int>(engine() % 7) - 3;
    } while (determinant() <= 0);
    return [columns](const Vec<D>& p) {
        Vec<D> q{};
        for (int c = 0; c < D; ++c) q += p[c] * columns[c];
        return q;
    };
}

/// A smooth map that rotates by less than a right angle everywhere.
template <int D>
Vec<D> bent(const Vec<D>& p) {
    Vec<D> q = p;
    for (int c = 0; c < D; ++c) q[c] += 0.2 * std::sin(0.7 * p[(c + 1) % D] + c);
    return q;
}
/// A map that preserves planes across the axes, but not the middles of edges.
template <int D>
Vec<D> stretched(const Vec<D>& p) {
    Vec<D> q = p;
    for (int c = 0; c < D; ++c) q[c] += 0.3 * std::sin(p[c]);
    return q;
}

/// Adds chains of cells of size 2, each joined only to the one before. Starts are arbitrary if `is_offset`, otherwise
/// on one lattice. Returns whether cells overlap.
template <int D>
bool add_walks(Bodies<D>& bodies, bool is_offset, Engine& engine) {
    using Cell = typename Bodies<D>::Cell;
    std::vector<Cell> cells;
    bool do_overlap = false;
    const int walks = 1 + static_cast<int>(engine() % 3);
    for (int w = 0; w < walks; ++w) {
        Cell at;
        for (int& x : at) x = is_offset ? static_cast<int>(engine() % 9) : 2 * static_cast<int>(engine() % 5);
        std::map<Cell, VertexId> shared;
        const int length = 1 + static_cast<int>(engine() % (D == 2 ? 7 : 5));
        Cell last = at;
        for (int k = 0; k < length; ++k) {
            if (k > 0) {
                Cell next = at;
                do {
                    next = at;
                    next[engine() % D] += engine() % 2 == 0 ? 2 : -2;
                } while (k > 1 && next == last);
                // Vertices of the common face are shared; all others are new.
                for (auto it = shared.begin(); it != shared.end();) {
                    bool is_common = true;
                    for (int c = 0; c < D; ++c)
                        is_common = is_common && it->first[c] >= std::max(at[c], next[c]) &&
                                    it->first[c] <= std::min(at[c], next[c]) + 2;
                    it = is_common ? std::next(it) : shared.erase(it);
                }
                last = std::exchange(at, next);
            }
            for (const Cell& other : cells) {
                bool meets = true;
                for (int c = 0; c < D; ++c) meets = meets && std::abs(other[c] - at[c]) < 2;
                do_overlap = do_overlap || meets;
            }
            bodies.add(at, 2, shared);
            cells.push_back(at);
        }
    }
    return do_overlap;
}

template <int D>
void test_walks(int& overlapping, int& clear) {
    Engine engine(*rc::gen::arbitrary<std::uint64_t>());
    Bodies<D> bodies;
    const bool do_overlap = add_walks(bodies, engine() % 2 == 0, engine);
    const QuadraticMesh<D> mesh = bodies.mesh(oblique<D>(engine));
    const Overlaps<D> found = overlaps_of(mesh);
    // Crossing walls are reported as crossings.
    const bool do_cross = find_crossings(mesh, Execution{}).value().crossing > 0;
    RC_ASSERT((do_cross || found.overlapping > 0) == do_overlap);
    RC_ASSERT(found.looked_at);
    RC_ASSERT(found.undecided == 0U);
    RC_ASSERT(found.overlapping >= found.found.size());
    RC_ASSERT((found.overlapping > 0) == !found.found.empty());
    RC_ASSERT(have_common_points(mesh, found));
    ++(do_overlap ? overlapping : clear);
}

template <int D>
void test_curved_walks(int& overlapping, int& clear) {
    Engine engine(*rc::gen::arbitrary<std::uint64_t>());
    Bodies<D> bodies;
    const bool keeps_planes = engine() % 2 == 0;
    const bool do_overlap = add_walks(bodies, keeps_planes && engine() % 2 == 0, engine);
    const QuadraticMesh<D> mesh = keeps_planes ? bodies.mesh(stretched<D>) : bodies.mesh(bent<D>);
    const Crossings crossings = find_crossings(mesh, Execution{}).value();
    const Overlaps<D> found = overlaps_of(mesh);
    const bool is_found = crossings.crossing > 0 || found.overlapping > 0;
    if (!do_overlap) RC_ASSERT(!is_found);
    // Contact of curved walls is not always decided, and counts as undecided then.
    if (do_overlap && crossings.undecided == 0 && found.undecided == 0) RC_ASSERT(is_found);
    ++(do_overlap ? overlapping : clear);
}

}  // namespace

TEST_CASE("chains of cells overlap exactly where two cells intersect") {
    int overlapping = 0, clear = 0;
    property("in the plane", [&] { test_walks<2>(overlapping, clear); });
    property("in space", [&] { test_walks<3>(overlapping, clear); });
    CHECK(std::min(overlapping, clear) > less_if_sanitized(10, 1));
}

TEST_CASE("curved chains of cells overlap exactly where two cells intersect") {
    int overlapping = 0, clear = 0;
    property("in the plane", [&] { test_curved_walks<2>(overlapping, clear); });
    property("in space", [&] { test_curved_walks<3>(overlapping, clear); });
    CHECK(std::min(overlapping, clear) > less_if_sanitized(10, 1));
}

TEST_CASE_TEMPLATE_DEFINE("a body inside another overlaps it unless there is a cavity", Dim, nested) {
    constexpr int D = Dim::value;
    using Cell = typename Bodies<D>::Cell;
    const auto cell = [](int x) {
        Cell c;
        c.fill(x);
        return c;
    };
    // A block of 5 cells of size 4 with or without a cavity at its middle cell. The inner body fills the cell or leaves
    // a gap.
    for (const bool has_cavity : {false, true})
        for (const int gap : {0, 1})
            for (const bool is_curved : {false, true}) {
                Bodies<D> bodies;
                bodies.add_block(cell(0), cell(5), 4, [&](const Cell& at) { return has_cavity && at == cell(8); });
                bodies.add_block(cell(8 + gap), cell(gap == 0 ? 1 : 2), gap == 0 ? 4 : 1);
                const QuadraticMesh<D> mesh =
                    is_curved ? bodies.mesh([](const Vec<D>& p) { return 4.0 * bent<D>(0.25 * p); }) : bodies.mesh();
                const Overlaps<D> found = overlaps_of(mesh);
                CAPTURE(has_cavity);
                CAPTURE(gap);
                CAPTURE(is_curved);
                CHECK(found.looked_at);
                CHECK(found.undecided == 0);
                CHECK((found.overlapping > 0) == !has_cavity);
                CHECK(found.found.empty() == has_cavity);
                if (!is_curved) CHECK(have_common_points(mesh, found));
                for (const auto& pair : found.found) CHECK(pair.first != pair.second);
                CHECK(found == overlaps_of(mesh, 3));
            }
}
TEST_CASE_TEMPLATE_INVOKE(nested, std::integral_constant<int, 2>, std::integral_constant<int, 3>);

namespace {

/// A ring of cells that closes after `turns` around the axis. Its section rotates by `half_turns`. Its centre is moved
/// by `offset` off the circle of radius 3, in a direction that rotates once (2D: not moved).
template <int D>
QuadraticMesh<D> ring(int cells, int turns, int half_turns, double offset) {
    Bodies<D> bodies;
    std::map<typename Bodies<D>::Cell, VertexId> vertices;
    const auto at = [](int i, int j, int k) {
        if constexpr (D == 2)
            return typename Bodies<D>::Cell{i, j};
        else
            return typename Bodies<D>::Cell{i, j, k};
    };
    bodies.add(at(0, 0, 0), 1, vertices);
    for (int j = 0; j < 2; ++j)
        for (int k = 0; k < D - 1; ++k) {
            const bool swaps = half_turns % 2 == 1;
            vertices[at(cells, j, k)] = vertices[swaps ? at(0, 1 - j, 1 - k) : at(0, j, k)];
        }
    for (int i = 1; i < cells; ++i) bodies.add(at(i, 0, 0), 1, vertices);
    constexpr double pi = std::numbers::pi;
    return bodies.straight_mesh([=](const Vec<D>& p) {
        const int i = static_cast<int>(p[0]);
        const double way = static_cast<double>(i) / cells;
        const double around = 2 * pi * (i * turns % cells) / cells;  // bitwise the same in each turn
        double r = 3 + p[1] - 0.5, z = 0;
        if constexpr (D == 3) {
            const double turn = pi * half_turns * way, x = p[1] - 0.5, y = p[2] - 0.5;
            r = 3 + x * std::cos(turn) - y * std::sin(turn) + offset * std::cos(2 * pi * way);
            z = x * std::sin(turn) + y * std::cos(turn) + offset * std::sin(2 * pi * way);
        }
        Vec<D> q{};
        q[0] = r * std::cos(around);
        q[1] = -r * std::sin(around);
        if constexpr (D == 3) q[2] = z;
        return q;
    });
}

/// Two coaxial rings of cells of equal height, given by their radii.
template <int D>
QuadraticMesh<D> coaxial_rings(std::array<int, 2> cells, std::array<std::array<double, 2>, 2> radii) {
    using Cell = typename Bodies<D>::Cell;
    Bodies<D> bodies;
    for (int b = 0; b < 2; ++b) {
        std::map<Cell, VertexId> vertices;
        const auto at = [&](int i, int j, int k) {
            if constexpr (D == 2)
                return Cell{i, 10 * b + j};
            else
                return Cell{i, 10 * b + j, k};
        };
        bodies.add(at(0, 0, 0), 1, vertices);
        for (int j = 0; j < 2; ++j)
            for (int k = 0; k < D - 1; ++k) vertices[at(cells[b], j, k)] = vertices[at(0, j, k)];
        for (int i = 1; i < cells[b]; ++i) bodies.add(at(i, 0, 0), 1, vertices);
    }
    return bodies.straight_mesh([=](const Vec<D>& p) {
        const int b = p[1] < 10 ? 0 : 1;
        const double t = 2 * std::numbers::pi * p[0] / cells[b], r = radii[b][static_cast<int>(p[1]) % 10];
        Vec<D> q = p;
        q[0] = r * std::cos(t);
        q[1] = -r * std::sin(t);
        return q;
    });
}

}  // namespace

TEST_CASE("rings wound once do not overlap") {
    for (const int cells : {8, 15, 40}) {
        CHECK(overlaps_of(ring<2>(cells, 1, 0, 0)) == Overlaps<2>{.looked_at = true, .walls = 2});
        for (const int half_turns : {0, 1, 2}) {
            if (cells == 8 && half_turns > 0) continue;  // too few cells for the twist
            const Overlaps<3> once = overlaps_of(ring<3>(cells, 1, half_turns, 0));
            CHECK(once == Overlaps<3>{.looked_at = true, .walls = 1});
        }
    }
    CHECK(overlaps_of(ring<3>(80, 2, 0, 1)) == Overlaps<3>{.looked_at = true, .walls = 1});  // the second turn runs
                                                                                             // beside the first one
}

TEST_CASE("rings wound twice overlap themselves") {
    for (const int cells : {16, 40}) {
        const QuadraticMesh<2> plane = ring<2>(cells, 2, 0, 0);
        const Overlaps<2> found = overlaps_of(plane);
        CHECK(find_crossings(plane, Execution{}).value().all_disjoint());
        CHECK(found.overlapping > 0);
        CHECK(have_common_points(plane, found));
        const QuadraticMesh<3> space = ring<3>(cells, 2, 0, 0);
        const Overlaps<3> in_space = overlaps_of(space);
        CHECK(in_space.overlapping > 0);
        CHECK(have_common_points(space, in_space));
    }
}

TEST_CASE_TEMPLATE_DEFINE("a pipe overlaps a surrounding pipe whose inner radius is too small", Dim, coaxial) {
    constexpr int D = Dim::value;
    const std::array<double, 2> pipe{1, 2};
    // With clearance; in contact with the same points; too narrow, with both ends in common planes (in space).
    CHECK(overlaps_of(coaxial_rings<D>({24, 30}, {{pipe, {2.2, 3}}})).overlapping == 0);
    CHECK(overlaps_of(coaxial_rings<D>({24, 24}, {{pipe, {2, 3}}})).overlapping == 0);
    const QuadraticMesh<D> mesh = coaxial_rings<D>({24, 30}, {{pipe, {1.8, 3}}});
    CHECK(find_crossings(mesh, Execution{}).value().crossing == 0);
    const Overlaps<D> found = overlaps_of(mesh);
    CHECK(found.overlapping > 0);
    CHECK(found.undecided == 0);
    CHECK(have_common_points(mesh, found));
}
TEST_CASE_TEMPLATE_INVOKE(coaxial, std::integral_constant<int, 2>, std::integral_constant<int, 3>);

TEST_CASE("a fan that winds around its vertex twice overlaps itself") {
    for (const int turns : {1, 2, 3})
        for (const int count : {5, 12}) {
            Bodies<2> bodies;
            const VertexId centre = bodies.add_vertex({});
            std::vector<VertexId> rim;
            for (int i = 0; i < count * turns; ++i) {
                const double t = 2 * std::numbers::pi * (i % count) / count;
                bodies.add_vertex({{std::cos(t), std::sin(t)}});
                rim.emplace_back(static_cast<std::size_t>(i + 1));
            }
            for (std::size_t i = 0; i < rim.size(); ++i)
                bodies.add_element({centre, rim[i], rim[(i + 1) % rim.size()]});
            const QuadraticMesh<2> mesh = bodies.mesh();
            const Overlaps<2> found = overlaps_of(mesh);
            CHECK((found.overlapping > 0) == (turns > 1));
            CHECK(have_common_points(mesh, found));
        }
}

TEST_CASE("a mesh with unlisted boundary faces is not examined for overlaps") {
    Bodies<3> bodies;
    bodies.add_block({0, 0, 0}, {2, 2, 2}, 1);
    QuadraticMesh<3> mesh = bodies.mesh();
    CHECK(overlaps_of(mesh) == Overlaps<3>{.looked_at = true, .walls = 1});
    const auto drop_last = [](auto& column) {
        auto items = take(std::move(column));
        items.pop_back();
        column = std::move(items);
    };
    drop_last(mesh.linear.facets.vertices);
    drop_last(mesh.linear.facets.references);
    drop_last(mesh.edges.of_facets);
    const auto crossings = find_crossings(mesh, Execution{});
    CHECK(find_overlaps(mesh, *crossings, Execution{}).value() == Overlaps<3>{});
}
