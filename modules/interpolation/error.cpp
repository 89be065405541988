// Interpolation errors on a mesh and its straight counterparts.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.interpolation;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

using States = std::vector<const State*>;

ErrorNorm norm_of(const States& states, std::size_t q) {
    ErrorNorm norm;
    Buffer<double> squares(states.size());
    double sum = 0, change = 0, rounding = 0;
    for (std::size_t e = 0; e < states.size(); ++e) {
        squares[e] = states[e]->integrals.squares[q];
        sum += squares[e];
        change += states[e]->change[q];
        rounding += q % 2 == 0 ? states[e]->integrals.l2_rounding : states[e]->integrals.h1_rounding;
    }
    norm.value = std::sqrt(sum);
    norm.uncertainty = sum > 0 ? change / sum / 2 : 0;
    norm.rounding = std::sqrt(rounding);
    norm.squares = std::move(squares);
    return norm;
}

std::size_t turned(const States& states) {
    return static_cast<std::size_t>(
        std::count_if(states.begin(), states.end(), [](const State* s) { return s->integrals.turned; }));
}

/// Returns true if det J ≤ 0 at a node. Thin layers first become invalid at nodes, where quadratures may have no point.
template <int D>
bool is_inverted_at_node(const QuadraticMesh<D>& mesh, std::size_t e) {
    const auto element = element_of(mesh, ElementId(e));
    for (int i = 0; i <= D; ++i)
        for (int j = i; j <= D; ++j) {
            Barycentric<D> xi{};
            xi[i] += 0.5;
            xi[j] += 0.5;
            const auto columns = element.derivatives(xi);
            if constexpr (D == 2) {
                if (!(det(columns[0], columns[1]) > 0)) return true;
            } else {
                if (!(det(columns[0], columns[1], columns[2]) > 0)) return true;
            }
        }
    return false;
}

Squares squares_of(const States& states) {
    Squares sum{};
    for (const State* s : states)
        for (std::size_t q = 0; q < sum.size(); ++q) sum[q] += s->integrals.squares[q];
    return sum;
}

template <int D>
bool same_nodes(const QuadraticMesh<D>& a, const QuadraticMesh<D>& b, std::size_t e) {
    const auto& edges = a.edges.of_elements[e];
    return std::all_of(edges.begin(), edges.end(), [&](EdgeId edge) { return a.mid_nodes[edge] == b.mid_nodes[edge]; });
}

InterpolantError error_of(const States& states) { return {norm_of(states, 0), norm_of(states, 1)}; }
InterpolantError linear_error_of(const States& states) { return {norm_of(states, 2), norm_of(states, 3)}; }

/// Errors of one field on several meshes. An element with the same nodes in several meshes is integrated once.
template <int D>
class Errors {
  public:
    Errors(const QuadraticMesh<D>& mesh, const ScalarField<D>& field, double tolerance, const Execution& execution)
        : mesh_(mesh), field_(field), tolerance_(tolerance), execution_(execution), bent_(curved_elements(mesh)) {}

    Outcome<InterpolantError> of_function(std::span<const double> nodal) {
        nodal_ = nodal;
        std::vector<std::uint32_t> straight;
        for (std::size_t e = 0, b = 0; e < mesh_.linear.elements.size(); ++e)
            if (b < bent_.size() && bent_[b] == e)
                ++b;
            else
                straight.push_back(static_cast<std::uint32_t>(e));
        static const State nothing{};
        auto states = integrated(mesh_, bent_, Sides::curved, States(mesh_.linear.elements.size(), &nothing));
        if (states) states = integrated(mesh_, std::move(straight), Sides::straight, std::move(*states));
        if (!states) return fail(states.error());
        return error_of(*states);
    }

