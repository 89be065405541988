module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <range/v3/action/sort.hpp>
#include <range/v3/action/unique.hpp>
module camber.shapes;
import camber.core;

namespace camber {

namespace {

/// About how many points a shell takes: volume over that of a regular simplex' share of a point, and the layers.
template <int D>
double expected_points(const ShellOptions<D>& o) {
    const auto on_sphere = [](double radius, double size) {
        return D == 2 ? 2 * std::numbers::pi * radius / size
                      : 8 * std::numbers::pi * radius * radius / (std::numbers::sqrt3 * size * size);
    };
    constexpr int samples = 1024;
    const double step = (o.outer_radius - o.inner_radius) / samples;
    double points = (o.inner_layer.count + 1) * on_sphere(o.inner_radius, o.inner_size) +
                    (o.outer_layer.count + 1) * on_sphere(o.outer_radius, o.outer_size);
    for (int k = 0; k < samples; ++k) {
        const double share = (k + 0.5) / samples;
        const double size = std::lerp(o.inner_size, o.outer_size, share);
        points += on_sphere(std::lerp(o.inner_radius, o.outer_radius, share), size) * step / size;
    }
    return points;
}

template <int D>
Outcome<Done> check(const ShellOptions<D>& o) {
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
    if (!(expected_points(o) * 6 < static_cast<double>(max_entities)))
        return bad("a shell of too many points for these sizes");
    return Done{};
}

/// Rows of prisms from `facets` (of the core) to spheres of these radii, one after the other; the last row's vertices
/// become the side's. Radii fall towards the inner sphere and rise towards the outer one.
template <int D>
void add_layers(ShellCore<D>& core, std::span<const SimplexVertices<D - 1>> facets, std::span<const double> radii,
                ShellSide side, const Noise& noise) {
    const std::size_t base_points = core.points.size();
    std::vector<VertexId> last(base_points);
    std::vector<VertexId> used;
    for (const auto& facet : facets) used.insert(used.end(), facet.begin(), facet.end());
    used |= ranges::actions::sort | ranges::actions::unique;
    for (const VertexId v : used) last[v.index()] = v;
    for (std::size_t k = 0; k < radii.size(); ++k) {
        std::vector<VertexId> next(base_points);
        for (const VertexId v : used) {
            next[v.index()] = VertexId(core.points.size());
            core.points.push_back(radii[k] * normalised(core.points[v.index()]));
            core.sides.push_back(side);
            core.sides[last[v.index()].index()] = k > 0                      ? ShellSide::between
                                                  : side == ShellSide::inner ? ShellSide::above_inner_layer
                                                                             : ShellSide::above_outer_layer;
        }
        const bool inwards = side == ShellSide::inner;
        extrude<D>(facets, inwards ? next : last, inwards ? last : next, noise.stream(k), core.elements);
        last = std::move(next);
    }
}

/// Adds the layers; the materials of all elements.
template <int D>
Buffer<Reference> add_layers(ShellCore<D>& core, const ShellOptions<D>& o, const Noise& noise) {
    std::vector<double> inner, outer;
    for (const double d : layer_distances(o.inner_layer)) inner.push_back(o.inner_radius + d);
    for (const double d : layer_distances(o.outer_layer)) outer.push_back(o.outer_radius - d);
    // From the core to the wall: the last distance is the core's own sphere.
    const auto to_wall = [](std::vector<double>& radii, double wall) {
        if (radii.empty()) return;
        radii.pop_back();
        std::reverse(radii.begin(), radii.end());
        radii.push_back(wall);
    };
    to_wall(inner, o.inner_radius);
    to_wall(outer, o.outer_radius);
    Buffer<Reference> materials(core.elements.size(), Reference{1});
    add_layers<D>(core, core.inner, inner, ShellSide::inner, noise.stream(1));
    materials.resize(core.elements.size(), o.inner_layer.material);
    add_layers<D>(core, core.outer, outer, ShellSide::outer, noise.stream(2));
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

}  // namespace

template <int D>
Outcome<LinearMesh<D>> generate(const ShellOptions<D>& options) {
    if (auto checked = check(options); !checked) return fail(checked.error());
    const Noise noise{options.seed};
    const ShellSizes sizes{options.inner_radius + thickness(options.inner_layer),
                           options.outer_radius - thickness(options.outer_layer), options.inner_size,
                           options.outer_size, options.jitter};
    Outcome<ShellCore<D>> core;
    if (options.structure == ShellStructure::prisms)
        core = prism_core<D>(sizes, noise);
    else
        core = unstructured_core<D>(sizes, noise);
    if (!core) return fail(core.error());
    Buffer<Reference> materials = add_layers(*core, options, noise.stream(400));
    for (Vec<D>& p : core->points) p += options.centre;
    const Buffer<ShellSide> sides = std::move(core->sides);
    return bounded_mesh<D>(
        std::move(core->points), std::move(core->elements), std::move(materials),
        [&](const SimplexVertices<D - 1>& facet) { return reference_on(sides[facet[0].index()], options); });
}

template Outcome<LinearMesh<2>> generate<2>(const ShellOptions<2>&);
template Outcome<LinearMesh<3>> generate<3>(const ShellOptions<3>&);

}  // namespace camber
