/// Generators of example domains: pure functions of their options, the same bytes for the same seed.
export module camber.shapes;
export import :box;
export import :delaunay;
export import :hybrid;