    Outcome<InterpolationError> found() {
        std::vector<std::uint32_t> all(mesh_.linear.elements.size());
        std::iota(all.begin(), all.end(), 0U);
        const States none(all.size());
        const auto straight = integrated(mesh_, std::move(all), Sides::straight, none);
        if (!straight) return fail(straight.error());
        const auto curved = integrated(mesh_, bent_, Sides::curved, *straight);
        if (!curved) return fail(curved.error());
        error_.linear = linear_error_of(*straight);
        error_.straight = error_.same_boundary = error_of(*straight);
        error_.curved = error_of(*curved);
        error_.straight_inverted = error_.same_boundary_inverted = turned(*straight);
        error_.curved_inverted = turned(*curved);
        const auto inside = straight_inside(mesh_, bent_);
        error_.volume = volumes_of(inside ? *inside : mesh_, inside ? bent_ : std::vector<std::uint32_t>{});
        if (inside)
            if (auto done = compare(*inside, *straight, *curved); !done) return fail(done.error());
        return std::move(error_);
    }

  private:
    /// Integrates the errors of `elements` to the tolerance of the total over all elements. Returns `states` with the
    /// results.
    Outcome<States> integrated(const QuadraticMesh<D>& mesh, std::vector<std::uint32_t> elements, Sides sides,
                               States states) {
        Quadrature<D>& quadrature =
            quadratures_.emplace_back(IntegrationDomain<D>{mesh, std::move(elements), sides},
                                      Integrand<D>{field_, nodal_}, rules_, tolerance_, execution_);
        quadrature.put_into(states);  // the states of `elements` are still empty, so the sum contains only the other
                                      // elements
        if (auto done = quadrature.integrate(squares_of(states)); !done) return fail(done.error());
        error_.evaluations += quadrature.evaluations();
        error_.unresolved += quadrature.unresolved();
        return states;
    }

    Outcome<Done> compare(const QuadraticMesh<D>& inside, States states, const States& curved) {
        std::vector<std::uint32_t> own;
        for (const std::uint32_t e : bent_) {
            if (is_straight(inside, e)) continue;
            if (same_nodes(inside, mesh_, e))
                states[e] = curved[e];
            else
                own.push_back(e);
        }
        const auto compared = integrated(inside, own, Sides::curved, std::move(states));
        if (!compared) return fail(compared.error());
        error_.compared_with = Comparison::same_boundary;
        error_.same_boundary = error_of(*compared);
        error_.same_boundary_inverted = turned(*compared);
        for (const std::uint32_t e : own)
            if (!(*compared)[e]->integrals.turned && is_inverted_at_node(inside, e)) ++error_.same_boundary_inverted;
        return Done{};
    }

    const QuadraticMesh<D>& mesh_;
    const ScalarField<D>& field_;
    std::span<const double> nodal_ = {};
    double tolerance_;
    const Execution& execution_;
    Rules<D> rules_ = quadrature_rules<D>();
    std::vector<std::uint32_t> bent_;
    std::deque<Quadrature<D>> quadratures_;
    InterpolationError error_;
};

template <int D>
Outcome<InterpolationError> errors_of(const QuadraticMesh<D>& mesh, const ScalarField<D>& field,
                                      const InterpolationOptions& options, const Execution& execution) {
    if (auto sound = check_limits(options); !sound) return fail(sound.error());
    return Errors<D>(mesh, field, options.tolerance, execution).found();
}

}  // namespace

template <int D>
Outcome<InterpolationError> interpolation_error(const Mesh<D>& mesh, const ScalarField<D>& field,
                                                const InterpolationOptions& options, const Execution& execution) {
    const auto quadratic = as_quadratic(mesh);
    if (!quadratic) return fail(quadratic.error());
    return guarded([&] { return errors_of(*quadratic, field, options, execution); });
}

template <int D>
Outcome<InterpolantError> function_error(const Mesh<D>& mesh, std::span<const double> values,
                                         const ScalarField<D>& field, const InterpolationOptions& options,
                                         const Execution& execution) {
    const auto quadratic = as_quadratic(mesh);
    if (!quadratic) return fail(quadratic.error());
    if (values.size() != count_nodes(mesh))
        return fail(ErrorKind::internal, "a function of degree 2 needs a value for each node");
    return guarded([&]() -> Outcome<InterpolantError> {
        if (auto sound = check_limits(options); !sound) return fail(sound.error());
        return Errors<D>(*quadratic, field, options.tolerance, execution).of_function(values);
    });
}

