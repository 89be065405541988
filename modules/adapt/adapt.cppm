/// A mesh, straight or of degree 2, brought to a metric by passes of the cavity operator: split, collapse, swap,
/// smooth, mend; and the paper's global algorithm, which puts every vertex in again.
export module camber.adapt;
export import :cone_shapes;
export import :passes;
export import :swaps;
