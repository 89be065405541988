// Tangents of boundary curves; junctions with prescribed geometries.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <numbers>
#include <span>
#include <utility>
#include <vector>
module camber.surface;
import camber.core;

namespace camber {

namespace {

enum Owner : std::uint8_t { none = 0, surrogate = 1, prescription = 2, both = 3 };

template <int D>
Buffer<std::uint8_t> owners_of_vertices(const LinearMesh<D>& mesh, std::span<const std::uint8_t> prescribed) {
    Buffer<std::uint8_t> owners(mesh.points.size());
    std::fill(owners.begin(), owners.end(), std::uint8_t{none});
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        for (const VertexId v : mesh.facets.vertices[f])
            owners[v.index()] =
                static_cast<std::uint8_t>(owners[v.index()] | (prescribed[f] != 0 ? prescription : surrogate));
    return owners;
}

void exclude_breaks(const LinearMesh<2>& mesh, const EdgeSet<2>&, const Incidence<FacetId>&,
                    std::span<const std::uint8_t>, Buffer<std::uint8_t>& owners) {
    for (const VertexId v : mesh.corners) owners[v.index()] = none;
    for (const std::uint32_t f : mesh.ridges)
        for (const VertexId v : mesh.facets.vertices[f]) owners[v.index()] = none;
}
void exclude_breaks(const LinearMesh<3>& mesh, const EdgeSet<3>& edges, const Incidence<FacetId>& shells,
                    std::span<const std::uint8_t> prescribed, Buffer<std::uint8_t>& owners) {
    for (const std::uint32_t ridge : mesh.ridges) {
        const auto shell = shells[edges.of_edges[ridge]];
        const auto count = std::ranges::count_if(shell, [&](FacetId f) { return prescribed[f.index()] != 0; });
        if (count == 0 || count == std::ssize(shell)) continue;
        for (const VertexId v : mesh.edges.vertices[ridge]) owners[v.index()] = none;
    }
}

Vec<3> away_from(const LinearMesh<3>& mesh, FacetId f, const std::array<VertexId, 2>& edge) {
    const Vec<3> along = normalised(mesh.points[edge[1]] - mesh.points[edge[0]]);
    for (const VertexId v : mesh.facets.vertices[f]) {
        if (v == edge[0] || v == edge[1]) continue;
        const Vec<3> to = normalised(mesh.points[v] - mesh.points[edge[0]]);
        return normalised(cross(along, cross(to, along)));
    }
    return {};
}
double turn_across(const LinearMesh<3>& mesh, const std::array<VertexId, 2>& edge, FacetId f, FacetId g) {
    const Vec<3> from = away_from(mesh, f, edge), to = -away_from(mesh, g, edge);
    return atan2(norm(cross(from, to)), dot(from, to));
}

double largest_turn(const MeshBoundary<3>& boundary, std::span<const FacetId> fan) {
    const auto& [mesh, edges, features, shells] = boundary;
    double largest = 0;
    for (const FacetId f : fan)
        for (const EdgeId e : edges.of_facets[f])
            if (features.edge_kinds[e] == EdgeKind::surface)
                largest = std::max(largest, turn_across(mesh, edges.vertices[e], shells[e][0], shells[e][1]));
    return largest;
}

}  // namespace

template <int D>
Vec<D> Junctions<D>::normal(const LinearMesh<D>& mesh, FacetId f, VertexId v) const {
    const auto found = std::lower_bound(facets.begin(), facets.end(), f);
    if (found == facets.end() || *found != f) return {};
    const auto& vertices = mesh.facets.vertices[f];
    const auto corner = std::find(vertices.begin(), vertices.end(), v) - vertices.begin();
    return normals[static_cast<std::size_t>(found - facets.begin())][static_cast<std::size_t>(corner)];
}

template <int D>
Outcome<Junctions<D>> find_junctions(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                     const Incidence<FacetId>& shells, const GeometryModel<D>& geometry,
                                     const Execution& execution) {
    auto prescribed = map_each(part_of(execution, 0, 0.2), mesh.facets.size(), [&](std::size_t f) -> std::uint8_t {
        return geometry.prescribes(mesh.facets.references[f]) ? 1 : 0;
    });
    if (!prescribed) return fail(prescribed.error());
    auto owners = owners_of_vertices(mesh, std::span<const std::uint8_t>(*prescribed));
    exclude_breaks(mesh, edges, shells, *prescribed, owners);
    const auto is_shared = [&](VertexId v) { return owners[v.index()] == both; };
    Buffer<FacetId> facets;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        if ((*prescribed)[f] != 0 && std::ranges::any_of(mesh.facets.vertices[f], is_shared))
            facets.push_back(FacetId(f));
    auto normals = map_each(part_of(execution, 0.2, 1), facets.size(), [&](std::size_t row) {
        auto at = geometry.normals_at(facet_site(mesh, facets[row])).value_or(std::array<Vec<D>, D>{});
        for (std::size_t i = 0; i < D; ++i)
            if (!is_shared(mesh.facets.vertices[facets[row]][i]) || !is_finite(at[i])) at[i] = {};
        return at;
    });
    if (!normals) return fail(normals.error());
    return Junctions<D>{std::move(*prescribed), std::move(facets), std::move(*normals)};
}

PrescribedNeighbour prescribed_neighbour(const Junctions<3>& junctions, const MeshBoundary<3>& boundary,
                                         const Fans& fans, std::uint32_t fan, const Vec<3>& fitted) {
    const auto& [mesh, edges, features, shells] = boundary;
    const VertexId v = fans.vertices[fan];
    const auto facets = fans.facets[fan];
    PrescribedNeighbour beyond;
    if (junctions.facets.empty() || junctions.is_prescribed(facets[0])) return beyond;
    double max_agreement = 0;
    for (const FacetId f : facets)
        for (const EdgeId e : edges.of_facets[f]) {
            if (edges.vertices[e][0] != v && edges.vertices[e][1] != v) continue;
            for (const FacetId g : shells[e]) {
                const Vec<3> normal = junctions.normal(mesh, g, v);
                const double agreement = dot(normal, fitted);
                if (!(std::fabs(agreement) > max_agreement)) continue;
                max_agreement = std::fabs(agreement);
                beyond = {g, agreement < 0 ? -normal : normal};
            }
        }
    if (!beyond.facet.valid()) return beyond;
    const std::uint32_t other = fans.of_facets[beyond.facet][corner_of(mesh.facets.vertices[beyond.facet], v)];
    beyond.tolerance =
        junction_share * std::max(largest_turn(boundary, facets), largest_turn(boundary, fans.facets[other]));
    return beyond;
}

namespace {

constexpr std::size_t max_neighbours = 4;

/// The two curve edges at each curve vertex other than a corner, for walks along curves.
template <int D>
struct Chains {
    const EdgeSet<D>& edges;
    const Features<D>& features;
    std::vector<std::array<EdgeId, 2>> around;  ///< lower edge first

