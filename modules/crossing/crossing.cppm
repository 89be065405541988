/// Crossing facets: pair tests, all facets of a mesh, a dynamic grid; overlapping elements.
export module camber.crossing;
export import :crossings;
import :net;
import :outer_boundary;
import :planar;
