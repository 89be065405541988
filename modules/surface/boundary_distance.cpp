// Distances of the curved boundary, its nodes and its vertices from the geometry.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
module camber.surface;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

template <int D>
constexpr const auto& lattice = facet_lattice<10, D>;
/// Test points that decide whether a facet is skipped. Typically, the distance between an edge and its curve varies
/// with the edge's parameter s like one of these functions. Each function reaches 0.92 of its maximum at a test point.
/// - s (1 − s): a straight edge
/// - s (s − 1/2) (s − 1): a quadratic edge
/// - s (1 − s) (s − 1/2)²: a quadratic edge through the middle of an arc
template <int D>
constexpr const auto& coarse_lattice = facet_lattice<5, D>;

template <int D>
constexpr std::array<Barycentric<D - 1>, 1> middle = [] {
    const auto largest = [](const Barycentric<D - 1>& xi) { return *std::max_element(xi.begin(), xi.end()); };
    return std::array<Barycentric<D - 1>, 1>{*std::min_element(
        lattice<D>.begin(), lattice<D>.end(), [&](const auto& a, const auto& b) { return largest(a) < largest(b); })};
}();

template <int D>
struct CurvedFacet {
    FacetSite<D> straight;
    QuadraticSimplex<D - 1, D> shape;
};

template <int D>
CurvedFacet<D> curved_facet(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> mid_nodes, FacetId f) {
    return {facet_site(mesh.linear, f), bezier_form<D - 1, D>(mesh.linear.points, mid_nodes,
                                                              mesh.linear.facets.vertices[f], mesh.edges.of_facets[f])};
}

template <int D>
double off_plane(const CurvedFacet<D>& facet, const Vec<D>& p) {
    const Plane<D> plane = plane_through(facet.straight.corners);
    return std::fabs(dot(p - plane.point, normalised(plane.normal)));
}

struct Samples {
    double largest = 0, mean = 0;
};

template <int D>
Samples distances(const Geometry<D>& geometry, const CurvedFacet<D>& facet) {
    constexpr std::size_t n = lattice<D>.size();
    std::array<Vec<D>, n> points;
    for (std::size_t i = 0; i < n; ++i) points[i] = facet.shape.point(lattice<D>[i]);
    std::array<double, n> found{};
    if (!geometry->distances(facet.straight, lattice<D>, points, found))
        for (std::size_t i = 0; i < n; ++i) found[i] = off_plane(facet, points[i]);
    Samples s;
    for (const double d : found) {
        s.largest = std::fmax(s.largest, d);
        s.mean += d / n;
    }
    return s;
}

template <int D>
void add(LargestDistance& total, const Geometry<D>& geometry, const CurvedFacet<D>& facet,
         std::span<const Barycentric<D - 1>> at) {
    std::array<Vec<D>, lattice<D>.size()> points;
    for (std::size_t i = 0; i < at.size(); ++i) points[i] = facet.shape.point(at[i]);
    const auto all = std::span<const Vec<D>>(points).first(at.size());
    if (const auto here = geometry->largest_distance(facet.straight, at, all, total.largest)) {
        total.largest = here->largest;
        total.projected += here->projected;
        return;
    }
    for (const Vec<D>& p : all) total.largest = std::fmax(total.largest, off_plane(facet, p));
}

struct Total {
    double largest = 0, weighted = 0, area = 0;
    FacetId worst = {};
};

Total joined(const Total& a, const Total& b) {
    const Total& worse = b.largest > a.largest ? b : a;
    return {worse.largest, a.weighted + b.weighted, a.area + b.area, worse.worst};
}

}  // namespace

