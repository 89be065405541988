/// Fields as functions of position: metrics by name and by expressions of the coordinates, and scalar expressions.
export module camber.fields;
export import :analytic;
export import :expression;
export import :scalar;
