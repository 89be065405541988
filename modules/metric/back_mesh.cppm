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

/// How a point lies in a back mesh.
enum class Placement : std::uint8_t {
    inside,
    outside,  ///< beyond the boundary: its nearest boundary point stands for it
    lost,     ///< not found within the search's limits: the best element seen stands for it
};

/// Where a point lies: an element, and the barycentric coordinates in it of the point, or of the point that stands for
/// it.
template <int D>
struct Location {
    ElementId element;
    std::array<double, D + 1> xi{};
    Placement placement = Placement::inside;
};

/// log M at a point and, where asked for, its gradient in physical coordinates there.
template <int D>
struct FieldSample {
    LogMetric<D> log_metric;
    LogGradient<D> gradient{};
    Location<D> location;
};

/// A vertex of a back mesh: its place, and log M there.
template <int D>
struct BackVertex {
    Vec<D> point;
    LogMetric<D> log_metric;
};

/// An edge of the mesh that a back mesh is made on: its ends, and the elements that hold it.
struct BackEdge {
    VertexId a, b;
    std::span<const ElementId> shell;
};

/// The field at an end of an edge, and the map through which the straight edge of the reference sees it.
template <int D>
struct EdgeEnd {
    LogMetric<D> log_metric;
    LogGradient<D> gradient{};  ///< recovered, without what the curves of the mesh itself make
    Mat<D> jacobian =
        Mat<D>::identity();  ///< F = ∂x/∂X, the mean over the shell; F t is the same in each of its elements
};
/// F is linear along an edge: at the middle the mean of both.
template <int D>
struct EdgeEnds {
    EdgeEnd<D> a, b;
    bool is_bent = false;  ///< whether an F is not the identity
};

/// One element of the shell of an edge, seen from the edge: the field's gradient on that side, and the inward normals
/// of the element's two faces through the edge (2D: of the one edge), of any length.
template <int D>
struct BackSector {
    LogGradient<D> gradient{};
    std::array<Vec<D>, D - 1> walls{};
};

template <int D>
class StraightBack;
template <int D>
class CurvedBack;

/// What of a field searches in packs can work on: a straight mesh, the field's own or its reference, and the map from
/// that where it is bent; null where there is none.
template <int D>
struct PackedField {
    const StraightBack<D>* straight = nullptr;
    const CurvedBack<D>* bent = nullptr;
};

/// The face that every kind of back mesh has: a metric field with elements, by which a search for a point begins where
/// the last one ended. Models are immutable, and asked by many threads at once; up to rounding no answer depends on a
/// hint. Nothing here says that elements are straight: in a curved back mesh ξ are coordinates of the reference
/// element, gradients go through the inverse of the element's Jacobian and are not constant in it, and the walls of a
/// `sector` are the tangent planes of the curved faces at the middle of the edge.
///
/// Samples are asked for a pack of points at a time, so that none is a call of its own: out[i] is the sample at
/// points[i], searched from `hint` for the first and from the element of the one before for each other, to the last bit
/// as if they were asked one by one. Points of a pack should follow one another in space. out.size() = points.size().
template <int D>
class BackModel {
  public:
    virtual ~BackModel() = default;

    /// The element that holds p, or what stands for it.
    [[nodiscard]] virtual Location<D> locate(const Vec<D>& p, ElementId hint) const = 0;
    /// log M alone; gradients are left as they are.
    virtual void sample_values(std::span<const Vec<D>> points, ElementId hint, std::span<FieldSample<D>> out) const = 0;
    /// log M with the gradient of the element in which the point lies; beyond the boundary, that of the constant
    /// continuation.
    virtual void sample_with_gradients(std::span<const Vec<D>> points, ElementId hint,
                                       std::span<FieldSample<D>> out) const = 0;
    /// log M with the recovered gradient, which is continuous across faces.
    virtual void sample_with_recovered_gradients(std::span<const Vec<D>> points, ElementId hint,
                                                 std::span<FieldSample<D>> out) const = 0;

    /// What edges of the mesh see: out[i] of edges[i].
    virtual void see(std::span<const BackEdge> edges, std::span<EdgeEnds<D>> out) const = 0;

