// Finds boundary features and flat patches.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>
#include <vector>
module camber.surface;
import camber.core;

namespace camber {

namespace {

/// Disjoint sets, each identified by its lowest member.
class DisjointSets {
  public:
    explicit DisjointSets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0U); }
    std::uint32_t find(std::uint32_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void merge(std::uint32_t a, std::uint32_t b) {
        a = find(a);
        b = find(b);
        parent_[std::max(a, b)] = std::min(a, b);
    }

  private:
    std::vector<std::uint32_t> parent_;
};

std::pair<Buffer<std::uint32_t>, std::size_t> numbered(DisjointSets& sets, std::size_t n) {
    Buffer<std::uint32_t> numbers(n);
    std::size_t count = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t root = sets.find(i);
        numbers[i] = root == i ? static_cast<std::uint32_t>(count++) : numbers[root];
    }
    return {std::move(numbers), count};
}

/// Scales a vector by a power of two so that its largest coordinate is near 1. Digits are preserved; products neither
/// vanish nor overflow.
template <int D>
Vec<D> near_one(Vec<D> direction) {
    double largest = 0;
    for (const double x : direction.c) largest = std::fmax(largest, std::fabs(x));
    if (!(largest > 0) || !std::isfinite(largest)) return direction;
    const int exponent = std::ilogb(largest);
    for (double& x : direction.c) x = std::ldexp(x, -exponent);
    return direction;
}

template <int D>
bool turns(const Vec<D>& from, const Vec<D>& to, double cosine) {
    const Vec<D> a = near_one(from), b = near_one(to);
    const double lengths = std::sqrt(norm_squared(a) * norm_squared(b));
    return lengths > 0 && dot(a, b) < cosine * lengths;
}

double cosine_of(double degrees) { return cos(degrees * std::numbers::pi / 180); }

Vec<3> away_from_edge(const LinearMesh<3>& mesh, FacetId f, const std::array<VertexId, 2>& edge) {
    const Vec<3> a = mesh.points[edge[0]];
    const Vec<3> e = near_one(mesh.points[edge[1]] - a);
    for (const VertexId v : mesh.facets.vertices[f]) {
        if (v == edge[0] || v == edge[1]) continue;
        const Vec<3> d = near_one(mesh.points[v] - a);
        // The part of d perpendicular to e, times |e|², without the cancellation of d − (d·e)e.
        return cross(e, cross(d, e));
    }
    return {};
}

Outcome<std::vector<EdgeId>> edges_of_facets(const Incidence<FacetId>& shells, std::size_t edges,
                                             const Execution& execution) {
    return reduce_each(
        execution, edges, std::vector<EdgeId>{},
        [&](std::vector<EdgeId>& found, std::size_t e) {
            if (!shells[e].empty()) found.push_back(EdgeId(e));
        },
        [](std::vector<EdgeId> found, const std::vector<EdgeId>& more) {
            found.insert(found.end(), more.begin(), more.end());
            return found;
        });
}

enum class Break : std::uint8_t { none, smooth, mild, sharp };

/// Cosines of the ridge angle and of the angle above which every turn is sharp.
struct TurnLimits {
    double mild, sharp;
};

Break break_at(const LinearMesh<3>& mesh, const std::array<VertexId, 2>& edge, std::span<const FacetId> shell,
               const TurnLimits& limits) {
    if (shell.empty()) return Break::none;
    if (shell.size() != 2) return Break::sharp;
    if (mesh.facets.references[shell[0]] != mesh.facets.references[shell[1]]) return Break::sharp;
    const Vec<3> d0 = away_from_edge(mesh, shell[0], edge);
    const Vec<3> d1 = away_from_edge(mesh, shell[1], edge);
    if (turns(d0, -d1, limits.sharp)) return Break::sharp;
    return turns(d0, -d1, limits.mild) ? Break::mild : Break::smooth;
}

void apply_listed_edges(const LinearMesh<3>& mesh, const EdgeSet<3>& edges, Buffer<Break>& breaks) {
    for (const EdgeId e : edges.of_edges)
        if (breaks[e.index()] == Break::mild) breaks[e.index()] = Break::sharp;
    for (const std::uint32_t ridge : mesh.ridges) {
        Break& at = breaks[edges.of_edges[ridge].index()];
        if (at != Break::none) at = Break::sharp;
    }
}

