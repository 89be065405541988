// Normals of the surrogate: fans, polynomial fits.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <vector>
#include <Eigen/Dense>
module camber.surface;
import camber.core;

namespace camber {

namespace {

constexpr std::array<std::size_t, 3> opposite_of_edge{2, 0, 1};

FacetId other_facet(std::span<const FacetId> shell, FacetId f) { return shell[0] == f ? shell[1] : shell[0]; }

Outcome<Buffer<std::array<FacetId, 3>>> smooth_neighbours(const EdgeSet<3>& edges, const Features<3>& features,
                                                          const Incidence<FacetId>& shells,
                                                          const Execution& execution) {
    return map_each(execution, edges.of_facets.size(), [&](std::size_t f) {
        std::array<FacetId, 3> across;
        for (std::size_t k = 0; k < 3; ++k) {
            const EdgeId e = edges.of_facets[f][k];
            if (features.edge_kinds[e] == EdgeKind::surface)
                across[opposite_of_edge[k]] = other_facet(shells[e], FacetId(f));
        }
        return across;
    });
}

bool runs_along(const SimplexVertices<2>& facet, VertexId a, VertexId b) {
    return facet[(corner_of(facet, a) + 1) % 3] == b;
}

/// Orients the facets of each patch like its first facet. A non-orientable patch has a seam.
Buffer<std::int8_t> patch_signs(const LinearMesh<3>& mesh, const Buffer<std::array<FacetId, 3>>& neighbours) {
    Buffer<std::int8_t> signs(neighbours.size());
    std::fill(signs.begin(), signs.end(), std::int8_t{0});
    std::vector<FacetId> front;
    for (std::size_t first = 0; first < signs.size(); ++first) {
        if (signs[first] != 0) continue;
        signs[first] = 1;
        front.assign(1, FacetId(first));
        while (!front.empty()) {
            const FacetId f = front.back();
            front.pop_back();
            const auto& facet = mesh.facets.vertices[f];
            for (std::size_t i = 0; i < 3; ++i) {
                const FacetId g = neighbours[f.index()][i];
                if (!g.valid() || signs[g.index()] != 0) continue;
                const bool same_way = runs_along(mesh.facets.vertices[g], facet[(i + 1) % 3], facet[(i + 2) % 3]);
                signs[g.index()] = static_cast<std::int8_t>(same_way ? -signs[f.index()] : signs[f.index()]);
                front.push_back(g);
            }
        }
    }
    return signs;
}

double angle_between(const Vec<3>& a, const Vec<3>& b) { return atan2(norm(cross(a, b)), dot(a, b)); }

/// At the end of a ridge, and where another surface ends (`is_shared`), facets may turn: the fan is not pointed.
bool is_pointed(const LinearMesh<3>& mesh, const Fans& fans, std::uint32_t fan, bool is_shared) {
    constexpr double max_turn = 20 * std::numbers::pi / 180;
    Vec<3> mean;
    std::vector<VertexId> ridges;  // vertices at the other ends of the fan's ridges
    for (const FacetId f : fans.facets[fan]) {
        const auto& v = mesh.facets.vertices[f];
        const std::size_t i = corner_of(v, fans.vertices[fan]), next = (i + 1) % 3, last = (i + 2) % 3;
        mean += angle_between(mesh.points[v[next]] - mesh.points[v[i]], mesh.points[v[last]] - mesh.points[v[i]]) *
                normalised(area_vector(mesh, fans, f));
        if (!fans.neighbours[f][next].valid()) ridges.push_back(v[last]);
        if (!fans.neighbours[f][last].valid()) ridges.push_back(v[next]);
    }
    if (ridges.size() == 2 && ridges[0] == ridges[1]) return false;
    if (ridges.empty() && is_shared) return false;
    return std::ranges::any_of(fans.facets[fan], [&](FacetId f) {
        return angle_between(area_vector(mesh, fans, f), mean) > (ridges.empty() ? 1 : 2) * max_turn;
    });
}

/// A facet corner: 3 f + i for corner i of facet f.
using Corner = std::uint32_t;

void walk_fan(const LinearMesh<3>& mesh, const Buffer<std::array<FacetId, 3>>& neighbours, Corner corner,
              std::vector<Corner>& fan) {
    const VertexId v = mesh.facets.vertices[corner / 3][corner % 3];
    fan.assign(1, corner);
    for (std::size_t next = 0; next < fan.size(); ++next) {
        const std::size_t f = fan[next] / 3, at = fan[next] % 3;
        for (const std::size_t side : {(at + 1) % 3, (at + 2) % 3}) {
            const FacetId g = neighbours[f][side];
            if (!g.valid()) continue;
            const Corner there = static_cast<Corner>(3 * g.index() + corner_of(mesh.facets.vertices[g], v));
            if (std::find(fan.begin(), fan.end(), there) == fan.end()) fan.push_back(there);
        }
    }
    std::sort(fan.begin(), fan.end());
}

}  // namespace

std::size_t corner_of(const SimplexVertices<2>& facet, VertexId v) {
    for (std::size_t i = 0; i < 3; ++i)
        if (facet[i] == v) return i;
    return 0;
}

Outcome<Fans> find_fans(const LinearMesh<3>& mesh, const EdgeSet<3>& edges, const Features<3>& features,
                        const Incidence<FacetId>& shells, const Execution& execution) {
    auto neighbours = smooth_neighbours(edges, features, shells, execution);
    if (!neighbours) return fail(neighbours.error());
    constexpr std::uint32_t unvisited = 0xffffffffU;
    Buffer<std::array<std::uint32_t, 3>> of_facets(mesh.facets.size());
    std::fill(of_facets.begin(), of_facets.end(), std::array{unvisited, unvisited, unvisited});
    Buffer<std::uint32_t> offsets;
    Buffer<FacetId> items;
    Buffer<VertexId> vertices;
    offsets.push_back(0);
    items.reserve(3 * mesh.facets.size());
    std::vector<Corner> fan;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        for (std::size_t i = 0; i < 3; ++i) {
            if (of_facets[f][i] != unvisited) continue;
            walk_fan(mesh, *neighbours, static_cast<Corner>(3 * f + i), fan);
            for (const Corner c : fan) {
                of_facets[c / 3][c % 3] = static_cast<std::uint32_t>(vertices.size());
                items.push_back(FacetId(std::size_t{c / 3}));
            }
            vertices.push_back(mesh.facets.vertices[f][i]);
            offsets.push_back(static_cast<std::uint32_t>(items.size()));
        }
    auto signs = patch_signs(mesh, *neighbours);
    Fans fans{std::move(of_facets), {std::move(offsets), std::move(items)},
              std::move(vertices),  std::move(*neighbours),
              std::move(signs),     {}};
    std::vector<std::uint8_t> fans_at(mesh.points.size(), 0);
    for (const VertexId v : fans.vertices) fans_at[v.index()] = fans_at[v.index()] == 0 ? 1 : 2;
    auto pointed = map_each(execution, fans.size(), [&](std::size_t i) -> std::uint8_t {
        const VertexId v = fans.vertices[i];
        if (features.vertex_kinds[v] != VertexKind::corner) return 0;
        return is_pointed(mesh, fans, static_cast<std::uint32_t>(i), fans_at[v.index()] > 1) ? 1 : 0;
    });
    if (!pointed) return fail(pointed.error());
    fans.pointed = std::move(*pointed);
    return fans;
}

Vec<3> area_vector(const LinearMesh<3>& mesh, const Fans& fans, FacetId f) {
    const auto& [a, b, c] = mesh.facets.vertices[f];
    return static_cast<double>(fans.signs[f]) * cross(mesh.points[b] - mesh.points[a], mesh.points[c] - mesh.points[a]);
}

std::vector<std::uint32_t> rings(const LinearMesh<3>& mesh, const Fans& fans, std::uint32_t fan, const Vec<3>& normal,
                                 const RingOptions& options) {
    constexpr double min_cosine = 0.3;
    std::vector<std::uint32_t> found;
    std::vector<FacetId> facets;
    const auto enter = [&](std::uint32_t other) {
        for (const FacetId f : fans.facets[other]) {
            const Vec<3> area = area_vector(mesh, fans, f);
            if (dot(area, normal) < min_cosine * norm(area)) continue;
            if (std::find(facets.begin(), facets.end(), f) == facets.end()) facets.push_back(f);
        }
    };
    enter(fan);
    std::size_t visited = 0, entered = 0;
    for (int ring = 1;; ++ring) {
        for (; visited < facets.size(); ++visited)
            for (const std::uint32_t other : fans.of_facets[facets[visited]])
                if (other != fan && std::find(found.begin(), found.end(), other) == found.end()) found.push_back(other);
        if (ring >= options.max_rings || found.size() >= options.most) break;
        if (ring >= options.min_rings && found.size() >= options.enough) break;
        for (const std::size_t end = found.size(); entered < end; ++entered)
            if (fans.pointed[found[entered]] == 0) enter(found[entered]);
        if (facets.size() == visited) break;
    }
    return found;
}

namespace {

constexpr int highest_degree = 4;
constexpr int max_terms = 15;
constexpr int max_rows = 128;
using Design = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, max_rows, max_terms>;
using Column1 = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, max_rows, 1>;
using Coefficients = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, max_terms, 1>;

constexpr int terms_of(int degree) { return (degree + 1) * (degree + 2) / 2; }

constexpr auto exponents = [] {
    std::array<std::array<std::size_t, 2>, max_terms> out{};
    std::size_t k = 0;
    for (std::size_t degree = 0; degree <= highest_degree; ++degree)
        for (std::size_t j = 0; j <= degree; ++j) out[k++] = {degree - j, j};
    return out;
}();

/// Frame of a height field: z along the normal, x and y along the principal axes of the projected points. `scale`: root
/// mean squares of x and y.
struct PlaneFrame {
    Mat<3> axes;
    std::array<double, 2> scale{};

