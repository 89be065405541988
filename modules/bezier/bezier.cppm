/// Bernstein algebra in any degree and dimension, P2 edges and simplices, and the verb `elevate`.
export module camber.bezier;
export import :bernstein;
export import :edge;
export import :simplex;
export import :elevate;