    /// For searches that take many edges at a time; those of a model without it go one by one.
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

/// A metric field on a mesh: an immutable value of any model, cheap to copy. Questions go through `->`; one without a
/// model must not be asked.
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

/// What a curved back mesh keeps at its vertices, a gradient each. Where the one that is asked for is not kept,
/// recovered gradients are those of the elements, and edges see a constant field.
enum class KeptGradients : std::uint8_t {
    recovered,  ///< for searches: sample_with_recovered_gradients
    seen,       ///< for offsets: what edges see
    all,
};

/// The discrete field of the paper (§1.2): log-metrics at the vertices of a straight mesh, linear in each element,
/// constant along the normal beyond the boundary. The recovered gradient interpolates volume-weighted means over the
/// balls of the vertices. Of a surface alone it lives on the triangles, and is constant along their normals; element
/// ids are their numbers. Errors: a column whose size is not that of the vertices; an element without neighbours' order
/// (see `neighbours`); stopped.
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> make_back_mesh(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                  Column<LogMetric<D>> log_metrics, const Execution& execution);

/// The field of a mesh of degree 2, which goes along with its curves: at x(X) = X + Σ 4 ξ_i ξ_j u_e (u_e: how far the
/// node of an edge is from the middle of its chord) the logs of the vertices as they are interpolated at X, which is
/// found by Newton's method from x, each iterate located in the straight mesh; gradients through F⁻ᵀ, F = ∂x/∂X. Beyond
/// the boundary the nearest point of the straight mesh stands for X. What edges see is relative to the curves of the
/// mesh itself: gradients are means over the balls of those of log(Fᵀ M F), linear in each element, brought into space.
/// A mesh whose nodes are all in the middles is a straight one. Elements that are not valid have no inverse: points in
/// them are where the last iterate is. The mesh's nodes are let go of. Errors: those of the straight one.
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> make_curved_back_mesh(QuadraticMesh<D> mesh, const Incidence<ElementId>& balls,
                                                         Column<LogMetric<D>> log_metrics, const Execution& execution,
                                                         KeptGradients kept = KeptGradients::all);

/// The straight mesh behind a back mesh of the functions above, with other logs at its vertices, to be asked for values
/// alone: what location needs is shared, and no gradients are kept at vertices. Errors: a column whose size is not that
/// of the vertices; a model of another kind (internal).
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> straight_back_mesh(const BackMesh<D>& back, Column<LogMetric<D>> log_metrics);

/// ∇u_i of the barycentric coordinates of an element; they sum to zero.
template <int D>
[[nodiscard]] std::array<Vec<D>, D + 1> barycentric_gradients(const LinearMesh<D>& mesh, ElementId e);

/// The element that holds p. In a straight mesh: a walk through neighbours from `hint`, else from the nearest boundary
/// point, from where no boundary hides p.
template <int D>
[[nodiscard]] Location<D> locate(const BackMesh<D>& back, const Vec<D>& p, ElementId hint) {
    return back->locate(p, hint);
}

/// A single point's sample_values.
template <int D>
[[nodiscard]] FieldSample<D> sample_value(const BackMesh<D>& back, const Vec<D>& p, ElementId hint) {
    FieldSample<D> sample;
    back->sample_values({&p, 1}, hint, {&sample, 1});
    return sample;
}

/// A single point's sample_with_gradients.
template <int D>
[[nodiscard]] FieldSample<D> sample_with_gradient(const BackMesh<D>& back, const Vec<D>& p, ElementId hint) {
    FieldSample<D> sample;
    back->sample_with_gradients({&p, 1}, hint, {&sample, 1});
    return sample;
}

/// A single point's sample_with_recovered_gradients.
template <int D>
[[nodiscard]] FieldSample<D> sample_with_recovered_gradient(const BackMesh<D>& back, const Vec<D>& p, ElementId hint) {
    FieldSample<D> sample;
    back->sample_with_recovered_gradients({&p, 1}, hint, {&sample, 1});
    return sample;
}

}  // namespace camber

/// Metric fields that are given at all nodes of a curved mesh of degree 2, as a mesh that was adapted once has them
/// when it is adapted again.
export namespace camber {

/// log M at the nodes of a mesh of degree 2.
template <int D>
struct NodalLogs {
    Column<LogMetric<D>> vertices;
    Column<LogMetric<D>> mid_nodes;  ///< one an edge
    friend bool operator==(const NodalLogs&, const NodalLogs&) = default;
};

/// A field that is known at the vertices alone: at the nodes the mean of both ends, so that form (4) is the linear one
/// (paper §2.1). Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<NodalLogs<D>> nodal_logs(const EdgeSet<D>& edges, Column<LogMetric<D>> vertices,
                                               const Execution& execution);

/// The same for a mesh whose elements bend along with axes that turn: at the nodes the mean in the frame of both ends
/// (frame_mean), which keeps sizes.
template <int D>
[[nodiscard]] Outcome<NodalLogs<D>> framed_logs(const EdgeSet<D>& edges, Column<LogMetric<D>> vertices,
                                                const Execution& execution);

