module;
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <tuple>
#include <utility>
#include <vector>
module camber.shapes;
import camber.core;
import :grid;

namespace camber {

namespace {

/// Bowyer–Watson: the simplices whose spheres hold the new point are emptied and the hole is starred from it. Outside
/// the hull, ghost simplices join each hull facet to one vertex at infinity; their "sphere" is the half space beyond.
template <int D>
class Triangulation {
  public:
    using Index = std::uint32_t;
    static constexpr Index none = 0xffffffffU;

    Triangulation(std::span<const Vec<D>> points, const Noise& noise)
        : grid_(grid_points(points)), infinity_(static_cast<Index>(points.size())), noise_(noise) {}

    Outcome<Done> build() {
        std::vector<Index> order = insertion_order();
        if (!start(order)) return fail(ErrorKind::usage, "the points lie in one plane, or are too few");
        for (const Index p : order)
            if (!insert(p))
                return fail(ErrorKind::usage, "two points are in the same place", {}, Entity{"vertex", p + 1ULL});
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
        std::array<Index, D + 1> neighbours{};  ///< across the face opposite each vertex
        Index stamp = 0;                        ///< the last insertion that asked about this cell …
        bool conflict = false;                  ///< … and the answer
        bool dead = false;
    };
    struct Face {
        Index cell;
        int opposite;
    };

    /// The ghost's vertex at infinity; −1 in a finite cell.
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
    /// Orientation of a cell with p in place of its vertex `slot`: negative when p is beyond that face.
    [[nodiscard]] int side(const Cell& cell, int slot, Index p) const {
        auto vertices = cell.vertices;
        vertices[slot] = p;
        return orientation(corners(vertices));
    }

    /// A random half last, a quarter before it …, each along a Z-curve: expected linear work on any input (biased
    /// randomised insertion order), with short walks.
    std::vector<Index> insertion_order() const {
        std::vector<Index> order(grid_.size());
        std::iota(order.begin(), order.end(), Index{0});
        std::vector<std::tuple<int, std::uint64_t>> keys(grid_.size());
        for (const Index p : order) keys[p] = {-std::countr_zero(noise_.bits(p) | 1ULL << 40U), z_order<D>(grid_[p])};
        std::sort(order.begin(), order.end(),
                  [&](Index a, Index b) { return std::tie(keys[a], a) < std::tie(keys[b], b); });
        return order;
    }

    /// The first simplex, of the first points in general position, which leave `order`, and its ghosts.
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
            // Orientation as if the point at infinity lay beyond face i: mirrored, so two vertices change places.
            Cell ghost{first};
            ghost.vertices[i] = infinity_;
            std::swap(ghost.vertices[(i + 1) % (D + 1)], ghost.vertices[(i + 2) % (D + 1)]);
            cells_.push_back(ghost);
        }
        link_all();
        order = std::move(rest);
        return true;
    }

    /// Whether p is not in the flat space of the first `have` points, by exact Gram elimination on minors.
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

    /// Neighbours of the few first cells, by comparing all faces.
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

    /// A cell in conflict with p: walks towards it, face by face.
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
            // In the plane of a hull facet: inside its circle or not, which the sphere of the cell behind it tells.
            conflict =
                beyond != 0 ? beyond > 0 : in_sphere(corners(cells_[cell.neighbours[slot]].vertices), grid_[p]) > 0;
        }
        cell.stamp = stamp_;
        cell.conflict = conflict;
        return conflict;
    }

    /// Empties the cells in conflict and fills the hole with a star; false when p is at a vertex.
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

    /// Looks across one face of a cell of the hole: either the cell there joins the hole, or the face is its rim.
    void look_across(Index at, int i, Index p) {
        const Index across = cells_[at].neighbours[i];
        if (cells_[across].dead) return;
        // With exact predicates the hole is star-shaped: were p in the plane of a rim face, it would be inside that
        // face's circle, so inside the sphere beyond it, too.
        if (in_conflict(across, p)) {
            cells_[across].dead = true;
            hole_.push_back(across);
        } else {
            rim_.push_back({at, i});
        }
    }

    /// Joins each rim face to p and links the new cells: to what is beyond the rim, and to each other where their
    /// faces share D − 1 vertices of the rim.
    void star(Index p) {
        shared_.clear();
        std::size_t reuse = 0;
        fresh_.clear();
        for (const Face& face : rim_) {
            Cell cell{cells_[face.cell].vertices};
            cell.vertices[face.opposite] = p;
            cell.neighbours[face.opposite] = cells_[face.cell].neighbours[face.opposite];
            fresh_.push_back(cell);
        }
        for (std::size_t k = 0; k < rim_.size(); ++k) {
            const Index at = reuse < hole_.size() ? hole_[reuse++] : static_cast<Index>(cells_.size());
            if (at == cells_.size()) cells_.emplace_back();
            const Cell& cell = cells_[at] = fresh_[k];
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
    /// Whether v is one of the vertices other than the one at `except`.
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
    std::vector<Cell> fresh_;
    std::vector<Shared> shared_;
};

}  // namespace

template <int D>
Outcome<Buffer<SimplexVertices<D>>> delaunay(std::span<const Vec<D>> points, const Noise& noise) {
    Triangulation<D> triangulation(points, noise);
    return triangulation.build().map([&](Done) { return triangulation.finite(); });
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<Buffer<SimplexVertices<D>>> delaunay<D>(std::span<const Vec<D>>, const Noise&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
