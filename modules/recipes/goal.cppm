module;
#include <optional>
export module camber.recipes:goal;
import camber.surface;
import :boundary;
import :metric_source;

export namespace camber {

/// What a recipe brings a mesh to.
template <int D>
struct MeshGoal {
    MetricSource<D> metric = natural_metric<D>();
    std::optional<Geometry<D>> geometry = {};  ///< none: smooth surfaces through the mesh's own vertices
    BoundaryOptions<D> boundary = {};
};

}  // namespace camber
