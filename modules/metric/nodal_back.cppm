module;
#include <array>
#include <cstddef>
#include <span>
module camber.metric:nodal_back;
import camber.core;
import :back_mesh;
import :curved_locator;
import :nodal_field;
import :spd;

namespace camber {

/// The back mesh of make_nodal_back_mesh.
template <int D>
class NodalBack final : public BackModel<D> {
  public:
    CurvedLocator<D> places;
    NodalLogs<D> logs;
    Column<LogGradient<D>> recovered;  ///< at the vertices: means over the balls, by volume

    [[nodiscard]] Location<D> locate(const Vec<D>& p, ElementId hint) const override { return places.locate(p, hint); }
    void sample_values(std::span<const Vec<D>> points, ElementId hint, std::span<FieldSample<D>> out) const override;
    void sample_with_gradients(std::span<const Vec<D>> points, ElementId hint,
                               std::span<FieldSample<D>> out) const override;
    void sample_with_recovered_gradients(std::span<const Vec<D>> points, ElementId hint,
                                         std::span<FieldSample<D>> out) const override;
    void see(std::span<const BackEdge> edges, std::span<EdgeEnds<D>> out) const override;
    [[nodiscard]] std::size_t vertex_count() const override { return places.mesh.linear.points.size(); }
    [[nodiscard]] BackVertex<D> vertex(VertexId v) const override {
        return {places.mesh.linear.points[v], logs.vertices[v]};
    }
    [[nodiscard]] BackSector<D> sector(ElementId e, VertexId a, VertexId b) const override;

    [[nodiscard]] LogMetric<D> value_at(const Location<D>& location) const;
    /// ∂ log M in space, as the element has it at ξ.
    [[nodiscard]] LogGradient<D> gradient_at(ElementId e, const std::array<double, D + 1>& xi) const;
};

/// The boundary point that is nearest to p: its face, its coordinates there, and whether p is seen to lie beyond it
/// (where it is within the face, and p on the outer side).
template <int D>
struct NearestOnCurved {
    ElementFace face;
    std::array<double, D> xi{};
    bool is_beyond = false;
};
template <int D>
[[nodiscard]] NearestOnCurved<D> nearest_on_boundary(const CurvedLocator<D>& back, const Vec<D>& p);

/// How the nearest point of a face moves with p, in its ξ_1 … ξ_{D−1}: ∂ξ/∂p, a row each, zero for what does not move
/// since the point is on the face's boundary.
template <int D>
[[nodiscard]] std::array<Vec<D>, D> slide_along_face(const CurvedLocator<D>& back, const Location<D>& location,
                                                     const Vec<D>& p);

}  // namespace camber
