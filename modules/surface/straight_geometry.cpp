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

template class StraightGeometry<2>;
template class StraightGeometry<3>;

}  // namespace camber
