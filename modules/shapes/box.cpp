// Generates boxes and channels as a whole or by rows; estimates the number of elements of shapes.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.shapes;
import camber.core;
import :prism_rows;

namespace camber {

template <int D>
Outcome<Buffer<SimplexVertices<D>>> lattice_simplices(std::span<const int, D> cells, const Noise& noise,
                                                      const Execution& execution) {
    if constexpr (D == 1) {
        return map_each(execution, static_cast<std::size_t>(cells[0]),
                        [](std::size_t i) { return SimplexVertices<1>{VertexId(i), VertexId(i + 1)}; });
    } else {
        const auto base = lattice_simplices<D - 1>(cells.template first<D - 1>(), noise, execution);
        if (!base) return fail(base.error());
        std::size_t row = 1;
        for (int i = 0; i + 1 < D; ++i) row *= static_cast<std::size_t>(cells[i]) + 1;
        const auto rows = static_cast<std::size_t>(cells[D - 1]);
        Buffer<SimplexVertices<D>> simplices(D * base->size() * rows);
        auto done = extrude_rows<D>({*base, row, rows}, noise.stream(D), 0, simplices, execution);
        if (!done) return fail(done.error());
        return simplices;
    }
}

template <int D>
Outcome<Done> check_box(const BoxOptions<D>& options) {
    double vertices = 1;
    for (int i = 0; i < D; ++i) {
        if (options.cells[i] < 1) return fail(ErrorKind::usage, "a box needs at least one cell along each axis");
        if (!(options.high[i] > options.low[i])) return fail(ErrorKind::usage, "a box needs high above low");
        vertices *= options.cells[i] + 1.0;
    }
    if (vertices * 6 > static_cast<double>(max_entities)) return fail(ErrorKind::usage, "the box has too many cells");
    return Done{};
}

namespace {

template <int D>
Outcome<LinearMesh<D>> generate_box(const BoxOptions<D>& options, const Execution& execution) {
    if (auto checked = check_box(options); !checked) return fail(checked.error());
    auto lattice = lattice_of<D>(options.cells, options.seed, execution);
    if (!lattice) return fail(lattice.error());
    const BoxPlaces<D> places(options);
    Buffer<Vec<D>>& at = lattice->points;
    const ElementRuns<D> all = [&](std::span<const std::uint8_t>, const auto& look) { return look(lattice->elements); };
    auto done = each(execution, at.size(), [&](std::size_t v) { at[v] = places.regular(v); });
    if (done && places.bends())
        done = move_points<D>(
            at, [&](std::size_t v) { return places.bent(v, at[v]); }, all, min_warped_volume_ratio, execution);
    if (done)
        done = move_points<D>(
            at, [&](std::size_t v) { return places.jittered(v, at[v]); }, all, min_jittered_volume_ratio, execution);
    if (!done) return fail(done.error());
    auto points = std::move(lattice->points);
    auto elements = std::move(lattice->elements);
    return bounded_mesh<D>(
        std::move(points), std::move(elements),
        [&](const SimplexVertices<D - 1>& facet) { return lattice->side(facet); },
        [&](VertexId v) { return lattice->on_boundary(v.index()); }, execution);
}

}  // namespace

template <int D>
Outcome<Lattice<D>> lattice_of(const std::array<int, D>& cells, std::uint64_t seed, const Execution& execution) {
    auto elements = lattice_simplices<D>(std::span<const int, D>(cells), Noise{seed}, execution);
    if (!elements) return fail(elements.error());
    Lattice<D> lattice{cells, {}, std::move(*elements)};
    std::size_t count = 1;
    for (const int n : cells) count *= static_cast<std::size_t>(n) + 1;
    auto points = map_each(execution, count, [&](std::size_t v) {
        const auto place = lattice.place(v);
        Vec<D> p;
        for (int i = 0; i < D; ++i) p[i] = static_cast<double>(place[i]) / cells[i];
        return p;
    });
    if (!points) return fail(points.error());
    lattice.points = std::move(*points);
    return lattice;
}

template <int D>
Outcome<LinearMesh<D>> generate(const BoxOptions<D>& options, const Execution& execution) {
    return guarded([&] { return generate_box(options, execution); });
}

template Outcome<Buffer<SimplexVertices<1>>> lattice_simplices<1>(std::span<const int, 1>, const Noise&,
                                                                  const Execution&);
template Outcome<Buffer<SimplexVertices<2>>> lattice_simplices<2>(std::span<const int, 2>, const Noise&,
                                                                  const Execution&);
template Outcome<Done> check_box<2>(const BoxOptions<2>&);
template Outcome<Done> check_box<3>(const BoxOptions<3>&);
template Outcome<Lattice<2>> lattice_of<2>(const std::array<int, 2>&, std::uint64_t, const Execution&);
template Outcome<Lattice<3>> lattice_of<3>(const std::array<int, 3>&, std::uint64_t, const Execution&);
template Outcome<LinearMesh<2>> generate<2>(const BoxOptions<2>&, const Execution&);
template Outcome<LinearMesh<3>> generate<3>(const BoxOptions<3>&, const Execution&);

namespace {

/// Adds segments along the 12 edges of a 3D box. An edge belongs to two sides; its reference is the position of this
/// pair among the pairs in ascending order.
void add_edges(const Lattice<3>& lattice, LinearMesh<3>& mesh) {
    struct Segment {
        std::array<VertexId, 2> ends;
        Reference number;
    };
    const auto vertex = [&](const std::array<int, 3>& at) {
        const std::size_t x = lattice.cells[0] + std::size_t{1}, y = lattice.cells[1] + std::size_t{1};
        return VertexId(static_cast<std::size_t>(at[0]) + x * (at[1] + y * at[2]));
    };
    constexpr std::array<std::array<int, 2>, 3> sides_along{{{1, 2}, {0, 2}, {0, 1}}};
    // In ascending order, the pairs of side references are (1, 3), (1, 4), (1, 5), (1, 6), (2, 3) … (4, 6).
    constexpr std::array<int, 3> first_number{9, 3, 1}, numbers_a_side{2, 4, 4};
    std::vector<Segment> segments;
    for (int axis = 0; axis < 3; ++axis) {
        const auto [i, j] = sides_along[axis];
        for (int ends = 0; ends < 4; ++ends)
            for (int k = 0; k < lattice.cells[axis]; ++k) {
                std::array<int, 3> low{};
                low[i] = ends / 2 * lattice.cells[i];
                low[j] = ends % 2 * lattice.cells[j];
                low[axis] = k;
                std::array<int, 3> high = low;
                ++high[axis];
                segments.push_back(
                    {{vertex(low), vertex(high)}, first_number[axis] + numbers_a_side[axis] * (ends / 2) + ends % 2});
            }
    }
    std::ranges::sort(segments, {}, &Segment::ends);
    Buffer<SimplexVertices<1>> edges;
    Buffer<Reference> references;
    Buffer<std::uint32_t> ridges;
    for (const Segment& s : segments) {
        ridges.push_back(static_cast<std::uint32_t>(edges.size()));
        edges.push_back(s.ends);
        references.push_back(s.number);
    }
    mesh.edges = {std::move(edges), std::move(references), {}};
    mesh.ridges = std::move(ridges);
}

template <int D>
class BoxRows final : public PrismRows<D> {
  public:
    BoxRows(const BoxOptions<D>& options, PrismBase<D> base, std::vector<PrismRow> rows, std::size_t rows_between)
        : PrismRows<D>(std::move(base), std::move(rows), rows_between), places_(options) {}

