module;
#include <cstddef>
export module camber.adapt:delaunay;
import camber.core;
import camber.metric;
import camber.cavity;
import camber.operation;
import :bent_spokes;

export namespace camber {

/// The Delaunay cavity of a point in its own metric (paper §1.3): to the elements that are in it already, which hold
/// the point, those that faces without facets connect and in whose spheres (2D: circles) the point lies, unless their
/// vertex opposite that face is nearer to the point than `shortest` (in the metric). Of degree 2 vertices are where the
/// tangents of the point's edges to them lead. At most `most` elements. `spokes`: begun at the point; in the end
/// they lead to all vertices that were looked at.
template <int D>
void grow_delaunay(const Adaptation<D>& r, BentSpokes<D>& spokes, std::size_t most, double shortest, Cavity<D>& cavity);

}  // namespace camber