/// The field of form (4) of the paper on the curved elements of a mesh of degree 2, in physical space: at x = F_K(ξ)
///   log M = Σ_i ξ_i L_i + Σ_e 4 ξ_i ξ_j (L_e − (L_i + L_j)/2),
/// which is Σ B_α(ξ) log M_α with the virtual metrics, and Σ φ_α(ξ) log M(P_α^l). The straight mesh of the same
/// vertices is never asked: it need not be valid. A point is inside of an element only with a proof (`root_radius`).
/// Beyond the boundary the nearest point of the curved boundary stands for it. Recovered gradients are linear between
/// means at the vertices over their balls, by volume; edges see the field as it is in space, without the mesh's curves.
/// On a straight mesh with the means of ends at the nodes all answers are those of `make_back_mesh`, to rounding.
/// Errors: columns whose sizes are not those of the vertices and the edges; those of `neighbours`; memory; stopped.
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> make_nodal_back_mesh(QuadraticMesh<D> mesh, const Incidence<ElementId>& balls,
                                                        NodalLogs<D> logs, const Execution& execution);

/// ρ such that F_K(ξ) = p has exactly one solution within ρ of location.xi (each of ξ_1 … ξ_D), in exact arithmetic for
/// the stored nodes: Kantorovich's theorem for a quadratic map with an approximate inverse, all rounding bounded. None
/// where that cannot be shown. A point whose ξ are all above D ρ therefore lies in the element; and in no other where
/// the mesh is one (elements certified valid by camber.validity, no crossing).
template <int D>
[[nodiscard]] std::optional<double> root_radius(const QuadraticMesh<D>& mesh, const Location<D>& location,
                                                const Vec<D>& p);

/// C = ∫ sqrt(det M) of the field above over the curved elements, by Gauss's rule with five points a direction. Errors:
/// those of make_nodal_back_mesh.
template <int D>
[[nodiscard]] Outcome<double> complexity(const QuadraticMesh<D>& mesh, const NodalLogs<D>& logs,
                                         const Execution& execution);

}  // namespace camber

/// Where a point lies in a curved mesh of degree 2, for whatever field lives on it.
export namespace camber {

/// A mesh of degree 2 with what location in it needs: an immutable value, asked by many threads at once. In an element
/// a point is x = F_K(ξ) = Σ ξ_i P_i + Σ_e 4 ξ_i ξ_j u_e; the straight mesh of the same vertices is never asked.
template <int D>
class CurvedLocator {
  public:
    QuadraticMesh<D> mesh;
    Neighbours<D> neighbours;
    Column<ElementFace> boundary;
    BoxTree<D> boundary_tree;  ///< boxes of the Bézier points of `boundary`
    BoxTree<D> element_tree;   ///< the same of the elements

    /// The element that holds p, `inside` only with a proof (`root_radius`); else the nearest point of the curved
    /// boundary stands for it. The search begins at `hint`, on which the answer does not depend up to rounding. The
    /// mesh has elements.
    [[nodiscard]] Location<D> locate(const Vec<D>& p, ElementId hint) const;
    /// A hint for a point of which nothing is known: an element whose box holds p, or no element.
    [[nodiscard]] ElementId hint_for(const Vec<D>& p) const;
};

/// Linear but for the trees. Errors: those of `neighbours`; memory; stopped.
template <int D>
[[nodiscard]] Outcome<CurvedLocator<D>> make_curved_locator(QuadraticMesh<D> mesh, const Incidence<ElementId>& balls,
                                                            const Execution& execution);

/// A rule on [0, 1]: ∫ f ≈ Σ w_q f(t_q).
struct Quadrature {
    std::vector<double> t, w;
    [[nodiscard]] std::size_t size() const { return t.size(); }
};

/// The Gauss–Legendre rule of n ≥ 1 points, exact to degree 2n − 1.
[[nodiscard]] inline Quadrature gauss_legendre(int n) {
    Quadrature rule{std::vector<double>(static_cast<std::size_t>(n)), std::vector<double>(static_cast<std::size_t>(n))};
    for (int i = 0; i < n; ++i) {
        double x = cos(std::numbers::pi * (i + 0.75) / (n + 0.5));
        double slope = 1;
        for (int newton = 0; newton < 100; ++newton) {
            // P_n and P_n' by the three-term recurrence.
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

/// The number of points by which lengths and gains are reported: finer than any rule that is minimised on.
inline constexpr int report_points = 12;

}  // namespace camber
