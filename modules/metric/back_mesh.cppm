module;
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <vector>
export module camber.metric:back_mesh;
import camber.core;
import camber.box_tree;
import :spd;

export namespace camber {

/// Derivatives ∂ log M/∂x_i of a metric field M, for i = 1 … D.
template <int D>
using LogGradient = std::array<Sym<D>, D>;

enum class Placement : std::uint8_t {
    inside,
    outside,  ///< the point is outside the mesh; its nearest boundary point replaces it
    lost,     ///< the search failed; the nearest boundary point replaces the point or, without a boundary, the centre
              ///< of an element
};

/// Location of a point, or of the point that replaces it (see `Placement`).
template <int D>
struct Location {
    ElementId element;
    std::array<double, D + 1> xi{};
    Placement placement = Placement::inside;
};

/// Metric field at a point. The gradient is in physical coordinates; functions that sample only values do not set it.
template <int D>
struct FieldSample {
    LogMetric<D> log_metric;
    LogGradient<D> gradient{};
    Location<D> location;
};

template <int D>
struct BackVertex {
    Vec<D> point;
    LogMetric<D> log_metric;
};

/// Edge of the mesh on which the field is defined; `shell` lists the elements around the edge.
struct BackEdge {
    VertexId a, b;
    std::span<const ElementId> shell;
};

template <int D>
struct EdgeEnd {
    LogMetric<D> log_metric;
    LogGradient<D> gradient{};             ///< recovered gradient of log M; on curved meshes, the gradient of log(Fᵀ M
                                           ///< F), see `make_curved_back_mesh`
    Mat<D> jacobian = Mat<D>::identity();  ///< F = ∂x/∂X for the map from the straight mesh (X) to the curved mesh (x),
                                           ///< averaged over the shell
};
/// Field at both ends of an edge. The Jacobian F is linear along the edge.
template <int D>
struct EdgeEnds {
    EdgeEnd<D> a, b;
    bool is_curved = false;
};

/// One element of an edge's shell. `walls` are normals, of any length, that point into the element: in 3D those of its
/// two faces that contain the edge, in 2D that of the edge.
template <int D>
struct BackSector {
    LogGradient<D> gradient{};
    std::array<Vec<D>, D - 1> walls{};
};

template <int D>
class StraightBack;
template <int D>
class CurvedBack;

/// Data of a field for code that searches several points at a time (packs); null pointers if the model does not support
/// this. For curved fields `straight` is the straight reference mesh.
template <int D>
struct PackedField {
    const StraightBack<D>* straight = nullptr;
    const CurvedBack<D>* bent = nullptr;
};

/// Interface of metric fields on meshes. Implementations are immutable and safe for concurrent use. A hint is an
/// element near the point; it changes results by rounding only.
///
/// In curved elements, `Location::xi` are coordinates in the reference element, and gradients are transformed to
/// physical space with the inverse Jacobian. The walls of a `sector` are tangent planes at the middle of the edge.
///
/// Sampling functions write the sample of `points[i]` to `out[i]`. The search for the first point starts from `hint`,
/// each later search from the element of the previous point, so consecutive points should be close. Results are bitwise
/// those of separate calls for each point with the same hints.
template <int D>
class BackModel {
  public:
    virtual ~BackModel() = default;

    [[nodiscard]] virtual Location<D> locate(const Vec<D>& p, ElementId hint) const = 0;
    virtual void sample_values(std::span<const Vec<D>> points, ElementId hint, std::span<FieldSample<D>> out) const = 0;
    /// Samples values, and the gradients of the field in each point's element. Outside the mesh, gradients are those of
    /// the constant continuation from the nearest boundary point.
    virtual void sample_with_gradients(std::span<const Vec<D>> points, ElementId hint,
                                       std::span<FieldSample<D>> out) const = 0;
    /// Samples values and recovered gradients. These interpolate volume-weighted means over the elements around each
    /// vertex, so they are continuous across faces.
    virtual void sample_with_recovered_gradients(std::span<const Vec<D>> points, ElementId hint,
                                                 std::span<FieldSample<D>> out) const = 0;

    virtual void sample_edges(std::span<const BackEdge> edges, std::span<EdgeEnds<D>> out) const = 0;

    [[nodiscard]] virtual PackedField<D> packed() const { return {}; }

    [[nodiscard]] virtual std::size_t vertex_count() const = 0;
    [[nodiscard]] virtual BackVertex<D> vertex(VertexId v) const = 0;
    [[nodiscard]] virtual BackSector<D> sector(ElementId e, VertexId a, VertexId b) const = 0;

