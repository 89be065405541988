// Delaunay triangulation with exact predicates, and points on circles and spheres.
module;
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <span>
#include <tuple>
#include <utility>
#include <vector>
module camber.shapes;
import camber.core;

namespace camber {

namespace {

/// Integers in [−2^22, 2^22], so that predicates fit in 128 bits.
template <int D>
using GridPoint = std::array<std::int64_t, D>;

// NOLINTNEXTLINE(*-pedantic): the one way to exact predicates without a library
__extension__ typedef __int128 Int128;

template <int D>
std::vector<GridPoint<D>> grid_points(std::span<const Vec<D>> points) {
    Box<D> box;
    for (const Vec<D>& p : points) box.include(p);
    double extent = 0;
    for (int i = 0; i < D; ++i) extent = std::fmax(extent, box.high[i] - box.low[i]);
    // The number of grid steps per unit is a power of two. So coordinates with few binary digits, such as those of
    // lattices, stay exact, and planes stay plane.
    int exponent = 0;
    std::frexp(extent, &exponent);
    const double steps = std::ldexp(1.0, 23 - exponent);
    std::vector<GridPoint<D>> grid(points.size());
    for (std::size_t v = 0; v < points.size(); ++v)
        for (int i = 0; i < D; ++i) grid[v][i] = std::llround((points[v][i] - midpoint(box.low, box.high)[i]) * steps);
    return grid;
}

template <class T>
T determinant3(const std::array<std::array<T, 3>, 3>& m) {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

int sign(Int128 x) { return (x > 0) - (x < 0); }

/// Sign of a simplex's volume: 1, 0 (flat) or −1. The determinant is at most 6 · 2^69.
int orientation(const std::array<const GridPoint<2>*, 3>& s) {
    std::array<GridPoint<2>, 2> d{};
    for (int r = 0; r < 2; ++r)
        for (int i = 0; i < 2; ++i) d[r][i] = (*s[r + 1])[i] - (*s[0])[i];
    return sign(Int128{d[0][0]} * d[1][1] - Int128{d[0][1]} * d[1][0]);
}
int orientation(const std::array<const GridPoint<3>*, 4>& s) {
    std::array<std::array<Int128, 3>, 3> d{};
    for (int r = 0; r < 3; ++r)
        for (int i = 0; i < 3; ++i) d[r][i] = (*s[r + 1])[i] - (*s[0])[i];
    return sign(determinant3(d));
}

/// Returns 1 if p is inside the circumcircle of a positively oriented triangle, 0 if p is on it, −1 if outside.
int in_sphere(const std::array<const GridPoint<2>*, 3>& s, const GridPoint<2>& p) {
    std::array<std::array<Int128, 3>, 3> m{};
    for (int r = 0; r < 3; ++r) {
        const std::int64_t x = (*s[r])[0] - p[0], y = (*s[r])[1] - p[1];
        m[r] = {x, y, Int128{x} * x + Int128{y} * y};
    }
    return sign(determinant3(m));
}

template <class T>
T lifted(const std::array<std::array<T, 3>, 4>& d, const std::array<T, 4>& squares) {
    const auto minor = [&](int a, int b, int c) { return determinant3<T>({d[a], d[b], d[c]}); };
    return squares[0] * minor(1, 2, 3) - squares[1] * minor(0, 2, 3) + squares[2] * minor(0, 1, 3) -
           squares[3] * minor(0, 1, 2);
}

/// Returns 1, 0 or −1 if p is inside, on or outside the circumsphere of a positively oriented tetrahedron. Doubles are
/// used if their sign is certain, else exact integers. These are at most 24 · 2^(69 + 47.6) < 2^122.
int in_sphere(const std::array<const GridPoint<3>*, 4>& s, const GridPoint<3>& p) {
    std::array<std::array<double, 3>, 4> d{};
    std::array<double, 4> squares{};
    std::array<double, 3> largest{};
    double largest_square = 0;
    for (int r = 0; r < 4; ++r) {
        for (int i = 0; i < 3; ++i) {
            d[r][i] = static_cast<double>((*s[r])[i] - p[i]);
            squares[r] += d[r][i] * d[r][i];
            largest[i] = std::fmax(largest[i], std::fabs(d[r][i]));
        }
        largest_square = std::fmax(largest_square, squares[r]);
    }
    // Error bound: the determinant has 24 products of 4 factors, and each product has fewer than 16 rounding errors of
    // 2^−53.
    const double error = 24 * 0x1p-49 * largest[0] * largest[1] * largest[2] * largest_square;
    if (const double value = lifted(d, squares); std::fabs(value) > error) return value > 0 ? 1 : -1;
    std::array<std::array<Int128, 3>, 4> exact{};
    std::array<Int128, 4> exact_squares{};
    for (int r = 0; r < 4; ++r)
        for (int i = 0; i < 3; ++i) {
            exact[r][i] = (*s[r])[i] - p[i];
            exact_squares[r] += exact[r][i] * exact[r][i];
        }
    return sign(lifted(exact, exact_squares));
}

template <int D>
std::uint64_t z_order(const GridPoint<D>& p) {
    std::uint64_t key = 0;
    for (int bit = 23; bit >= 3; --bit)  // 21 bits for each axis, so 63 bits in 3D
        for (int i = 0; i < D; ++i)
            key = key << 1U | (static_cast<std::uint64_t>(p[i] + (std::int64_t{1} << 22)) >> bit & 1U);
    return key;
}

/// Bowyer–Watson algorithm. It removes the simplices whose circumspheres contain the new point, and joins the hole's
/// boundary to this point. Ghost simplices join the facets of the hull to infinity; their "sphere" is the half space
/// beyond the facet.
template <int D>
class Triangulation {
  public:
    using Index = std::uint32_t;
    static constexpr Index none = 0xffffffffU;

    Triangulation(std::span<const Vec<D>> points, const Noise& noise)
        : grid_(grid_points(points)), infinity_(static_cast<Index>(points.size())), noise_(noise) {}

    Outcome<Done> build() {
        std::vector<Index> order = insertion_order();
        if (!start(order)) return fail(ErrorKind::usage, "the points lie in one plane, or there are too few of them");
        for (const Index p : order)
            if (!insert(p))
                return fail(ErrorKind::usage, "two points have the same position", {}, Entity{"vertex", p + 1ULL});
        return Done{};
    }

    [[nodiscard]] Buffer<SimplexVertices<D>> finite() const {
        Buffer<SimplexVertices<D>> out;
        for (const Cell& cell : cells_) {
            if (cell.dead || is_ghost(cell)) continue;
            SimplexVertices<D> s;
            for (int i = 0; i <= D; ++i) s[i] = VertexId(cell.vertices[i]);
            out.push_back(s);
        }
        return out;
    }

  private:
    struct Cell {
        std::array<Index, D + 1> vertices{};
        std::array<Index, D + 1> neighbours{};  ///< for each vertex the cell across the opposite face
        Index stamp = 0;                        ///< number of the last insertion that tested this cell
        bool conflict = false;
        bool dead = false;
    };
    struct Face {
        Index cell;
        int opposite;
    };

    /// Position of the infinite vertex in the cell; −1 in a finite cell.
    [[nodiscard]] int infinite_slot(const Cell& cell) const {
        for (int i = 0; i <= D; ++i)
            if (cell.vertices[i] == infinity_) return i;
        return -1;
    }
    [[nodiscard]] bool is_ghost(const Cell& cell) const { return infinite_slot(cell) >= 0; }
    [[nodiscard]] std::array<const GridPoint<D>*, D + 1> corners(const std::array<Index, D + 1>& vertices) const {
        std::array<const GridPoint<D>*, D + 1> at{};
        for (int i = 0; i <= D; ++i) at[i] = &grid_[vertices[i]];
        return at;
    }
    /// Orientation of the cell with p in place of vertex `slot`. It is negative if p is beyond the face opposite this
    /// vertex.
    [[nodiscard]] int side(const Cell& cell, int slot, Index p) const {
        auto vertices = cell.vertices;
        vertices[slot] = p;
        return orientation(corners(vertices));
    }

    /// Biased randomised insertion order: a random half of the points is last, a quarter is before it, and so on. Each
    /// group is sorted along a Z-curve. Expected time is linear, and walks are short.
    std::vector<Index> insertion_order() const {
        std::vector<Index> order(grid_.size());
        std::iota(order.begin(), order.end(), Index{0});
        std::vector<std::tuple<int, std::uint64_t>> keys(grid_.size());
        for (const Index p : order) keys[p] = {-std::countr_zero(noise_.bits(p) | 1ULL << 40U), z_order<D>(grid_[p])};
        std::sort(order.begin(), order.end(),
                  [&](Index a, Index b) { return std::tie(keys[a], a) < std::tie(keys[b], b); });
        return order;
    }

    bool start(std::vector<Index>& order) {
        std::array<Index, D + 1> first{};
        int have = 0;
        std::vector<Index> rest;
        for (const Index p : order) {
            if (have <= D && extends(first, have, p))
                first[have++] = p;
            else
                rest.push_back(p);
        }
        if (have <= D) return false;
        if (orientation(corners(first)) < 0) std::swap(first[0], first[1]);
        cells_.push_back({first});
        for (int i = 0; i <= D; ++i) {
            // The ghost cell is on the other side of face i, so its vertices need the opposite orientation: two of them
            // are swapped.
            Cell ghost{first};
            ghost.vertices[i] = infinity_;
            std::swap(ghost.vertices[(i + 1) % (D + 1)], ghost.vertices[(i + 2) % (D + 1)]);
            cells_.push_back(ghost);
        }
        link_all();
        order = std::move(rest);
        return true;
    }

    /// True if p is not in the affine hull of the first `have` points. The test by minors is exact.
    [[nodiscard]] bool extends(const std::array<Index, D + 1>& first, int have, Index p) const {
        const auto difference = [&](Index a, int i) { return Int128{grid_[a][i] - grid_[first[0]][i]}; };
        if (have == 0) return true;
        if (have == 1) return grid_[p] != grid_[first[0]];
        if (have == 2) {
            for (int i = 0; i < D; ++i)
                for (int j = 0; j < i; ++j)
                    if (difference(first[1], i) * difference(p, j) != difference(first[1], j) * difference(p, i))
                        return true;
            return false;
        }
        auto all = first;
        all[D] = p;
        return orientation(corners(all)) != 0;
    }

    void link_all() {
        const auto face = [&](Index cell, int opposite) {
            std::array<Index, D + 1> key = cells_[cell].vertices;
            key[opposite] = none;
            std::sort(key.begin(), key.end());
            return key;
        };
        for (Index a = 0; a < cells_.size(); ++a)
            for (Index b = 0; b < cells_.size(); ++b)
                for (int i = 0; i <= D && a != b; ++i)
                    for (int j = 0; j <= D; ++j)
                        if (face(a, i) == face(b, j)) cells_[a].neighbours[i] = b;
    }

    [[nodiscard]] Index locate(Index p) const {
        Index at = last_;
        if (const int slot = infinite_slot(cells_[at]); slot >= 0) at = cells_[at].neighbours[slot];
        for (std::uint64_t step = 0;; ++step) {
            const Cell& cell = cells_[at];
            if (is_ghost(cell)) return at;
            const int turn = static_cast<int>(noise_.bits(p, step) % (D + 1));
            bool moved = false;
            for (int k = 0; k <= D && !moved; ++k) {
                const int i = (k + turn) % (D + 1);
                if (side(cell, i, p) >= 0) continue;
                at = cell.neighbours[i];
                moved = true;
            }
            if (!moved) return at;
        }
    }

    [[nodiscard]] bool in_conflict(Index at, Index p) {
        Cell& cell = cells_[at];
        if (cell.stamp == stamp_) return cell.conflict;
        bool conflict = false;
        const int slot = infinite_slot(cell);
        if (slot < 0) {
            conflict = in_sphere(corners(cell.vertices), grid_[p]) > 0;
        } else {
            const int beyond = side(cell, slot, p);
            // For p in the plane of the hull facet, the sphere of the finite cell at this facet decides.
            conflict =
                beyond != 0 ? beyond > 0 : in_sphere(corners(cells_[cell.neighbours[slot]].vertices), grid_[p]) > 0;
        }
        cell.stamp = stamp_;
        cell.conflict = conflict;
        return conflict;
    }

    bool insert(Index p) {
        ++stamp_;
        const Index from = locate(p);
        if (!in_conflict(from, p)) return false;
        hole_.assign(1, from);
        rim_.clear();
        cells_[from].dead = true;
        for (std::size_t k = 0; k < hole_.size(); ++k)
            for (int i = 0; i <= D; ++i) look_across(hole_[k], i, p);
        std::erase_if(rim_, [&](const Face& f) { return cells_[cells_[f.cell].neighbours[f.opposite]].dead; });
        star(p);
        return true;
    }

    /// Adds the cell across face i to the hole if its sphere contains p, else adds the face to the hole's boundary.
    void look_across(Index at, int i, Index p) {
        const Index across = cells_[at].neighbours[i];
        if (cells_[across].dead) return;
        // Exact predicates ensure that p is not in the plane of a boundary face of the hole. Otherwise p would be
        // inside the face's circle, and so inside the sphere of the cell across the face.
        if (in_conflict(across, p)) {
            cells_[across].dead = true;
            hole_.push_back(across);
        } else {
            rim_.push_back({at, i});
        }
    }

    /// Joins the hole's boundary to p by new cells, which are neighbours if they share p and D − 1 other vertices.
    void star(Index p) {
        shared_.clear();
        std::size_t reuse = 0;
        new_cells_.clear();
        for (const Face& face : rim_) {
            Cell cell{cells_[face.cell].vertices};
            cell.vertices[face.opposite] = p;
            cell.neighbours[face.opposite] = cells_[face.cell].neighbours[face.opposite];
            new_cells_.push_back(cell);
        }
        for (std::size_t k = 0; k < rim_.size(); ++k) {
            const Index at = reuse < hole_.size() ? hole_[reuse++] : static_cast<Index>(cells_.size());
            if (at == cells_.size()) cells_.emplace_back();
            const Cell& cell = cells_[at] = new_cells_[k];
            const int opposite = rim_[k].opposite;
            Cell& beyond = cells_[cell.neighbours[opposite]];
            for (int j = 0; j <= D; ++j)
                if (!contains(cell.vertices, beyond.vertices[j], opposite)) beyond.neighbours[j] = at;
            for (int i = 0; i <= D; ++i) {
                if (i == opposite) continue;
                auto key = cell.vertices;
                key[i] = key[opposite] = none;
                std::sort(key.begin(), key.end());
                shared_.push_back({key, at, i});
            }
            last_ = at;
        }
        std::sort(shared_.begin(), shared_.end(), [](const Shared& a, const Shared& b) { return a.key < b.key; });
        for (std::size_t k = 0; k + 1 < shared_.size(); k += 2) {
            cells_[shared_[k].cell].neighbours[shared_[k].opposite] = shared_[k + 1].cell;
            cells_[shared_[k + 1].cell].neighbours[shared_[k + 1].opposite] = shared_[k].cell;
        }
    }
    [[nodiscard]] static bool contains(const std::array<Index, D + 1>& vertices, Index v, int except) {
        for (int i = 0; i <= D; ++i)
            if (i != except && vertices[i] == v) return true;
        return false;
    }

    struct Shared {
        std::array<Index, D + 1> key;
        Index cell;
        int opposite;
    };

    std::vector<GridPoint<D>> grid_;
    Index infinity_;
    Noise noise_;
    std::vector<Cell> cells_;
    Index stamp_ = 0, last_ = 0;
    std::vector<Index> hole_;
    std::vector<Face> rim_;
    std::vector<Cell> new_cells_;
    std::vector<Shared> shared_;
};

}  // namespace

template <int D>
Outcome<Buffer<SimplexVertices<D>>> delaunay(std::span<const Vec<D>> points, const Noise& noise) {
    Triangulation<D> triangulation(points, noise);
    return triangulation.build().map([&](Done) { return triangulation.finite(); });
}

namespace {

std::array<Vec<3>, 3> random_axes(const Noise& noise) {
    std::uint64_t draw = 0;
    const auto direction = [&] {
        Vec<3> v;
        do v = noise.vector<3>(draw++);
        while (norm_squared(v) > 1 || norm_squared(v) < 0.01);
        return normalised(v);
    };
    const Vec<3> x = direction();
    Vec<3> y;
    do {
        const Vec<3> v = direction();
        y = v - dot(v, x) * x;
    } while (norm_squared(y) < 0.01);
    y = normalised(y);
    return {x, y, cross(x, y)};
}

Buffer<Vec<2>> circle(std::size_t n, double start) {
    Buffer<Vec<2>> points(n);
    for (std::size_t i = 0; i < n; ++i) {
        const double angle = 2 * std::numbers::pi * (static_cast<double>(i) + start) / static_cast<double>(n);
        points[i] = normalised(Vec<2>{{cos(angle), sin(angle)}});
    }
    return points;
}

/// Builds an icosphere. A point is identified by integer weights of icosahedron corners, so that adjacent faces share
/// points.
class IcosphereBuilder {
  public:
    explicit IcosphereBuilder(int n) : n_(n), side_(static_cast<std::size_t>(n) + 1) {}

