/// Walls that pass through each other: whether two P2 facets cross, all pairs of a mesh's facets that do, a grid of
/// facets that come and go; and elements that overlap.
export module camber.crossing;
export import :crossings;
import :net;
import :outer_boundary;
import :planar;
