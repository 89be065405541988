module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
module camber.shapes;
import camber.core;
import :box_places;

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
        auto done = extrude_rows<D>(*base, row, rows, noise.stream(D), 0, simplices, execution);
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
    if (vertices * 6 > static_cast<double>(max_entities)) return fail(ErrorKind::usage, "a box of too many cells");
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
        done = move_points<D>(at, [&](std::size_t v) { return places.bent(v, at[v]); }, all, least_bent, execution);
    if (done)
        done = move_points<D>(
            at, [&](std::size_t v) { return places.jittered(v, at[v]); }, all, least_jittered, execution);
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

}  // namespace camber
