/// Walls that pass through each other: whether two P2 facets cross, all pairs of a mesh's facets that do, a grid of
/// facets that come and go; and elements that overlap.
export module camber.crossing;
export import :facet;
export import :pair;
export import :facet_grid;
export import :crossings;
export import :disjoint;
export import :overlaps;
import :net;
import :separation;
import :graph;
import :transversal;
import :parabola;
import :search;
import :planar;
import :straight;
import :ray;
import :outer_boundary;
