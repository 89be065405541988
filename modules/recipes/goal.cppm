module;
#include <optional>
#include <vector>
export module camber.recipes:goal;
import camber.surface;
import :boundary;
import :known_solution;
import :metric_source;

export namespace camber {

/// What a recipe brings a mesh to.
template <int D>
struct MeshGoal {
    MetricSource<D> metric = natural_metric<D>();
    std::optional<Geometry<D>> geometry = {};  ///< none: smooth surfaces through the mesh's own vertices
    BoundaryOptions<D> boundary = {};
    GivenSolution<D> solution = {};  ///< of the objective solution; curving alone asks for it
};

}  // namespace camber