    [[nodiscard]] VertexId other_end(EdgeId e, VertexId v) const {
        const auto& ends = edges.vertices[e];
        return ends[0] == v ? ends[1] : ends[0];
    }
    [[nodiscard]] EdgeId next(EdgeId e, VertexId v) const {
        const auto& at = around[v.index()];
        return at[0] == e ? at[1] : at[0];
    }
    [[nodiscard]] std::vector<VertexId> walk(VertexId v, EdgeId e) const {
        std::vector<VertexId> out;
        VertexId at = v;
        while (out.size() < max_neighbours) {
            at = other_end(e, at);
            if (at == v) break;
            out.push_back(at);
            if (features.vertex_kinds[at] == VertexKind::corner) break;
            e = next(e, at);
            if (!e.valid()) break;
        }
        return out;
    }
};

template <int D>
Chains<D> make_chains(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const Features<D>& features,
                      std::span<const EdgeId> curve_edges) {
    Chains<D> chains{edges, features, std::vector<std::array<EdgeId, 2>>(mesh.points.size())};
    for (const EdgeId e : curve_edges)
        for (const VertexId v : edges.vertices[e]) {
            auto& at = chains.around[v.index()];
            (at[0].valid() ? at[1] : at[0]) = e;
        }
    return chains;
}

/// A neighbour of a vertex, at the offset d = (x, y) from it, with x along and y across the assumed tangent: u = |d|²/x
/// and `slope` = y/x. If the tangent is off by the angle δ and the curvature is κ, then y/x = δ + κ/2 u + O(u²). On a
/// circle y = κ/2 |d|², so the fit is exact.
template <int D>
struct Height {
    double u = 0;
    Vec<D> slope;
};

/// Returns the heights up to the first step that does not go forward. A step goes forward if it advances along the
/// tangent by at least a third of its length.
template <int D>
std::vector<Height<D>> heights_over(const Vec<D>& tangent, std::span<const Vec<D>> offsets, double direction) {
    constexpr double min_advance = 0.33;
    std::vector<Height<D>> out;
    Vec<D> last;
    for (const Vec<D>& d : offsets) {
        const Vec<D> step = d - last;
        if (!(direction * dot(step, tangent) > min_advance * norm(step))) break;
        const double x = dot(d, tangent);
        out.push_back({norm_squared(d) / x, (d - x * tangent) / x});
        last = d;
    }
    return out;
}

template <int D>
std::vector<Height<D>> chosen(const std::vector<Height<D>>& ahead, const std::vector<Height<D>>& behind) {
    const std::size_t few_ahead = std::min<std::size_t>(ahead.size(), 2),
                      few_behind = std::min<std::size_t>(behind.size(), 2);
    const std::size_t from_ahead = std::min(ahead.size(), max_neighbours - few_behind);
    const std::size_t from_behind = std::min(behind.size(), max_neighbours - std::max(few_ahead, from_ahead));
    std::vector<Height<D>> out(ahead.begin(), ahead.begin() + static_cast<std::ptrdiff_t>(from_ahead));
    out.insert(out.end(), behind.begin(), behind.begin() + static_cast<std::ptrdiff_t>(from_behind));
    return out;
}

/// Returns δ (see `Height`), the value at u = 0 of the polynomial that interpolates the slopes: Σ_i (y_i/x_i) ∏_{j≠i}
/// u_j/(u_j − u_i).
template <int D>
Vec<D> slope_at_zero(std::span<const Height<D>> heights) {
    Vec<D> slope;
    for (std::size_t i = 0; i < heights.size(); ++i) {
        double weight = 1;
        for (std::size_t j = 0; j < heights.size(); ++j)
            if (j != i) weight *= heights[j].u / (heights[j].u - heights[i].u);
        slope += weight * heights[i].slope;
    }
    return slope;
}

template <int D>
struct Tangent {
    Vec<D> direction;
    std::uint8_t support = 0;
};

/// Tangent of the parabola through three points, parametrised by chord length; for two points, the chord.
template <int D>
Vec<D> first_tangent(std::span<const Vec<D>> ahead, std::span<const Vec<D>> behind) {
    if (ahead.empty()) return behind.empty() ? Vec<D>{} : -first_tangent<D>(behind, ahead);
    const Vec<D> a = ahead[0];
    const double la = norm(a);
    if (!behind.empty()) {
        const double lb = norm(behind[0]);
        return normalised((lb / la) * a - (la / lb) * behind[0]);
    }
    if (ahead.size() < 2) return normalised(a);
    const double lb = la + distance(ahead[1], a);
    return normalised((lb / la) * a - (la / lb) * ahead[1]);
}

template <int D>
Tangent<D> fitted_tangent(std::span<const Vec<D>> ahead, std::span<const Vec<D>> behind) {
    constexpr int passes = 4;
    constexpr double min_agreement = 0.8;
    const Vec<D> first = first_tangent<D>(ahead, behind);
    Tangent<D> t{first, static_cast<std::uint8_t>(std::min<std::size_t>(ahead.size() + behind.size(), 2))};
    if (ahead.size() + behind.size() < 2) return t;
    for (int pass = 0; pass < passes; ++pass) {
        const auto heights = chosen(heights_over<D>(t.direction, ahead, 1), heights_over<D>(t.direction, behind, -1));
        if (heights.size() < 2) break;
        const Vec<D> next = normalised(t.direction + slope_at_zero<D>(heights));
        if (!is_finite(next) || dot(next, first) < min_agreement) return {first, t.support};
        t = {next, static_cast<std::uint8_t>(heights.size())};
    }
    return t;
}

template <int D>
Tangent<D> tangent_at(const LinearMesh<D>& mesh, const Chains<D>& chains, VertexId v, EdgeId e) {
    std::vector<VertexId> ahead, behind;
    const bool passes_through = chains.features.vertex_kinds[v] != VertexKind::corner;
    const EdgeId lead = passes_through ? chains.around[v.index()][0] : e;
    ahead = chains.walk(v, lead);
    if (passes_through)
        if (const EdgeId back = chains.around[v.index()][1]; back.valid())
            for (const VertexId w : chains.walk(v, back)) {
                // On a short closed curve both walks meet: each vertex counts once, on its nearer side.
                const auto twice = std::find(ahead.begin(), ahead.end(), w);
                if (twice != ahead.end()) {
                    if (static_cast<std::size_t>(twice - ahead.begin()) <= behind.size()) break;
                    ahead.erase(twice, ahead.end());
                }
                behind.push_back(w);
            }
    const auto offsets = [&](const std::vector<VertexId>& vertices) {
        std::vector<Vec<D>> out;
        for (const VertexId w : vertices)
            if (mesh.points[w] != mesh.points[v]) out.push_back(mesh.points[w] - mesh.points[v]);
        return out;
    };
    Tangent<D> t = fitted_tangent<D>(offsets(ahead), offsets(behind));
    // Turns the direction of `lead` so that it leaves v along e.
    if (lead != e) t.direction = -t.direction;
    return t;
}

template <int D>
Tangent<D> preferred(const FileDirections<D>& file_directions, double min_cosine, VertexId v, Tangent<D> fitted) {
    double best = min_cosine;
    Tangent<D> out = fitted;
    for (const DirectionRow& at : file_directions.of(v)) {
        const Vec<D> tangent = file_directions.unit(at);
        const double cosine = dot(tangent, fitted.direction);
        if (!(std::fabs(cosine) > best)) continue;
        best = std::fabs(cosine);
        out = {cosine < 0 ? -tangent : tangent, max_neighbours};
    }
    return out;
}

Vec<2> prescribed_tangent(const Junctions<2>& junctions, const LinearMesh<2>& mesh, std::span<const FacetId> shell,
                          VertexId v) {
    const Vec<2> n = shell.size() == 1 ? junctions.normal(mesh, shell[0], v) : Vec<2>{};
    return {{-n[1], n[0]}};
}
/// Direction of the curve of two prescribed surfaces; nonzero only if they meet at an angle.
Vec<3> prescribed_tangent(const Junctions<3>& junctions, const LinearMesh<3>& mesh, std::span<const FacetId> shell,
                          VertexId v) {
    constexpr double min_sine = 0.1;
    if (shell.size() != 2) return {};
    const Vec<3> line = cross(junctions.normal(mesh, shell[0], v), junctions.normal(mesh, shell[1], v));
    return norm(line) > min_sine ? normalised(line) : Vec<3>{};
}

struct EdgeAt {
    VertexId vertex;
    EdgeId edge;
};
template <int D>
std::vector<EdgeAt> prescribed_ends(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, std::span<const EdgeId> curves,
                                    const Incidence<FacetId>& shells, const Junctions<D>& junctions) {
    std::vector<EdgeAt> ends;
    if (junctions.facets.empty()) return ends;
    for (const EdgeId e : curves)
        for (const VertexId v : edges.vertices[e])
            if (norm_squared(prescribed_tangent(junctions, mesh, shells[e], v)) > 0) ends.push_back({v, e});
    std::ranges::sort(ends, {}, [](const EdgeAt& at) { return std::pair(at.vertex, at.edge); });
    return ends;
}

template <int D>
struct TangentSources {
    const LinearMesh<D>& mesh;
    const Chains<D>& chains;
    const Incidence<FacetId>& shells;
    const Junctions<D>& junctions;
    std::vector<EdgeAt> prescribed;
    FileDirections<D> file_directions;
    double min_cosine = 2;

