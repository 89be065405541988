/// Detection of crossing facets and overlapping elements.
export module camber.crossing;
export import :crossings;
import :net;
import :outer_boundary;
import :planar;
