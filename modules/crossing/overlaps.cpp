module;
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>
module camber.crossing;
import camber.core;
import camber.box_tree;
import camber.bezier;

namespace camber {

namespace {

struct FacetSides {
    std::uint32_t count = 0, element = no_boundary_row;
    int opposite = 0;
};
template <std::size_t N>
std::array<std::uint64_t, N> key_of(const std::array<VertexId, N>& facet) {
    std::array<std::uint64_t, N> key{};
    for (std::size_t i = 0; i < N; ++i) key[i] = facet[i].value;
    return sorted(key);
}

template <int D>
std::vector<FacetSides> sides_of_facets(const LinearMesh<D>& mesh) {
    const auto& facets = mesh.facets.vertices;
    std::vector<std::uint8_t> is_marked(mesh.points.size(), 0);
    std::vector<std::array<std::uint64_t, D>> keys(facets.size());
    RowTable table(facets.size());
    for (std::size_t f = 0; f < facets.size(); ++f) {
        for (const VertexId v : facets[f]) is_marked[v.index()] = 1;
        keys[f] = key_of(facets[f]);
        table.insert(hash_of(keys[f]), static_cast<std::uint32_t>(f),
                     [&](std::uint32_t g) { return keys[g] == keys[f]; });
    }
    std::vector<FacetSides> sides(facets.size());
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
        const SimplexVertices<D>& element = mesh.elements.vertices[e];
        int unmarked = 0, member_index = -1;
        for (int i = 0; i <= D; ++i)
            if (is_marked[element[i].index()] == 0) {
                ++unmarked;
                member_index = i;
            }
        if (unmarked > 1) continue;
        for (int i = 0; i <= D; ++i) {
            if (unmarked == 1 && i != member_index) continue;
            std::array<VertexId, D> face;
            for (int k = 0; k < D; ++k) face[k] = element[face_opposite<D>(i)[k]];
            const auto key = key_of(face);
            const std::uint32_t f = table.find(hash_of(key), [&](std::uint32_t g) { return keys[g] == key; });
            if (f == RowTable::none) continue;
            ++sides[f].count;
            sides[f].element = static_cast<std::uint32_t>(e);
            sides[f].opposite = i;
        }
    }
    return sides;
}

template <int D>
class MeshNodes {
  public:
    explicit MeshNodes(const LinearMesh<D>& mesh) : linear_(mesh) {}
    explicit MeshNodes(const QuadraticMesh<D>& mesh) : linear_(mesh.linear), quadratic_(&mesh) {}

    [[nodiscard]] const LinearMesh<D>& linear() const { return linear_; }

    [[nodiscard]] NodalFacet<D> facet(FacetId f) const {
        return quadratic_ ? nodal_facet(*quadratic_, f) : straight_facet<D>(corners(linear_.facets.vertices[f]));
    }

    [[nodiscard]] std::array<NodalFacet<D>, D + 1> faces(ElementId e) const {
        std::array<NodalFacet<D>, D + 1> faces;
        for (int i = 0; i <= D; ++i) {
            const auto local = face_opposite<D>(i);
            std::array<VertexId, D> vertices;
            for (int k = 0; k < D; ++k) vertices[k] = linear_.elements.vertices[e][local[k]];
            faces[i] = straight_facet<D>(corners(vertices));
            if (!quadratic_) continue;
            for (int k = 0; k < edges_per_simplex<D - 1>; ++k) {
                const auto [a, b] = local_edges<D - 1>[k];
                faces[i].nodes[D + k] = mid_node(e, local[a], local[b]);
            }
        }
        return faces;
    }

  private:
    [[nodiscard]] std::array<Vec<D>, D> corners(const std::array<VertexId, D>& vertices) const {
        std::array<Vec<D>, D> corners;
        for (int i = 0; i < D; ++i) corners[i] = linear_.points[vertices[i]];
        return corners;
    }
    [[nodiscard]] Vec<D> mid_node(ElementId e, int a, int b) const {
        int edge = 0;
        while (std::minmax(local_edges<D>[edge][0], local_edges<D>[edge][1]) != std::minmax(a, b)) ++edge;
        return quadratic_->mid_nodes[quadratic_->edges.of_elements[e][edge]].point;
    }

    const LinearMesh<D>& linear_;
    const QuadraticMesh<D>* quadratic_ = nullptr;
};

template <int D>
class Elements {
  public:
    explicit Elements(const MeshNodes<D>& mesh) : mesh_(mesh) {
        std::vector<Box<D>> boxes(mesh.linear().elements.size());
        for (std::size_t e = 0; e < boxes.size(); ++e)
            for (const NodalFacet<D>& face : mesh.faces(ElementId(e))) boxes[e].include(box_of(face));
        tree_ = BoxTree<D>(std::span<const Box<D>>(boxes));
    }

