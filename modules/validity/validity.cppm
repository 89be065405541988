/// Validity of quadratic elements: Jacobian coefficients with error bounds, certified verdicts, and the verbs
/// `validate` and `relax`.
export module camber.validity;
export import :twice;
export import :coefficients;
export import :jacobian;
export import :subdivide;
export import :verdict;
export import :validate;
export import :segment;
export import :relax;
export import :repair;