template <int D>
Outcome<BoundaryDistance> boundary_distance(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> mid_nodes,
                                            const Features<D>& features, const Geometry<D>& geometry,
                                            const Execution& execution) {
    if (features.patches.size() != mesh.linear.facets.size() || mid_nodes.size() != mesh.edges.size())
        return fail(ErrorKind::internal, "the features or the nodes belong to another mesh");
    const auto accumulate = [&](Total& total, std::size_t f) {
        const FacetId id(f);
        const CurvedFacet<D> facet = curved_facet<D>(mesh, mid_nodes, id);
        const Samples s = distances(geometry, facet);
        const double area = straight_measure(facet.straight);
        if (s.largest > total.largest || !total.worst.valid()) {
            total.largest = s.largest;
            total.worst = id;
        }
        total.weighted += area * s.mean;
        total.area += area;
    };
    const auto total = reduce_each(execution, mesh.linear.facets.size(), Total{}, accumulate, joined, 64);
    if (!total) return fail(total.error());
    return BoundaryDistance{total->largest, total->area > 0 ? total->weighted / total->area : 0, total->worst};
}

namespace {

template <int D>
double rounding_of(const Vec<D>& p) {
    return 64 * std::numeric_limits<double>::epsilon() * norm(p);
}

template <class Id, int D>
void count_off(OffGeometry<Id>& to, Id id, const Vec<D>& at, double away, double length, double tolerance) {
    constexpr double far = std::numeric_limits<double>::infinity();
    if (std::isnan(away)) away = far;  // the geometry has no closest point
    const double share = length > 0 ? away / length : (away > rounding_of(at) ? far : 0);
    ++to.measured;
    to.off += share > tolerance && away > rounding_of(at) ? 1 : 0;
    to.largest = std::fmax(to.largest, away);
    if (share > to.share) {
        to.share = share;
        to.worst = id;
    }
}

template <class Id>
OffGeometry<Id> joined(const OffGeometry<Id>& a, const OffGeometry<Id>& b) {
    const OffGeometry<Id>& worse = b.share > a.share ? b : a;
    return {a.measured + b.measured, a.off + b.off, std::fmax(a.largest, b.largest), worse.share, worse.worst};
}

template <int D>
double longest_edge(std::span<const FacetSite<D>> facets) {
    double longest = 0;
    for (const FacetSite<D>& facet : facets)
        for (std::size_t i = 1; i < D; ++i)
            for (std::size_t j = 0; j < i; ++j)
                longest = std::fmax(longest, distance(facet.corners[i], facet.corners[j]));
    return longest;
}

template <int D>
double node_distance(const EdgeSite<D>& site, const Vec<D>& node, const Geometry<D>& geometry,
                     std::span<const LagrangeNode<D>> own_nodes) {
    const bool is_prescribed =
        std::ranges::any_of(site.facets, [&](const auto& facet) { return geometry->prescribes(facet.reference); });
    if (!own_nodes.empty() && !is_prescribed) return distance(node, own_nodes[site.id.index()].point);
    return distance(node, geometry->on_edge(site, node).point);
}

template <int D>
Outcome<OffGeometry<EdgeId>> nodes_off(const QuadraticMesh<D>& mesh, std::span<const EdgeKind> kinds,
                                       const Geometry<D>& geometry, std::span<const LagrangeNode<D>> own_nodes,
                                       double tolerance, const Execution& execution) {
    const auto shells = facet_shells(mesh.edges, without_progress(execution));
    if (!shells) return fail(shells.error());
    const auto measure = [&](OffGeometry<EdgeId>& total, std::size_t e) {
        if (kinds[e] == EdgeKind::volume || kinds[e] == EdgeKind::fixed || (*shells)[e].empty()) return;
        const auto& [low, high] = mesh.edges.vertices[e];
        const EdgeSite<D> site{EdgeId(e),
                               kinds[e],
                               {mesh.linear.points[low], mesh.linear.points[high]},
                               facet_sites<D>(mesh.linear, (*shells)[e])};
        const Vec<D>& node = mesh.mid_nodes[e].point;
        count_off(total, site.id, node, node_distance(site, node, geometry, own_nodes),
                  distance(site.ends[0], site.ends[1]), tolerance);
    };
    return reduce_each(execution, mesh.edges.size(), OffGeometry<EdgeId>{}, measure, joined<EdgeId>, 256);
}

template <int D>
Outcome<OffGeometry<VertexId>> vertices_off(const LinearMesh<D>& mesh, const Geometry<D>& geometry, double tolerance,
                                            const Execution& execution) {
    const auto balls = facet_balls(mesh, without_progress(execution));
    if (!balls) return fail(balls.error());
    const auto required = required_vertices(mesh);
    const auto measure = [&](OffGeometry<VertexId>& total, std::size_t v) {
        if ((*balls)[v].empty() || required[v] != 0) return;
        const auto around = facet_sites<D>(mesh, (*balls)[v]);
        const Vec<D>& p = mesh.points[v];
        count_off(total, VertexId(v), p, geometry->distance_at_facets(around, p), longest_edge<D>(around), tolerance);
    };
    return reduce_each(execution, mesh.points.size(), OffGeometry<VertexId>{}, measure, joined<VertexId>, 256);
}

}  // namespace

