/// Metrics from solutions: local error models, optimal metrics in L^p and W^{1,p} norms, and their composition.
export module camber.solution_metric;
export import :fixed_metrics;
export import :models;
export import :optimal_metric;
