module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <variant>
module camber.surface;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

constexpr int lattice_degree = 10;

/// A curved facet of the mesh.
template <int D>
struct CurvedFacet {
    FacetId id;
    Reference reference = 0;
    QuadraticSimplex<D - 1, D> shape;
};

template <int D>
double straight_area(const CurvedFacet<D>& facet) {
    const auto& c = facet.shape.control;
    if constexpr (D == 2)
        return distance(c[0], c[1]);
    else
        return 0.5 * norm(cross(c[1] - c[0], c[2] - c[0]));
}

/// Distances to the line or plane through the facet's vertices.
template <int D>
auto to_own_plane(const CurvedFacet<D>& facet) {
    const auto& c = facet.shape.control;
    Vec<D> normal;
    if constexpr (D == 2)
        normal = normalised(Vec<2>{{c[1][1] - c[0][1], c[0][0] - c[1][0]}});
    else
        normal = normalised(cross(c[1] - c[0], c[2] - c[0]));
    return
        [normal, from = c[0]](const Vec<D>& p, const Barycentric<D - 1>&) { return std::fabs(dot(p - from, normal)); };
}

template <int D>
auto to_surface(const AnalyticSurface<D>& surface) {
    return [&surface](const Vec<D>& p, const Barycentric<D - 1>&) {
        return distance(p, closest_point<D>(surface, p).point);
    };
}

template <int D>
auto to_flat(const FlatPatch<D>& flat) {
    return [&flat](const Vec<D>& p, const Barycentric<D - 1>&) { return std::fabs(flat.height(p)); };
}

/// Whether the surrogate's facet of that number is the mesh's own.
template <int D>
bool is_own_facet(const Surrogate<D>& surrogate, const CurvedFacet<D>& facet) {
    if (facet.id.index() >= surrogate.facets.size()) return false;
    const auto& cubic = surrogate.facets[facet.id];
    for (std::size_t i = 0; i < D; ++i) {
        MultiIndex<D - 1> alpha{};
        alpha[i] = 3;
        if (cubic.at(alpha) != facet.shape.control[i]) return false;
    }
    return true;
}

struct Samples {
    double largest = 0, mean = 0;
};

template <int D, class Distance>
Samples sampled(const CurvedFacet<D>& facet, Distance&& distance_from) {
    Samples s;
    for (const auto& alpha : multi_indices<lattice_degree, D - 1>) {
        Barycentric<D - 1> xi{};
        for (std::size_t i = 0; i < D; ++i) xi[i] = static_cast<double>(alpha[i]) / lattice_degree;
        const double d = distance_from(facet.shape.point(xi), xi);
        s.largest = std::fmax(s.largest, d);
        s.mean += d / node_count<lattice_degree, D - 1>;
    }
    return s;
}

template <int D>
Samples distances(const StraightGeometry&, const CurvedFacet<D>& facet) {
    return sampled(facet, to_own_plane(facet));
}

template <int D>
Samples distances(const AnalyticGeometry<D>& geometry, const CurvedFacet<D>& facet) {
    const auto* surface = surface_of(geometry, facet.reference);
    return surface ? sampled(facet, to_surface<D>(*surface)) : sampled(facet, to_own_plane(facet));
}

template <int D>
Samples distances(const Surrogate<D>& surrogate, const CurvedFacet<D>& facet) {
    if (is_own_facet(surrogate, facet)) {
        const auto& flat = surrogate.flats[surrogate.patches[facet.id]];
        if (flat.is_flat()) return sampled(facet, to_flat(flat));
        return sampled(facet, [&](const Vec<D>& p, const Barycentric<D - 1>& xi) {
            return std::sqrt(closest_near(surrogate, facet.id, xi, p).distance_squared);
        });
    }
    const auto of_reference = [&](FacetId f) { return surrogate.references[f] == facet.reference; };
    const auto first = closest_among(surrogate, facet.shape.control[0], of_reference);
    if (!first.facet.valid()) return sampled(facet, to_own_plane(facet));
    return sampled(facet, [&](const Vec<D>& p, const Barycentric<D - 1>&) {
        const auto foot = closest_among(surrogate, p, of_reference);
        const auto& flat = surrogate.flats[surrogate.patches[foot.facet]];
        return flat.is_flat() && flat.height(p) == 0 ? 0 : std::sqrt(foot.distance_squared);
    });
}

template <int D>
Samples distances(const MixedGeometry<D>& geometry, const CurvedFacet<D>& facet) {
    return surface_of(geometry.analytic, facet.reference) ? distances(geometry.analytic, facet)
                                                          : distances(geometry.surrogate, facet);
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
        const CurvedFacet<D> facet{id, mesh.linear.facets.references[id],
                                   bezier_form<D - 1, D>(mesh.linear.points, mid_nodes, mesh.linear.facets.vertices[id],
                                                         mesh.edges.of_facets[id])};
        const Samples s = std::visit([&](const auto& g) { return distances(g, facet); }, geometry);
        const double area = straight_area(facet);
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

template Outcome<BoundaryDistance> boundary_distance(const QuadraticMesh<2>&, std::span<const LagrangeNode<2>>,
                                                     const Features<2>&, const Geometry<2>&, const Execution&);
template Outcome<BoundaryDistance> boundary_distance(const QuadraticMesh<3>&, std::span<const LagrangeNode<3>>,
                                                     const Features<3>&, const Geometry<3>&, const Execution&);

}  // namespace camber