    [[nodiscard]] bool spans_plane() const { return scale[0] > 0 && scale[1] > 0; }
    [[nodiscard]] Vec<3> scaled(const Vec<3>& d) const {
        const Vec<3> v = transposed_times(axes, d);
        return {{v[0] / scale[0], v[1] / scale[1], v[2]}};
    }
};

PlaneFrame principal_frame(const Vec<3>& normal, std::span<const Vec<3>> offsets) {
    const Vec<3> seed = std::fabs(normal[0]) < 0.6 ? Vec<3>{{1, 0, 0}} : Vec<3>{{0, 1, 0}};
    const Vec<3> u = normalised(cross(normal, seed));
    const Vec<3> v = cross(normal, u);
    double uu = 0, uv = 0, vv = 0;
    for (const Vec<3>& d : offsets) {
        const double x = dot(d, u), y = dot(d, v);
        uu += x * x;
        uv += x * y;
        vv += y * y;
    }
    const double angle = 0.5 * atan2(2 * uv, uu - vv);
    const Vec<3> first = cos(angle) * u + sin(angle) * v;
    const Vec<3> second = cross(normal, first);
    double xx = 0, yy = 0;
    for (const Vec<3>& d : offsets) {
        xx += dot(d, first) * dot(d, first);
        yy += dot(d, second) * dot(d, second);
    }
    const double n = static_cast<double>(offsets.size());
    return {{{first, second, normal}}, {std::sqrt(xx / n), std::sqrt(yy / n)}};
}

std::array<double, highest_degree + 1> powers_of(double x) { return {1, x, x * x, x * x * x, x * x * x * x}; }

std::optional<Coefficients> solved(Design columns, const Column1& right) {
    constexpr double min_pivot_ratio = 1e-3;
    const Eigen::Index terms = columns.cols();
    if (columns.rows() < terms) return std::nullopt;
    const Coefficients lengths = columns.colwise().norm().transpose();
    if (!(lengths.minCoeff() > 0)) return std::nullopt;
    for (Eigen::Index k = 0; k < terms; ++k) columns.col(k) /= lengths(k);
    const Eigen::ColPivHouseholderQR<Design> qr(columns);
    const auto pivots = qr.matrixQR().diagonal().cwiseAbs();
    if (!(pivots(terms - 1) > min_pivot_ratio * pivots(0))) return std::nullopt;
    const Coefficients solution = qr.solve(right);
    if (!solution.allFinite()) return std::nullopt;
    return solution.cwiseQuotient(lengths);
}

FittedNormal jet_over(const Vec<3>& normal, std::span<const Vec<3>> offsets) {
    constexpr std::array<Eigen::Index, highest_degree + 1> enough{0, 0, 5, 12, 18};
    const PlaneFrame frame = principal_frame(normal, offsets);
    if (!frame.spans_plane()) return {};
    const auto rows = static_cast<Eigen::Index>(offsets.size());
    Design design(rows, max_terms - 1);  // no constant term: height 0 at the origin
    Column1 heights(rows);
    for (Eigen::Index r = 0; r < rows; ++r) {
        const Vec<3> at = frame.scaled(offsets[static_cast<std::size_t>(r)]);
        const double weight = pow(0.3 + at[0] * at[0] + at[1] * at[1], -1.5);
        const auto x = powers_of(at[0]), y = powers_of(at[1]);
        for (std::size_t k = 1; k < max_terms; ++k)
            design(r, static_cast<Eigen::Index>(k) - 1) = weight * x[exponents[k][0]] * y[exponents[k][1]];
        heights(r) = weight * at[2];
    }
    for (int degree = highest_degree; degree >= 2; --degree) {
        if (rows < enough[static_cast<std::size_t>(degree)]) continue;
        const auto c = solved(design.leftCols(terms_of(degree) - 1), heights);
        if (!c) continue;
        const auto& [x, y, z] = frame.axes.column;
        return {normalised(z - ((*c)(0) / frame.scale[0]) * x - ((*c)(1) / frame.scale[1]) * y), degree};
    }
    return {};
}

}  // namespace

FittedNormal fitted_normal(const Vec<3>& origin, const Vec<3>& normal, std::span<const Vec<3>> points) {
    std::vector<Vec<3>> offsets(std::min<std::size_t>(points.size(), max_rows));
    for (std::size_t i = 0; i < offsets.size(); ++i) offsets[i] = points[i] - origin;
    if (offsets.empty()) return {};
    const FittedNormal first = jet_over(normal, offsets);
    return first.degree == 0 ? first : jet_over(first.normal, offsets);
}

FittedHeight fitted_height(const Vec<3>& origin, const Vec<3>& normal, std::span<const PointAndNormal> samples) {
    constexpr int rows_per_sample = 3;
    constexpr double min_cosine = 0.2, slope_weight = 0.5, nearness = 0.05;
    const std::size_t count = std::min<std::size_t>(samples.size(), max_rows / rows_per_sample);
    std::vector<Vec<3>> offsets(count);
    for (std::size_t s = 0; s < count; ++s) offsets[s] = samples[s].point - origin;
    if (count == 0) return {};
    const PlaneFrame frame = principal_frame(normal, offsets);
    if (!frame.spans_plane()) return {};

    Design design(rows_per_sample * static_cast<Eigen::Index>(count), max_terms);
    Column1 right(design.rows());
    for (std::size_t s = 0; s < count; ++s) {
        const Vec<3> at = frame.scaled(offsets[s]), n = transposed_times(frame.axes, samples[s].normal);
        if (!(n[2] > min_cosine)) return {};
        const double weight = 1 / (nearness + at[0] * at[0] + at[1] * at[1]);
        const auto x = powers_of(at[0]), y = powers_of(at[1]);
        const Eigen::Index row = rows_per_sample * static_cast<Eigen::Index>(s);
        for (std::size_t k = 0; k < max_terms; ++k) {
            const auto [i, j] = exponents[k];
            const auto column = static_cast<Eigen::Index>(k);
            const double di = static_cast<double>(i), dj = static_cast<double>(j);
            design(row, column) = weight * x[i] * y[j];
            design(row + 1, column) = i == 0 ? 0 : slope_weight * weight * di * x[i - 1] * y[j];
            design(row + 2, column) = j == 0 ? 0 : slope_weight * weight * dj * x[i] * y[j - 1];
        }
        // The equations for the polynomial p are p(x, y) = z, p_x = −n_x/n_z and p_y = −n_y/n_z, with the sample's
        // normal n and scaled x and y.
        right(row) = weight * at[2];
        right(row + 1) = -slope_weight * weight * frame.scale[0] * n[0] / n[2];
        right(row + 2) = -slope_weight * weight * frame.scale[1] * n[1] / n[2];
    }
    for (int degree = highest_degree; degree >= 3; --degree)
        if (const auto c = solved(design.leftCols(terms_of(degree)), right)) return {(*c)(0), degree};
    return {};
}

namespace {

struct Fitter {
    const SurrogateInput<3>& input;
    const Fans& fans;
    double min_cosine = 0;
    const LinearMesh<3>& mesh = input.boundary.mesh;
    const EdgeSet<3>& edges = input.boundary.edges;
    const CurveTangents<3>& tangents = input.tangents;
    FileDirections<3> file_directions = FileDirections<3>(mesh.geometry.normals);

