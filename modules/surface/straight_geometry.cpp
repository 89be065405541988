module;
#include <optional>
module camber.surface;
import camber.core;

namespace camber {

template <int D>
SurfacePoint<D> StraightGeometry<D>::project(const SurfaceHint&, const Vec<D>& p) const {
    return {.point = p, .normal = {}};
}

template <int D>
GeometryEntity StraightGeometry<D>::surface_at(const FacetSite<D>&) const {
    return {};
}

#define CAMBER_INSTANTIATE(D) template class StraightGeometry<D>;

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
