/// Generators of example domains: pure functions of their options, the same bytes for the same seed.
export module camber.shapes;
export import :random;
export import :extrude;
export import :boundary;
export import :jitter;
export import :delaunay;
export import :sphere;
export import :layers;
export import :shell;
export import :shell_core;
export import :box;
export import :bump;
export import :amount;
export import :shape_rows;