namespace {

double determinant(const std::array<Vec<2>, 2>& columns) { return det(columns[0], columns[1]); }
double determinant(const std::array<Vec<3>, 3>& columns) { return det(columns[0], columns[1], columns[2]); }

template <int D>
double straight_determinant(const LinearMesh<D>& mesh, std::size_t e) {
    const auto& vertices = mesh.elements.vertices[e];
    std::array<Vec<D>, D> columns;
    for (std::size_t a = 0; a < D; ++a) columns[a] = mesh.points[vertices[a + 1]] - mesh.points[vertices[0]];
    return determinant(columns);
}

}  // namespace

template <int D>
Volumes volumes_of(const QuadraticMesh<D>& mesh, const std::vector<std::uint32_t>& bent) {
    const CollapsedRule<D> rule(2);  // exact for det J of degree D
    double straight = 0, beyond = 0;
    for (std::size_t e = 0; e < mesh.linear.elements.size(); ++e)
        straight += straight_determinant(mesh.linear, e) / (D == 2 ? 2 : 6);
    for (const std::uint32_t e : bent) {
        const auto element = element_of(mesh, ElementId(std::size_t{e}));
        const double of_straight = straight_determinant(mesh.linear, e);
        for (std::size_t p = 0; p < rule.count; ++p) {
            Barycentric<D> xi{};
            for (std::size_t i = 0; i <= D; ++i) xi[i] = rule.barycentric[i][p];
            beyond += rule.weights[p] * (determinant(element.derivatives(xi)) - of_straight);
        }
    }
    return {straight, straight + beyond};
}

template Volumes volumes_of<2>(const QuadraticMesh<2>&, const std::vector<std::uint32_t>&);
template Volumes volumes_of<3>(const QuadraticMesh<3>&, const std::vector<std::uint32_t>&);

namespace {

/// A facet is flat if the distance of its nodes from the plane of its corners, relative to its size, is at most this.
/// The limit is below the thickness of layers of anisotropy 10^6, and above rounding errors and the precision of text
/// files.
constexpr double flat = 1e-9;

template <int D>
struct CurvedFace {
    std::array<VertexId, D> vertices;
    ElementFace face;
};

template <int D>
using FaceEdges = std::array<EdgeId, edges_per_simplex<D - 1>>;

template <int D>
FaceEdges<D> edges_of(const QuadraticMesh<D>& mesh, const ElementFace& face) {
    FaceEdges<D> edges{};
    std::size_t next = 0;
    for (std::size_t k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        if (i != static_cast<int>(face.opposite) && j != static_cast<int>(face.opposite))
            edges[next++] = mesh.edges.of_elements[face.element][k];
    }
    return edges;
}

Vec<2> normal(const std::array<Vec<2>, 2>& p) { return {{p[1][1] - p[0][1], p[0][0] - p[1][0]}}; }
Vec<3> normal(const std::array<Vec<3>, 3>& p) { return cross(p[1] - p[0], p[2] - p[0]); }

template <int D>
bool is_flat(const QuadraticMesh<D>& mesh, const CurvedFace<D>& bent) {
    std::array<Vec<D>, D> corners;
    double longest = 0, largest = 0, highest = 0;
    for (std::size_t i = 0; i < D; ++i) {
        corners[i] = mesh.linear.points[bent.vertices[i]];
        for (int c = 0; c < D; ++c) largest = std::max(largest, std::abs(corners[i][c]));
    }
    const Vec<D> n = normal(corners);
    for (const EdgeId e : edges_of(mesh, bent.face)) {
        const QuadraticEdge<D> edge = edge_of(mesh, e);
        longest = std::max(longest, norm(edge.chord()));
        highest = std::max(highest, std::abs(dot(edge.offset(), n)));
    }
    // Collinear corners define no plane.
    return norm(n) > 0 && highest <= (flat * longest + 8 * std::numeric_limits<double>::epsilon() * largest) * norm(n);
}

template <int D>
std::vector<CurvedFace<D>> faces_of(const QuadraticMesh<D>& mesh, const std::vector<std::uint32_t>& bent) {
    std::vector<CurvedFace<D>> faces;
    for (const std::uint32_t e : bent)
        for (std::uint32_t opposite = 0; opposite <= D; ++opposite) {
            CurvedFace<D> face{{}, {ElementId(std::size_t{e}), opposite}};
            const auto local = face_opposite<D>(static_cast<int>(opposite));
            for (std::size_t i = 0; i < D; ++i)
                face.vertices[i] = mesh.linear.elements.vertices[e][static_cast<std::size_t>(local[i])];
            std::sort(face.vertices.begin(), face.vertices.end());
            if (!is_flat(mesh, face)) faces.push_back(face);
        }
    std::sort(faces.begin(), faces.end(), [](const auto& a, const auto& b) { return a.vertices < b.vertices; });
    return faces;
}

/// Returns true for a boundary face, or an interface between elements with different references. `same`: the face in
/// each of its elements.
template <int D>
bool bounds(const LinearMesh<D>& mesh, std::span<const CurvedFace<D>> same) {
    const auto reference = [&](const CurvedFace<D>& f) { return mesh.elements.references[f.face.element]; };
    return same.size() == 1 || (same.size() == 2 && reference(same[0]) != reference(same[1]));
}

}  // namespace