    [[nodiscard]] std::vector<ElementId> containing(const Vec<D>& p) const {
        std::vector<ElementId> found;
        tree_.containing(p, [&](std::size_t e) {
            if (contains(ElementId(e), p)) found.emplace_back(e);
        });
        std::sort(found.begin(), found.end());
        return found;
    }

  private:
    [[nodiscard]] bool contains(ElementId e, const Vec<D>& p) const {
        const auto faces = mesh_.faces(e);
        for (int axis = 0; axis < D; ++axis) {
            const RayCaster<D> caster(Ray<D>{p, axis, 1});
            RayHits sum;
            for (const NodalFacet<D>& face : faces) sum = sum + caster.hits(face);
            if (sum.certain) return sum.count > 0;
        }
        return false;
    }

    const MeshNodes<D>& mesh_;
    BoxTree<D> tree_;
};

template <std::size_t N>
std::optional<std::array<double, N>> solved(std::array<std::array<double, N>, N> a, std::array<double, N> b) {
    for (std::size_t i = 0; i < N; ++i) {
        std::size_t pivot = i;
        for (std::size_t r = i + 1; r < N; ++r)
            if (std::abs(a[r][i]) > std::abs(a[pivot][i])) pivot = r;
        if (!(std::abs(a[pivot][i]) > 1e-14)) return {};
        std::swap(a[i], a[pivot]);
        std::swap(b[i], b[pivot]);
        for (std::size_t r = 0; r < N; ++r) {
            if (r == i) continue;
            const double factor = a[r][i] / a[i][i];
            for (std::size_t c = i; c < N; ++c) a[r][c] -= factor * a[i][c];
            b[r] -= factor * b[i];
        }
    }
    for (std::size_t i = 0; i < N; ++i) b[i] /= a[i][i];
    return b;
}

/// Point whose minimum depth below all faces of two straight elements is largest. There, D + 1 depths are equal.
template <int D>
Vec<D> deepest_point(const MeshNodes<D>& mesh, ElementId first, ElementId second) {
    constexpr int count = 2 * (D + 1);
    std::array<Vec<D>, count> normals;
    std::array<Vec<D>, count> on;
    const Vec<D> origin = mesh.linear().points[mesh.linear().elements.vertices[first][0]];
    int row = 0;
    for (const ElementId e : {first, second})
        for (const NodalFacet<D>& face : mesh.faces(e)) {
            on[row] = face.nodes[0] - origin;
            normals[row++] = normalised(straight_normal(Net<D>{.control = face.nodes}));
        }
    const auto depth = [&](const Vec<D>& p) {
        double least = std::numeric_limits<double>::infinity();
        for (int i = 0; i < count; ++i) least = std::min(least, dot(normals[i], on[i] - p));
        return least;
    };
    Vec<D> best = on[0];
    for (unsigned chosen = 0; chosen < (1U << static_cast<unsigned>(count)); ++chosen) {
        if (std::popcount(chosen) != D + 1) continue;
        std::array<std::array<double, D + 1>, D + 1> a{};
        std::array<double, D + 1> b{};
        std::size_t r = 0;
        for (int i = 0; i < count; ++i) {
            if (((chosen >> static_cast<unsigned>(i)) & 1U) == 0) continue;
            for (int c = 0; c < D; ++c) a[r][c] = normals[i][c];
            a[r][D] = 1;
            b[r++] = dot(normals[i], on[i]);
        }
        const auto x = solved<D + 1>(a, b);
        if (!x) continue;
        Vec<D> p;
        for (int c = 0; c < D; ++c) p[c] = (*x)[c];
        if (depth(p) > depth(best)) best = p;
    }
    return origin + best;
}

template <int D>
ElementOverlap<D> overlap_of(ElementId a, ElementId b, const Vec<D>& point) {
    return {std::min(a, b), std::max(a, b), point};
}

template <int D>
struct RowsOfBoundary {
    std::vector<OuterFacet<D>> facets;
    std::vector<std::uint32_t> rows;
};
template <int D>
RowsOfBoundary<D> boundary_of(const MeshNodes<D>& mesh) {
    const LinearMesh<D>& linear = mesh.linear();
    const auto sides = sides_of_facets(linear);
    RowsOfBoundary<D> boundary{{}, std::vector<std::uint32_t>(sides.size(), no_boundary_row)};
    for (std::size_t f = 0; f < sides.size(); ++f) {
        if (sides[f].count != 1) continue;
        const ElementId element(sides[f].element);
        std::array<VertexId, D> outwards;
        for (int k = 0; k < D; ++k)
            outwards[k] = linear.elements.vertices[element][face_opposite<D>(sides[f].opposite)[k]];
        NodalFacet<D> nodes = mesh.facet(FacetId(f));
        if (is_odd(outwards) != is_odd(linear.facets.vertices[f])) nodes = turned(nodes);
        boundary.rows[f] = static_cast<std::uint32_t>(boundary.facets.size());
        boundary.facets.push_back({nodes, outwards, element});
    }
    return boundary;
}

template <int D>
std::vector<ElementOverlap<D>> overlapping_elements(const MeshNodes<D>& mesh, const OuterBoundary<D>& boundary,
                                                    std::span<const Witness<D>> witnesses) {
    std::vector<ElementOverlap<D>> found;
    for (const auto& [f, g] : boundary.overlapping())
        found.push_back(overlap_of<D>(boundary[f].element, boundary[g].element,
                                      deepest_point(mesh, boundary[f].element, boundary[g].element)));
    const auto is_overlap = [](const Witness<D>& w) { return w.covers > 1; };
    if (std::any_of(witnesses.begin(), witnesses.end(), is_overlap)) {
        const Elements<D> elements(mesh);
        for (const Witness<D>& w : witnesses) {
            if (!is_overlap(w)) continue;
            const std::vector<ElementId> all = elements.containing(w.point);
            const ElementId own = boundary[w.facet].element;
            const bool has_own = std::find(all.begin(), all.end(), own) != all.end();
            const auto other = std::find_if(all.begin(), all.end(), [&](ElementId e) { return e != own; });
            const ElementId first = has_own || all.size() < 2 ? own : all[1];
            found.push_back(overlap_of<D>(first, other == all.end() ? own : *other, w.point));
        }
    }
    std::sort(found.begin(), found.end(), [](const ElementOverlap<D>& a, const ElementOverlap<D>& b) {
        return std::tie(a.first, a.second) < std::tie(b.first, b.second);
    });
    found.erase(std::unique(found.begin(), found.end(),
                            [](const ElementOverlap<D>& a, const ElementOverlap<D>& b) {
                                return a.first == b.first && a.second == b.second;
                            }),
                found.end());
    return found;
}

template <int D>
Outcome<Overlaps<D>> overlaps_in(const MeshNodes<D>& mesh, const Crossings& crossings, const Execution& execution) {
    return guarded([&]() -> Outcome<Overlaps<D>> {
        RowsOfBoundary<D> rows = boundary_of(mesh);
        OuterBoundary<D> boundary(std::move(rows.facets));
        boundary.cancel();
        boundary.mark(crossings, rows.rows);
        const auto walls = boundary.walls();
        if (!walls) return Overlaps<D>{};
        boundary.index();
        auto witnesses =
            map_each(execution, walls->size(), [&](std::size_t w) { return boundary.witness((*walls)[w]); }, 16);
        if (!witnesses) return fail(witnesses.error());
        Overlaps<D> overlaps{.looked_at = true, .walls = walls->size(), .overlapping = boundary.overlapping().size()};
        for (const Witness<D>& w : *witnesses) {
            overlaps.undecided += w.covers == 0 ? 1 : 0;
            overlaps.overlapping += w.covers > 1 ? 1 : 0;
        }
        if (overlaps.overlapping > 0)
            overlaps.found = overlapping_elements<D>(mesh, boundary, std::span<const Witness<D>>(*witnesses));
        return overlaps;
    });
}

}  // namespace

