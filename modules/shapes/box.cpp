module;
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
module camber.shapes;
import camber.core;

namespace camber {

namespace {

/// Simplices of the lattice, dimension by dimension: each is the extrusion of the one below.
template <int D>
Buffer<SimplexVertices<D>> lattice_simplices(std::span<const int, D> cells, const Noise& noise) {
    Buffer<SimplexVertices<D>> simplices;
    if constexpr (D == 1) {
        for (std::size_t i = 0; i < static_cast<std::size_t>(cells[0]); ++i)
            simplices.push_back({VertexId(i), VertexId(i + 1)});
    } else {
        const auto base = lattice_simplices<D - 1>(cells.template first<D - 1>(), noise);
        std::size_t row = 1;
        for (int i = 0; i + 1 < D; ++i) row *= static_cast<std::size_t>(cells[i]) + 1;
        std::vector<VertexId> bottom(row), top(row);
        for (std::size_t k = 0; k < static_cast<std::size_t>(cells[D - 1]); ++k) {
            for (std::size_t v = 0; v < row; ++v) {
                bottom[v] = VertexId(k * row + v);
                top[v] = VertexId((k + 1) * row + v);
            }
            extrude<D>(base, bottom, top, noise.stream(D).stream(k), simplices);
        }
    }
    return simplices;
}

template <int D>
Outcome<Done> check(const BoxOptions<D>& options) {
    double vertices = 1;
    for (int i = 0; i < D; ++i) {
        if (options.cells[i] < 1) return fail(ErrorKind::usage, "a box needs at least one cell along each axis");
        if (!(options.high[i] > options.low[i])) return fail(ErrorKind::usage, "a box needs high above low");
        vertices *= options.cells[i] + 1.0;
    }
    if (vertices * 6 > static_cast<double>(max_entities)) return fail(ErrorKind::usage, "a box of too many cells");
    return Done{};
}

}  // namespace

template <int D>
Lattice<D> unit_lattice(const std::array<int, D>& cells, std::uint64_t seed) {
    Lattice<D> lattice{cells, {}, lattice_simplices<D>(std::span<const int, D>(cells), Noise{seed})};
    std::size_t count = 1;
    for (const int n : cells) count *= static_cast<std::size_t>(n) + 1;
    lattice.points.resize(count);
    for (std::size_t v = 0; v < count; ++v)
        for (int i = 0; i < D; ++i) lattice.points[v][i] = static_cast<double>(lattice.place(v)[i]) / cells[i];
    return lattice;
}

template <int D>
Outcome<LinearMesh<D>> generate(const BoxOptions<D>& options) {
    if (auto checked = check(options); !checked) return fail(checked.error());
    Lattice<D> lattice = unit_lattice<D>(options.cells, options.seed);
    const Noise noise = Noise{options.seed}.stream(100);
    Buffer<Vec<D>> moved(lattice.points.size());
    for (std::size_t v = 0; v < moved.size(); ++v) {
        const auto place = lattice.place(v);
        const Vec<D> shift = options.jitter * noise.vector<D>(v);
        Vec<D>& p = lattice.points[v];
        for (int i = 0; i < D; ++i) {
            const double size = (options.high[i] - options.low[i]) / options.cells[i];
            const bool free = place[i] > 0 && place[i] < options.cells[i];
            // std::lerp is exact at both ends: sides are planes to the last bit.
            p[i] = std::lerp(options.low[i], options.high[i], p[i]);
            moved[v][i] = p[i] + (free ? shift[i] * size : 0.0);
        }
    }
    move_points<D>(lattice.points, moved, lattice.elements, 0.2);
    auto points = std::move(lattice.points);
    auto elements = std::move(lattice.elements);
    return bounded_mesh<D>(std::move(points), std::move(elements),
                           [&](const SimplexVertices<D - 1>& facet) { return lattice.side(facet); });
}

template Lattice<2> unit_lattice<2>(const std::array<int, 2>&, std::uint64_t);
template Lattice<3> unit_lattice<3>(const std::array<int, 3>&, std::uint64_t);
template Outcome<LinearMesh<2>> generate<2>(const BoxOptions<2>&);
template Outcome<LinearMesh<3>> generate<3>(const BoxOptions<3>&);

}  // namespace camber
