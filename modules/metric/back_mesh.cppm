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

/// ∂_i log M, i = 1 … D.
template <int D>
using LogGradient = std::array<Sym<D>, D>;

enum class Placement : std::uint8_t {
    inside,
    outside,  ///< beyond the boundary: replaced by its nearest point
    lost,     ///< search limit reached: replaced by the best element
};

/// Element and barycentric coordinates of a point or its replacement.
template <int D>
struct Location {
    ElementId element;
    std::array<double, D + 1> xi{};
    Placement placement = Placement::inside;
};

/// log M and, if requested, its gradient in physical coordinates.
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

/// Edge of the mesh of the field, and the elements around it.
struct BackEdge {
    VertexId a, b;
    std::span<const ElementId> shell;
};

/// Field at an edge end, and the Jacobian from the straight reference.
template <int D>
struct EdgeEnd {
    LogMetric<D> log_metric;
    LogGradient<D> gradient{};             ///< recovered, without the curvature of the mesh itself
    Mat<D> jacobian = Mat<D>::identity();  ///< F = ∂x/∂X, mean over the shell; F t is the same in each element
};
/// Field at both ends of an edge; F is linear between them.
template <int D>
struct EdgeEnds {
    EdgeEnd<D> a, b;
    bool is_bent = false;  ///< an F is not the identity
};

/// Element of an edge's shell: its gradient, and inward normals, of any length, of its faces through the edge (2D: of
/// the edge).
template <int D>
struct BackSector {
    LogGradient<D> gradient{};
    std::array<Vec<D>, D - 1> walls{};
};

template <int D>
class StraightBack;
template <int D>
class CurvedBack;

/// Straight mesh of the field or its reference, and the map if curved; null if unsupported.
template <int D>
struct PackedField {
    const StraightBack<D>* straight = nullptr;
    const CurvedBack<D>* bent = nullptr;
};

/// Interface of metric fields on meshes. Models are immutable and safe for concurrent use. Results depend on hints by
/// rounding only.
///
/// In curved elements ξ are reference coordinates, gradients use the inverse Jacobian and vary, and the walls of a
/// `sector` are tangent planes at the middle of the edge.
///
/// Sampling functions take packs of points: `out[i]` belongs to `points[i]`, `out.size() = points.size()`. Each search
/// starts from the element of the previous point, the first from `hint`, so consecutive points should be close. Results
/// are bitwise those of single calls.
template <int D>
class BackModel {
  public:
    virtual ~BackModel() = default;

    [[nodiscard]] virtual Location<D> locate(const Vec<D>& p, ElementId hint) const = 0;
    /// Samples log M; leaves the gradients unchanged.
    virtual void sample_values(std::span<const Vec<D>> points, ElementId hint, std::span<FieldSample<D>> out) const = 0;
    /// Gradients are those of the point's element; beyond the boundary, of the constant continuation.
    virtual void sample_with_gradients(std::span<const Vec<D>> points, ElementId hint,
                                       std::span<FieldSample<D>> out) const = 0;
    /// Recovered gradients are continuous across faces.
    virtual void sample_with_recovered_gradients(std::span<const Vec<D>> points, ElementId hint,
                                                 std::span<FieldSample<D>> out) const = 0;

    /// Samples the field at the ends of mesh edges.
    virtual void see(std::span<const BackEdge> edges, std::span<EdgeEnds<D>> out) const = 0;

    /// Data for searches in packs; without it, edges are searched one by one.
    [[nodiscard]] virtual PackedField<D> packed() const { return {}; }

