module;
#include <array>
#include <cstddef>
#include <span>
module camber.metric:surface_back;
import camber.core;
import camber.box_tree;
import :back_mesh;
import :spd;

namespace camber {

/// A triangle's unit tangents (the first along its first edge) and normal, and the gradients of its barycentric
/// coordinates; all 0 where it has no area.
struct TriangleFrame {
    std::array<Vec<3>, 2> tangents{};
    Vec<3> normal{};
    std::array<Vec<3>, 3> gradients{};
    double area = 0;
};
[[nodiscard]] TriangleFrame triangle_frame(const std::array<Vec<3>, 3>& p);

[[nodiscard]] inline std::array<Vec<3>, 3> triangle_corners(const LinearMesh<3>& mesh, std::size_t f) {
    const auto& v = mesh.facets.vertices[f];
    return {mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]]};
}

/// The back mesh of a surface alone: log-metrics at its vertices, linear in each triangle; a point of space has the
/// values of the nearest point of the triangles, so that the field is constant along their normals, and its gradient
/// has no part there.
class SurfaceBack final : public BackModel<3> {
  public:
    LinearMesh<3> mesh;
    Column<LogMetric<3>> log_metrics;
    Column<LogGradient<3>> nodal_gradients;  ///< area-weighted means over the balls; or none
    BoxTree<3> tree;                         ///< of the triangles

    [[nodiscard]] Location<3> locate(const Vec<3>& p, ElementId hint) const override;
    void sample_values(std::span<const Vec<3>> points, ElementId hint, std::span<FieldSample<3>> out) const override;
    void sample_with_gradients(std::span<const Vec<3>> points, ElementId hint,
                               std::span<FieldSample<3>> out) const override;
    void sample_with_recovered_gradients(std::span<const Vec<3>> points, ElementId hint,
                                         std::span<FieldSample<3>> out) const override;
    void see(std::span<const BackEdge> edges, std::span<EdgeEnds<3>> out) const override;
    [[nodiscard]] std::size_t vertex_count() const override { return mesh.points.size(); }
    [[nodiscard]] BackVertex<3> vertex(VertexId v) const override { return {mesh.points[v], log_metrics[v]}; }
    [[nodiscard]] BackSector<3> sector(ElementId e, VertexId a, VertexId b) const override;

    [[nodiscard]] LogGradient<3> gradient_in(ElementId triangle) const;
};

/// Without gradients at the vertices where they are not asked for. Errors: a column of another size; stopped.
[[nodiscard]] Outcome<SurfaceBack> make_surface_back(const LinearMesh<3>& mesh, Column<LogMetric<3>> log_metrics,
                                                     const Execution& execution);

/// The natural metric of a surface alone at its vertices, the log-Euclidean mean over the triangles around, weighted by
/// area: in a triangle's plane the metric for which its edges have length 1; along its normal the geometric mean of the
/// two sizes there, for nothing of the mesh tells another. Vertices without triangles get the identity metric.
[[nodiscard]] Outcome<Buffer<LogMetric<3>>> natural_surface_log_metrics(const LinearMesh<3>& mesh,
                                                                        const Execution& execution);

}  // namespace camber