    [[nodiscard]] Vec<3> area_weighted(std::uint32_t fan) const {
        Vec<3> sum;
        for (const FacetId f : fans.facets[fan]) sum += area_vector(mesh, fans, f);
        return normalised(sum);
    }

    [[nodiscard]] Vec<3> file_normal(VertexId v, const Vec<3>& base) const {
        double best = min_cosine;
        Vec<3> out;
        for (const DirectionRow& at : file_directions.of(v)) {
            const Vec<3> normal = file_directions.unit(at);
            const double cosine = dot(normal, base);
            if (!(std::fabs(cosine) > best)) continue;
            best = std::fabs(cosine);
            out = cosine < 0 ? -normal : normal;
        }
        return out;
    }

    [[nodiscard]] bool is_bounded(std::uint32_t fan) const {
        return std::ranges::any_of(fans.facets[fan], [&](FacetId f) {
            const std::size_t i = corner_of(mesh.facets.vertices[f], fans.vertices[fan]);
            return !fans.neighbours[f][(i + 1) % 3].valid() || !fans.neighbours[f][(i + 2) % 3].valid();
        });
    }

    /// Plane of the fan's facets, or of the stencil's points if the fan has fewer than three facets. Beside a ridge,
    /// neighbouring fans are included, because on a cylinder a row of facets along a ridge is coplanar too.
    [[nodiscard]] FlatPatch<3> local_plane(std::uint32_t fan, std::span<const Vec<3>> stencil) const {
        std::vector<Vec<3>> points(stencil.begin(), stencil.end());
        points.push_back(mesh.points[fans.vertices[fan]]);
        if (fans.facets[fan].size() >= 3) {
            points.clear();
            const auto add = [&](std::uint32_t of) {
                for (const FacetId f : fans.facets[of])
                    for (const VertexId v : mesh.facets.vertices[f]) points.push_back(mesh.points[v]);
            };
            add(fan);
            if (is_bounded(fan))
                for (const FacetId f : fans.facets[fan])
                    for (const std::uint32_t other : fans.of_facets[f])
                        if (other != fan) add(other);
        }
        return plane_of<3>(points);
    }

