/// Generators of example domains: pure functions of their options, including the seed.
export module camber.shapes;
export import :box;
export import :delaunay;
export import :hybrid;
