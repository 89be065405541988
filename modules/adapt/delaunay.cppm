module;
#include <cstddef>
export module camber.adapt:delaunay;
import camber.core;
import camber.metric;
import camber.cavity;
import camber.operation;
import :bent_spokes;

export namespace camber {

/// Whether a point lies in the sphere (2D: circle) through an element's vertices, in the point's own metric; of degree
/// 2 the vertices are where the tangents of its edges to them lead.
template <int D>
[[nodiscard]] bool is_in_metric_sphere(const Adaptation<D>& r, ElementId e, const ConePoint<D>& point,
                                       BentSpokes<D>& spokes);

/// The Delaunay cavity of a point in its own metric (paper §1.3): to the elements that are in it already, which hold
/// the point, those that faces without facets connect and in whose spheres the point lies, unless their vertex opposite
/// that face is nearer to the point than `shortest` (in the metric). At most `most` elements.
template <int D>
void grow_delaunay(const Adaptation<D>& r, const ConePoint<D>& point, BentSpokes<D>& spokes, std::size_t most,
                   double shortest, Cavity<D>& cavity);

}  // namespace camber
