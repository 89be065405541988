/// Lengths and energies of quadratic edges in a metric field with their derivatives, and the mid nodes that minimise
/// them or by which functions are interpolated best.
export module camber.edge_optimisation;
export import :edge_accuracy;
export import :edge_minimiser;
