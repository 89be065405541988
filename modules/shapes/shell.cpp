module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>
#include <range/v3/action/sort.hpp>
#include <range/v3/action/unique.hpp>
module camber.shapes;
import camber.core;
import :prism_rows;

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
        return bad("the shell has too many points with these sizes");
    return Done{};
}

namespace {

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

/// Adds rows of prisms between the core's `facets` and spheres with these radii, in order from the core to the wall.
/// Vertices of the last sphere get `side`.
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

namespace {

template <int D>
std::size_t points_on_sphere(double radius, double size) {
    const double cover = D == 2 ? 2 * std::numbers::pi * radius / size
                                : 8 * std::numbers::pi * radius * radius / (std::numbers::sqrt3 * size * size);
    return std::max<std::size_t>(D == 2 ? 6 : 12, static_cast<std::size_t>(std::lround(cover)));
}

template <int D>
std::vector<double> level_radii(const ShellSizes& sizes) {
    const double height = D == 2 ? std::numbers::sqrt3 / 2 : std::numbers::sqrt2 / std::numbers::sqrt3;
    constexpr int samples = 4096;
    const double dr = (sizes.outer_radius - sizes.inner_radius) / samples;
    const auto middle = [&](int k) { return sizes.inner_radius + (k + 0.5) * dr; };
    double total = 0;
    for (int k = 0; k < samples; ++k) total += dr / (height * sizes.at(middle(k)));
    const int levels = std::max(1, static_cast<int>(std::lround(total)));
    std::vector<double> radii{sizes.inner_radius};
    double sum = 0;
    for (int k = 0; k < samples; ++k) {
        sum += dr / (height * sizes.at(middle(k)));
        if (sum * levels >= total * static_cast<double>(radii.size()) &&
            radii.size() < static_cast<std::size_t>(levels))
            radii.push_back(middle(k) + dr / 2);
    }
    radii.push_back(sizes.outer_radius);
    return radii;
}

template <int D>
void add_points(ShellCore<D>& core, double radius, std::size_t count, ShellSide side, double jitter,
                const Noise& noise) {
    for (const Vec<D>& p : spread_points<D>(count, noise)) {
        const Vec<D> moved = radius * p + jitter * noise.template vector<D>(core.points.size());
        core.points.push_back(side == ShellSide::between ? moved : radius * normalised(moved));
        core.sides.push_back(side);
    }
}

/// Projects boundary vertices onto their sphere. Keeps other vertices at least half an edge away from both spheres.
template <int D>
Vec<D> projected(const Vec<D>& p, ShellSide side, const ShellSizes& sizes) {
    if (side == ShellSide::inner) return sizes.inner_radius * normalised(p);
    if (side == ShellSide::outer) return sizes.outer_radius * normalised(p);
    const double gap = 0.5 * std::min({sizes.inner_size, sizes.outer_size, sizes.outer_radius - sizes.inner_radius});
    const double low = sizes.inner_radius + std::min(gap, 0.5 * sizes.inner_size);
    const double high = sizes.outer_radius - std::max(gap, 0.5 * sizes.outer_size);
    const double r = norm(p);
    return std::clamp(r, std::min(low, high), std::max(low, high)) / r * p;
}

template <int D>
Outcome<Buffer<SimplexVertices<D>>> triangulate_with_hole(const ShellCore<D>& core, const Noise& noise) {
    Buffer<Vec<D>> points = core.points;
    const VertexId centre(points.size());
    points.push_back({});
    auto elements = delaunay<D>(points, noise);
    if (elements)
        std::erase_if(*elements, [&](const auto& s) { return std::find(s.begin(), s.end(), centre) != s.end(); });
    return elements;
}

/// Moves vertices by one step of springs on all edges. A spring repels if its edge is shorter than 1.15 times the
/// target length.
template <int D>
Outcome<Done> spread(ShellCore<D>& core, const ShellSizes& sizes, const Execution& execution) {
    std::vector<std::array<VertexId, 2>> edges;
    for (const auto& s : core.elements)
        for (const auto& [i, j] : local_edges<D>) edges.push_back({std::min(s[i], s[j]), std::max(s[i], s[j])});
    edges |= ranges::actions::sort | ranges::actions::unique;
    std::vector<Vec<D>> push(core.points.size());
    for (const auto& [a, b] : edges) {
        const Vec<D> way = core.points[b.index()] - core.points[a.index()];
        const double target = 1.15 * sizes.at(norm(midpoint(core.points[a.index()], core.points[b.index()])));
        const double length = norm(way);
        if (length >= target) continue;
        push[b.index()] += 0.15 * (target - length) / length * way;
        push[a.index()] -= 0.15 * (target - length) / length * way;
    }
    return each(execution, core.points.size(),
                [&](std::size_t v) { core.points[v] = projected(core.points[v] + push[v], core.sides[v], sizes); });
}

template <int D>
double quality_of(const Buffer<Vec<D>>& p, const SimplexVertices<D>& s) {
    if constexpr (D == 2)
        return quality(p[s[0].index()], p[s[1].index()], p[s[2].index()]);
    else
        return quality(p[s[0].index()], p[s[1].index()], p[s[2].index()], p[s[3].index()]);
}

/// Moves the vertices of elements below quality `enough` at random. Returns the minimum quality before the moves.
template <int D>
Outcome<double> jitter_bad_elements(ShellCore<D>& core, const ShellSizes& sizes, double enough, const Noise& noise,
                                    const Execution& execution) {
    double worst = 1;
    std::vector<std::uint8_t> move(core.points.size(), 0);
    for (const auto& s : core.elements) {
        const double q = quality_of<D>(core.points, s);
        worst = std::min(worst, q);
        if (q < enough)
            for (const VertexId v : s) move[v.index()] = 1;
    }
    auto done = each(execution, core.points.size(), [&](std::size_t v) {
        if (move[v] == 0) return;
        const double step = (core.sides[v] == ShellSide::between ? 0.1 : 0.04) * sizes.at(norm(core.points[v]));
        core.points[v] = projected(core.points[v] + step * noise.template vector<D>(v), core.sides[v], sizes);
    });
    if (!done) return fail(done.error());
    return worst;
}

template <int D>
Outcome<Done> triangulate(ShellCore<D>& core, const Noise& noise) {
    auto elements = triangulate_with_hole(core, noise);
    if (!elements) return fail(elements.error());
    core.elements = std::move(*elements);
    return Done{};
}

/// Spreads points, then moves vertices of flat elements until none is flat or the iteration limit is reached. Among the
/// meshes of all these iterations, the result is the one with the highest minimum quality.
template <int D>
Outcome<Done> improve(ShellCore<D>& core, const ShellSizes& sizes, const Noise& noise, const Execution& execution) {
    constexpr int spreads = 8, max_jitter_rounds = 30;
    constexpr double enough = 0.15;
    const Execution quiet = without_progress(execution);
    for (int k = 0; k < spreads; ++k) {
        if (auto done = triangulate(core, noise); !done) return done;
        if (auto done = spread(core, sizes, quiet); !done) return done;
        report_progress(execution, static_cast<std::size_t>(k) + 1, spreads + max_jitter_rounds);
    }
    ShellCore<D> best;
    double best_worst = -2;
    for (int k = 0; k < max_jitter_rounds && best_worst < enough; ++k) {
        if (auto done = triangulate(core, noise); !done) return done;
        ShellCore<D> before = core;
        const auto worst = jitter_bad_elements(core, sizes, enough, noise.stream(200 + k), quiet);
        if (!worst) return fail(worst.error());
        report_progress(execution, static_cast<std::size_t>(spreads + k) + 1, spreads + max_jitter_rounds);
        if (*worst > best_worst) {
            best_worst = *worst;
            best = std::move(before);
        }
    }
    core = std::move(best);
    return Done{};
}

template <int D>
Outcome<Done> find_walls(ShellCore<D>& core, const Execution& execution) {
    LinearMesh<D> mesh;
    mesh.points = core.points;
    mesh.elements.vertices = core.elements;
    mesh.elements.references = Buffer<Reference>(core.elements.size(), Reference{1});
    auto around = balls(mesh, execution);
    if (!around) return fail(around.error());
    auto adjacent = neighbours(mesh, *around, execution);
    if (!adjacent) return fail(adjacent.error());
    for (const auto& [element, opposite] : boundary_faces<D>(*adjacent)) {
        SimplexVertices<D - 1> facet;
        const auto local = face_opposite<D>(static_cast<int>(opposite));
        for (int i = 0; i < D; ++i) facet[i] = core.elements[element.index()][local[i]];
        const ShellSide side = core.sides[facet[0].index()];
        for (const VertexId v : facet)
            if (side == ShellSide::between || core.sides[v.index()] != side)
                return fail(ErrorKind::usage, "the sizes are too coarse for the gap between the spheres");
        // Orders the vertices such that the facet and the outward direction are positively oriented. In 2D the edges
        // then run clockwise.
        if ((side == ShellSide::inner) == (D == 3)) std::swap(facet[0], facet[1]);
        (side == ShellSide::inner ? core.inner : core.outer).push_back(facet);
    }
    return Done{};
}

}  // namespace

double quality(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c) {
    const double squares = norm_squared(b - a) + norm_squared(c - b) + norm_squared(a - c);
    return 2 * std::numbers::sqrt3 * det(b - a, c - a) / squares;
}

double quality(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& d) {
    const double mean_square = (norm_squared(b - a) + norm_squared(c - a) + norm_squared(d - a) + norm_squared(c - b) +
                                norm_squared(d - b) + norm_squared(d - c)) /
                               6;
    return std::numbers::sqrt2 * det(b - a, c - a, d - a) / (mean_square * std::sqrt(mean_square));
}

template <int D>
Outcome<ShellCore<D>> unstructured_core(const ShellSizes& sizes, const Noise& noise, const Execution& execution) {
    ShellCore<D> core;
    const auto radii = level_radii<D>(sizes);
    for (std::size_t k = 0; k < radii.size(); ++k) {
        const double size = sizes.at(radii[k]);
        const ShellSide side = k == 0                  ? ShellSide::inner
                               : k + 1 == radii.size() ? ShellSide::outer
                                                       : ShellSide::between;
        add_points<D>(core, radii[k], points_on_sphere<D>(radii[k], size), side, sizes.jitter * size, noise.stream(k));
    }
    if (auto done = improve(core, sizes, noise, execution); !done) return fail(done.error());
    if (auto done = find_walls(core, without_progress(execution)); !done) return fail(done.error());
    return core;
}

template <int D>
PrismCounts prism_counts(const ShellSizes& sizes) {
    const double cuts = D == 2 ? 2 * std::numbers::pi * sizes.inner_radius / (5 * sizes.inner_size)
                               : 1.2046 * sizes.inner_radius / sizes.inner_size;
    // All levels have the same number of triangles, so triangles grow with the radius. Levels grow in proportion.
    const double ratio = 1 + 0.8 * sizes.inner_size / sizes.inner_radius;
    const double rows = log(sizes.outer_radius / sizes.inner_radius) / log(ratio);
    return {std::max(1.0, std::round(cuts)), std::max(1.0, std::round(rows))};
}

template <int D>
Outcome<ShellCore<D>> prism_core(const ShellSizes& sizes, int layers, const Noise& noise, const Execution& execution) {
    const PrismCounts counts = prism_counts<D>(sizes);
    auto sphere = icosphere<D>(static_cast<int>(counts.cuts));
    const auto rows = static_cast<std::size_t>(counts.rows);
    const std::size_t count = sphere.points.size();
    ShellCore<D> core;
    const PrismPlaces<D> places{sizes, row_radii(sizes, rows), std::move(sphere.points), noise};
    core.points = Buffer<Vec<D>>(places.size());
    core.sides = Buffer<ShellSide>(places.size());
    auto done = each(execution, places.size(), [&](std::size_t v) {
        core.points[v] = places.regular(v);
        core.sides[v] = places.side(v);
    });
    if (!done) return fail(done.error());
    core.elements.reserve(D * sphere.facets.size() * (rows + static_cast<std::size_t>(layers)));
    core.elements.resize(D * sphere.facets.size() * rows);
    done = extrude_rows<D>({sphere.facets, count, rows}, noise, 300, core.elements, execution);
    if (!done) return fail(done.error());
    core.inner = sphere.facets;
    core.outer = std::move(sphere.facets);
    for (auto& facet : core.outer)
        for (VertexId& v : facet) v = VertexId(v.index() + rows * count);
    done = move_points<D>(
        core.points, [&](std::size_t v) { return places.moved(v); },
        [&](std::span<const std::uint8_t>, const auto& look) { return look(core.elements); }, min_jittered_volume_ratio,
        execution);
    if (!done) return fail(done.error());
    done =
        each(execution, core.points.size(), [&](std::size_t v) { core.points[v] = places.settled(v, core.points[v]); });
    if (!done) return fail(done.error());
    return core;
}

#define CAMBER_INSTANTIATE(D)                                                                               \
    template Outcome<Done> check_shell<D>(const ShellOptions<D>&);                                          \
    template Outcome<LinearMesh<D>> generate<D>(const ShellOptions<D>&, const Execution&);                  \
    template Outcome<ShellCore<D>> unstructured_core<D>(const ShellSizes&, const Noise&, const Execution&); \
    template PrismCounts prism_counts<D>(const ShellSizes&);                                                \
    template Outcome<ShellCore<D>> prism_core<D>(const ShellSizes&, int, const Noise&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
