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

/// Derivatives ∂_i log M, i = 1 … D.
template <int D>
using LogGradient = std::array<Sym<D>, D>;

enum class Placement : std::uint8_t {
    inside,
    outside,  ///< beyond the boundary; replaced by the nearest boundary point
    lost,     ///< step limit of the search reached; replaced by a point of the best element
};

/// Location of a point or of its replacement (see `Placement`).
template <int D>
struct Location {
    ElementId element;
    std::array<double, D + 1> xi{};
    Placement placement = Placement::inside;
};

/// The gradient is in physical coordinates, and set only if requested.
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

/// Edge of the field's mesh; `shell` lists the elements around it.
struct BackEdge {
    VertexId a, b;
    std::span<const ElementId> shell;
};

template <int D>
struct EdgeEnd {
    LogMetric<D> log_metric;
    LogGradient<D> gradient{};             ///< recovered, without the effect of the mesh's own curvature
    Mat<D> jacobian = Mat<D>::identity();  ///< F = ∂x/∂X (X: straight mesh), averaged over the shell; for the edge t, F
                                           ///< t is the same in all its elements
};
/// The Jacobian is linear between both ends.
template <int D>
struct EdgeEnds {
    EdgeEnd<D> a, b;
    bool is_curved = false;  ///< true if a Jacobian is not the identity
};

/// Element of an edge's shell, with the inward normals, of any length, of its two faces that contain the edge (2D: of
/// the edge itself).
template <int D>
struct BackSector {
    LogGradient<D> gradient{};
    std::array<Vec<D>, D - 1> walls{};
};

template <int D>
class StraightBack;
template <int D>
class CurvedBack;

/// Data for searches in packs; null pointers if unsupported. For curved fields `straight` is the reference mesh.
template <int D>
struct PackedField {
    const StraightBack<D>* straight = nullptr;
    const CurvedBack<D>* bent = nullptr;
};

/// Interface of metric fields on meshes. Models are immutable and safe for concurrent use. A hint is an element near
/// the point; it changes results by rounding only.
///
/// In curved elements `xi` are reference coordinates, gradients use the inverse Jacobian, and the walls of a `sector`
/// are tangent planes at the middle of the edge.
///
/// Sampling functions write the sample of `points[i]` to `out[i]`. The first search starts from `hint`, each later one
/// from the previous element, so consecutive points should be close. Results are bitwise those of calls with single
/// points.
template <int D>
class BackModel {
  public:
    virtual ~BackModel() = default;

    [[nodiscard]] virtual Location<D> locate(const Vec<D>& p, ElementId hint) const = 0;
    /// Leaves the gradients in `out` unchanged.
    virtual void sample_values(std::span<const Vec<D>> points, ElementId hint, std::span<FieldSample<D>> out) const = 0;
    /// Gradients are those of the field in the point's element; beyond the boundary, those of the constant
    /// continuation.
    virtual void sample_with_gradients(std::span<const Vec<D>> points, ElementId hint,
                                       std::span<FieldSample<D>> out) const = 0;
    /// Recovered gradients are continuous across faces.
    virtual void sample_with_recovered_gradients(std::span<const Vec<D>> points, ElementId hint,
                                                 std::span<FieldSample<D>> out) const = 0;

    /// Samples the field at both ends of each edge.
    virtual void sample_edges(std::span<const BackEdge> edges, std::span<EdgeEnds<D>> out) const = 0;

    /// Returns no data if packs are unsupported; edges are then searched one by one.
    [[nodiscard]] virtual PackedField<D> packed() const { return {}; }

    [[nodiscard]] virtual std::size_t vertex_count() const = 0;
    [[nodiscard]] virtual BackVertex<D> vertex(VertexId v) const = 0;
    /// Returns the sector of e, an element in the shell of the edge (a, b).
    [[nodiscard]] virtual BackSector<D> sector(ElementId e, VertexId a, VertexId b) const = 0;

  protected:
    BackModel() = default;
    BackModel(const BackModel&) = default;
    BackModel(BackModel&&) = default;
    BackModel& operator=(const BackModel&) = default;
    BackModel& operator=(BackModel&&) = default;
};

/// Metric field on a mesh: an immutable handle, cheap to copy. `->` requires a model.
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

/// Vertex gradients that a curved back mesh stores. Without `recovered`, recovered gradients are those in the elements;
/// without `sampled`, edges sample a constant field.
enum class StoredGradients : std::uint8_t {
    recovered,
    sampled,  ///< gradients for `sample_edges`, used to compute offsets of edge nodes
    all,
};

/// Makes the field of the paper (§1.2): log-metrics at the vertices of a straight mesh, linear in each element,
/// constant along the normal beyond the boundary. Recovered gradients interpolate volume-weighted means over vertex
/// balls. On standalone surfaces an element id is a triangle's number. Errors: not one row per vertex; those of
/// `neighbours`; stopped.
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> make_back_mesh(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                  Column<LogMetric<D>> log_metrics, const Execution& execution);

