module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <range/v3/action/sort.hpp>
#include <range/v3/action/unique.hpp>
module camber.shapes;
import camber.core;
import :prism_places;

namespace camber {

template <int D>
Outcome<Done> check_shell(const ShellOptions<D>& o) {
    const auto bad = [](std::string what) { return fail(ErrorKind::usage, std::move(what)); };
    if (!(o.inner_radius > 0 && o.outer_radius > o.inner_radius))
        return bad("a shell needs 0 < inner radius < outer radius");
    if (!(o.inner_size > 0 && o.outer_size > 0)) return bad("a shell needs positive sizes");
    if (!(o.jitter >= 0 && o.jitter <= 0.3)) return bad("jitter must be in [0, 0.3]");
    for (const BoundaryLayer* layer : {&o.inner_layer, &o.outer_layer})
        if (layer->count < 0 || (layer->count > 0 && !(layer->first_height > 0 && layer->growth > 0)))
            return bad("a boundary layer needs a positive first height and growth");
    if (!(thickness(o.inner_layer) + thickness(o.outer_layer) < o.outer_radius - o.inner_radius))
        return bad("the boundary layers are thicker than the shell");
    if (!(expected_elements(o) < static_cast<double>(max_entities)))
        return bad("a shell of too many points for these sizes");
    return Done{};
}

namespace {

/// The vertices of the facets, rising; the facets then name them by their places there.
template <int D>
std::vector<VertexId> own_numbers(Buffer<SimplexVertices<D - 1>>& facets) {
    std::vector<VertexId> used;
    used.reserve(D * facets.size());
    for (const auto& facet : facets) used.insert(used.end(), facet.begin(), facet.end());
    used |= ranges::actions::sort | ranges::actions::unique;
    const std::size_t first = used.empty() ? 0 : used.front().index();
    std::vector<VertexId> number(used.empty() ? 0 : used.back().index() - first + 1);
    for (std::size_t k = 0; k < used.size(); ++k) number[used[k].index() - first] = VertexId(k);
    for (auto& facet : facets)
        for (VertexId& v : facet) v = number[v.index() - first];
    return used;
}

/// Rows of prisms from `facets` (of the core) to spheres of these radii, one after the other; the last row's vertices
/// become the side's. Radii fall towards the inner sphere and rise towards the outer one.
template <int D>
Outcome<Done> add_layers(ShellCore<D>& core, Buffer<SimplexVertices<D - 1>> facets, std::span<const double> radii,
                         ShellSide side, const Noise& noise, const Execution& execution) {
    if (radii.empty()) return Done{};
    const std::vector<VertexId> wall = own_numbers<D>(facets);
    const bool inwards = side == ShellSide::inner;
    const std::size_t n = wall.size(), old_points = core.points.size(), old_elements = core.elements.size();
    for (const VertexId v : wall)
        core.sides[v.index()] = inwards ? ShellSide::above_inner_layer : ShellSide::above_outer_layer;
    core.points.resize(old_points + radii.size() * n);
    core.sides.resize(core.points.size(), ShellSide::between);
    std::fill(core.sides.end() - static_cast<std::ptrdiff_t>(n), core.sides.end(), side);
    core.elements.resize(old_elements + radii.size() * D * facets.size());
    Buffer<std::uint64_t> ranks(n);
    for (std::size_t k = 0; k < radii.size(); ++k) {
        const Noise of_row = noise.stream(k);
        const auto next = [&](VertexId v) { return VertexId(old_points + k * n + v.index()); };
        const auto last = [&](VertexId v) { return k == 0 ? wall[v.index()] : VertexId(next(v).index() - n); };
        auto done = each(execution, n, [&](std::size_t v) {
            ranks[v] = of_row.bits(wall[v].index());
            core.points[next(VertexId(v)).index()] = radii[k] * normalised(core.points[wall[v].index()]);
        });
        if (!done) return done;
        const std::span row = std::span(core.elements).subspan(old_elements + k * D * facets.size(), D * facets.size());
        done = inwards ? extrude<D>(facets, ranks, next, last, row, execution)
                       : extrude<D>(facets, ranks, last, next, row, execution);
        if (!done) return done;
    }
    return Done{};
}

/// Adds the layers; the materials of all elements.
template <int D>
Outcome<Buffer<Reference>> add_layers(ShellCore<D>& core, const ShellOptions<D>& o, const Noise& noise,
                                      const Execution& execution) {
    const std::vector<double> inner = inner_layer_radii(o), outer = outer_layer_radii(o);
    Buffer<Reference> materials;
    const std::size_t facets = core.inner.size() * inner.size() + core.outer.size() * outer.size();
    materials.reserve(core.elements.size() + D * facets);
    materials.resize(core.elements.size(), Reference{1});
    auto done = add_layers<D>(core, std::move(core.inner), inner, ShellSide::inner, noise.stream(1), execution);
    if (!done) return fail(done.error());
    materials.resize(core.elements.size(), o.inner_layer.material);
    done = add_layers<D>(core, std::move(core.outer), outer, ShellSide::outer, noise.stream(2), execution);
    if (!done) return fail(done.error());
    materials.resize(core.elements.size(), o.outer_layer.material);
    return materials;
}

template <int D>
Reference reference_on(ShellSide side, const ShellOptions<D>& o) {
    switch (side) {
        case ShellSide::inner: return o.inner_reference;
        case ShellSide::above_inner_layer: return o.inner_layer.interface;
        case ShellSide::above_outer_layer: return o.outer_layer.interface;
        default: return o.outer_reference;
    }
}

template <int D>
Outcome<ShellCore<D>> core_of(const ShellOptions<D>& options, const Noise& noise, const Execution& execution) {
    const ShellSizes sizes = core_sizes(options);
    if (options.structure == ShellStructure::prisms)
        return prism_core<D>(sizes, options.inner_layer.count + options.outer_layer.count, noise, execution);
    return unstructured_core<D>(sizes, noise, execution);
}

template <int D>
Outcome<LinearMesh<D>> generate_shell(const ShellOptions<D>& options, const Execution& execution) {
    if (auto checked = check_shell(options); !checked) return fail(checked.error());
    const Noise noise{options.seed};
    auto core = core_of(options, noise, execution);
    if (!core) return fail(core.error());
    auto materials = add_layers(*core, options, noise.stream(400), without_progress(execution));
    if (!materials) return fail(materials.error());
    auto moved = each(execution, core->points.size(), [&](std::size_t v) { core->points[v] += options.centre; });
    if (!moved) return fail(moved.error());
    const Buffer<ShellSide> sides = std::move(core->sides);
    return bounded_mesh<D>(
        std::move(core->points), std::move(core->elements), std::move(*materials),
        [&](const SimplexVertices<D - 1>& facet) { return reference_on(sides[facet[0].index()], options); },
        [&](VertexId v) { return sides[v.index()] != ShellSide::between; }, execution);
}

}  // namespace

template <int D>
Outcome<LinearMesh<D>> generate(const ShellOptions<D>& options, const Execution& execution) {
    return guarded([&] { return generate_shell(options, execution); });
}

#define CAMBER_INSTANTIATE(D)                                      \
    template Outcome<Done> check_shell<D>(const ShellOptions<D>&); \
    template Outcome<LinearMesh<D>> generate<D>(const ShellOptions<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