    [[nodiscard]] double next_turn(VertexId v, EdgeId e) const {
        const auto ahead = chains.walk(v, e);
        if (ahead.size() < 2) return 0;
        return angle_between(normalised(mesh.points[ahead[0]] - mesh.points[v]),
                             normalised(mesh.points[ahead[1]] - mesh.points[ahead[0]]));
    }
    [[nodiscard]] static double angle_between(const Vec<D>& a, const Vec<D>& b) {
        return 2 * asin(std::fmin(1, distance(a, b) / 2));
    }

    /// Returns the prescribed tangent at v if it continues edge e smoothly, in the fitted direction; else zero.
    [[nodiscard]] Vec<D> tangent_beyond(VertexId v, EdgeId e, const Vec<D>& fitted) const {
        double least = std::numbers::pi / 2;
        Vec<D> tangent;
        EdgeId beyond;
        for (auto at = std::ranges::lower_bound(prescribed, v, {}, &EdgeAt::vertex);
             at != prescribed.end() && at->vertex == v; ++at) {
            if (at->edge == e) return {};
            const Vec<D> line = prescribed_tangent(junctions, mesh, shells[at->edge], v);
            const Vec<D> turned = dot(line, fitted) < 0 ? -line : line;
            const double off = angle_between(turned, fitted);
            if (!(off < least)) continue;
            least = off;
            tangent = turned;
            beyond = at->edge;
        }
        if (!beyond.valid()) return {};
        const double around = std::fmax(next_turn(v, e), next_turn(v, beyond));
        return least <= junction_share * around ? tangent : Vec<D>{};
    }

