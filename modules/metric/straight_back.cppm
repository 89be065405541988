module;
#include <cstddef>
#include <span>
module camber.metric:straight_back;
import camber.core;
import camber.box_tree;
import :back_mesh;
import :spd;

namespace camber {

/// The back mesh that is straight, with all that location needs.
template <int D>
class StraightBack final : public BackModel<D> {
  public:
    LinearMesh<D> mesh;
    Column<LogMetric<D>> log_metrics;        ///< at the vertices
    Column<LogGradient<D>> nodal_gradients;  ///< volume-weighted means over the balls: they do not jump; or none
    Neighbours<D> neighbours;
    Column<ElementFace> boundary;
    BoxTree<D> boundary_tree;  ///< boxes of `boundary`

    [[nodiscard]] Location<D> locate(const Vec<D>& p, ElementId hint) const override;
    void sample_values(std::span<const Vec<D>> points, ElementId hint, std::span<FieldSample<D>> out) const override;
    void sample_with_gradients(std::span<const Vec<D>> points, ElementId hint,
                               std::span<FieldSample<D>> out) const override;
    void sample_with_recovered_gradients(std::span<const Vec<D>> points, ElementId hint,
                                         std::span<FieldSample<D>> out) const override;
    void see(std::span<const BackEdge> edges, std::span<EdgeEnds<D>> out) const override;
    [[nodiscard]] PackedField<D> packed() const override { return {this, nullptr}; }
    [[nodiscard]] std::size_t vertex_count() const override { return mesh.points.size(); }
    [[nodiscard]] BackVertex<D> vertex(VertexId v) const override { return {mesh.points[v], log_metrics[v]}; }
    [[nodiscard]] BackSector<D> sector(ElementId e, VertexId a, VertexId b) const override;

    /// ∂ log M in one element, where it is constant: ∂_i log M = Σ_j ∂_i u_j log M_j.
    [[nodiscard]] LogGradient<D> gradient_in(ElementId e) const;
    /// log M = Σ ξ_i log M_i (paper §1.2), and its gradients, as they are sampled at points with that location.
    [[nodiscard]] LogMetric<D> value_at(const Location<D>& location) const;
    [[nodiscard]] LogGradient<D> gradient_at(const Location<D>& location) const;
    [[nodiscard]] LogGradient<D> recovered_gradient_at(const Location<D>& location) const;
};

/// With what location needs, but no gradients at the vertices. Errors: those of make_back_mesh.
template <int D>
[[nodiscard]] Outcome<StraightBack<D>> make_straight_back(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                          Column<LogMetric<D>> log_metrics, const Execution& execution);

/// The gradient in an element times its volume, and the volume (both D! times).
template <int D>
struct WeightedGradient {
    LogGradient<D> gradient{};
    double volume = 0;
};
template <int D>
[[nodiscard]] WeightedGradient<D> weighted_gradient(const StraightBack<D>& back, ElementId e);

/// The gradients of a straight back mesh, of each vertex the mean over its ball, weighted by volume. Errors: memory,
/// stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LogGradient<D>>> mean_gradients(const StraightBack<D>& back,
                                                             const Incidence<ElementId>& balls,
                                                             const Execution& execution);

}  // namespace camber
