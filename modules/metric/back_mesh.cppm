module;
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
export module camber.metric:back_mesh;
import camber.core;
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