bool is_coarse(const EdgeSet<3>& edges, const Buffer<Break>& breaks, FacetId f) {
    const auto& of = edges.of_facets[f];
    return std::all_of(of.begin(), of.end(), [&](EdgeId e) { return breaks[e.index()] == Break::mild; });
}

/// A mild ridge (slightly above the ridge angle) that meets no other ridge becomes smooth, because it is a fold between
/// thin triangles.
void drop_isolated_edges(const LinearMesh<3>& mesh, const EdgeSet<3>& edges, std::span<const EdgeId> of_facets,
                         const Buffer<Break>& breaks, Buffer<EdgeKind>& kinds) {
    std::vector<std::uint8_t> ridges(mesh.points.size(), 0);
    for (const EdgeId e : of_facets)
        if (kinds[e.index()] == EdgeKind::ridge)
            for (const VertexId v : edges.vertices[e]) ridges[v.index()] = ridges[v.index()] == 0 ? 1 : 2;
    for (const EdgeId e : of_facets) {
        const auto& [a, b] = edges.vertices[e];
        if (kinds[e.index()] == EdgeKind::ridge && breaks[e.index()] == Break::mild && ridges[a.index()] == 1 &&
            ridges[b.index()] == 1)
            kinds[e.index()] = EdgeKind::surface;
    }
}

Outcome<Buffer<EdgeKind>> find_edge_kinds(const LinearMesh<3>& mesh, const EdgeSet<3>& edges,
                                          const Incidence<FacetId>& shells, std::span<const EdgeId> of_facets,
                                          const TurnLimits& limits, const Execution& execution) {
    auto breaks = map_each(part_of(execution, 0, 0.8), edges.size(),
                           [&](std::size_t e) { return break_at(mesh, edges.vertices[e], shells[e], limits); });
    if (!breaks) return fail(breaks.error());
    apply_listed_edges(mesh, edges, *breaks);
    auto kinds = map_each(part_of(execution, 0.8, 1), edges.size(), [&](std::size_t e) {
        switch ((*breaks)[e]) {
            case Break::none: return EdgeKind::volume;
            case Break::smooth: return EdgeKind::surface;
            case Break::sharp: return EdgeKind::ridge;
            case Break::mild: break;
        }
        const bool coarse = is_coarse(edges, *breaks, shells[e][0]) || is_coarse(edges, *breaks, shells[e][1]);
        return coarse ? EdgeKind::surface : EdgeKind::ridge;
    });
    if (kinds) drop_isolated_edges(mesh, edges, of_facets, *breaks, *kinds);
    return kinds;
}

Outcome<Buffer<EdgeKind>> find_edge_kinds(const LinearMesh<2>&, const EdgeSet<2>& edges,
                                          const Incidence<FacetId>& shells, std::span<const EdgeId>, const TurnLimits&,
                                          const Execution& execution) {
    return map_each(execution, edges.size(),
                    [&](std::size_t e) { return shells[e].empty() ? EdgeKind::volume : EdgeKind::surface; });
}

template <int D>
constexpr EdgeKind curve_kind = D == 3 ? EdgeKind::ridge : EdgeKind::surface;

VertexId other_end(const std::array<VertexId, 2>& edge, VertexId v) { return edge[0] == v ? edge[1] : edge[0]; }

struct CurveEdges {
    std::uint32_t count = 0;
    std::array<std::uint32_t, 2> places{};
};

template <int D>
std::vector<CurveEdges> curve_edges_of_vertices(std::size_t vertices, const EdgeSet<D>& edges,
                                                std::span<const EdgeId> on_curves) {
    std::vector<CurveEdges> around(vertices);
    for (std::uint32_t place = 0; place < on_curves.size(); ++place)
        for (const VertexId v : edges.vertices[on_curves[place]]) {
            auto& at = around[v.index()];
            if (at.count < 2) at.places[at.count] = place;
            ++at.count;
        }
    return around;
}