    [[nodiscard]] Outcome<LinearMesh<D>> lists() const override {
        return guarded([&]() -> Outcome<LinearMesh<D>> {
            LinearMesh<D> lists;
            Buffer<VertexId> corners;
            for (unsigned corner = 0; corner < 1U << D; ++corner) {
                std::size_t v = 0, step = 1;
                for (int i = 0; i < D; ++i) {
                    const auto cells = static_cast<std::size_t>(lattice().cells[i]);
                    v += (corner >> i & 1U) * cells * step;
                    step *= cells + 1;
                }
                corners.push_back(VertexId(v));
            }
            lists.corners = std::move(corners);
            if constexpr (D == 3) add_edges(lattice(), lists);
            return lists;
        });
    }

  private:
    [[nodiscard]] const Lattice<D>& lattice() const { return places_.lattice(); }
    [[nodiscard]] std::size_t count() const { return this->base().count; }

    [[nodiscard]] Outcome<MovedLevels<D>> regular(Levels levels, const Execution& execution) const {
        const std::size_t first = levels.first * count();
        auto points = map_each(execution, (levels.last - levels.first) * count(),
                               [&](std::size_t v) { return places_.regular(first + v); });
        if (!points) return fail(points.error());
        return MovedLevels<D>{levels.first, std::move(*points)};
    }
    [[nodiscard]] Outcome<MovedLevels<D>> bent(Levels levels, const Execution& execution) const {
        if (!places_.bends()) return regular(levels, execution);
        return moved_levels<D>(
            {this->base(), this->all_rows()}, levels, min_warped_volume_ratio,
            [&](Levels l) { return regular(l, execution); },
            [&](std::size_t v, const Vec<D>& p) { return places_.bent(v, p); }, execution);
    }
    [[nodiscard]] Outcome<Buffer<Vec<D>>> points(std::span<const std::size_t> levels,
                                                 const Execution& execution) const override {
        auto moved = moved_levels<D>(
            {this->base(), this->all_rows()}, {levels.front(), levels.back() + 1}, min_jittered_volume_ratio,
            [&](Levels l) { return bent(l, execution); },
            [&](std::size_t v, const Vec<D>& p) { return places_.jittered(v, p); }, execution);
        if (!moved) return fail(moved.error());
        return std::move(moved->points);
    }
    [[nodiscard]] std::optional<Reference> facet_reference(const PrismRow& /*row*/,
                                                           const SimplexVertices<D - 1>& face) const override {
        const Reference side = lattice().side(face);
        return side != 0 ? std::optional(side) : std::nullopt;
    }
    [[nodiscard]] bool may_have_facets(VertexId v) const override { return lattice().on_boundary(v.index()); }
    [[nodiscard]] Reference point_reference(VertexId v) const override {
        const auto place = lattice().place(v.index());
        for (int i = 0; i < D; ++i) {
            if (place[i] == 0) return 2 * i + 1;
            if (place[i] == lattice().cells[i]) return 2 * i + 2;
        }
        return 0;
    }
    [[nodiscard]] std::size_t facets_of_row(std::size_t row) const override {
        const std::size_t ends = (row == 0 ? 1U : 0U) + (row + 1 == this->rows() ? 1U : 0U);
        return (D - 1) * rim() + ends * this->base().simplices.size();
    }
    [[nodiscard]] std::size_t rim() const {
        std::size_t faces = 1;
        if constexpr (D == 3) faces = static_cast<std::size_t>(lattice().cells[0]) + lattice().cells[1];
        return 2 * faces;
    }
    [[nodiscard]] std::size_t edges() const override {
        std::size_t sum = 0;
        if constexpr (D == 3)
            for (const int n : lattice().cells) sum += 4 * static_cast<std::size_t>(n);
        return sum;
    }