/// Makes a field that follows the curves of a quadratic mesh (docs/algorithms/curved-back-mesh.md). It is linear at a
/// point X of the straight mesh, which maps to x(X) = X + Σ 4 ξ_i ξ_j u_e; u_e is the offset of an edge node from the
/// chord's middle. Gradients use F⁻ᵀ with F = ∂x/∂X. Beyond the boundary X is the nearest point of the straight mesh.
/// In invalid elements, which have no inverse map, X is the last iterate of Newton's method.
///
/// Edges sample gradients of log(Fᵀ M F), that is relative to the mesh's curves. If all offsets are zero, the result is
/// a straight back mesh. Releases the mesh nodes. Errors: those of `make_back_mesh`.
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> make_curved_back_mesh(QuadraticMesh<D> mesh, const Incidence<ElementId>& balls,
                                                         Column<LogMetric<D>> log_metrics, const Execution& execution,
                                                         StoredGradients stored = StoredGradients::all);

/// Makes a field without gradients from other log-metrics on the straight mesh of a back mesh, whose location data it
/// shares. Errors: not one row per vertex; no straight mesh (internal).
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> straight_back_mesh(const BackMesh<D>& back, Column<LogMetric<D>> log_metrics);

/// Returns ∇ξ_i of the barycentric coordinates; they sum to zero.
template <int D>
[[nodiscard]] std::array<Vec<D>, D + 1> barycentric_gradients(const LinearMesh<D>& mesh, ElementId e);

/// Locates p. On a straight mesh it walks from the element `hint`, or else from the nearest boundary point.
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

/// Gives each edge node the mean of both ends, so that form (4) becomes linear (paper §2.1). Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<NodalLogs<D>> nodal_logs(const EdgeSet<D>& edges, Column<LogMetric<D>> vertices,
                                               const Execution& execution);

/// Gives each edge node the `frame_mean` of both ends, which preserves sizes if axes turn. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<NodalLogs<D>> framed_logs(const EdgeSet<D>& edges, Column<LogMetric<D>> vertices,
                                                const Execution& execution);

/// Makes the field of form (4) (docs/algorithms/metric-interpolation.md) on the curved elements of a quadratic mesh.
///
/// The straight mesh may be invalid. A point is located inside an element only if this is proven (`root_radius`).
/// Beyond the boundary the nearest point of the curved boundary is used. Recovered gradients are linear between
/// volume-weighted ball means. Edges sample the field in space and ignore the mesh's curves. On straight meshes with
/// `nodal_logs`, results equal those of `make_back_mesh` up to rounding.
///
/// Errors: not one row per vertex and edge; those of `neighbours`; memory; stopped.
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> make_nodal_back_mesh(QuadraticMesh<D> mesh, const Incidence<ElementId>& balls,
                                                        NodalLogs<D> logs, const Execution& execution);

/// Returns ρ such that F_K(ξ) = p, with F_K the map of the element, has exactly one solution with each of ξ_1 … ξ_D
/// within ρ of `location.xi`, in exact arithmetic for the stored nodes; no value if unproven. Method: Kantorovich's
/// theorem (docs/algorithms/back-mesh-location.md). If all ξ exceed D ρ, p lies in the element. It lies in no other
/// element if camber.validity certifies the mesh and no faces cross.
template <int D>
[[nodiscard]] std::optional<double> root_radius(const QuadraticMesh<D>& mesh, const Location<D>& location,
                                                const Vec<D>& p);

/// Computes C = ∫ sqrt(det M) over curved elements, with five Gauss points per direction. Errors: those of
/// `make_nodal_back_mesh`.
template <int D>
[[nodiscard]] Outcome<double> complexity(const QuadraticMesh<D>& mesh, const NodalLogs<D>& logs,
                                         const Execution& execution);

}  // namespace camber

export namespace camber {

/// Locates points in a quadratic mesh. Immutable, safe for concurrent use; ignores the straight elements.
template <int D>
class CurvedLocator {
  public:
    QuadraticMesh<D> mesh;
    Neighbours<D> neighbours;
    Column<ElementFace> boundary;
    BoxTree<D> boundary_tree;
    BoxTree<D> element_tree;

    /// Returns the element of p. It is `inside` only if proven (`root_radius`); otherwise the nearest point of the
    /// curved boundary is returned. `hint` changes the result by rounding only. The mesh must have elements.
    [[nodiscard]] Location<D> locate(const Vec<D>& p, ElementId hint) const;
    /// Returns an element whose bounding box contains p, if any.
    [[nodiscard]] ElementId hint_for(const Vec<D>& p) const;
};

/// Errors: those of `neighbours`; memory; stopped.
template <int D>
[[nodiscard]] Outcome<CurvedLocator<D>> make_curved_locator(QuadraticMesh<D> mesh, const Incidence<ElementId>& balls,
                                                            const Execution& execution);

/// Quadrature rule on [0, 1]: ∫ f ≈ Σ w_q f(t_q).
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

/// Quadrature points for reported lengths and gains; minimisations use fewer.
inline constexpr int report_points = 12;

}  // namespace camber
