/// A mesh, straight or of degree 2, brought to a metric: the cavity operator on wishes, and the passes split, collapse,
/// swap and smooth.
export module camber.remesh;
export import :state;
export import :measures;
export import :wish;
export import :curved_workspace;
export import :plan;
export import :quality_bar;
export import :cone_shapes;
export import :delaunay;
export import :near_geometry;
export import :rounds;
export import :passes;
export import :node_moves;
export import :to_metric;
export import :settled;
import :boundary_moves;
import :candidates;
import :curved_star;
import :homecoming;
import :kept_shapes;
import :nodal_facets;
import :heights;
import :node_shell;
import :old_curves;
import :on_geometry;
import :walls;
import :wall_elements;