bool references_differ(const LinearMesh<2>& mesh, const Incidence<FacetId>& shells, const std::array<EdgeId, 2>& pair) {
    const auto reference = [&](EdgeId e) { return mesh.facets.references[shells[e][0]]; };
    return reference(pair[0]) != reference(pair[1]);
}
bool references_differ(const LinearMesh<3>&, const Incidence<FacetId>&, const std::array<EdgeId, 2>&) { return false; }

template <int D>
std::vector<std::uint8_t> listed_corners(const LinearMesh<D>& mesh) {
    std::vector<std::uint8_t> listed(mesh.points.size(), 0);
    for (const VertexId v : mesh.corners) listed[v.index()] = 1;
    if constexpr (D == 2)
        for (const std::uint32_t f : mesh.ridges)
            for (const VertexId v : mesh.facets.vertices[f]) listed[v.index()] = 1;
    return listed;
}

std::array<Vec<3>, 2> directions_at(const LinearMesh<3>& mesh, FacetId f, std::size_t i) {
    const auto& v = mesh.facets.vertices[f];
    return {normalised(near_one(mesh.points[v[(i + 1) % 3]] - mesh.points[v[i]])),
            normalised(near_one(mesh.points[v[(i + 2) % 3]] - mesh.points[v[i]]))};
}

/// Finds tips of cones among vertices without ridges. At each vertex, let m be the integral of the unit directions that
/// point from the vertex into its triangles. A triangle with unit edge vectors a and b and the angle θ between them
/// contributes (a + b) tan(θ/2). In a plane m is 0; at a tip it is along the axis, for any facet orientation. At a tip,
/// d · m > `limit` |m| for the direction d of each edge. `limit`: sine of the ridge angle.
std::vector<std::uint8_t> find_tips(const LinearMesh<3>& mesh, const std::vector<CurveEdges>& around, double limit) {
    std::vector<Vec<3>> means(mesh.points.size());
    const auto each_corner = [&](auto&& use) {
        for (std::size_t f = 0; f < mesh.facets.size(); ++f)
            for (std::size_t i = 0; i < 3; ++i)
                if (const VertexId v = mesh.facets.vertices[f][i]; around[v.index()].count == 0)
                    use(v, directions_at(mesh, FacetId(f), i));
    };
    each_corner([&](VertexId v, const std::array<Vec<3>, 2>& at) {
        const double c = dot(at[0], at[1]);
        means[v.index()] += std::sqrt(std::fmax(0, 1 - c) / std::fmax(1 + c, 1e-12)) * (at[0] + at[1]);
    });
    std::vector<std::uint8_t> is_tip(mesh.points.size(), 1);
    each_corner([&](VertexId v, const std::array<Vec<3>, 2>& at) {
        const Vec<3>& mean = means[v.index()];
        for (const Vec<3>& d : at)
            if (!(dot(d, mean) > limit * norm(mean))) is_tip[v.index()] = 0;
    });
    return is_tip;
}
std::vector<std::uint8_t> find_tips(const LinearMesh<2>& mesh, const std::vector<CurveEdges>&, double) {
    return std::vector<std::uint8_t>(mesh.points.size(), 0);
}

struct FacetsAtVertex {
    std::uint32_t count = 0;
    FacetId one;
};

template <int D>
std::vector<FacetsAtVertex> facets_at_vertices(const LinearMesh<D>& mesh) {
    std::vector<FacetsAtVertex> at(mesh.points.size());
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        for (const VertexId v : mesh.facets.vertices[f]) at[v.index()] = {at[v.index()].count + 1, FacetId(f)};
    return at;
}

/// Facets around a vertex that are connected across smooth edges.
struct Sheet {
    std::uint32_t facets = 0;
    EdgeId end;  ///< ridge at the end of the walk; invalid: closed sheet
};

template <int D>
struct ClassifiedEdges {
    const EdgeSet<D>& edges;
    const Incidence<FacetId>& shells;
    const Buffer<EdgeKind>& kinds;
};

