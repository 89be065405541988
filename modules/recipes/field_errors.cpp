// Errors of the interpolants of a field, by kinds of elements
module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
#include <fmt/format.h>
module camber.recipes;
import camber.core;
import camber.bezier;
import camber.interpolation;
import camber.fields;

namespace camber::run {

namespace {

constexpr double max_hops = 8;

/// 1: the vertex is on a face that one element alone has.
template <int D>
Outcome<std::vector<std::uint8_t>> boundary_vertices(const LinearMesh<D>& mesh, const Execution& execution) {
    std::vector<std::uint8_t> on(mesh.points.size(), 0);
    auto around = balls(mesh, execution);
    if (!around) return fail(around.error());
    auto across = neighbours(mesh, *around, execution);
    if (across) {
        for (const ElementFace& face : boundary_faces<D>(*across))
            for (const int i : face_opposite<D>(static_cast<int>(face.opposite)))
                on[mesh.elements.vertices[face.element][static_cast<std::size_t>(i)].index()] = 1;
        return on;
    }
    if (across.error().kind != ErrorKind::input) return fail(across.error());
    // More than two elements on a face: no neighbours. What the file calls facets must do.
    for (const auto& facet : mesh.facets.vertices)
        for (const VertexId v : facet) on[v.index()] = 1;
    return on;
}

/// Edges from each vertex to the boundary.
template <int D>
Outcome<std::vector<double>> hops_of_vertices(const QuadraticMesh<D>& mesh, const Execution& execution) {
    auto on = boundary_vertices(mesh.linear, execution);
    if (!on) return fail(on.error());
    std::vector<double> hops(on->size(), max_hops);
    for (std::size_t v = 0; v < hops.size(); ++v)
        if ((*on)[v] == 1) hops[v] = 0;
    for (double hop = 1; hop < max_hops; ++hop)
        for (const auto& [a, b] : mesh.edges.vertices) {
            double &first = hops[a.index()], &second = hops[b.index()];
            if (first == hop - 1) second = std::min(second, hop);
            if (second == hop - 1) first = std::min(first, hop);
        }
    return hops;
}

/// Bin k holds what is below its limit and not below that of the one before; a last one holds the rest.
struct Bins {
    std::string_view key, title;
    std::vector<double> limits;
    std::vector<std::string> ranges;  ///< one more
};

Bins curvature_bins() {
    return {"curvature",
            "curvature, |node - middle|/|chord| of the edge that is bent most",
            {1e-12, 1e-3, 1e-2, 0.03, 0.1},
            {"0", "below 0.001", "0.001 to 0.01", "0.01 to 0.03", "0.03 to 0.1", "0.1 and above"}};
}
Bins jacobian_bins() {
    return {"scaled_jacobian",
            "smallest scaled Jacobian",
            {0, 0.1, 0.3, 0.5, 0.8, 1 - 1e-6},
            {"below 0", "0 to 0.1", "0.1 to 0.3", "0.3 to 0.5", "0.5 to 0.8", "0.8 to 1", "1: as straight"}};
}
Bins boundary_bins() {
    return {"boundary",
            "edges between the element and the boundary",
            {1, 2, 3, 5, max_hops},
            {"0: touches it", "1", "2", "3 or 4", "5 to 7", "8 and above"}};
}

/// Which bin each element is in.
std::vector<std::size_t> bins_of(const Bins& bins, std::span<const double> kinds) {
    std::vector<std::size_t> at(kinds.size());
    for (std::size_t e = 0; e < kinds.size(); ++e)
        at[e] = static_cast<std::size_t>(std::upper_bound(bins.limits.begin(), bins.limits.end(), kinds[e]) -
                                         bins.limits.begin());
    return at;
}

void add_shares(ErrorPlace& place, double ErrorBin::* share, std::span<const std::size_t> at, const ErrorNorm& norm) {
    double all = 0;
    for (std::size_t e = 0; e < at.size(); ++e) {
        place.bins[at[e]].*share += norm.squares[e];
        all += norm.squares[e];
    }
    for (ErrorBin& bin : place.bins) bin.*share /= all > 0 ? all : 1;
}

ErrorPlace placed(const Bins& bins, std::span<const double> kinds, const InterpolationError& errors) {
    ErrorPlace place{bins.key, bins.title, {}};
    for (const std::string& range : bins.ranges) place.bins.push_back({range});
    const std::vector<std::size_t> at = bins_of(bins, kinds);
    for (const std::size_t bin : at) ++place.bins[bin].elements;
    add_shares(place, &ErrorBin::straight, at, errors.straight.l2);
    add_shares(place, &ErrorBin::same_boundary, at, errors.same_boundary.l2);
    add_shares(place, &ErrorBin::curved, at, errors.curved.l2);
    return place;
}

}  // namespace

template <int D>
Outcome<ElementKinds> element_kinds(const QuadraticMesh<D>& mesh, const Column<float>& min_scaled_jacobian,
                                    const Execution& execution) {
    auto hops = hops_of_vertices(mesh, execution);
    if (!hops) return fail(hops.error());
    const std::size_t elements = mesh.linear.elements.size();
    ElementKinds kinds{Buffer<double>(elements), Buffer<double>(elements), Buffer<double>(elements)};
    auto done = each(execution, elements, [&](std::size_t e) {
        double bent = 0, nearest = max_hops;
        for (const EdgeId edge : mesh.edges.of_elements[e]) bent = std::max(bent, curvature(edge_of(mesh, edge)));
        for (const VertexId v : mesh.linear.elements.vertices[e]) nearest = std::min(nearest, (*hops)[v.index()]);
        kinds.curvature[e] = bent;
        kinds.hops[e] = nearest;
        kinds.scaled_jacobian[e] = static_cast<double>(min_scaled_jacobian[e]);
    });
    if (!done) return fail(done.error());
    return kinds;
}

template <int D>
Outcome<FieldErrors> field_errors(const QuadraticMesh<D>& mesh, const std::string& expression,
                                  const ElementKinds& kinds, const Execution& execution) {
    const auto parsed = ScalarExpression<D>::parsed(expression);
    if (!parsed) return fail(parsed.error());
    const ScalarField<D> field = [&] { return parsed->evaluator(); };
    auto errors = interpolation_error<D>(as_mesh(mesh), field, {}, execution);
    if (!errors) {
        Error error = errors.error();
        if (error.kind == ErrorKind::usage) error.where = quoted_expression(expression);
        return fail(std::move(error));
    }
    FieldErrors found{expression, std::move(*errors), {}};
    found.places = {placed(curvature_bins(), kinds.curvature, found.errors),
                    placed(jacobian_bins(), kinds.scaled_jacobian, found.errors),
                    placed(boundary_bins(), kinds.hops, found.errors)};
    return found;
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template Outcome<ElementKinds> element_kinds<D>(const QuadraticMesh<D>&, const Column<float>&, const Execution&); \
    template Outcome<FieldErrors> field_errors<D>(const QuadraticMesh<D>&, const std::string&, const ElementKinds&,   \
                                                  const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
