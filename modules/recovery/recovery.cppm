/// Gradient, Hessian and third derivatives of fields that are known by their values at a mesh's nodes: what metrics for
/// adaptation are made from.
export module camber.recovery;
export import :derivatives;
import :polynomials;
