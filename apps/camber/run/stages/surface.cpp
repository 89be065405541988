module;
#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>
module camber.run;
import camber.core;
import camber.config;
import camber.recipes;
import camber.surface;
import :report;
import :runner;
import :stages;
import :state;
import :steps;

namespace camber::run {

namespace {

template <int D>
FeatureOptions<D> by_angle(const config::Features& options) {
    return {.ridge_angle_degrees = options.ridge_angle};
}

template <class T, class More>
Column<T> with(const Column<T>& rows, const More& more) {
    Buffer<T> all(rows.begin(), rows.end());
    all.reserve(rows.size() + more.size());
    for (const auto& row : more) all.push_back(T(row));
    return all;
}

/// The features with those that the model has: its edges may be smooth, and its vertices lie on smooth curves.
template <int D>
Outcome<Features<D>> with_those_of_model(Features<D> features, LinearMesh<D> mesh, EdgeSet<D> edges,
                                         const MadeGeometry<D>& made, const FeatureOptions<D>& options,
                                         const Execution& execution) {
    if constexpr (D == 2) {
        return features;
    } else {
        const auto is_ridge = [&](EdgeId e) { return features.edge_kinds[e] == EdgeKind::ridge; };
        const auto is_corner = [&](VertexId v) { return features.vertex_kinds[v] == VertexKind::corner; };
        if (std::ranges::all_of(made.ridges, is_ridge) && std::ranges::all_of(made.corners, is_corner)) return features;
        std::vector<std::uint32_t> listed(made.ridges.size());
        std::iota(listed.begin(), listed.end(), static_cast<std::uint32_t>(mesh.edges.size()));
        std::vector<std::array<VertexId, 2>> ends;
        ends.reserve(made.ridges.size());
        for (const EdgeId e : made.ridges) ends.push_back(edges.vertices[e]);
        mesh.ridges = with(mesh.ridges, listed);
        mesh.corners = with(mesh.corners, made.corners);
        mesh.edges.vertices = with(mesh.edges.vertices, ends);
        mesh.edges.references = with(mesh.edges.references, std::vector<Reference>(ends.size(), 0));
        edges.of_edges = with(edges.of_edges, made.ridges);
        return find_features(mesh, edges, options, execution);
    }
}

/// Features and geometry of the boundary, by these breaks; of a mesh that was remeshed with the geometry that it has.
template <int D>
Outcome<DescribedBoundary<D>> described(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                        std::span<const LagrangeNode<D>> curves, const config::Pipeline& pipeline,
                                        const GeometrySource& source, const Inherited<D>* inherited,
                                        const Execution& execution) {
    const config::Features& options = pipeline.features;
    const FeatureOptions<D> breaks = inherited ? listed_breaks<D> : by_angle<D>(options);
    auto features = find_features(mesh, edges, breaks, part_of(execution, 0, 0.3));
    if (!features) return fail(features.error());
    auto made = inherited ? MadeGeometry<D>{inherited->geometry}
                          : make_geometry(pipeline.geometry, source, mesh, edges, *features, by_angle<D>(options),
                                          curves, part_of(execution, 0.3, 1));
    if (!made) return fail(made.error());
    if (made->misfit) return fail(*made->misfit);
    features = with_those_of_model(std::move(*features), mesh, edges, *made, breaks, without_progress(execution));
    if (!features) return fail(features.error());
    BoundaryReport report{features->surface_edges,
                          features->ridge_edges,
                          features->corners,
                          features->patch_count,
                          {},
                          {},
                          {},
                          made->cad};
    report.curved_patches = made->curved_patches;
    report.off_surfaces = made->off_surfaces;
    return DescribedBoundary<D>{{std::move(*features), options.required_boundary, std::move(made->geometry)}, report};
}

}  // namespace

template <int D>
Outcome<DescribedBoundary<D>> boundary_by_config(const config::Pipeline& pipeline, const GeometrySource& source,
                                                 const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                 const Execution& execution) {
    return described<D>(mesh, edges, {}, pipeline, source, nullptr, execution);
}

template <int D>
Outcome<Boundary<D>> describe_boundary(Runner<D>& run, const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                       std::span<const LagrangeNode<D>> curves) {
    const Inherited<D>* const inherited = run.state.inherited ? &*run.state.inherited : nullptr;
    auto made = run.step("surface", [&](const Execution& e) {
        return described(mesh, edges, curves, run.config, run.geometry, inherited, e);
    });
    if (!made) return fail(made.error());
    if (made->report.cad) made->report.cad->moves = run.state.cad_moves;
    run.report(made->report);
    return std::move(made->boundary);
}

#define CAMBER_INSTANTIATE(D)                                                                                       \
    template Outcome<DescribedBoundary<D>> boundary_by_config<D>(                                                   \
        const config::Pipeline&, const GeometrySource&, const LinearMesh<D>&, const EdgeSet<D>&, const Execution&); \
    template Outcome<Boundary<D>> describe_boundary<D>(Runner<D>&, const LinearMesh<D>&, const EdgeSet<D>&,         \
                                                       std::span<const LagrangeNode<D>>);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
