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

/// Derivatives ∂_i log M along the axes i = 1 … D.
template <int D>
using LogGradient = std::array<Sym<D>, D>;

enum class Placement : std::uint8_t {
    inside,
    outside,  ///< the point is beyond the boundary and replaced by the nearest boundary point
    lost,     ///< the search reached its step limit; the point is replaced by one in the best element found
};

/// Element and barycentric coordinates of a point or of the point that replaces it.
template <int D>
struct Location {
    ElementId element;
    std::array<double, D + 1> xi{};
    Placement placement = Placement::inside;
};

/// log M at a point and, if requested, its gradient in physical coordinates.
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

/// Field at an end of an edge.
template <int D>
struct EdgeEnd {
    LogMetric<D> log_metric;
    LogGradient<D> gradient{};             ///< recovered gradient, without the effect of the mesh's own curvature
    Mat<D> jacobian = Mat<D>::identity();  ///< Jacobian F = ∂x/∂X of the map from the straight mesh, averaged over the
                                           ///< shell; F t along the edge t is the same in each element
};
/// Field at both ends of an edge. The Jacobian is interpolated linearly between them.
template <int D>
struct EdgeEnds {
    EdgeEnd<D> a, b;
    bool is_curved = false;  ///< true if a Jacobian is not the identity
};

/// Element of an edge's shell: the field's gradient in it, and the inward normals, of any length, of its two faces that
/// contain the edge (in 2D: of the edge itself).
template <int D>
struct BackSector {
    LogGradient<D> gradient{};
    std::array<Vec<D>, D - 1> walls{};
};

template <int D>
class StraightBack;
template <int D>
class CurvedBack;

/// Data of a field for searches in packs: its straight mesh (for a curved field, the reference mesh) and, if it is
/// curved, the map. Null pointers if packs are unsupported.
template <int D>
struct PackedField {
    const StraightBack<D>* straight = nullptr;
    const CurvedBack<D>* bent = nullptr;
};

/// Interface of metric fields on meshes. Models are immutable and safe for concurrent use. A hint is an element near
/// the point; it changes results by rounding only.
///
/// In curved elements `xi` are reference coordinates, gradients use the inverse Jacobian and vary within the element,
/// and the walls of a `sector` are tangent planes at the middle of the edge.
///
/// Sampling functions take several points: `out[i]` belongs to `points[i]`, and `out.size() = points.size()`. The first
/// search starts from `hint`, each later one from the element of the previous point, so consecutive points should be
/// close. Results are bitwise those of calls with a single point.
template <int D>
class BackModel {
  public:
    virtual ~BackModel() = default;

    [[nodiscard]] virtual Location<D> locate(const Vec<D>& p, ElementId hint) const = 0;
    /// Samples log M; leaves the gradients in `out` unchanged.
    virtual void sample_values(std::span<const Vec<D>> points, ElementId hint, std::span<FieldSample<D>> out) const = 0;
    /// Samples log M and the gradient in the element of the point. Beyond the boundary the gradient is that of the
    /// constant continuation.
    virtual void sample_with_gradients(std::span<const Vec<D>> points, ElementId hint,
                                       std::span<FieldSample<D>> out) const = 0;
    /// Samples log M and recovered gradients, which are continuous across faces.
    virtual void sample_with_recovered_gradients(std::span<const Vec<D>> points, ElementId hint,
                                                 std::span<FieldSample<D>> out) const = 0;

    /// Samples the field at both ends of each edge.
    virtual void sample_edges(std::span<const BackEdge> edges, std::span<EdgeEnds<D>> out) const = 0;

    /// Returns the data for searches in packs. Without it, edges are searched one by one.
    [[nodiscard]] virtual PackedField<D> packed() const { return {}; }

    [[nodiscard]] virtual std::size_t vertex_count() const = 0;
    [[nodiscard]] virtual BackVertex<D> vertex(VertexId v) const = 0;
    /// Returns the sector of element e, which belongs to the shell of the edge (a, b).
    [[nodiscard]] virtual BackSector<D> sector(ElementId e, VertexId a, VertexId b) const = 0;

  protected:
    BackModel() = default;
    BackModel(const BackModel&) = default;
    BackModel(BackModel&&) = default;
    BackModel& operator=(const BackModel&) = default;
    BackModel& operator=(BackModel&&) = default;
};

/// Metric field on a mesh: an immutable handle, cheap to copy. `->` requires that the handle has a model.
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

/// Selects which vertex gradients a curved back mesh stores. Without `recovered`, recovered gradients are the gradients
/// in the elements; without `sampled`, edges sample a constant field.
enum class StoredGradients : std::uint8_t {
    recovered,  ///< gradients for `sample_with_recovered_gradients`
    sampled,    ///< gradients for `sample_edges`, used to compute offsets of edge nodes
    all,
};

/// Makes the discrete field of the paper (§1.2): log-metrics at the vertices of a straight mesh, linear in each
/// element, constant along the normal beyond the boundary. Recovered gradients interpolate volume-weighted means over
/// vertex balls. On standalone surfaces an element id is a triangle's number, and the field is constant along the
/// triangle normals. Errors: the number of rows is not that of the vertices; those of `neighbours`; stopped.
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> make_back_mesh(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                  Column<LogMetric<D>> log_metrics, const Execution& execution);

