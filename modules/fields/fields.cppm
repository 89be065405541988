/// Metric fields as functions of position: analytic ones by name, and expressions of the coordinates.
export module camber.fields;
export import :analytic;
export import :expression;