template <int D>
Outcome<BoundaryDeviation> boundary_deviation(const QuadraticMesh<D>& mesh, std::span<const EdgeKind> kinds,
                                              const Geometry<D>& geometry, std::span<const LagrangeNode<D>> own_nodes,
                                              const BoundaryTolerance& tolerance, const Execution& execution) {
    const std::size_t edges = mesh.edges.size();
    if (kinds.size() != edges || mesh.mid_nodes.size() != edges || (!own_nodes.empty() && own_nodes.size() != edges))
        return fail(ErrorKind::internal, "the kinds or the nodes belong to another mesh");
    const auto nodes = nodes_off(mesh, kinds, geometry, own_nodes, tolerance.nodes, part_of(execution, 0, 0.7));
    if (!nodes) return fail(nodes.error());
    const auto vertices = vertices_off(mesh.linear, geometry, tolerance.vertices, part_of(execution, 0.7, 1));
    if (!vertices) return fail(vertices.error());
    return BoundaryDeviation{*nodes, *vertices};
}

namespace {

struct FarthestFacet {
    LargestDistance distance;
    FacetId facet = {};
};

template <int D>
class MeasuredFacets {
  public:
    MeasuredFacets(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> mid_nodes,
                   const Geometry<D>& geometry)
        : mesh_(mesh), mid_nodes_(mid_nodes), geometry_(geometry) {}

    [[nodiscard]] CurvedFacet<D> facet(std::size_t f) const { return curved_facet<D>(mesh_, mid_nodes_, FacetId(f)); }

    template <class Measure>
    [[nodiscard]] Outcome<FarthestFacet> farthest(double least, const Measure& measure,
                                                  const Execution& execution) const {
        return reduce_each(
            execution, mesh_.linear.facets.size(), FarthestFacet{{least, 0}},
            [&](FarthestFacet& total, std::size_t f) {
                const double before = total.distance.largest;
                measure(total.distance, f);
                if (total.distance.largest > before) total.facet = FacetId(f);
            },
            [](const FarthestFacet& a, const FarthestFacet& b) {
                const FarthestFacet& larger = b.distance.largest > a.distance.largest ? b : a;
                return FarthestFacet{{larger.distance.largest, a.distance.projected + b.distance.projected},
                                     larger.facet};
            },
            64);
    }

    void add_to(LargestDistance& total, std::size_t f, std::span<const Barycentric<D - 1>> at) const {
        add<D>(total, geometry_, facet(f), at);
    }

    /// Skips facets f for which may_exceed(f, largest distance so far) is false.
    template <class MayExceed>
    [[nodiscard]] Outcome<LargestDistance> largest(const MayExceed& may_exceed, const Execution& execution) const {
        // The facet with the farthest middle gives a bound that excludes most points of other facets.
        const auto middles = farthest(
            0,
            [&](LargestDistance& total, std::size_t f) {
                if (may_exceed(f, total.largest)) add_to(total, f, middle<D>);
            },
            part_of(execution, 0, 0.2));
        if (!middles) return fail(middles.error());
        constexpr double nearly = 0.8;
        LargestDistance bound = middles->distance;
        if (middles->facet.valid()) add_to(bound, middles->facet.index(), lattice<D>);
        const auto measure = [&](LargestDistance& total, std::size_t f) {
            if (!may_exceed(f, total.largest)) return;
            LargestDistance coarse{nearly * bound.largest, 0};
            add_to(coarse, f, coarse_lattice<D>);
            total.projected += coarse.projected;
            if (coarse.largest > nearly * bound.largest) add_to(total, f, lattice<D>);
        };
        return farthest(bound.largest, measure, part_of(execution, 0.2, 1)).map([&](const FarthestFacet& all) {
            return LargestDistance{all.distance.largest, all.distance.projected + bound.projected,
                                   all.facet.valid() ? all.facet : middles->facet};
        });
    }

