/// Validity of quadratic elements: Jacobian coefficients with error bounds, certificates of elements and motions, the
/// verbs `validate` and `relax`, and the programmes of a single edge. Soundness of the mesh that all of it begins with,
/// and its repair: `examine`, `prepare`.
export module camber.validity;
export import :twice;
export import :coefficients;
export import :jacobian;
export import :subdivide;
export import :verdict;
export import :certificate;
export import :motion;
export import :validate;
export import :segment;
export import :relax;
export import :repair;
export import :soundness;
export import :prepare;
export import :linear_programme;
export import :quadratic_programme;
export import :edge_shell;
export import :edge_programme;
export import :lowest_point;
export import :mean_ratio;
import :examination;
import :tensor;