template <int D>
Outcome<Overlaps<D>> find_overlaps(const QuadraticMesh<D>& mesh, const Crossings& crossings,
                                   const Execution& execution) {
    if (mesh.linear.elements.size() == 0) return Overlaps<D>{};
    return overlaps_in(MeshNodes<D>(mesh), crossings, execution);
}

template <int D>
Outcome<Overlaps<D>> find_overlaps(const QuadraticMesh<D>& mesh, const Execution& execution) {
    if (mesh.linear.elements.size() == 0) return Overlaps<D>{};
    const auto crossings = find_crossings(mesh, part_of(execution, 0, 0.7));
    if (!crossings) return fail(crossings.error());
    return overlaps_in(MeshNodes<D>(mesh), *crossings, part_of(execution, 0.7, 1));
}

template <int D>
Outcome<Overlaps<D>> find_overlaps(const LinearMesh<D>& mesh, const Crossings& crossings, const Execution& execution) {
    if (mesh.elements.size() == 0) return Overlaps<D>{};
    return overlaps_in(MeshNodes<D>(mesh), crossings, execution);
}

#define CAMBER_INSTANTIATE(D)                                                                                    \
    template Outcome<Overlaps<D>> find_overlaps<D>(const QuadraticMesh<D>&, const Crossings&, const Execution&); \
    template Outcome<Overlaps<D>> find_overlaps<D>(const QuadraticMesh<D>&, const Execution&);                   \
    template Outcome<Overlaps<D>> find_overlaps<D>(const LinearMesh<D>&, const Crossings&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
