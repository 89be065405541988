/// Bernstein algebra in any degree and dimension, Lagrange functions of all shapes, quadrature rules, P2 edges and
/// simplices, and `elevate`.
export module camber.bezier;
export import :bernstein;
export import :lagrange;
export import :quadrature;
