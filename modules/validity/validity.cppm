/// Validity of quadratic elements: Jacobian coefficients with error bounds, certificates, `validate` for proposals, and
/// `commit` for judged proposals.
export module camber.validity;
export import :jacobian;
export import :validate;
export import :verdict;