    [[nodiscard]] Tangent<D> operator()(VertexId v, EdgeId e) const {
        const Tangent<D> fitted = tangent_at<D>(mesh, chains, v, e);
        const Vec<D> beyond = tangent_beyond(v, e, fitted.direction);
        return preferred<D>(file_directions, min_cosine, v,
                            norm_squared(beyond) > 0 ? Tangent<D>{beyond, max_neighbours} : fitted);
    }
};

}  // namespace

template <int D>
std::size_t CurveTangents<D>::row(EdgeId e) const {
    const auto at = std::lower_bound(edges.begin(), edges.end(), e);
    return at != edges.end() && *at == e ? static_cast<std::size_t>(at - edges.begin()) : edges.size();
}

template <int D>
Outcome<CurveTangents<D>> curve_tangents(const MeshBoundary<D>& boundary, const Junctions<D>& junctions,
                                         double max_degrees, const Execution& execution) {
    const auto& [mesh, edges, features, shells] = boundary;
    Buffer<EdgeId> curve_edges;
    for (std::size_t e = 0; e < edges.size(); ++e)
        if (features.curves[e] != no_feature) curve_edges.push_back(EdgeId(e));
    const auto chains = make_chains<D>(mesh, edges, features, curve_edges);
    const TangentSources<D> tangent{mesh,
                                    chains,
                                    shells,
                                    junctions,
                                    prescribed_ends<D>(mesh, edges, curve_edges, shells, junctions),
                                    FileDirections<D>(mesh.geometry.tangents),
                                    max_degrees > 0 ? cos(max_degrees * std::numbers::pi / 180) : 2};
    Buffer<std::array<std::uint8_t, 2>> supports(curve_edges.size());
    auto tangents = map_each(execution, curve_edges.size(), [&](std::size_t row) {
        const EdgeId e = curve_edges[row];
        const auto [low, high] = edges.vertices[e];
        const auto at_low = tangent(low, e), at_high = tangent(high, e);
        supports[row] = {at_low.support, at_high.support};
        return std::array{at_low.direction, -at_high.direction};
    });
    if (!tangents) return fail(tangents.error());
    return CurveTangents<D>{std::move(curve_edges), std::move(*tangents), std::move(supports)};
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template struct Junctions<D>;                                                                                     \
    template Outcome<Junctions<D>> find_junctions(const LinearMesh<D>&, const EdgeSet<D>&, const Incidence<FacetId>&, \
                                                  const GeometryModel<D>&, const Execution&);                         \
    template struct CurveTangents<D>;                                                                                 \
    template Outcome<CurveTangents<D>> curve_tangents(const MeshBoundary<D>&, const Junctions<D>&, double,            \
                                                      const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
