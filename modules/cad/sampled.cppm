module;
#include <cstddef>
#include <span>
#include <vector>
module camber.cad:sampled;
import camber.core;
import camber.surface;
import :association;
import :model;

/// Some facets of a mesh, and whether they lie on a model: what decides whether it is the model of this mesh.
namespace camber {

/// Facets of one reference, spread evenly over all that it has.
struct SampledReference {
    Reference reference = 0;
    std::size_t count = 0;  ///< of all its facets
    std::vector<FacetId> facets;
};

/// Of the facets whose reference is not among `elsewhere` (rising).
template <int D>
[[nodiscard]] std::vector<SampledReference> sampled(const LinearMesh<D>& mesh, std::span<const Reference> elsewhere);

/// How much of a sample is astray. A facet's share is that of its vertices which are farther from the model's best face
/// for it than half of its longest edge; all of it where that face runs across it.
struct SampleVerdict {
    double share = 0;                        ///< of all facets, as the sample tells
    std::size_t astray = 0, facets = 0;      ///< of those looked at
    const SampledReference* lost = nullptr;  ///< more than half of it is astray, the most of all
    std::size_t lost_astray = 0;
    FacetId farthest;  ///< of those astray

    [[nodiscard]] bool fits() const {
        constexpr double most = 0.1;
        return share <= most && lost == nullptr;
    }
};

/// `factor`: of the mesh's coordinates. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<SampleVerdict> judged(const LinearMesh<D>& mesh, const CadModel& model,
                                            std::span<const SampledReference> sample,
                                            std::span<const std::size_t> candidates, double factor,
                                            const Execution& execution);

}  // namespace camber