/// Makes the field of a quadratic mesh that follows the curves of the mesh. The field is linear at a point X of the
/// straight mesh, which maps to x(X) = X + Σ 4 ξ_i ξ_j u_e; u_e is the offset of an edge node from the chord's middle.
/// Newton's method computes X from x and locates each iterate in the straight mesh. Gradients use F⁻ᵀ with F = ∂x/∂X.
/// Beyond the boundary X is the nearest point of the straight mesh. Invalid elements have no inverse map; a point there
/// is located at the last iterate.
///
/// Edges sample gradients relative to the mesh's curves: ball means of the gradients of log(Fᵀ M F), linear in each
/// element, transformed to physical space. If all offsets are zero, the result is a straight back mesh. Releases the
/// mesh nodes. Errors: those of `make_back_mesh`.
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> make_curved_back_mesh(QuadraticMesh<D> mesh, const Incidence<ElementId>& balls,
                                                         Column<LogMetric<D>> log_metrics, const Execution& execution,
                                                         StoredGradients stored = StoredGradients::all);

/// Makes a field with values only (no gradients) from other log-metrics on the straight mesh of a back mesh, and shares
/// its location data. Errors: the number of rows is not that of the vertices; no straight mesh (internal).
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> straight_back_mesh(const BackMesh<D>& back, Column<LogMetric<D>> log_metrics);

/// Returns the gradients ∇ξ_i of the barycentric coordinates of an element; they sum to zero.
template <int D>
[[nodiscard]] std::array<Vec<D>, D + 1> barycentric_gradients(const LinearMesh<D>& mesh, ElementId e);

/// Locates p. On a straight mesh it walks from the element `hint`, or else from the boundary point nearest to p.
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

/// Sets the log-metric of each edge node to the mean of both ends, so that form (4) becomes linear (paper §2.1).
/// Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<NodalLogs<D>> nodal_logs(const EdgeSet<D>& edges, Column<LogMetric<D>> vertices,
                                               const Execution& execution);

/// Sets the log-metric of each edge node to the `frame_mean` of both ends, which preserves sizes if the axes turn from
/// one end to the other. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<NodalLogs<D>> framed_logs(const EdgeSet<D>& edges, Column<LogMetric<D>> vertices,
                                                const Execution& execution);

/// Makes the field of form (4) of the paper on the curved elements of a quadratic mesh, in physical space. With L_i and
/// L_e the log-metrics at vertices and edge nodes, at x = F_K(ξ)
///     log M = Σ_i ξ_i L_i + Σ_e 4 ξ_i ξ_j (L_e − (L_i + L_j)/2).
/// This equals Σ B_α(ξ) log M_α with the virtual metrics, and Σ φ_α(ξ) log M(P_α^l).
///
/// The straight mesh of the vertices may be invalid. A point is located inside an element only if this is proven
/// (`root_radius`). Beyond the boundary the nearest point of the curved boundary is used. Recovered gradients are
/// linear between volume-weighted ball means. Edges sample the field in space and ignore the mesh's curves. On straight
/// meshes with `nodal_logs`, results equal those of `make_back_mesh` up to rounding.
///
/// Errors: the number of rows is not that of the vertices or edges; those of `neighbours`; memory; stopped.
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> make_nodal_back_mesh(QuadraticMesh<D> mesh, const Incidence<ElementId>& balls,
                                                        NodalLogs<D> logs, const Execution& execution);

/// Returns ρ such that F_K(ξ) = p has exactly one solution whose coordinates ξ_1 … ξ_D differ from `location.xi` by at
/// most ρ, in exact arithmetic for the stored nodes. Returns no value if this is not proven. Method: Kantorovich's
/// theorem with an approximate inverse and rounding bounds. If all ξ exceed D ρ, p lies in the element. If
/// camber.validity also certifies the mesh and no faces cross, p lies in no other element.
template <int D>
[[nodiscard]] std::optional<double> root_radius(const QuadraticMesh<D>& mesh, const Location<D>& location,
                                                const Vec<D>& p);

/// Computes the complexity C = ∫ sqrt(det M) over curved elements, by a Gauss rule of five points per direction.
/// Errors: those of `make_nodal_back_mesh`.
template <int D>
[[nodiscard]] Outcome<double> complexity(const QuadraticMesh<D>& mesh, const NodalLogs<D>& logs,
                                         const Execution& execution);

}  // namespace camber

export namespace camber {

/// Locates points in a quadratic mesh with x = F_K(ξ) = Σ ξ_i P_i + Σ_e 4 ξ_i ξ_j u_e. Immutable, safe for concurrent
/// use; does not use the straight elements.
template <int D>
class CurvedLocator {
  public:
    QuadraticMesh<D> mesh;
    Neighbours<D> neighbours;
    Column<ElementFace> boundary;
    BoxTree<D> boundary_tree;
    BoxTree<D> element_tree;

    /// Returns the element of p. The placement is `inside` only if that is proven (`root_radius`); otherwise the
    /// nearest point of the curved boundary is returned. `hint` changes the result by rounding only. The mesh must have
    /// elements.
    [[nodiscard]] Location<D> locate(const Vec<D>& p, ElementId hint) const;
    /// Returns an element whose bounding box contains p, or no element.
    [[nodiscard]] ElementId hint_for(const Vec<D>& p) const;
};

/// Errors: those of `neighbours`; memory; stopped.
template <int D>
[[nodiscard]] Outcome<CurvedLocator<D>> make_curved_locator(QuadraticMesh<D> mesh, const Incidence<ElementId>& balls,
                                                            const Execution& execution);

/// Quadrature rule on [0, 1] with points t and weights w: ∫ f ≈ Σ w_q f(t_q).
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

/// Number of quadrature points for reported lengths and gains; minimisations use fewer.
inline constexpr int report_points = 12;

}  // namespace camber
