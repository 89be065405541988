/// What a mesh is good for: the error of a function's interpolant on it, of degree 1 and 2, straight and curved, and
/// straight within curved walls.
export module camber.interpolation;
export import :gauss_jacobi;
export import :error;
import :collapsed_rule;
import :piece;
import :quadrature;
import :straight_inside;
import :volumes;
