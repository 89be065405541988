/// Validity of quadratic elements: Jacobian coefficients with error bounds, certificates of elements and of motions,
/// and the verbs around them: `validate`, which judges a proposal, and `commit`, which takes nothing but a judged one.
export module camber.validity;
export import :twice;
export import :coefficients;
export import :jacobian;
export import :affine_jacobian;
export import :subdivide;
export import :verdict;
export import :certificate;
export import :motion;
export import :packs;
export import :surface_triangle;
export import :signed_volume;
export import :validate;
export import :commit;
import :tensor;
