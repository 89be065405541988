module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <ranges>
#include <span>
#include <utility>

module camber.recipes;
import camber.core;
import camber.bezier;
import camber.surface;
import camber.metric;
import camber.curving;
import camber.repair;
import camber.validity;
import :boundary;
import :curve_input;

namespace camber {

namespace {

template <int D>
Outcome<Buffer<LagrangeNode<D>>> on_geometry(const QuadraticMesh<D>& mesh, const Boundary<D>& boundary,
                                             const EmbeddedCurves<D>& curves, const Execution& execution) {
    const QuadraticMesh<D> free = boundary.required == RequiredBoundary::keep ? mesh : without_required(mesh);
    auto nodes = boundary_nodes(free, boundary.features, boundary.geometry, part_of(execution, 0, 0.9));
    if (!nodes) return nodes;
    return nodes_on_curves(free, std::move(*nodes), curves, boundary.geometry, part_of(execution, 0.9, 1));
}

template <int D>
Outcome<CurveInput<D>> input_of(const QuadraticMesh<D>& mesh, const Boundary<D>& boundary,
                                const EmbeddedCurves<D>& curves, Buffer<LagrangeNode<D>> nodes, std::size_t kept,
                                const Execution& execution) {
    auto around = holders_of_edges(mesh, execution);
    if (!around) return fail(around.error());
    return CurveInput<D>{held_kinds(mesh, kinds_with_curves(boundary.features.edge_kinds, curves), boundary.required),
                         Column<LagrangeNode<D>>(std::move(nodes)), std::move(*around), kept};
}

/// Boundary nodes on the geometry.
template <int D>
Outcome<CurveInput<D>> input_of_elevated(const QuadraticMesh<D>& mesh, const Boundary<D>& boundary,
                                         const EmbeddedCurves<D>& curves, const Execution& execution) {
    auto nodes = on_geometry(mesh, boundary, curves, part_of(execution, 0, 0.33));
    if (!nodes) return fail(nodes.error());
    return input_of(mesh, boundary, curves, std::move(*nodes), 0, part_of(execution, 0.33, 1));
}

template <int D>
bool is_prescribed(const LinearMesh<D>& mesh, const Boundary<D>& boundary, std::span<const FacetId> facets) {
    return std::ranges::any_of(facets,
                               [&](FacetId f) { return boundary.geometry->prescribes(mesh.facets.references[f]); });
}

/// The same of a mesh with curves of its own: boundary nodes where they are, but for edges on prescribed
/// surfaces.
template <int D>
Outcome<CurveInput<D>> input_of_read(const QuadraticMesh<D>& mesh, const Boundary<D>& boundary,
                                     const EmbeddedCurves<D>& curves, const Execution& execution) {
    auto nodes = on_geometry(mesh, boundary, curves, part_of(execution, 0, 0.33));
    if (!nodes) return fail(nodes.error());
    const auto around = facet_shells(mesh.edges, without_progress(execution));
    if (!around) return fail(around.error());
    std::size_t kept = 0;
    for (std::size_t e = 0; e < nodes->size(); ++e) {
        if (boundary.features.edge_kinds[e] == EdgeKind::volume) continue;
        if (is_prescribed<D>(mesh.linear, boundary, (*around)[e])) continue;
        (*nodes)[e] = mesh.mid_nodes[e];
        ++kept;
    }
    return input_of(mesh, boundary, curves, std::move(*nodes), kept, part_of(execution, 0.33, 1));
}

}  // namespace

template <int D>
Outcome<CurveInput<D>> curve_input(const CurvedFrom<D>& from, const Execution& execution) {
    const bool is_read = from.nodes == NodesOf::input;
    const auto curves = find_embedded_curves<D>(
        from.mesh.linear, from.mesh.edges, from.boundary.features, from.boundary.geometry,
        is_read ? from.mesh.mid_nodes.view() : std::span<const LagrangeNode<D>>{}, without_progress(execution));
    if (!curves) return fail(curves.error());
    return is_read ? input_of_read(from.mesh, from.boundary, *curves, execution)
                   : input_of_elevated(from.mesh, from.boundary, *curves, execution);
}

template <int D>
Outcome<CurveInput<D>> slid_input(const CurvedFrom<D>& from, CurveInput<D> input, const BackMesh<D>& field,
                                  const CurveOptions& options, const Execution& execution) {
    if (options.aim != CurvingAim::accuracy || from.nodes == NodesOf::input) return input;
    auto shifts = accurate_offsets(from.mesh, input.kinds, EdgeKind::surface, input.shells, field, options,
                                   part_of(execution, 0, 0.05));
    if (!shifts) return fail(shifts.error());
    const QuadraticMesh<D> mesh =
        from.boundary.required == RequiredBoundary::keep ? from.mesh : without_required(from.mesh);
    const Column<LagrangeNode<D>>& present = input.base;
    auto nodes = slid_nodes<D>(mesh, present, *shifts, from.boundary.features, from.boundary.geometry,
                               part_of(execution, 0.05, 0.78));
    if (!nodes) return fail(nodes.error());
    Buffer<Vec<D>>& slides = *shifts;
    for (std::size_t e = 0; e < slides.size(); ++e) slides[e] = (*nodes)[e].point - present[e].point;
    if (options.metric_kind == MetricKind::natural) {
        const auto held =
            limit_smooth_loss<D>(from.mesh, input.shells, options.smooth_loss, slides, part_of(execution, 0.78, 0.82));
        if (!held) return fail(held.error());
        input.held_back += *held;
    }
    // A slide is worth no element; volume edges, which are where the field has them, have their say after it.
    auto borne = limit_by_jacobian<D>(from.mesh, present.view(), input.shells, options.min_jacobian, slides,
                                      part_of(execution, 0.82, 1));
    if (!borne) return fail(borne.error());
    input.drawn_back += *borne;
    for (std::size_t e = 0; e < slides.size(); ++e) (*nodes)[e].point = present[e].point + slides[e];
    input.base = std::move(*nodes);
    return input;
}

namespace {

/// Edges of a mesh with curves of its own stay, but for those on prescribed surfaces.
template <int D>
Outcome<Column<EdgeKind>> may_move(const CurvedFrom<D>& from, const Column<EdgeKind>& kinds,
                                   const Execution& execution) {
    if (from.nodes != NodesOf::input) return kinds;
    const auto around = facet_shells(from.mesh.edges, without_progress(execution));
    if (!around) return fail(around.error());
    Buffer<EdgeKind> held(kinds.begin(), kinds.end());
    for (std::size_t e = 0; e < held.size(); ++e)
        if (!is_prescribed<D>(from.mesh.linear, from.boundary, (*around)[e])) held[e] = EdgeKind::fixed;
    return Column<EdgeKind>(std::move(held));
}

}  // namespace

template <int D>
Outcome<CurveInput<D>> placed_input(const CurvedFrom<D>& from, CurveInput<D> input, const BackMesh<D>& field,
                                    const CurveOptions& edges, const PlacementOptions& options,
                                    const Execution& execution) {
    if (options.boundary_nodes == BoundaryNodeAim::projection) return input;
    return guarded([&]() -> Outcome<CurveInput<D>> {
        auto kinds = may_move(from, input.kinds, execution);
        if (!kinds) return fail(kinds.error());
        const auto placed = placed_nodes(from.mesh, *kinds, input.base, input.shells, from.boundary.features,
                                         from.boundary.geometry, field, edges, options, execution);
        if (!placed) return fail(placed.error());
        Buffer<LagrangeNode<D>> nodes(placed->size());
        for (std::size_t e = 0; e < nodes.size(); ++e) nodes[e] = (*placed)[e].node;
        input.base = std::move(nodes);
        input.placed = placement_statistics<D>(*placed);
        return std::move(input);
    });
}

namespace {

/// Whether no node of the boundary is off its chord's middle.
template <int D>
bool is_straight(const QuadraticMesh<D>& mesh, const CurveInput<D>& input) {
    const auto stays = [&](std::size_t e) {
        if (input.kinds[e] == EdgeKind::volume) return true;
        const auto& [a, b] = mesh.edges.vertices[e];
        return input.base[e].point == midpoint(mesh.linear.points[a], mesh.linear.points[b]);
    };
    return std::ranges::all_of(std::views::iota(std::size_t{0}, input.base.size()), stays);
}

}  // namespace

template <int D>
Outcome<CurveInput<D>> extended_in_planes(const CurvedFrom<D>& from, CurveInput<D> input, const Execution& execution) {
    if (D == 2 || from.nodes == NodesOf::input || is_surface_alone(from.mesh.linear) || is_straight(from.mesh, input))
        return input;
    const auto inside =
        edges_in_planes(from.mesh, from.boundary.features, from.boundary.geometry, part_of(execution, 0, 0.1));
    if (!inside) return fail(inside.error());
    Buffer<EdgeKind> free(input.kinds.begin(), input.kinds.end());
    for (std::size_t e = 0; e < free.size(); ++e)
        if ((*inside)[e] != 0 && free[e] == EdgeKind::surface) free[e] = EdgeKind::volume;
    const Column<EdgeKind> kinds(std::move(free));
    if (kinds == input.kinds) return input;
    const auto extended = extend_boundary(from.mesh, kinds, input.base, input.shells, {}, part_of(execution, 0.1, 0.9));
    if (!extended) return fail(extended.error());
    Buffer<Vec<D>> shifts(input.base.size(), Vec<D>{});
    for (std::size_t e = 0; e < shifts.size(); ++e)
        if (kinds[e] != input.kinds[e]) shifts[e] = extended->nodes[e].point - input.base[e].point;
    auto nodes = slid_nodes<D>(from.mesh, input.base, shifts, from.boundary.features, from.boundary.geometry,
                               part_of(execution, 0.9, 1));
    if (!nodes) return fail(nodes.error());
    input.base = std::move(*nodes);
    return input;
}

template <int D>
Outcome<CurveInput<D>> extended_input(const CurvedFrom<D>& from, CurveInput<D> input, const Execution& execution) {
    if (is_straight(from.mesh, input)) return input;
    auto extended = extend_boundary(from.mesh, input.kinds, input.base, input.shells, {}, execution);
    if (!extended) return fail(extended.error());
    input.extended = std::move(extended->nodes);
    return input;
}

#define CAMBER_INSTANTIATE(D)                                                                                        \
    template Outcome<CurveInput<D>> curve_input<D>(const CurvedFrom<D>&, const Execution&);                          \
    template Outcome<CurveInput<D>> extended_in_planes<D>(const CurvedFrom<D>&, CurveInput<D>, const Execution&);    \
    template Outcome<CurveInput<D>> extended_input<D>(const CurvedFrom<D>&, CurveInput<D>, const Execution&);        \
    template Outcome<CurveInput<D>> placed_input<D>(const CurvedFrom<D>&, CurveInput<D>, const BackMesh<D>&,         \
                                                    const CurveOptions&, const PlacementOptions&, const Execution&); \
    template Outcome<CurveInput<D>> slid_input<D>(const CurvedFrom<D>&, CurveInput<D>, const BackMesh<D>&,           \
                                                  const CurveOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
