/// Gradients, Hessians and third derivatives of fields from nodal values, for adaptation metrics.
export module camber.recovery;
export import :derivatives;
import :polynomials;