    BoxPlaces<D> places_;
};

}  // namespace

template <int D>
Outcome<std::unique_ptr<const ShapeRows<D>>> rows_of_shape(const BoxOptions<D>& options, const Execution& execution) {
    return guarded([&]() -> Outcome<std::unique_ptr<const ShapeRows<D>>> {
        if (auto checked = check_box(options); !checked) return fail(checked.error());
        const Noise noise{options.seed};
        auto simplices = lattice_simplices<D - 1>(std::span(options.cells).template first<D - 1>(), noise, execution);
        if (!simplices) return fail(simplices.error());
        PrismBase<D> base{std::move(*simplices), 1};
        for (int i = 0; i + 1 < D; ++i) base.count *= static_cast<std::size_t>(options.cells[i]) + 1;
        std::vector<PrismRow> rows;
        const auto number = static_cast<std::size_t>(options.cells[D - 1]);
        rows.reserve(number);
        for (std::size_t k = 0; k < number; ++k) rows.push_back({k, k + 1, noise.stream(D).stream(k)});
        return std::make_unique<const BoxRows<D>>(options, std::move(base), std::move(rows), number);
    });
}

template Outcome<std::unique_ptr<const ShapeRows<2>>> rows_of_shape<2>(const BoxOptions<2>&, const Execution&);
template Outcome<std::unique_ptr<const ShapeRows<3>>> rows_of_shape<3>(const BoxOptions<3>&, const Execution&);

namespace {

Outcome<Done> check(const BumpOptions& o) {
    const auto bad = [](const char* what) { return fail(ErrorKind::usage, what); };
    if (!(o.length > 0 && o.height > 0)) return bad("a channel needs a positive length and height");
    if (o.cells[0] < 2 || o.cells[1] < 1) return bad("a channel needs at least 2 × 1 cells");
    if (!(o.bump_width > 0 && o.bump_width <= o.length))
        return bad("the bump must be narrower than the channel is long");
    if (!(std::abs(o.bump_height) + thickness(o.floor_layer) < o.height))
        return bad("the bump and the layers together must be lower than the channel");
    if (!(expected_elements(o) < static_cast<double>(max_entities))) return bad("the channel has too many cells");
    return Done{};
}

/// Heights of rows of vertices above a flat floor: boundary layers, then cells of equal height.
std::vector<double> row_heights(const BumpOptions& o) {
    std::vector<double> rows{0};
    for (const double d : layer_distances(o.floor_layer)) rows.push_back(d);
    const double start = rows.back();
    for (int k = 1; k <= o.cells[1]; ++k)
        rows.push_back(std::lerp(start, o.height, static_cast<double>(k) / o.cells[1]));
    return rows;
}

/// Maps a channel without bump to one with the bump. Layers move with the floor; the height of the other cells shrinks
/// in proportion.
Vec<2> lifted(const BumpOptions& o, const Vec<2>& p) {
    const double top = thickness(o.floor_layer);
    const double part = p[1] <= top ? 1.0 : (o.height - p[1]) / (o.height - top);
    return {{p[0], p[1] + part * floor_height(o, p[0])}};
}

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
        // All layer vertices above a floor vertex have the same shift along the floor, so that layer heights stay
        // exact.
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
    auto result = lattice_of<2>({options.cells[0], static_cast<int>(rows.size()) - 1}, options.seed, execution);
    if (!result) return fail(result.error());
    Lattice<2>& lattice = *result;
    const auto moved = place_points(lattice, options, rows, execution);
    if (!moved) return fail(moved.error());
    auto jittered = move_points<2>(lattice.points, *moved, lattice.elements, 0.2, execution);
    if (!jittered) return fail(jittered.error());
    // Halved moves of floor vertices end on chords of the bump, so these vertices are projected onto the bump again.
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

namespace {

template <int D>
double cover(double radius, double size) {
    return D == 2 ? 2 * std::numbers::pi * radius / size
                  : 8 * std::numbers::pi * radius * radius / (std::numbers::sqrt3 * size * size);
}

template <int D>
double facets_of(double points) {
    return D == 2 ? points : 2 * points - 4;
}

template <int D>
double prisms(const ShellOptions<D>& o) {
    const PrismCounts counts = prism_counts<D>(core_sizes(o));
    const double facets = D == 2 ? 5 * counts.cuts : 20 * counts.cuts * counts.cuts;
    return D * facets * (counts.rows + o.inner_layer.count + o.outer_layer.count);
}

/// Estimates the number of elements if the points are on concentric spheres, whose distance is the height of a regular
/// simplex. 2D: two triangles per inner point, one per boundary point (Euler's formula). 3D: ratios measured on shells
/// with 10^3 to 1.5·10^5 elements.
template <int D>
double unstructured(const ShellOptions<D>& o) {
    constexpr double an_inner_point = D == 2 ? 2 : 6.2, a_wall_point = D == 2 ? 1 : 3.1;
    constexpr int samples = 1024;
    const double height = D == 2 ? std::numbers::sqrt3 / 2 : std::numbers::sqrt2 / std::numbers::sqrt3;
    const ShellSizes sizes = core_sizes(o);
    const double inner = cover<D>(sizes.inner_radius, sizes.inner_size);
    const double outer = cover<D>(sizes.outer_radius, sizes.outer_size);
    const double step = (sizes.outer_radius - sizes.inner_radius) / samples;
    double points = (inner + outer) / 2;
    for (int k = 0; k < samples; ++k) {
        const double radius = sizes.inner_radius + (k + 0.5) * step;
        points += cover<D>(radius, sizes.at(radius)) * step / (height * sizes.at(radius));
    }
    const double layers = o.inner_layer.count * facets_of<D>(inner) + o.outer_layer.count * facets_of<D>(outer);
    return an_inner_point * std::max(0.0, points - inner - outer) + a_wall_point * (inner + outer) + D * layers;
}

double off(double elements, double target) { return std::abs(log(elements / target)); }

template <std::size_t N, class Elements>
std::array<int, N> rounded(const std::array<double, N>& ideal, const std::array<int, N>& least, double target,
                           Elements&& elements) {
    constexpr double most = 1e9;
    std::array<int, N> best{};
    double best_off = std::numeric_limits<double>::infinity();
    for (unsigned up = 0; up < 1U << N; ++up) {
        std::array<int, N> cells{};
        for (std::size_t i = 0; i < N; ++i)
            cells[i] = std::max(least[i], static_cast<int>(std::min(ideal[i], most)) + static_cast<int>(up >> i & 1U));
        if (const double o = off(elements(cells), target); o < best_off) {
            best = cells;
            best_off = o;
        }
    }
    return best;
}

template <int D>
double of_lattice(const std::array<int, D>& cells) {
    double elements = D == 2 ? 2 : 6;
    for (const int n : cells) elements *= n;
    return elements;
}

double of_channel(const std::array<int, 2>& cells, int layers) {
    return 2.0 * cells[0] * (static_cast<double>(cells[1]) + layers);
}

}  // namespace

template <int D>
double expected_elements(const ShellOptions<D>& options) {
    return options.structure == ShellStructure::prisms ? prisms(options) : unstructured(options);
}

template <int D>
double expected_elements(const BoxOptions<D>& options) {
    return of_lattice<D>(options.cells);
}

double expected_elements(const BumpOptions& options) { return of_channel(options.cells, options.floor_layer.count); }

template <int D>
ShellOptions<D> with_elements(ShellOptions<D> options, double count) {
    const auto scaled = [&](double log_factor) {
        ShellOptions<D> o = options;
        o.inner_size *= exp(log_factor);
        o.outer_size *= exp(log_factor);
        return o;
    };
    double fine = -40, coarse = 40;  // bisection: the logarithm of the factor for both sizes is between these bounds
    for (int step = 0; step < 60; ++step) {
        const double middle = (fine + coarse) / 2;
        (expected_elements(scaled(middle)) > count ? fine : coarse) = middle;
    }
    const ShellOptions<D> finer = scaled(fine), coarser = scaled(coarse);
    return off(expected_elements(finer), count) < off(expected_elements(coarser), count) ? finer : coarser;
}

template <int D>
BoxOptions<D> with_elements(BoxOptions<D> options, double count) {
    const double factor = pow(count / expected_elements(options), 1.0 / D);
    std::array<double, D> ideal{};
    std::array<int, D> least{};
    for (int i = 0; i < D; ++i) {
        ideal[i] = factor * options.cells[i];
        least[i] = 1;
    }
    options.cells = rounded(ideal, least, count, of_lattice<D>);
    return options;
}

BumpOptions with_elements(BumpOptions options, double count) {
    // A channel of a × b cells has 2 a (b + layers) elements. The factor f solves 2 f a (f b + layers) = count.
    const double a = options.cells[0], b = options.cells[1], layers = options.floor_layer.count;
    const double factor = (std::sqrt(a * a * layers * layers + 2 * a * b * count) - a * layers) / (2 * a * b);
    options.cells = rounded(std::array{factor * a, factor * b}, {2, 1}, count, [&](const std::array<int, 2>& cells) {
        return of_channel(cells, options.floor_layer.count);
    });
    return options;
}

#define CAMBER_INSTANTIATE(D)                                           \
    template double expected_elements<D>(const ShellOptions<D>&);       \
    template double expected_elements<D>(const BoxOptions<D>&);         \
    template ShellOptions<D> with_elements<D>(ShellOptions<D>, double); \
    template BoxOptions<D> with_elements<D>(BoxOptions<D>, double);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