    [[nodiscard]] std::vector<Vec<3>> border_tangents(std::uint32_t fan) const {
        constexpr int min_support = 3;
        const VertexId v = fans.vertices[fan];
        std::vector<Vec<3>> out;
        for (const FacetId f : fans.facets[fan])
            for (const EdgeId e : edges.of_facets[f]) {
                if (input.boundary.features.edge_kinds[e] != EdgeKind::ridge) continue;
                const auto& ends = edges.vertices[e];
                if (ends[0] != v && ends[1] != v) continue;
                const std::size_t row = tangents.row(e), end = ends[0] == v ? 0 : 1;
                if (tangents.supports[row][end] >= min_support) out.push_back(tangents.tangents[row][end]);
            }
        return out;
    }

    [[nodiscard]] Vec<3> perpendicular_to_ridges(std::uint32_t fan, const Vec<3>& normal) const {
        constexpr double min_sine = 0.3, min_agreement = 0.8;
        const auto borders = border_tangents(fan);
        if (borders.empty()) return normal;
        Vec<3> out = normal - dot(normal, borders[0]) * borders[0];
        if (borders.size() == 2) {
            const Vec<3> across = cross(borders[0], borders[1]);
            if (norm(across) > min_sine) out = dot(across, normal) < 0 ? -across : across;
        }
        out = normalised(out);
        return dot(out, normal) > min_agreement ? out : normal;
    }

