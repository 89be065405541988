/// Validity of quadratic elements: Jacobian coefficients with error bounds, certificates of elements,
/// and the verbs around them: `validate`, which judges a proposal, and `commit`, which takes nothing but a judged one.
export module camber.validity;
export import :jacobian;
export import :validate;
export import :verdict;