/// Walks around v from facet f, until it reaches a ridge or f again. The first step does not cross the edge `from`, if
/// valid.
Sheet sheet_from(const ClassifiedEdges<3>& of_mesh, const FacetsAtVertex& at, VertexId v, FacetId f, EdgeId from) {
    const auto& [edges, shells, kinds] = of_mesh;
    Sheet sheet;
    for (const FacetId first = f; sheet.facets < at.count;) {
        ++sheet.facets;
        const auto& of = edges.of_facets[f];
        const auto* const next = std::ranges::find_if(
            of, [&](EdgeId e) { return e != from && (edges.vertices[e][0] == v || edges.vertices[e][1] == v); });
        if (kinds[next->index()] == EdgeKind::ridge) {
            sheet.end = *next;
            break;
        }
        f = shells[*next][0] == f ? shells[*next][1] : shells[*next][0];
        if (f == first) break;
        from = *next;
    }
    return sheet;
}

/// True if the two ridges at v bound all sheets at v (see `Sheet`), or if v has one sheet and no ridge. Otherwise
/// another surface touches v, such as a baffle tip on a wall.
bool is_bounded_by_ridges(const ClassifiedEdges<3>& edges, const FacetsAtVertex& at, VertexId v,
                          std::span<const EdgeId> ridges) {
    if (ridges.empty()) return sheet_from(edges, at, v, at.one, {}).facets == at.count;
    std::uint32_t facets = 0;
    for (const FacetId f : edges.shells[ridges[0]]) {
        const Sheet sheet = sheet_from(edges, at, v, f, ridges[0]);
        if (sheet.end != ridges[1]) return false;
        facets += sheet.facets;
    }
    return facets == at.count;
}
bool is_bounded_by_ridges(const ClassifiedEdges<2>&, const FacetsAtVertex&, VertexId, std::span<const EdgeId>) {
    return true;
}

struct CornerLimits {
    double cosine = 0;
    double tip_sine = 0;  ///< see find_tips
};

template <int D>
Outcome<Buffer<VertexKind>> find_vertex_kinds(const LinearMesh<D>& mesh, const ClassifiedEdges<D>& classified,
                                              std::span<const EdgeId> on_curves, const std::vector<CurveEdges>& around,
                                              const CornerLimits& limits, const Execution& execution) {
    const auto& [edges, shells, kinds] = classified;
    const auto facets = facets_at_vertices(mesh);
    const auto listed = listed_corners(mesh);
    const auto is_tip = find_tips(mesh, around, limits.tip_sine);
    return map_each(execution, mesh.points.size(), [&](std::size_t v) {
        if (facets[v].count == 0) return VertexKind::volume;
        const auto& at = around[v];
        const auto is_touched = [&](std::span<const EdgeId> ridges) {
            return !is_bounded_by_ridges(classified, facets[v], VertexId(v), ridges);
        };
        if (at.count == 0) return listed[v] || is_tip[v] || is_touched({}) ? VertexKind::corner : VertexKind::surface;
        if (listed[v] || at.count != 2) return VertexKind::corner;
        const std::array<EdgeId, 2> pair{on_curves[at.places[0]], on_curves[at.places[1]]};
        const auto from_vertex = [&](EdgeId e) {
            return mesh.points[other_end(edges.vertices[e], VertexId(v))] - mesh.points[v];
        };
        if (references_differ(mesh, shells, pair) ||
            turns(from_vertex(pair[0]), -from_vertex(pair[1]), limits.cosine) || is_touched(pair))
            return VertexKind::corner;
        return D == 3 ? VertexKind::ridge : VertexKind::surface;
    });
}

DisjointSets chains(const std::vector<CurveEdges>& around, const Buffer<VertexKind>& kinds, std::size_t on_curves) {
    DisjointSets sets(on_curves);
    for (std::size_t v = 0; v < around.size(); ++v)
        if (around[v].count == 2 && kinds[v] != VertexKind::corner)
            sets.merge(around[v].places[0], around[v].places[1]);
    return sets;
}

Outcome<Buffer<std::uint32_t>> curves_by_edge(std::span<const std::uint32_t> numbers, std::span<const EdgeId> on_curves,
                                              std::size_t edges, const Execution& execution) {
    auto curves = map_each(execution, edges, [](std::size_t) { return no_feature; });
    for (std::size_t place = 0; curves && place < on_curves.size(); ++place)
        (*curves)[on_curves[place].index()] = numbers[place];
    return curves;
}

