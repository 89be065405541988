/// Validity of quadratic elements: Jacobian coefficients with error bounds, certified verdicts, and the verbs
/// `validate` and `relax`. Soundness of the mesh that all of it begins with, and its repair: `examine`, `prepare`.
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
export import :soundness;
export import :prepare;
export import :lowest_point;
import :examination;