template <int D>
bool is_straight(const QuadraticMesh<D>& mesh, std::size_t e) {
    const auto& edges = mesh.edges.of_elements[e];
    return std::all_of(edges.begin(), edges.end(), [&](EdgeId edge) {
        const auto& [a, b] = mesh.edges.vertices[edge];
        return mesh.mid_nodes[edge].point == midpoint(mesh.linear.points[a], mesh.linear.points[b]);
    });
}

template <int D>
std::vector<std::uint32_t> curved_elements(const QuadraticMesh<D>& mesh) {
    std::vector<std::uint32_t> bent;
    for (std::size_t e = 0; e < mesh.linear.elements.size(); ++e)
        if (!is_straight(mesh, e)) bent.push_back(static_cast<std::uint32_t>(e));
    return bent;
}

template <int D>
std::optional<QuadraticMesh<D>> straight_inside(const QuadraticMesh<D>& mesh, const std::vector<std::uint32_t>& bent) {
    // The neighbour across a curved face is curved too, so the faces of curved elements are sufficient to find the
    // boundary.
    const std::vector<CurvedFace<D>> faces = faces_of(mesh, bent);
    std::vector<EdgeId> selected;
    for (std::size_t first = 0, last = 0; first < faces.size(); first = last) {
        while (last < faces.size() && faces[last].vertices == faces[first].vertices) ++last;
        if (!bounds<D>(mesh.linear, std::span(faces).subspan(first, last - first))) continue;
        const auto edges = edges_of(mesh, faces[first].face);
        selected.insert(selected.end(), edges.begin(), edges.end());
    }
    if (selected.empty()) return {};
    Buffer<LagrangeNode<D>> nodes(mesh.mid_nodes.size());
    for (std::size_t e = 0; e < nodes.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        nodes[e].point = midpoint(mesh.linear.points[a], mesh.linear.points[b]);
    }
    for (const EdgeId e : selected) nodes[e.index()] = mesh.mid_nodes[e];
    QuadraticMesh<D> inside = mesh;
    inside.mid_nodes = std::move(nodes);
    return inside;
}

#define CAMBER_INSTANTIATE(D)                                                                                   \
    template Outcome<InterpolantError> function_error<D>(const Mesh<D>&, std::span<const double>,               \
                                                         const ScalarField<D>&, const InterpolationOptions&,    \
                                                         const Execution&);                                     \
    template Outcome<InterpolationError> interpolation_error<D>(const Mesh<D>&, const ScalarField<D>&,          \
                                                                const InterpolationOptions&, const Execution&); \
    template bool is_straight<D>(const QuadraticMesh<D>&, std::size_t);                                         \
    template std::vector<std::uint32_t> curved_elements<D>(const QuadraticMesh<D>&);                            \
    template std::optional<QuadraticMesh<D>> straight_inside<D>(const QuadraticMesh<D>&,                        \
                                                                const std::vector<std::uint32_t>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