  private:
    const QuadraticMesh<D>& mesh_;
    std::span<const LagrangeNode<D>> mid_nodes_;
    const Geometry<D>& geometry_;
};

/// Upper bound on the distance between points of facets a and b with equal barycentric coordinates ξ; infinity if their
/// vertices differ. The bound uses Σ_(i<j) 2 ξ_i ξ_j ≤ (D − 1)/D.
template <int D>
double distance_bound(const QuadraticSimplex<D - 1, D>& a, const QuadraticSimplex<D - 1, D>& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.control.size(); ++i) {
        const double here = distance(a.control[i], b.control[i]);
        if (i < D && here > 0) return std::numeric_limits<double>::infinity();
        largest = std::fmax(largest, here);
    }
    return largest * (D - 1) / D;
}

}  // namespace

template <int D>
Outcome<LargestDistance> largest_boundary_distance(const QuadraticMesh<D>& mesh,
                                                   std::span<const LagrangeNode<D>> mid_nodes,
                                                   const Features<D>& features, const Geometry<D>& geometry,
                                                   const Execution& execution) {
    if (features.patches.size() != mesh.linear.facets.size() || mid_nodes.size() != mesh.edges.size())
        return fail(ErrorKind::internal, "the features or the nodes belong to another mesh");
    return MeasuredFacets<D>(mesh, mid_nodes, geometry).largest([](std::size_t, double) { return true; }, execution);
}

template <int D>
Outcome<LargestDistance> largest_boundary_distance(const QuadraticMesh<D>& mesh,
                                                   std::span<const LagrangeNode<D>> mid_nodes,
                                                   const Features<D>& features, const Geometry<D>& geometry,
                                                   const NearBoundary<D>& near, const Execution& execution) {
    if (features.patches.size() != mesh.linear.facets.size() || mid_nodes.size() != mesh.edges.size() ||
        near.mid_nodes.size() != mesh.edges.size() || near.mesh.linear.facets.size() != mesh.linear.facets.size())
        return fail(ErrorKind::internal, "the features or the nodes belong to another mesh");
    const MeasuredFacets<D> facets(mesh, mid_nodes, geometry), others(near.mesh, near.mid_nodes, geometry);
    constexpr double rounding = 1 + 1e-12;
    const auto bounds = map_each(part_of(execution, 0, 0.2), mesh.linear.facets.size(), [&](std::size_t f) {
        return rounding * (near.largest + distance_bound<D>(facets.facet(f).shape, others.facet(f).shape));
    });
    if (!bounds) return fail(bounds.error());
    return facets.largest([&](std::size_t f, double largest) { return !((*bounds)[f] <= largest); },
                          part_of(execution, 0.2, 1));
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template Outcome<BoundaryDistance> boundary_distance(const QuadraticMesh<D>&, std::span<const LagrangeNode<D>>,   \
                                                         const Features<D>&, const Geometry<D>&, const Execution&);   \
    template Outcome<BoundaryDeviation> boundary_deviation<D>(const QuadraticMesh<D>&, std::span<const EdgeKind>,     \
                                                              const Geometry<D>&, std::span<const LagrangeNode<D>>,   \
                                                              const BoundaryTolerance&, const Execution&);            \
    template Outcome<LargestDistance> largest_boundary_distance(const QuadraticMesh<D>&,                              \
                                                                std::span<const LagrangeNode<D>>, const Features<D>&, \
                                                                const Geometry<D>&, const Execution&);                \
    template Outcome<LargestDistance> largest_boundary_distance(                                                      \
        const QuadraticMesh<D>&, std::span<const LagrangeNode<D>>, const Features<D>&, const Geometry<D>&,            \
        const NearBoundary<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
