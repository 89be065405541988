module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>
module camber.shapes;
import camber.core;

namespace camber {

namespace {

Outcome<Done> check(const BumpOptions& o) {
    const auto bad = [](const char* what) { return fail(ErrorKind::usage, what); };
    if (!(o.length > 0 && o.height > 0)) return bad("a channel needs a positive length and height");
    if (o.cells[0] < 2 || o.cells[1] < 1) return bad("a channel needs at least 2 × 1 cells");
    if (!(o.bump_width > 0 && o.bump_width <= o.length))
        return bad("the bump must be narrower than the channel is long");
    if (!(std::abs(o.bump_height) + thickness(o.floor_layer) < o.height))
        return bad("bump and layers must be lower than the channel");
    if (!(expected_elements(o) < static_cast<double>(max_entities))) return bad("a channel of too many cells");
    return Done{};
}

/// Heights of the rows of vertices over a flat floor: the layers, then equal cells.
std::vector<double> row_heights(const BumpOptions& o) {
    std::vector<double> rows{0};
    for (const double d : layer_distances(o.floor_layer)) rows.push_back(d);
    const double start = rows.back();
    for (int k = 1; k <= o.cells[1]; ++k)
        rows.push_back(std::lerp(start, o.height, static_cast<double>(k) / o.cells[1]));
    return rows;
}

/// Lifts a point of the flat channel: layers rise with the floor, what is above is squeezed between them and the
/// ceiling.
Vec<2> lifted(const BumpOptions& o, const Vec<2>& p) {
    const double top = thickness(o.floor_layer);
    const double part = p[1] <= top ? 1.0 : (o.height - p[1]) / (o.height - top);
    return {{p[0], p[1] + part * floor_height(o, p[0])}};
}

/// The points of the unit lattice in the channel, and where jitter would have them.
Outcome<Buffer<Vec<2>>> place_points(Lattice<2>& lattice, const BumpOptions& options, const std::vector<double>& rows,
                                     const Execution& execution) {
    const int layers = options.floor_layer.count;
    const Noise noise = Noise{options.seed}.stream(100);
    const Vec<2> cell{{options.length / options.cells[0], (options.height - rows[layers]) / options.cells[1]}};
    return map_each(execution, lattice.points.size(), [&](std::size_t v) {
        const auto [column, row] = lattice.place(v);
        Vec<2> p{{std::lerp(0.0, options.length, lattice.points[v][0]), rows[row]}};
        Vec<2> shifted = p;
        const Vec<2> shift = options.jitter * noise.vector<2>(v);
        // A column of the layers moves as one along the floor, so that its heights stay what was asked.
        const bool within_layers = row <= layers;
        if (column > 0 && column < options.cells[0])
            shifted[0] += cell[0] * (within_layers ? options.jitter * noise.symmetric(column, 1) : shift[0]);
        if (!within_layers && row + 1 < static_cast<int>(rows.size())) shifted[1] += cell[1] * shift[1];
        lattice.points[v] = lifted(options, p);
        return lifted(options, shifted);
    });
}

Outcome<LinearMesh<2>> generate_bump(const BumpOptions& options, const Execution& execution) {
    if (auto checked = check(options); !checked) return fail(checked.error());
    const auto rows = row_heights(options);
    const int layers = options.floor_layer.count;
    auto made = lattice_of<2>({options.cells[0], static_cast<int>(rows.size()) - 1}, options.seed, execution);
    if (!made) return fail(made.error());
    Lattice<2>& lattice = *made;
    const auto moved = place_points(lattice, options, rows, execution);
    if (!moved) return fail(moved.error());
    auto jittered = move_points<2>(lattice.points, *moved, lattice.elements, 0.2, execution);
    if (!jittered) return fail(jittered.error());
    // Halved moves are chords of the lift: put the floor exactly back onto the bump.
    auto on_floor = each(execution, lattice.points.size(), [&](std::size_t v) {
        if (lattice.place(v)[1] == 0) lattice.points[v][1] = floor_height(options, lattice.points[v][0]);
    });
    if (!on_floor) return fail(on_floor.error());
    auto points = std::move(lattice.points);
    auto elements = std::move(lattice.elements);
    auto materials = map_each(execution, elements.size(), [&](std::size_t e) {
        const bool in_layers =
            std::ranges::all_of(elements[e], [&](VertexId v) { return lattice.place(v.index())[1] <= layers; });
        return in_layers ? options.floor_layer.material : Reference{1};
    });
    if (!materials) return fail(materials.error());
    return bounded_mesh<2>(
        std::move(points), std::move(elements), std::move(*materials),
        [&](const SimplexVertices<1>& facet) {
            const Reference side = lattice.side(facet);
            return side != 0 ? side : options.floor_layer.interface;
        },
        [&](VertexId v) { return lattice.on_boundary(v.index()) || lattice.place(v.index())[1] == layers; }, execution);
}

}  // namespace

double floor_height(const BumpOptions& o, double x) {
    const double s = 2 * (x - o.length / 2) / o.bump_width;
    const double inside = 1 - s * s;
    return inside > 0 ? o.bump_height * inside * inside * inside : 0.0;
}

Outcome<LinearMesh<2>> generate(const BumpOptions& options, const Execution& execution) {
    return guarded([&] { return generate_bump(options, execution); });
}

}  // namespace camber