    UnitSphere<3> build() {
        constexpr double g = std::numbers::phi;
        for (const auto& [a, b] : std::array<std::array<double, 2>, 4>{{{-1, g}, {1, g}, {-1, -g}, {1, -g}}}) {
            corners_.push_back({{a, b, 0}});
            corners_.push_back({{0, a, b}});
            corners_.push_back({{b, 0, a}});
        }
        const std::size_t squares = (side_ - 1) * (side_ - 1);
        sphere_.points.reserve(10 * squares + 2);
        sphere_.facets.reserve(20 * squares);
        on_edges_.resize(12 * 12);
        // The faces of the icosahedron are the triples of corners at mutual distance 2, the minimum.
        for (int a = 0; a < 12; ++a)
            for (int b = a + 1; b < 12; ++b)
                for (int c = b + 1; c < 12; ++c)
                    if (adjacent(a, b) && adjacent(b, c) && adjacent(a, c)) add_face({a, b, c});
        return std::move(sphere_);
    }

  private:
    [[nodiscard]] bool adjacent(int a, int b) const { return norm_squared(corners_[a] - corners_[b]) < 5; }

    void add_face(std::array<int, 3> face) {
        if (det(corners_[face[0]], corners_[face[1]], corners_[face[2]]) < 0) std::swap(face[0], face[1]);
        inside_.assign(side_ * side_, VertexId());
        const auto at = [&](int i, int j) { return vertex(face, {n_ - i - j, i, j}); };
        for (int i = 0; i < n_; ++i)
            for (int j = 0; i + j < n_; ++j) {
                sphere_.facets.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
                if (i + j + 2 <= n_) sphere_.facets.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
            }
    }