std::pair<Buffer<std::uint32_t>, std::size_t> find_patches(const LinearMesh<3>& mesh, const EdgeSet<3>&,
                                                           const Incidence<FacetId>& shells,
                                                           std::span<const EdgeId> of_facets,
                                                           const Buffer<EdgeKind>& kinds,
                                                           const Buffer<std::uint32_t>&) {
    DisjointSets sets(mesh.facets.size());
    for (const EdgeId e : of_facets)
        if (kinds[e.index()] == EdgeKind::surface) sets.merge(shells[e][0].value, shells[e][1].value);
    return numbered(sets, mesh.facets.size());
}

std::pair<Buffer<std::uint32_t>, std::size_t> find_patches(const LinearMesh<2>& mesh, const EdgeSet<2>& edges,
                                                           const Incidence<FacetId>& shells,
                                                           std::span<const EdgeId> of_facets, const Buffer<EdgeKind>&,
                                                           const Buffer<std::uint32_t>& curves) {
    DisjointSets sets(mesh.facets.size());
    std::vector<std::uint32_t> first(edges.size(), no_feature);  // first facet of each curve
    for (const EdgeId e : of_facets)
        for (const FacetId f : shells[e]) {
            auto& lead = first[curves[e.index()]];
            if (lead == no_feature) lead = f.value;
            sets.merge(lead, f.value);
        }
    return numbered(sets, mesh.facets.size());
}

template <int D>
bool belongs(const LinearMesh<D>& mesh, const EdgeSet<D>& edges) {
    return edges.of_facets.size() == mesh.facets.size() && (D == 2 || edges.of_edges.size() == mesh.edges.size());
}

}  // namespace

template <int D>
Outcome<Features<D>> find_features(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const FeatureOptions<D>& options,
                                   const Execution& execution) {
    if (!belongs(mesh, edges)) return fail(ErrorKind::internal, "the edge set belongs to another mesh");
    const auto shells = facet_shells(edges, part_of(execution, 0, 0.5));
    if (!shells) return fail(shells.error());
    const auto of_facets = edges_of_facets(*shells, edges.size(), part_of(execution, 0.5, 0.6));
    if (!of_facets) return fail(of_facets.error());
    constexpr double sharp_share = 1.5;
    const double ridge_cosine = cosine_of(options.ridge_angle_degrees);
    const TurnLimits limits{ridge_cosine, cosine_of(std::fmin(180, sharp_share * options.ridge_angle_degrees))};
    auto edge_kinds = find_edge_kinds(mesh, edges, *shells, *of_facets, limits, part_of(execution, 0.6, 0.8));
    if (!edge_kinds) return fail(edge_kinds.error());
    const auto of_kind = [&](EdgeKind kind) {
        return [&, kind](EdgeId e) { return (*edge_kinds)[e.index()] == kind; };
    };
    const auto count_of = [&](EdgeKind kind) {
        return static_cast<std::size_t>(std::count_if(of_facets->begin(), of_facets->end(), of_kind(kind)));
    };

    std::vector<EdgeId> on_curves;
    on_curves.reserve(count_of(curve_kind<D>));
    std::copy_if(of_facets->begin(), of_facets->end(), std::back_inserter(on_curves), of_kind(curve_kind<D>));
    const auto around = curve_edges_of_vertices(mesh.points.size(), edges, on_curves);
    const double tip_sine = options.ridge_angle_degrees < 90 ? std::sqrt(1 - ridge_cosine * ridge_cosine) : 1;
    const double corner_cosine = D == 2 ? ridge_cosine : cosine_of(options.corner_angle_degrees);
    auto vertex_kinds = find_vertex_kinds<D>(mesh, {edges, *shells, *edge_kinds}, on_curves, around,
                                             {corner_cosine, tip_sine}, part_of(execution, 0.8, 0.9));
    if (!vertex_kinds) return fail(vertex_kinds.error());
    auto sets = chains(around, *vertex_kinds, on_curves.size());
    const auto [numbers, curve_count] = numbered(sets, on_curves.size());
    auto curves = curves_by_edge(numbers, on_curves, edges.size(), part_of(execution, 0.9, 1));
    if (!curves) return fail(curves.error());
    auto [patches, patch_count] = find_patches(mesh, edges, *shells, *of_facets, *edge_kinds, *curves);

    Features<D> features;
    features.surface_edges = count_of(EdgeKind::surface);
    features.ridge_edges = count_of(EdgeKind::ridge);
    features.corners =
        static_cast<std::size_t>(std::count(vertex_kinds->begin(), vertex_kinds->end(), VertexKind::corner));
    features.patch_count = patch_count;
    features.curve_count = curve_count;
    features.edge_kinds = std::move(*edge_kinds);
    features.vertex_kinds = std::move(*vertex_kinds);
    features.patches = std::move(patches);
    features.curves = std::move(*curves);
    return features;
}

