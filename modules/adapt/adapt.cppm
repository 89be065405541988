/// Passes that adapt a straight or quadratic mesh to a metric: split, collapse, swap, smooth, and mend, which improves
/// bad elements. Also the paper's global algorithm, which reinserts every vertex.
export module camber.adapt;
export import :cone_shapes;
export import :passes;
export import :swaps;
