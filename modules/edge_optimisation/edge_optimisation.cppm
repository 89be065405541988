/// Lengths and energies of quadratic edges in a metric field; mid nodes of minimum length or best interpolation.
export module camber.edge_optimisation;
export import :edge_accuracy;
export import :edge_minimiser;
