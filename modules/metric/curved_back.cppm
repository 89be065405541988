module;
#include <cstddef>
#include <span>
module camber.metric:curved_back;
import camber.core;
import :back_mesh;
import :spd;
import :straight_back;

namespace camber {

/// A place in the reference mesh, and the map there.
template <int D>
struct Bent {
    Vec<D> point;     ///< x
    Mat<D> jacobian;  ///< F = ∂x/∂X
};

/// The back mesh of degree 2: a straight one, its reference, and the displacement of the nodes.
template <int D>
class CurvedBack final : public BackModel<D> {
  public:
    StraightBack<D> reference;
    EdgeSet<D> edges;
    Column<Vec<D>> displacements;  ///< u_e
    /// At the vertices, means over the balls of what the elements see: the gradient of log(Fᵀ M F), linear in each,
    /// brought into space by the map there; or none.
    Column<LogGradient<D>> relative_gradients;

    [[nodiscard]] Location<D> locate(const Vec<D>& p, ElementId hint) const override;
    void sample_values(std::span<const Vec<D>> points, ElementId hint, std::span<FieldSample<D>> out) const override;
    void sample_with_gradients(std::span<const Vec<D>> points, ElementId hint,
                               std::span<FieldSample<D>> out) const override;
    void sample_with_recovered_gradients(std::span<const Vec<D>> points, ElementId hint,
                                         std::span<FieldSample<D>> out) const override;
    void see(std::span<const BackEdge> pack, std::span<EdgeEnds<D>> out) const override;
    [[nodiscard]] PackedField<D> packed() const override { return {&reference, this}; }
    [[nodiscard]] std::size_t vertex_count() const override { return reference.vertex_count(); }
    [[nodiscard]] BackVertex<D> vertex(VertexId v) const override { return reference.vertex(v); }
    [[nodiscard]] BackSector<D> sector(ElementId e, VertexId a, VertexId b) const override;

    [[nodiscard]] bool is_bent(ElementId e) const;
    [[nodiscard]] Bent<D> at(const Location<D>& location) const;
};

}  // namespace camber