  protected:
    BackModel() = default;
    BackModel(const BackModel&) = default;
    BackModel(BackModel&&) = default;
    BackModel& operator=(const BackModel&) = default;
    BackModel& operator=(BackModel&&) = default;
};

/// Handle of a metric field on a mesh; immutable and cheap to copy. A default-constructed handle has no model, so `->`
/// must not be used.
template <int D>
class BackMesh {
  public:
    BackMesh() = default;
    explicit BackMesh(std::shared_ptr<const BackModel<D>> model) : model_(std::move(model)) {}
    template <std::derived_from<BackModel<D>> Model>
    explicit BackMesh(Model model) : model_(std::make_shared<const Model>(std::move(model))) {}

    [[nodiscard]] const BackModel<D>* operator->() const { return model_.get(); }
    [[nodiscard]] const BackModel<D>& operator*() const { return *model_; }

  private:
    std::shared_ptr<const BackModel<D>> model_;
};

/// Gradients that a curved back mesh stores at vertices. Without `recovered`, functions for recovered gradients return
/// the gradient in the point's element. Without `sampled`, `sample_edges` returns zero gradients.
enum class StoredGradients : std::uint8_t {
    recovered,
    sampled,
    all,
};

/// Makes a field from log-metrics at the vertices of a straight mesh (paper, §1.2). It is linear in each element, and
/// constant along the normal beyond the boundary. On standalone surface meshes, an element id is the number of a
/// triangle. Errors: not one row per vertex; those of `neighbours`; stopped.
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> make_back_mesh(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                  Column<LogMetric<D>> log_metrics, const Execution& execution);

/// Makes a field that follows the curved edges of a quadratic mesh (docs/algorithms/curved-back-mesh.md). The map
///
///     x(X) = X + Σ 4 ξ_i ξ_j u_e (sum over the edges e = i–j of an element)
///
/// takes the point X of the straight mesh with barycentric coordinates ξ to the curved mesh. u_e is the vector from the
/// chord's middle to the edge node. The value at x is the linear interpolation at X. Gradients are transformed by F⁻ᵀ
/// with F = ∂x/∂X. For points outside the mesh, X is the nearest point of the straight mesh. In invalid elements, which
/// have no inverse map, X is the last iterate of Newton's method.
///
/// `sample_edges` returns gradients of log(Fᵀ M F): the metric relative to the curved edges. Errors: those of
/// `make_back_mesh`.
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> make_curved_back_mesh(QuadraticMesh<D> mesh, const Incidence<ElementId>& balls,
                                                         Column<LogMetric<D>> log_metrics, const Execution& execution,
                                                         StoredGradients stored = StoredGradients::all);

/// Makes a field from the straight mesh of `back` and other log-metrics, without vertex gradients. Errors: not one row
/// per vertex; `back` has no straight mesh (internal).
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> straight_back_mesh(const BackMesh<D>& back, Column<LogMetric<D>> log_metrics);

template <int D>
[[nodiscard]] std::array<Vec<D>, D + 1> barycentric_gradients(const LinearMesh<D>& mesh, ElementId e);

template <int D>
[[nodiscard]] Location<D> locate(const BackMesh<D>& back, const Vec<D>& p, ElementId hint) {
    return back->locate(p, hint);
}

template <int D>
[[nodiscard]] FieldSample<D> sample_value(const BackMesh<D>& back, const Vec<D>& p, ElementId hint) {
    FieldSample<D> sample;
    back->sample_values({&p, 1}, hint, {&sample, 1});
    return sample;
}

template <int D>
[[nodiscard]] FieldSample<D> sample_with_gradient(const BackMesh<D>& back, const Vec<D>& p, ElementId hint) {
    FieldSample<D> sample;
    back->sample_with_gradients({&p, 1}, hint, {&sample, 1});
    return sample;
}

template <int D>
[[nodiscard]] FieldSample<D> sample_with_recovered_gradient(const BackMesh<D>& back, const Vec<D>& p, ElementId hint) {
    FieldSample<D> sample;
    back->sample_with_recovered_gradients({&p, 1}, hint, {&sample, 1});
    return sample;
}

}  // namespace camber

export namespace camber {

template <int D>
struct NodalLogs {
    Column<LogMetric<D>> vertices;
    Column<LogMetric<D>> mid_nodes;  ///< one row per edge
    friend bool operator==(const NodalLogs&, const NodalLogs&) = default;
};

/// Sets the log-metric of each edge node to the mean of both ends; the quadratic interpolation is then linear. Errors:
/// memory, stopped.
template <int D>
[[nodiscard]] Outcome<NodalLogs<D>> nodal_logs(const EdgeSet<D>& edges, Column<LogMetric<D>> vertices,
                                               const Execution& execution);

/// Sets the log-metric of each edge node to the `frame_mean` of both ends, which preserves sizes if the axes rotate
/// along the edge. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<NodalLogs<D>> framed_logs(const EdgeSet<D>& edges, Column<LogMetric<D>> vertices,
                                                const Execution& execution);

