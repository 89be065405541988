/// A straight mesh brought to a metric: the P1 cavity operator on wishes, and the passes split, collapse, swap and
/// smooth.
export module camber.remesh;
export import :state;
export import :measures;
export import :plan;
export import :cone_shapes;
export import :delaunay;
export import :near_geometry;
export import :rounds;
export import :passes;
export import :to_metric;
export import :settled;
import :boundary_moves;
import :candidates;
import :homecoming;
import :kept_shapes;
import :on_geometry;
import :wall_elements;