    [[nodiscard]] std::vector<Vec<3>> points_around(std::uint32_t fan, const Vec<3>& base) const {
        std::vector<Vec<3>> points;
        for (const std::uint32_t other : rings(mesh, fans, fan, base, {}))
            points.push_back(mesh.points[fans.vertices[other]]);
        return points;
    }

    [[nodiscard]] Vec<3> fitted(std::uint32_t fan, const Vec<3>& base, std::span<const Vec<3>> points) const {
        constexpr double min_agreement = 0.5;
        const FittedNormal jet = fitted_normal(mesh.points[fans.vertices[fan]], base, points);
        return jet.degree > 0 && dot(jet.normal, base) > min_agreement ? jet.normal : Vec<3>{};
    }

    /// Normal of the prescribed surface if the fan continues that surface smoothly, else zero. Two fits are tested: a
    /// one-sided fit for jumps of the curvature, a two-sided fit for a narrow side of the junction.
    [[nodiscard]] Vec<3> prescribed(std::uint32_t fan, const Vec<3>& one_sided, std::vector<Vec<3>> points) const {
        constexpr double min_agreement = 0.7;
        constexpr double both_sides = 0.5;  // factor of the tolerance for two-sided fits: they are more accurate, and
                                            // show only half of a crease's angle
        const PrescribedNeighbour beyond = prescribed_neighbour(input.junctions, input.boundary, fans, fan, one_sided);
        if (!beyond.facet.valid() || dot(beyond.normal, one_sided) < min_agreement) return {};
        const auto agrees = [&](const Vec<3>& n, double tolerance) {
            return norm_squared(n) > 0 && atan2(norm(cross(n, beyond.normal)), dot(n, beyond.normal)) <= tolerance;
        };
        if (agrees(one_sided, beyond.tolerance)) return beyond.normal;
        const auto& facet = mesh.facets.vertices[beyond.facet];
        const std::uint32_t other = fans.of_facets[beyond.facet][corner_of(facet, fans.vertices[fan])];
        for (const Vec<3>& p : points_around(other, area_weighted(other)))
            if (std::ranges::find(points, p) == points.end()) points.push_back(p);
        return agrees(fitted(fan, beyond.normal, points), both_sides * beyond.tolerance) ? beyond.normal : Vec<3>{};
    }

