/// A mesh, straight or of degree 2, brought to a metric by passes of the cavity operator: split, collapse, swap,
/// smooth, mend; and the paper's global algorithm, which puts every vertex in again.
export module camber.adapt;
export import :bent_spokes;
export import :bent_swaps;
export import :cone_shapes;
export import :delaunay;
export import :passes;
export import :node_moves;
export import :reinsert;
export import :straight_swaps;
export import :to_metric;
import :boundary_moves;
import :candidates;
import :kept_shapes;
import :snap;
