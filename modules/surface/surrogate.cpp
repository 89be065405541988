// Builds the surrogate; finds closest points on it.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>
module camber.surface;
import camber.core;
import camber.box_tree;
import camber.bezier;
import camber.extension;

namespace camber {

namespace {

template <int D>
SurrogateEdge<D> straight_edge(const Vec<D>& a, const Vec<D>& b) {
    const Vec<D> third = (b - a) / 3;
    return {{{a, a + third, b - third, b}}, midpoint(a, b)};
}

/// Cubic edge; exactly straight if both tangents are along the chord within rounding.
template <int D>
SurrogateEdge<D> smooth_edge(const Vec<D>& a, const Vec<D>& tangent_a, const Vec<D>& tangent_b, const Vec<D>& b) {
    const Vec<D> e = b - a;
    const double length = norm(e);
    double largest = 0;
    for (int i = 0; i < D; ++i) largest = std::fmax(largest, std::fmax(std::fabs(a[i]), std::fabs(b[i])));
    const double tolerance = flat_tolerance + (length > 0 ? coordinate_ulps * largest / length : 1);
    const auto along_chord = [&](const Vec<D>& t) {
        const Vec<D> chord = e / (length > 0 ? length : 1);
        return norm(normalised(t) - dot(normalised(t), chord) * chord) <= tolerance;
    };
    if (along_chord(tangent_a) && along_chord(tangent_b)) return straight_edge(a, b);
    SurrogateEdge<D> edge{cubic_edge(a, tangent_a, tangent_b, b), {}};
    // With the inner control points c and d, the middle is (a + 3 c + 3 d + b)/8. It is computed relative to the
    // chord's middle.
    const auto& c = edge.curve.control;
    edge.middle = midpoint(a, b) + 0.375 * ((c[1] - a) + (c[2] - b));
    return edge;
}

template <int D>
void snap(SurrogateEdge<D>& edge, const FlatPatch<D>& flat) {
    // The ends are mesh vertices and stay fixed.
    edge.curve.control[1] = flat.snapped(edge.curve.control[1]);
    edge.curve.control[2] = flat.snapped(edge.curve.control[2]);
    edge.middle = flat.snapped(edge.middle);
}

template <int D>
Buffer<EdgeId> boundary_edges(const Features<D>& features) {
    Buffer<EdgeId> edges;
    for (std::size_t e = 0; e < features.edge_kinds.size(); ++e)
        if (features.edge_kinds[e] != EdgeKind::volume) edges.push_back(EdgeId(e));
    return edges;
}

template <int D>
std::array<Vec<D>, 2> inner_points(const SurrogateEdge<D>& edge, const std::array<VertexId, 2>& ends, VertexId from) {
    const auto& c = edge.curve.control;
    return ends[0] == from ? std::array{c[1], c[2]} : std::array{c[2], c[1]};
}

struct SurrogateParts {
    const LinearMesh<3>& mesh;
    const EdgeSet<3>& edges;
    const Features<3>& features;
    const Incidence<FacetId>& shells;
    const Fans& fans;
    std::span<const FlatPatch<3>> flats;
    const CurveTangents<3>& tangents;
    const Junctions<3>& junctions;
    const FanNormals& normals;
};

/// Returns the only surrogate facet at an edge where the junction is smooth (prescribed normals at both ends), else an
/// invalid number.
FacetId smooth_side(const SurrogateParts& parts, EdgeId e) {
    FacetId own;
    for (const FacetId f : parts.shells[e]) {
        if (parts.junctions.is_prescribed(f)) continue;
        if (own.valid()) return {};
        own = f;
    }
    if (!own.valid() || parts.shells[e].size() < 2) return {};
    for (const VertexId v : parts.edges.vertices[e]) {
        const std::uint32_t fan = parts.fans.of_facets[own][corner_of(parts.mesh.facets.vertices[own], v)];
        if (parts.normals.prescribed[fan] == 0) return {};
    }
    return own;
}

std::vector<FlatPatch<3>> planes_around(const SurrogateParts& parts, EdgeId e) {
    constexpr double same_direction = 1e-12;
    std::vector<FlatPatch<3>> planes;
    for (const FacetId f : parts.shells[e]) {
        const FlatPatch<3>& flat = parts.flats[parts.features.patches[f]];
        if (!flat.is_flat() || planes.size() == 2) continue;
        const bool known = std::any_of(planes.begin(), planes.end(), [&](const FlatPatch<3>& other) {
            return norm_squared(cross(other.normal, flat.normal)) < same_direction;
        });
        if (!known) planes.push_back(flat);
    }
    return planes;
}

SurrogateEdge<3> inner_edge(const SurrogateParts& parts, EdgeId e, FacetId f) {
    const auto& [low, high] = parts.edges.vertices[e];
    const Vec<3> a = parts.mesh.points[low], b = parts.mesh.points[high];
    if (parts.flats[parts.features.patches[f]].is_flat()) return straight_edge(a, b);
    const auto& facet = parts.mesh.facets.vertices[f];
    const auto normal = [&](VertexId v) { return parts.normals.normals[parts.fans.of_facets[f][corner_of(facet, v)]]; };
    const Vec<3> at_low = normal(low), at_high = normal(high), chord = b - a;
    const auto tangent = [&](const Vec<3>& n) { return chord - dot(chord, n) * n; };
    // An end in a pointed fan has no normal. Its tangent makes the same angle with the chord as the tangent at the
    // other end, as on a circle.
    const double length_squared = norm_squared(chord);
    const auto mirrored = [&](const Vec<3>& n) {
        const double rise = dot(chord, n);
        return length_squared > 0 ? chord + rise * (n - (2 * rise / length_squared) * chord) : chord;
    };
    const bool has_low = norm_squared(at_low) > 0, has_high = norm_squared(at_high) > 0;
    return smooth_edge(a, has_low ? tangent(at_low) : mirrored(at_high), has_high ? tangent(at_high) : mirrored(at_low),
                       b);
}

SurrogateEdge<3> ridge_edge(const SurrogateParts& parts, EdgeId e) {
    if (const FacetId side = smooth_side(parts, e); side.valid()) return inner_edge(parts, e, side);
    const auto& [low, high] = parts.edges.vertices[e];
    const Vec<3> a = parts.mesh.points[low], b = parts.mesh.points[high];
    const auto planes = planes_around(parts, e);
    if (planes.size() == 2) return straight_edge(a, b);
    const auto& [at_low, at_high] = parts.tangents.tangents[parts.tangents.row(e)];
    SurrogateEdge<3> edge = smooth_edge(a, at_low, at_high, b);
    const bool straight = edge.middle == midpoint(a, b);  // a straight edge is in the plane already, like its ends
    if (planes.size() == 1 && !straight) snap(edge, planes[0]);
    return edge;
}

/// Tangential displacement of a ridge's middle from the middle of the same edge in the smooth surface of facet f.
Vec<3> shift_in_surface(const SurrogateParts& parts, const SurrogateEdge<3>& ridge, EdgeId e, FacetId f) {
    const auto& facet = parts.mesh.facets.vertices[f];
    Vec<3> normal;
    for (const VertexId v : parts.edges.vertices[e])
        normal += parts.normals.normals[parts.fans.of_facets[f][corner_of(facet, v)]];
    if (!(norm_squared(normal) > 0)) return {};
    const Vec<3> shift = ridge.middle - inner_edge(parts, e, f).middle, n = normalised(normal);
    return shift - dot(shift, n) * n;
}

/// Moves the middle of an edge by `shift`. Its inner control points move within the tangent planes at the ends.
void bend(const SurrogateParts& parts, SurrogateEdge<3>& edge, EdgeId e, FacetId f, const Vec<3>& shift) {
    constexpr double of_inner_points = 4.0 / 3;
    const auto& facet = parts.mesh.facets.vertices[f];
    auto& c = edge.curve.control;
    for (std::size_t i = 0; i < 2; ++i) {
        const VertexId v = parts.edges.vertices[e][i];
        const Vec<3>& n = parts.normals.normals[parts.fans.of_facets[f][corner_of(facet, v)]];
        c[1 + i] += of_inner_points * (shift - dot(shift, n) * n);
    }
    edge.middle = midpoint(c[0], c[3]) + 0.375 * ((c[1] - c[0]) + (c[2] - c[3]));
}

Outcome<Done> bend_beside_ridges(const SurrogateParts& parts, std::span<const EdgeId> rows,
                                 Buffer<SurrogateEdge<3>>& curves, const Execution& execution) {
    const auto row = [&](EdgeId e) {
        return static_cast<std::size_t>(std::lower_bound(rows.begin(), rows.end(), e) - rows.begin());
    };
    Faces faces{Buffer<std::uint8_t>(parts.mesh.facets.size(), 0), Buffer<std::uint8_t>(parts.edges.size(), 0)};
    for (std::size_t f = 0; f < faces.facets.size(); ++f)
        faces.facets[f] =
            !parts.flats[parts.features.patches[f]].is_flat() && !parts.junctions.is_prescribed(FacetId(f));
    for (const EdgeId e : rows)
        faces.inside[e.index()] = parts.features.edge_kinds[e] == EdgeKind::surface && !parts.shells[e].empty() &&
                                  faces.facets[parts.shells[e][0].index()] != 0;
    for (const EmbeddedEdge& curve : embedded_edges(parts.mesh, parts.edges, parts.features, parts.shells))
        faces.inside[curve.edge.index()] = 0;
    const auto shifts = extend_over_triangles(
        parts.mesh, parts.edges, faces,
        [&](FacetId f, EdgeId e) { return shift_in_surface(parts, curves[row(e)], e, f); }, execution);
    if (!shifts) return fail(shifts.error());
    for (std::size_t i = 0; i < shifts->edges.size(); ++i) {
        const EdgeId e = shifts->edges[i];
        bend(parts, curves[row(e)], e, parts.shells[e][0], shifts->shifts[i]);
    }
    return Done{};
}

std::vector<PointAndNormal> samples_around(const SurrogateParts& parts, FacetId f) {
    std::vector<std::uint32_t> fans;
    const auto add = [&](std::uint32_t fan) {
        if (parts.fans.pointed[fan] == 0 && std::find(fans.begin(), fans.end(), fan) == fans.end()) fans.push_back(fan);
    };
    for (const std::uint32_t fan : parts.fans.of_facets[f]) add(fan);
    for (const std::uint32_t fan : parts.fans.of_facets[f])
        if (parts.fans.pointed[fan] == 0)
            for (const FacetId g : parts.fans.facets[fan])
                for (const std::uint32_t other : parts.fans.of_facets[g]) add(other);
    std::vector<PointAndNormal> samples;
    samples.reserve(fans.size());
    const double side = parts.fans.signs[f];
    for (const std::uint32_t fan : fans)
        samples.push_back({parts.mesh.points[parts.fans.vertices[fan]], side * parts.normals.normals[fan]});
    return samples;
}

/// Middle control point b_111 that puts the centroid on the fitted surface. The weight of b_111 at the centroid is
/// 6/27.
Vec<3> fitted_centre(const SurrogateParts& parts, FacetId f, const CubicSimplex<2, 3>& triangle) {
    constexpr double largest_share = 0.25;
    const Barycentric<2> centroid{1.0 / 3, 1.0 / 3, 1.0 / 3};
    const Vec<3> normal = normal_at<3>(triangle, centroid);
    const auto fit = fitted_height(point_at(triangle, centroid), normal, samples_around(parts, f));
    const double size = distance(triangle.control.front(), triangle.control.back());
    const Vec<3>& centre = triangle.at({1, 1, 1});
    return fit.degree > 0 && std::fabs(fit.height) < largest_share * size ? centre + 4.5 * fit.height * normal : centre;
}

/// Middle control point of a triangle with one pointed corner, where polynomial fits fail. The centroid is placed two
/// thirds of the way from this corner to the middle of the opposite edge, plus an offset. The offset is the mean
/// distance vector of the two edges at the corner from their chords, at two thirds of their lengths.
Vec<3> ruled_centre(const CubicSimplex<2, 3>& triangle, std::size_t tip) {
    const auto at = [&](double of_tip, double of_next, double of_last) {
        Barycentric<2> xi{};
        xi[tip] = of_tip;
        xi[(tip + 1) % 3] = of_next;
        xi[(tip + 2) % 3] = of_last;
        return point_at(triangle, xi);
    };
    constexpr double third = 1.0 / 3;
    const Vec<3> apex = at(1, 0, 0), next = at(0, 1, 0), last = at(0, 0, 1);
    const auto raised = [&](const Vec<3>& p, const Vec<3>& end) { return p - (apex + 2 * third * (end - apex)); };
    const Vec<3> target = apex + 2 * third * (at(0, 0.5, 0.5) - apex) +
                          0.5 * (raised(at(third, 2 * third, 0), next) + raised(at(third, 0, 2 * third), last));
    return triangle.at({1, 1, 1}) + 4.5 * (target - at(third, third, third));
}

std::size_t pointed_corner(const SurrogateParts& parts, FacetId f) {
    std::size_t tip = 3, count = 0;
    for (std::size_t i = 0; i < 3; ++i)
        if (parts.fans.pointed[parts.fans.of_facets[f][i]] != 0) {
            tip = i;
            ++count;
        }
    return count == 1 ? tip : 3;
}

CubicSimplex<2, 3> cubic_triangle(const SurrogateParts& parts, std::span<const EdgeId> edge_ids,
                                  std::span<const SurrogateEdge<3>> curves, FacetId f) {
    const auto& facet = parts.mesh.facets.vertices[f];
    CubicSimplex<2, 3> triangle;
    for (std::size_t i = 0; i < 3; ++i) {
        MultiIndex<2> alpha{};
        alpha[i] = 3;
        triangle.at(alpha) = parts.mesh.points[facet[i]];
    }
    for (std::size_t k = 0; k < 3; ++k) {
        const auto [i, j] = local_edges<2>[k];
        const EdgeId e = parts.edges.of_facets[f][k];
        const auto row =
            static_cast<std::size_t>(std::lower_bound(edge_ids.begin(), edge_ids.end(), e) - edge_ids.begin());
        const auto inner = inner_points(curves[row], parts.edges.vertices[e], facet[static_cast<std::size_t>(i)]);
        MultiIndex<2> alpha{};
        alpha[static_cast<std::size_t>(i)] = 2;
        alpha[static_cast<std::size_t>(j)] = 1;
        triangle.at(alpha) = inner[0];
        alpha[static_cast<std::size_t>(i)] = 1;
        alpha[static_cast<std::size_t>(j)] = 2;
        triangle.at(alpha) = inner[1];
    }
    Vec<3>& centre = triangle.at({1, 1, 1});
    centre = classical_centre(triangle);
    const FlatPatch<3>& flat = parts.flats[parts.features.patches[f]];
    const std::size_t tip = pointed_corner(parts, f);
    centre = flat.is_flat() ? flat.snapped(centre)
             : tip < 3      ? ruled_centre(triangle, tip)
                            : fitted_centre(parts, f, triangle);
    return triangle;
}

template <int D>
Outcome<Surrogate<D>> assembled(const SurrogateInput<D>& input, Buffer<EdgeId> edges, Buffer<SurrogateEdge<D>> curves,
                                Buffer<CubicSimplex<D - 1, D>> facets, Column<std::array<FacetId, D>> neighbours,
                                const Execution& execution) {
    const LinearMesh<D>& mesh = input.boundary.mesh;
    const Features<D>& features = input.boundary.features;
    Surrogate<D> s;
    if constexpr (D == 3) {
        Buffer<std::uint32_t> ridges;
        for (std::size_t row = 0; row < edges.size(); ++row)
            if (features.edge_kinds[edges[row]] == EdgeKind::ridge) ridges.push_back(static_cast<std::uint32_t>(row));
        s.ridge_rows = std::move(ridges);
    }
    s.facets = std::move(facets);
    s.references = mesh.facets.references;
    s.patches = features.patches;
    s.flats = input.flats;
    s.vertices = mesh.facets.vertices;
    s.neighbours = std::move(neighbours);
    s.edges = std::move(edges);
    s.edge_curves = std::move(curves);
    if (auto planted = build_trees(s, without_progress(execution)); !planted) return fail(planted.error());
    return s;
}

Outcome<Surrogate<3>> build(const SurrogateInput<3>& input, const SurrogateOptions& options,
                            const Execution& execution) {
    const auto& [mesh, edges, features, shells] = input.boundary;
    const auto fans = find_fans(mesh, edges, features, shells, without_progress(execution));
    if (!fans) return fail(fans.error());
    const auto normals = fan_normals(input, *fans, options.file_directions_degrees, part_of(execution, 0, 0.4));
    if (!normals) return fail(normals.error());
    const SurrogateParts parts{mesh,           edges,           features, shells, *fans, input.flats.view(),
                               input.tangents, input.junctions, *normals};

    auto rows = boundary_edges(features);
    auto curves = map_each(part_of(execution, 0.4, 0.42), rows.size(), [&](std::size_t row) {
        const EdgeId e = rows[row];
        SurrogateEdge<3> edge =
            features.edge_kinds[e] == EdgeKind::ridge ? ridge_edge(parts, e) : inner_edge(parts, e, shells[e][0]);
        edge.curve_number = features.curves[e];
        return edge;
    });
    if (!curves) return fail(curves.error());
    if (auto bent = bend_beside_ridges(parts, rows, *curves, without_progress(execution)); !bent)
        return fail(bent.error());
    auto facets = map_each(part_of(execution, 0.42, 1), mesh.facets.size(),
                           [&](std::size_t f) { return cubic_triangle(parts, rows, *curves, FacetId(f)); });
    if (!facets) return fail(facets.error());
    return assembled<3>(input, std::move(rows), std::move(*curves), std::move(*facets), fans->neighbours, execution);
}

/// Facets beyond both ends of each facet. Entry i is beyond vertex 1 − i; it is invalid where the curve ends.
Buffer<std::array<FacetId, 2>> next_along(const LinearMesh<2>& mesh, const Features<2>& features) {
    std::vector<std::array<FacetId, 2>> around(mesh.points.size());
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        for (const VertexId v : mesh.facets.vertices[f]) {
            auto& at = around[v.index()];
            (at[0].valid() ? at[1] : at[0]) = FacetId(f);
        }
    Buffer<std::array<FacetId, 2>> next(mesh.facets.size());
    for (std::size_t f = 0; f < next.size(); ++f)
        for (std::size_t i = 0; i < 2; ++i) {
            const VertexId v = mesh.facets.vertices[f][1 - i];
            const auto& at = around[v.index()];
            next[f][i] = features.vertex_kinds[v] == VertexKind::corner ? FacetId{}
                         : at[0].index() == f                           ? at[1]
                                                                        : at[0];
        }
    return next;
}

Outcome<Surrogate<2>> build(const SurrogateInput<2>& input, const SurrogateOptions&, const Execution& execution) {
    const auto& [mesh, edges, features, shells] = input.boundary;
    auto rows = boundary_edges(features);
    auto curves = map_each(part_of(execution, 0, 0.5), rows.size(), [&](std::size_t row) {
        const EdgeId e = rows[row];
        const auto& [low, high] = edges.vertices[e];
        const Vec<2> a = mesh.points[low], b = mesh.points[high];
        const auto& [at_low, at_high] = input.tangents.tangents[input.tangents.row(e)];
        const bool flat = input.flats[features.patches[shells[e][0]]].is_flat();
        SurrogateEdge<2> edge = flat ? straight_edge(a, b) : smooth_edge(a, at_low, at_high, b);
        edge.curve_number = features.curves[e];
        return edge;
    });
    if (!curves) return fail(curves.error());
    auto facets = map_each(part_of(execution, 0.5, 1), mesh.facets.size(), [&](std::size_t f) {
        const EdgeId e = edges.of_facets[f][0];
        const auto row = static_cast<std::size_t>(std::lower_bound(rows.begin(), rows.end(), e) - rows.begin());
        CubicSimplex<1, 2> facet = (*curves)[row].curve;
        if (edges.vertices[e][0] != mesh.facets.vertices[f][0])
            std::reverse(facet.control.begin(), facet.control.end());
        return facet;
    });
    if (!facets) return fail(facets.error());
    return assembled<2>(input, std::move(rows), std::move(*curves), std::move(*facets), next_along(mesh, features),
                        execution);
}

template <int K, int D>
Box<D> control_box(const CubicSimplex<K, D>& simplex) {
    Box<D> box;
    for (const Vec<D>& c : simplex.control) box.include(c);
    return box;
}

}  // namespace

template <int D>
Outcome<Done> build_trees(Surrogate<D>& surrogate, const Execution& execution) {
    const auto boxes =
        map_each(execution, surrogate.facets.size(), [&](std::size_t f) { return control_box(surrogate.facets[f]); });
    if (!boxes) return fail(boxes.error());
    surrogate.tree = BoxTree<D>(*boxes);
    Buffer<Box<D>> of_ridges;
    for (const std::uint32_t row : surrogate.ridge_rows)
        of_ridges.push_back(control_box(surrogate.edge_curves[row].curve));
    if constexpr (D == 3) surrogate.curve_tree = BoxTree<D>(of_ridges);
    return Done{};
}

template <int D>
std::size_t Surrogate<D>::row(EdgeId e) const {
    const auto at = std::lower_bound(edges.begin(), edges.end(), e);
    return at != edges.end() && *at == e ? static_cast<std::size_t>(at - edges.begin()) : edges.size();
}

namespace {

template <int D>
Outcome<Surrogate<D>> build_beside_prescribed(const GeometryModel<D>* prescribed, const LinearMesh<D>& mesh,
                                              const EdgeSet<D>& edges, const Features<D>& features,
                                              const SurrogateOptions& options, const Execution& execution) {
    if (edges.of_facets.size() != mesh.facets.size() || features.patches.size() != mesh.facets.size() ||
        features.edge_kinds.size() != edges.size())
        return fail(ErrorKind::internal, "the edge set or the features belong to another mesh");
    const Execution quiet = without_progress(execution);
    const auto shells = facet_shells(edges, quiet);
    if (!shells) return fail(shells.error());
    auto flats = flat_patches(mesh, features, quiet);
    if (!flats) return fail(flats.error());
    Outcome<Junctions<D>> junctions = Junctions<D>{};
    if (prescribed != nullptr && prescribed->prescribes_any())
        junctions = find_junctions(mesh, edges, *shells, *prescribed, quiet);
    if (!junctions) return fail(junctions.error());
    const MeshBoundary<D> boundary{mesh, edges, features, *shells};
    const auto tangents = curve_tangents(boundary, *junctions, options.file_directions_degrees, quiet);
    if (!tangents) return fail(tangents.error());
    const Column<FlatPatch<D>> planes(std::move(*flats));
    return build(SurrogateInput<D>{boundary, planes, *tangents, *junctions}, options, execution);
}

}  // namespace

template <int D>
Outcome<Surrogate<D>> build_surrogate(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const Features<D>& features,
                                      const SurrogateOptions& options, const Execution& execution) {
    return build_beside_prescribed<D>(nullptr, mesh, edges, features, options, execution);
}
template <int D>
Outcome<Surrogate<D>> build_surrogate(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const Features<D>& features,
                                      const GeometryModel<D>& prescribed, const SurrogateOptions& options,
                                      const Execution& execution) {
    return build_beside_prescribed(&prescribed, mesh, edges, features, options, execution);
}

namespace {

template <int K>
Barycentric<K> carried_over(const SimplexVertices<K>& from, const Barycentric<K>& xi, const SimplexVertices<K>& to) {
    Barycentric<K> out{};
    for (int i = 0; i <= K; ++i)
        for (int j = 0; j <= K; ++j)
            if (from[i] == to[j]) out[j] = xi[i];
    return out;
}

template <int D>
SurrogateFoot<D> named(FacetId f, const CubicFoot<D - 1, D>& foot) {
    return {f, foot.xi, foot.point, foot.distance_squared};
}

template <int D>
SurrogateFoot<D> walked(const Surrogate<D>& surrogate, SurrogateFoot<D> here, const Vec<D>& p) {
    constexpr int max_steps = 1000;
    for (int step = 0; step < max_steps; ++step) {
        SurrogateFoot<D> best = here;
        for (int i = 0; i < D; ++i) {
            const FacetId next = surrogate.neighbours[here.facet][i];
            if (here.xi[i] != 0 || !next.valid()) continue;
            const auto start = carried_over<D - 1>(surrogate.vertices[here.facet], here.xi, surrogate.vertices[next]);
            const auto there = named<D>(next, closest_from(surrogate.facets[next], p, start));
            if (there.distance_squared < best.distance_squared) best = there;
        }
        if (best.facet == here.facet) return here;
        here = best;
    }
    return here;
}

}  // namespace

template <int D>
SurrogateFoot<D> closest_near(const Surrogate<D>& surrogate, FacetId start, const Vec<D>& p) {
    SurrogateFoot<D> here = walked(surrogate, named<D>(start, closest_on(surrogate.facets[start], p)), p);
    for (bool improved = true; improved;) {
        improved = false;
        for (const FacetId next : surrogate.neighbours[here.facet]) {
            if (!next.valid()) continue;
            const auto there = named<D>(next, closest_on(surrogate.facets[next], p));
            if (!(there.distance_squared < here.distance_squared)) continue;
            here = walked(surrogate, there, p);
            improved = true;
            break;
        }
    }
    return here;
}

template <int D>
SurrogateFoot<D> closest_near(const Surrogate<D>& surrogate, FacetId start, const Barycentric<D - 1>& xi,
                              const Vec<D>& p) {
    return walked(surrogate, named<D>(start, closest_from(surrogate.facets[start], p, xi)), p);
}

template <int D>
CurveFoot<D> closest_on_ridges(const Surrogate<D>& surrogate, const Vec<D>& p) {
    const auto curve = [&](std::size_t i) -> const CubicSimplex<1, D>& {
        return surrogate.edge_curves[surrogate.ridge_rows[i]].curve;
    };
    const auto nearest =
        surrogate.curve_tree.nearest(p, [&](std::size_t i) { return closest_on(curve(i), p).distance_squared; });
    if (nearest.item == std::numeric_limits<std::size_t>::max())
        return {surrogate.edges.size(), 0, {}, std::numeric_limits<double>::infinity()};
    const auto foot = closest_on(curve(nearest.item), p);
    return {surrogate.ridge_rows[nearest.item], foot.xi[1], foot.point, foot.distance_squared};
}

template <int D>
Vec<D> normal_at(const CubicSimplex<D - 1, D>& facet, const Barycentric<D - 1>& xi) {
    const auto expansion = expand(facet, xi);
    if constexpr (D == 2) {
        const Vec<2>& t = expansion.first[0];
        return normalised(Vec<2>{{t[1], -t[0]}});
    } else {
        const Vec<3> n = cross(expansion.first[0], expansion.first[1]);
        if (norm_squared(n) > 0) return normalised(n);
        const auto& c = facet.control;
        return normalised(cross(c[6] - c[0], c[9] - c[0]));
    }
}

template SurrogateFoot<2> closest_near(const Surrogate<2>&, FacetId, const Vec<2>&);
template SurrogateFoot<3> closest_near(const Surrogate<3>&, FacetId, const Vec<3>&);
template SurrogateFoot<2> closest_near(const Surrogate<2>&, FacetId, const Barycentric<1>&, const Vec<2>&);
template SurrogateFoot<3> closest_near(const Surrogate<3>&, FacetId, const Barycentric<2>&, const Vec<3>&);
template CurveFoot<2> closest_on_ridges(const Surrogate<2>&, const Vec<2>&);
template CurveFoot<3> closest_on_ridges(const Surrogate<3>&, const Vec<3>&);
template Vec<2> normal_at<2>(const CubicSimplex<1, 2>&, const Barycentric<1>&);
template Vec<3> normal_at<3>(const CubicSimplex<2, 3>&, const Barycentric<2>&);

#define CAMBER_INSTANTIATE(D)                                                                                   \
    template struct Surrogate<D>;                                                                               \
    template Outcome<Done> build_trees(Surrogate<D>&, const Execution&);                                        \
    template Outcome<Surrogate<D>> build_surrogate(const LinearMesh<D>&, const EdgeSet<D>&, const Features<D>&, \
                                                   const SurrogateOptions&, const Execution&);                  \
    template Outcome<Surrogate<D>> build_surrogate(const LinearMesh<D>&, const EdgeSet<D>&, const Features<D>&, \
                                                   const GeometryModel<D>&, const SurrogateOptions&,            \
                                                   const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