    struct Normal {
        Vec<3> direction;
        bool is_prescribed = false;
    };
    [[nodiscard]] Normal operator()(std::uint32_t fan) const {
        const Vec<3> base = area_weighted(fan);
        const auto turned = [&](const Vec<3>& n) { return dot(n, base) < 0 ? -n : n; };
        const FlatPatch<3>& flat = input.flats[input.boundary.features.patches[fans.facets[fan][0]]];
        if (flat.is_flat()) return {turned(flat.normal)};
        if (fans.pointed[fan] != 0) return {};

        if (const Vec<3> normal = file_normal(fans.vertices[fan], base); norm_squared(normal) > 0) return {normal};

        const auto points = points_around(fan, base);
        if (const auto plane = local_plane(fan, points); plane.is_flat()) return {turned(plane.normal)};

        const Vec<3> jet = fitted(fan, base, points);
        const Vec<3> own = norm_squared(jet) > 0 ? jet : base;
        const Vec<3> beyond = prescribed(fan, own, points);
        return norm_squared(beyond) > 0 ? Normal{beyond, true} : Normal{perpendicular_to_ridges(fan, own)};
    }
};

}  // namespace

Outcome<FanNormals> fan_normals(const SurrogateInput<3>& input, const Fans& fans, double max_degrees,
                                const Execution& execution) {
    const Fitter fit{input, fans, max_degrees > 0 ? cos(max_degrees * std::numbers::pi / 180) : 2};
    Buffer<std::uint8_t> prescribed(fans.size());
    auto normals = map_each(
        execution, fans.size(),
        [&](std::size_t i) {
            const auto normal = fit(static_cast<std::uint32_t>(i));
            prescribed[i] = normal.is_prescribed ? 1 : 0;
            return normal.direction;
        },
        64);
    if (!normals) return fail(normals.error());
    return FanNormals{std::move(*normals), std::move(prescribed)};
}

}  // namespace camber
