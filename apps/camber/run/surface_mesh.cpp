module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <utility>
#include <vector>
module camber.run;
import camber.core;
import camber.bezier;
import camber.io;
import camber.surface;
import :surface_mesh;

namespace camber::run {

namespace {

constexpr int degree = 6;

template <int D>
constexpr auto lattice = [] {
    std::array<Barycentric<D - 1>, node_count<degree, D - 1>> all{};
    for (std::size_t n = 0; n < all.size(); ++n)
        for (std::size_t i = 0; i < D; ++i)
            all[n][i] = static_cast<double>(multi_indices<degree, D - 1>[n][i]) / degree;
    return all;
}();

/// The lattice's point at α with one more in some places.
template <int K>
std::uint32_t point_at(MultiIndex<K> alpha, std::initializer_list<std::size_t> more) {
    for (const std::size_t i : more) ++alpha[i];
    return static_cast<std::uint32_t>(position<degree, K>(alpha));
}

/// The small facets between the points of a lattice, turned as the large one.
std::vector<std::array<std::uint32_t, 2>> small_facets_2d() {
    std::vector<std::array<std::uint32_t, 2>> all;
    all.reserve(degree);
    for (const auto& alpha : multi_indices<degree - 1, 1>)
        all.push_back({point_at<1>(alpha, {0}), point_at<1>(alpha, {1})});
    return all;
}
std::vector<std::array<std::uint32_t, 3>> small_facets_3d() {
    std::vector<std::array<std::uint32_t, 3>> all;
    all.reserve(degree * degree);
    for (const auto& alpha : multi_indices<degree - 1, 2>)
        all.push_back({point_at<2>(alpha, {0}), point_at<2>(alpha, {1}), point_at<2>(alpha, {2})});
    for (const auto& alpha : multi_indices<degree - 2, 2>)
        all.push_back({point_at<2>(alpha, {0, 1}), point_at<2>(alpha, {1, 2}), point_at<2>(alpha, {2, 0})});
    return all;
}
template <int D>
auto small_facets() {
    if constexpr (D == 2)
        return small_facets_2d();
    else
        return small_facets_3d();
}

Vec<2> normal_of(const std::array<Vec<2>, 2>& c) { return normalised(Vec<2>{{c[1][1] - c[0][1], c[0][0] - c[1][0]}}); }
Vec<3> normal_of(const std::array<Vec<3>, 3>& c) { return normalised(cross(c[1] - c[0], c[2] - c[0])); }

/// Points and normals over one facet.
template <int D>
void sample(const Geometry<D>& geometry, const FacetSite<D>& site, std::span<Vec<D>> points,
            std::span<Vec<D>> normals) {
    const bool has_surface = geometry->points_over(site, lattice<D>, points);
    const Vec<D> own = normal_of(site.corners);
    const SurfaceHint hint{.facet = site.id, .reference = site.reference, .entity = geometry->surface_at(site)};
    for (std::size_t n = 0; n < points.size(); ++n) {
        if (!has_surface) {
            points[n] = {};
            for (std::size_t i = 0; i < D; ++i) points[n] += lattice<D>[n][i] * site.corners[i];
        }
        normals[n] = has_surface ? geometry->project(hint, points[n]).normal : own;
        // A surface has its own side; shown is that of the facet.
        if (dot(normals[n], own) < 0) normals[n] = -normals[n];
    }
}

template <int D>
MeshField vectors(const Column<Vec<D>>& values) {
    Buffer<double> column(values.size() * D);
    for (std::size_t n = 0; n < values.size(); ++n)
        std::copy(values[n].c.begin(), values[n].c.end(), column.begin() + static_cast<std::ptrdiff_t>(n * D));
    return {"normal", Centring::node, FieldKind::vector, Column<double>(std::move(column))};
}

}  // namespace

template <int D>
Outcome<SurfaceMesh> surface_mesh(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                  const Geometry<D>& geometry, const Execution& execution) {
    constexpr std::size_t n = lattice<D>.size();
    const auto small = small_facets<D>();
    const std::size_t facets = mesh.linear.facets.size(), m = small.size();
    Buffer<Vec<D>> points(facets * n), normals(facets * n);
    Buffer<SimplexVertices<D - 1>> vertices(facets * m);
    Buffer<Reference> references(facets * m), of_points(facets * n);
    Buffer<std::int32_t> numbers(facets * m), patches(facets * m);
    std::fill(of_points.begin(), of_points.end(), 0);
    auto done = each(
        execution, facets,
        [&](std::size_t f) {
            sample(geometry, facet_site(mesh.linear, FacetId(f)), std::span(points).subspan(f * n, n),
                   std::span(normals).subspan(f * n, n));
            for (std::size_t k = 0; k < m; ++k) {
                for (std::size_t i = 0; i < D; ++i) vertices[f * m + k][i] = VertexId(f * n + small[k][i]);
                references[f * m + k] = mesh.linear.facets.references[f];
                numbers[f * m + k] = static_cast<std::int32_t>(f + 1);
                patches[f * m + k] = static_cast<std::int32_t>(features.patches[f]);
            }
        },
        64);
    if (!done) return fail(done.error());
    LinearMesh<D> out;
    out.points = std::move(points);
    out.point_references = std::move(of_points);
    out.facets.vertices = std::move(vertices);
    out.facets.references = std::move(references);
    const auto of_cells = [](const char* name, Buffer<std::int32_t> values) {
        return MeshField{name, Centring::cell, FieldKind::scalar, Column<std::int32_t>(std::move(values))};
    };
    return SurfaceMesh{AnyMesh(std::move(out)),
                       MeshFields({vectors<D>(Column<Vec<D>>(std::move(normals))),
                                   of_cells("facet", std::move(numbers)), of_cells("patch", std::move(patches))})};
}

#define CAMBER_INSTANTIATE(D)                                                                                      \
    template Outcome<SurfaceMesh> surface_mesh<D>(const QuadraticMesh<D>&, const Features<D>&, const Geometry<D>&, \
                                                  const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
