module;
#include <functional>
#include <memory>
#include <optional>
#include <vector>
export module camber.surface:makers;
import camber.core;
import :analytic;
import :features;
import :geometry;
import :geometry_places;
import :plane;
import :surrogate;

export namespace camber {

/// The boundary is what the straight facets are: nothing is curved, and there is no surface to project onto.
template <int D>
class StraightGeometry final : public GeometryModel<D> {
  public:
    [[nodiscard]] SurfacePoint<D> project(const SurfaceHint& hint, const Vec<D>& p) const override;
    [[nodiscard]] GeometryEntity surface_at(const FacetSite<D>& facet) const override;
};

/// The surrogate as a geometry: surfaces are its patches, curves its ridge curves. Edges and facets of the mesh that it
/// was made from are known by their number and place; those of others are projected.
template <int D>
[[nodiscard]] std::shared_ptr<const GeometryModel<D>> model_of(Surrogate<D> surrogate);

/// A surrogate that was made from another mesh: it prescribes the surface of the references that it has, and each of
/// its ridges that of edges whose ends are near it.
template <int D>
struct PrescribedSurrogate {
    Surrogate<D> surrogate;
};
template <int D>
[[nodiscard]] std::shared_ptr<const GeometryModel<D>> model_of(PrescribedSurrogate<D> prescribed);

/// Analytic surfaces as a geometry; references without one have no surface.
template <int D>
[[nodiscard]] std::shared_ptr<const GeometryModel<D>> model_of(AnalyticGeometry<D> analytic);

/// Two geometries mixed by reference: facets of `references` lie on `first`, which has surfaces for them, all others on
/// `rest`, which may be a mixture too. Where a surface of `first` meets one that `rest` prescribes, edges lie on the
/// curve of both; where these touch rather than cross, on the rim of one of them, if that has one there and tells its
/// number (a CAD model's face ends at an edge). Where it meets what is not prescribed, on its own rim, if it has one;
/// else, beside a plane, on the curve of both, and beside another, which is known by its nodes alone, on `first`, next
/// to where `rest` has the edge.
template <int D>
struct MixedGeometry {
    std::vector<Reference> references;
    Geometry<D> first, rest;
};
template <int D>
[[nodiscard]] std::shared_ptr<const GeometryModel<D>> model_of(MixedGeometry<D> mixed);

/// Makes the surrogate of what a geometry leaves of a mesh's boundary.
template <int D>
using MakesSurrogate = std::function<Outcome<Surrogate<D>>(const GeometryModel<D>& prescribed)>;

/// The analytic surfaces alone where every facet has one, else with the surrogate for the rest, which is made only
/// then. Errors: of its making.
template <int D>
[[nodiscard]] Outcome<Geometry<D>> with_surrogate(AnalyticGeometry<D> analytic, const LinearMesh<D>& mesh,
                                                  const MakesSurrogate<D>& surrogate);

}  // namespace camber