namespace {

template <class Measure, int D>
Vec<D> farthest(std::span<const Vec<D>> points, Measure&& measure) {
    Vec<D> best = points[0];
    double most = measure(best);
    for (const Vec<D>& p : points)
        if (const double m = measure(p); m > most) {
            most = m;
            best = p;
        }
    return best;
}

/// Normal of the line (3D: plane) through two (3D: three) points that are far from each other. Bitwise equal
/// coordinates give exact zeros.
Vec<2> spanned_normal(std::span<const Vec<2>> points) {
    const Vec<2> a = farthest(points, [&](const Vec<2>& p) { return norm_squared(p - points[0]); });
    const Vec<2> b = farthest(points, [&](const Vec<2>& p) { return norm_squared(p - a); });
    return {{-(b[1] - a[1]), b[0] - a[0]}};
}
Vec<3> spanned_normal(std::span<const Vec<3>> points) {
    const Vec<3> a = farthest(points, [&](const Vec<3>& p) { return norm_squared(p - points[0]); });
    const Vec<3> b = farthest(points, [&](const Vec<3>& p) { return norm_squared(p - a); });
    const Vec<3> c = farthest(points, [&](const Vec<3>& p) { return norm_squared(cross(p - a, b - a)); });
    return cross(b - a, c - a);
}

template <int D>
int axis_along(const Vec<D>& unit) {
    for (int i = 0; i < D; ++i) {
        bool alone = unit[i] != 0;
        for (int j = 0; j < D; ++j) alone = alone && (i == j || unit[j] == 0);
        if (alone) return i;
    }
    return -1;
}

}  // namespace

template <int D>
FlatPatch<D> plane_of(std::span<const Vec<D>> points) {
    FlatPatch<D> flat;
    if (points.size() < D) return flat;
    Box<D> box;
    double largest = 0;
    for (const Vec<D>& p : points) {
        box.include(p);
        for (int i = 0; i < D; ++i) largest = std::fmax(largest, std::fabs(p[i]));
    }
    const Vec<D> normal = normalised(spanned_normal(points));
    if (!(norm_squared(normal) > 0)) return flat;
    const double tolerance = flat_tolerance * box.diagonal() + coordinate_ulps * largest;
    for (const Vec<D>& p : points)
        if (!(std::fabs(dot(p - points[0], normal)) <= tolerance)) return flat;
    return {points[0], normal, tolerance, axis_along(normal)};
}

template <int D>
Outcome<Buffer<FlatPatch<D>>> flat_patches(const LinearMesh<D>& mesh, const Features<D>& features,
                                           const Execution& execution) {
    std::vector<std::vector<Vec<D>>> points(features.patch_count);
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        for (const VertexId v : mesh.facets.vertices[f]) points[features.patches[f]].push_back(mesh.points[v]);
    return map_each(execution, points.size(), [&](std::size_t p) { return plane_of<D>(points[p]); }, 1);
}

#define CAMBER_INSTANTIATE(D)                                                                                      \
    template Outcome<Features<D>> find_features(const LinearMesh<D>&, const EdgeSet<D>&, const FeatureOptions<D>&, \
                                                const Execution&);                                                 \
    template FlatPatch<D> plane_of(std::span<const Vec<D>>);                                                       \
    template Outcome<Buffer<FlatPatch<D>>> flat_patches(const LinearMesh<D>&, const Features<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
