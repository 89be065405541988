module;
#include <algorithm>
#include <cmath>
module camber.validity;
import camber.core;
import camber.bezier;
import :certificate;
import :jacobian;
import :surface_triangle;
import :verdict;

namespace camber {

namespace {

template <int D, class Element, class Points>
Certificate<D> by_levels(const Element& element, const Points& points, double bound) {
    Certificate<D> certificate = certify_in_doubles<D>(bounded_jacobian(element), bound);
    if (certificate.verdict != Verdict::undecided) return certificate;
    if (!std::all_of(points.begin(), points.end(), [](const auto& p) { return is_finite(p); }))
        return {Verdict::invalid, Level::filter, {}};
    certificate = certify_in_doubles<D>(sharp_jacobian(element), bound);
    certificate.level = Level::twice;
    if (certificate.verdict != Verdict::undecided) return certificate;
    return certify_exactly(element, bound);
}

}  // namespace

template <int D>
Certificate<D> certify(const NodalSimplex<D>& element, double bound) {
    return by_levels<D>(element, element.nodes, bound);
}

template <int D>
Certificate<D> certify(const QuadraticSimplex<D, D>& element, double bound) {
    return by_levels<D>(element, element.control, bound);
}

Certificate<2> certify(const SurfaceTriangle& triangle, double bound) {
    return by_levels<2>(triangle, triangle.nodes, bound);
}

#define CAMBER_INSTANTIATE(D)                                           \
    template Certificate<D> certify<D>(const NodalSimplex<D>&, double); \
    template Certificate<D> certify<D>(const QuadraticSimplex<D, D>&, double);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
