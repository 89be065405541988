module;
#include <cstddef>
export module camber.adapt:delaunay;
import camber.core;
import camber.metric;
import camber.cavity;
import camber.operation;

export namespace camber {

/// Whether a point lies in the sphere (2D: circle) through an element's vertices, in the point's own metric.
template <int D>
[[nodiscard]] bool is_in_metric_sphere(const Adaptation<D>& r, ElementId e, const Vec<D>& point,
                                       const MeasuringMetric<D>& metric);

/// The Delaunay cavity of a point in its own metric (paper §1.3): to the elements that are in it already, which hold
/// the point, those that faces without facets connect and in whose spheres the point lies, unless their vertex opposite
/// that face is nearer to the point than `shortest` (in the metric). At most `most` elements.
template <int D>
void grow_delaunay(const Adaptation<D>& r, const Vec<D>& point, const MeasuringMetric<D>& metric, std::size_t most,
                   double shortest, Cavity<D>& cavity);

}  // namespace camber