/// Makes a field on the curved elements of a quadratic mesh from log-metrics at all nodes, by form (4) of
/// docs/algorithms/metric-interpolation.md.
///
/// The straight elements may be inverted. A point is located inside an element only if this is proven (`root_radius`).
/// Points outside the mesh have the value of the nearest point of the curved boundary. `sample_edges` returns gradients
/// in physical space, without a Jacobian.
///
/// Errors: not one row per vertex and edge; those of `neighbours`; memory; stopped.
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> make_nodal_back_mesh(QuadraticMesh<D> mesh, const Incidence<ElementId>& balls,
                                                        NodalLogs<D> logs, const Execution& execution);

/// Returns a radius ρ such that the equation F(ξ) = p has exactly one solution with each of ξ_1 … ξ_D within ρ of
/// `location.xi`. F is the map of the element; the statement holds in exact arithmetic for the stored nodes. Returns no
/// value if this is not proven. Method: Kantorovich's theorem (docs/algorithms/back-mesh-location.md). If all
/// coordinates of `location.xi` exceed D ρ, p lies in the element. Then p lies in no other element if camber.validity
/// certifies the mesh and no faces cross.
template <int D>
[[nodiscard]] std::optional<double> root_radius(const QuadraticMesh<D>& mesh, const Location<D>& location,
                                                const Vec<D>& p);

/// Computes the complexity C = ∫ sqrt(det M) dx of the field M over the curved elements, with five Gauss points per
/// direction. Errors: those of `make_nodal_back_mesh`.
template <int D>
[[nodiscard]] Outcome<double> complexity(const QuadraticMesh<D>& mesh, const NodalLogs<D>& logs,
                                         const Execution& execution);

}  // namespace camber

export namespace camber {

/// Locates points in the curved elements of a quadratic mesh, whose straight elements may be inverted. Immutable, and
/// safe for concurrent use.
template <int D>
class CurvedLocator {
  public:
    QuadraticMesh<D> mesh;
    Neighbours<D> neighbours;
    Column<ElementFace> boundary;
    BoxTree<D> boundary_tree;
    BoxTree<D> element_tree;

    /// Finds the element that contains p. The placement is `inside` only if this is proven (`root_radius`). Otherwise
    /// the result is the nearest point of the curved boundary. `hint` is an element near p; it changes the result by
    /// rounding only. The mesh must have elements.
    [[nodiscard]] Location<D> locate(const Vec<D>& p, ElementId hint) const;
    /// Returns an element whose bounding box contains p, if any.
    [[nodiscard]] ElementId hint_for(const Vec<D>& p) const;
};

/// Errors: those of `neighbours`; memory; stopped.
template <int D>
[[nodiscard]] Outcome<CurvedLocator<D>> make_curved_locator(QuadraticMesh<D> mesh, const Incidence<ElementId>& balls,
                                                            const Execution& execution);

struct Quadrature {
    std::vector<double> t, w;
    [[nodiscard]] std::size_t size() const { return t.size(); }
};

/// Gauss–Legendre rule of n ≥ 1 points, exact to degree 2n − 1.
[[nodiscard]] inline Quadrature gauss_legendre(int n) {
    Quadrature rule{std::vector<double>(static_cast<std::size_t>(n)), std::vector<double>(static_cast<std::size_t>(n))};
    for (int i = 0; i < n; ++i) {
        double x = cos(std::numbers::pi * (i + 0.75) / (n + 0.5));
        double slope = 1;
        for (int newton = 0; newton < 100; ++newton) {
            double p0 = 1;
            double p1 = x;
            for (int k = 2; k <= n; ++k) {
                const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
                p0 = p1;
                p1 = p2;
            }
            slope = n * (x * p1 - p0) / (x * x - 1);
            const double step = p1 / slope;
            x -= step;
            if (std::abs(step) < 1e-16) break;
        }
        const auto slot = static_cast<std::size_t>(n - 1 - i);
        rule.t[slot] = (1 + x) / 2;
        rule.w[slot] = 1 / ((1 - x * x) * slope * slope);
    }
    return rule;
}

/// Number of quadrature points per edge for reported lengths.
inline constexpr int report_points = 12;

}  // namespace camber