    VertexId vertex(const std::array<int, 3>& face, const std::array<int, 3>& weights) {
        VertexId& id = place(face, weights);
        if (id.valid()) return id;
        id = VertexId(sphere_.points.size());
        std::array<int, 3> order{0, 1, 2};
        std::sort(order.begin(), order.end(), [&](int a, int b) { return face[a] < face[b]; });
        Vec<3> p;
        for (const int k : order)
            if (weights[k] > 0) p += static_cast<double>(weights[k]) * corners_[face[k]];
        sphere_.points.push_back(normalised(p));
        return id;
    }

    VertexId& place(const std::array<int, 3>& face, const std::array<int, 3>& weights) {
        for (int k = 0; k < 3; ++k) {
            if (weights[k] == n_) return at_corners_[face[k]];
            if (weights[k] > 0) continue;
            int low = (k + 1) % 3, high = (k + 2) % 3;
            if (weights[low] == 0 || weights[high] == 0) continue;
            if (face[low] > face[high]) std::swap(low, high);
            auto& edge = on_edges_[static_cast<std::size_t>(face[low]) * 12 + face[high]];
            edge.resize(side_);
            return edge[weights[low]];
        }
        return inside_[side_ * weights[1] + weights[2]];
    }

    int n_;
    std::size_t side_;
    std::vector<Vec<3>> corners_;
    std::array<VertexId, 12> at_corners_;
    std::vector<std::vector<VertexId>> on_edges_;  ///< points on the icosahedron's edges; row: 12 × lower corner +
                                                   ///< higher corner; column: weight of the lower corner
    std::vector<VertexId> inside_;
    UnitSphere<3> sphere_;
};

}  // namespace

template <>
Buffer<Vec<2>> spread_points<2>(std::size_t n, const Noise& noise) {
    return circle(n, noise.symmetric(0));
}

template <>
Buffer<Vec<3>> spread_points<3>(std::size_t n, const Noise& noise) {
    const auto axes = random_axes(noise);
    const double golden_angle = std::numbers::pi * (3 - std::sqrt(5.0));
    const double c = cos(golden_angle), s = sin(golden_angle);
    Buffer<Vec<3>> points(n);
    double x = 1, y = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const double z = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(n);
        const double r = std::sqrt(1 - z * z);
        points[i] = normalised(r * x * axes[0] + r * y * axes[1] + z * axes[2]);
        const double turned = c * x - s * y;
        y = s * x + c * y;
        x = turned;
    }
    return points;
}

template <>
UnitSphere<2> icosphere<2>(int n) {
    UnitSphere<2> sphere{circle(5 * static_cast<std::size_t>(n), 0), {}};
    const std::size_t count = sphere.points.size();
    // In 2D, facets are edges. They run clockwise, so that an edge and the outward direction are positively oriented,
    // as in 3D.
    for (std::size_t i = 0; i < count; ++i) sphere.facets.push_back({VertexId((i + 1) % count), VertexId(i)});
    return sphere;
}

template <>
UnitSphere<3> icosphere<3>(int n) {
    return IcosphereBuilder(n).build();
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<Buffer<SimplexVertices<D>>> delaunay<D>(std::span<const Vec<D>>, const Noise&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