    [[nodiscard]] virtual std::size_t vertex_count() const = 0;
    [[nodiscard]] virtual BackVertex<D> vertex(VertexId v) const = 0;
    /// Element e of the shell of the edge (a, b).
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

/// Vertex gradients of a curved back mesh. Without them, recovered gradients are those of the elements, and edges
/// sample a constant field.
enum class KeptGradients : std::uint8_t {
    recovered,  ///< for `sample_with_recovered_gradients`
    seen,       ///< for `see` (offsets of edges)
    all,
};

/// Discrete field of the paper (§1.2): log-metrics at the vertices of a straight mesh, linear in each element, constant
/// along the normal beyond the boundary. Recovered gradients interpolate volume-weighted means over vertex balls. On
/// standalone surfaces element ids are triangle numbers, and the field is constant along normals. Errors: not one row
/// per vertex; those of `neighbours`; stopped.
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> make_back_mesh(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                  Column<LogMetric<D>> log_metrics, const Execution& execution);

/// Field of a quadratic mesh that follows its curves: linear interpolation at X in the straight mesh, mapped to x(X) =
/// X + Σ 4 ξ_i ξ_j u_e, u_e the offset of an edge node from the chord's middle. Newton's method computes X, locating
/// each iterate in the straight mesh. Gradients use F⁻ᵀ, F = ∂x/∂X. Beyond the boundary X is the nearest point of the
/// straight mesh. Invalid elements have no inverse; their points are at the last iterate.
///
/// Edges sample gradients relative to the mesh's curves: ball means of those of log(Fᵀ M F), linear in each element,
/// transformed to space. Without offsets a straight back mesh results. Releases the mesh nodes. Errors: those of
/// `make_back_mesh`.
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> make_curved_back_mesh(QuadraticMesh<D> mesh, const Incidence<ElementId>& balls,
                                                         Column<LogMetric<D>> log_metrics, const Execution& execution,
                                                         KeptGradients kept = KeptGradients::all);

/// Value-only field with other logs on the straight mesh of a back mesh; shares its location data. Errors: not one row
/// per vertex; no straight mesh (internal).
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> straight_back_mesh(const BackMesh<D>& back, Column<LogMetric<D>> log_metrics);

/// Returns ∇u_i of the barycentric coordinates; they sum to zero.
template <int D>
[[nodiscard]] std::array<Vec<D>, D + 1> barycentric_gradients(const LinearMesh<D>& mesh, ElementId e);

/// Walks a straight mesh from `hint`, else from the nearest boundary point that sees p.
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
    Column<LogMetric<D>> mid_nodes;  ///< one per edge
    friend bool operator==(const NodalLogs&, const NodalLogs&) = default;
};

/// Sets edge nodes to the mean of both ends: form (4) becomes linear (paper §2.1). Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<NodalLogs<D>> nodal_logs(const EdgeSet<D>& edges, Column<LogMetric<D>> vertices,
                                               const Execution& execution);

/// Sets edge nodes to the `frame_mean` of both ends, which preserves sizes where axes turn with the elements. Errors:
/// memory, stopped.
template <int D>
[[nodiscard]] Outcome<NodalLogs<D>> framed_logs(const EdgeSet<D>& edges, Column<LogMetric<D>> vertices,
                                                const Execution& execution);

/// Field of form (4) of the paper on the curved elements of a quadratic mesh, in physical space. At x = F_K(ξ)
///     log M = Σ_i ξ_i L_i + Σ_e 4 ξ_i ξ_j (L_e − (L_i + L_j)/2),
/// which is Σ B_α(ξ) log M_α with the virtual metrics, and Σ φ_α(ξ) log M(P_α^l).
///
/// The straight mesh of the vertices may be invalid. Points are inside an element only with a proof (`root_radius`);
/// beyond the boundary the nearest curved boundary point is used. Recovered gradients are linear between
/// volume-weighted ball means. Edges sample the field in space, without the mesh's curves. On straight meshes with
/// `nodal_logs`, results are those of `make_back_mesh` to rounding.
///
/// Errors: not one row per vertex and edge; those of `neighbours`; memory; stopped.
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> make_nodal_back_mesh(QuadraticMesh<D> mesh, const Incidence<ElementId>& balls,
                                                        NodalLogs<D> logs, const Execution& execution);

/// Returns ρ such that F_K(ξ) = p has exactly one solution within ρ of `location.xi` (in each of ξ_1 … ξ_D), in exact
/// arithmetic for the stored nodes; none if unproven. Method: Kantorovich's theorem with an approximate inverse and
/// rounding bounds. If all ξ exceed D ρ, p lies in the element. It lies in no other if camber.validity certifies the
/// mesh and nothing crosses.
template <int D>
[[nodiscard]] std::optional<double> root_radius(const QuadraticMesh<D>& mesh, const Location<D>& location,
                                                const Vec<D>& p);

/// C = ∫ sqrt(det M) over curved elements, by a Gauss rule of five points per direction. Errors: those of
/// `make_nodal_back_mesh`.
template <int D>
[[nodiscard]] Outcome<double> complexity(const QuadraticMesh<D>& mesh, const NodalLogs<D>& logs,
                                         const Execution& execution);

}  // namespace camber

export namespace camber {

/// Quadratic mesh, x = F_K(ξ) = Σ ξ_i P_i + Σ_e 4 ξ_i ξ_j u_e, with location data. Immutable, safe for concurrent use;
/// ignores its straight mesh.
template <int D>
class CurvedLocator {
  public:
    QuadraticMesh<D> mesh;
    Neighbours<D> neighbours;
    Column<ElementFace> boundary;
    BoxTree<D> boundary_tree;
    BoxTree<D> element_tree;

    /// Returns the element of p; `inside` only with a proof (`root_radius`), else the nearest curved boundary point.
    /// `hint` changes the result by rounding only. Requires elements.
    [[nodiscard]] Location<D> locate(const Vec<D>& p, ElementId hint) const;
    /// Returns an element whose box contains p, or no element.
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

/// Points for reported lengths and gains: more than in any minimisation.
inline constexpr int report_points = 12;

}  // namespace camber
