/// A metric from what is known of a solution: local models of the error from its derivatives, optimal metrics in L^p
/// and W^{1,p} norms, and their composition with fixed metrics, bounds and gradation to a given complexity.
export module camber.solution_metric;
export import :fixed_metrics;
export import :models;
export import :optimal_metric;
