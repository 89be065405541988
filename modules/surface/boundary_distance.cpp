module;
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
module camber.surface;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

template <int D>
constexpr const auto& lattice = facet_lattice<10, D>;

/// A curved facet of the mesh.
template <int D>
struct CurvedFacet {
    FacetSite<D> straight;
    QuadraticSimplex<D - 1, D> shape;
};

struct Samples {
    double largest = 0, mean = 0;
};

/// Distances from the geometry; where that has no surface, from the plane through the facet's vertices.
template <int D>
Samples distances(const Geometry<D>& geometry, const CurvedFacet<D>& facet) {
    constexpr std::size_t n = lattice<D>.size();
    std::array<Vec<D>, n> points;
    for (std::size_t i = 0; i < n; ++i) points[i] = facet.shape.point(lattice<D>[i]);
    std::array<double, n> found{};
    if (!geometry->distances(facet.straight, lattice<D>, points, found)) {
        const Plane<D> plane = plane_through(facet.straight.corners);
        const Vec<D> normal = normalised(plane.normal);
        for (std::size_t i = 0; i < n; ++i) found[i] = std::fabs(dot(points[i] - plane.point, normal));
    }
    Samples s;
    for (const double d : found) {
        s.largest = std::fmax(s.largest, d);
        s.mean += d / n;
    }
    return s;
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
        return fail(ErrorKind::internal, "the features or the nodes are not of this mesh");
    const auto accumulate = [&](Total& total, std::size_t f) {
        const FacetId id(f);
        const CurvedFacet<D> facet{facet_site(mesh.linear, id),
                                   bezier_form<D - 1, D>(mesh.linear.points, mid_nodes, mesh.linear.facets.vertices[id],
                                                         mesh.edges.of_facets[id])};
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

#define CAMBER_INSTANTIATE(D)                                                                                       \
    template Outcome<BoundaryDistance> boundary_distance(const QuadraticMesh<D>&, std::span<const LagrangeNode<D>>, \
                                                         const Features<D>&, const Geometry<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
