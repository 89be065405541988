// Reads points and cells of VTU files.
module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;

namespace camber::vtu {

namespace {

constexpr std::size_t row_grain = 4096;

auto damaged(const File& file, std::size_t at, std::string what) {
    return fail(ErrorKind::input, std::move(what), place(file, at), {},
                "the file is damaged, or was joined from two "
                "files");
}

/// A cell type of VTK, with its number of nodes for degree 1 and for degree 2 (0: the type does not have this degree).
struct Kind {
    std::uint64_t type;
    int dimension;
    std::size_t nodes, quadratic_nodes;
};
constexpr std::array kinds{Kind{3, 1, 2, 0},  Kind{5, 2, 3, 0},  Kind{10, 3, 4, 0},
                           Kind{21, 1, 0, 3}, Kind{22, 2, 0, 6}, Kind{24, 3, 0, 10},
                           Kind{68, 1, 2, 3}, Kind{69, 2, 3, 6}, Kind{71, 3, 4, 10}};
constexpr std::uint64_t vertex_cell = 1, vertices_cell = 2, first_lagrange = 68;

const Kind* find_kind(std::uint64_t type) {
    for (const Kind& kind : kinds)
        if (kind.type == type) return &kind;
    return nullptr;
}

std::string plural_of(std::uint64_t type) {
    constexpr std::array<std::pair<std::uint64_t, std::string_view>, 34> names{{{0, "empty cells"},
                                                                                {4, "poly lines"},
                                                                                {6, "triangle strips"},
                                                                                {7, "polygons"},
                                                                                {8, "pixels"},
                                                                                {9, "quadrilaterals"},
                                                                                {11, "voxels"},
                                                                                {12, "hexahedra"},
                                                                                {13, "prisms"},
                                                                                {14, "pyramids"},
                                                                                {15, "pentagonal prisms"},
                                                                                {16, "hexagonal prisms"},
                                                                                {23, "quadratic quadrilaterals"},
                                                                                {25, "quadratic hexahedra"},
                                                                                {26, "quadratic prisms"},
                                                                                {27, "quadratic pyramids"},
                                                                                {28, "biquadratic quadrilaterals"},
                                                                                {29, "triquadratic hexahedra"},
                                                                                {30, "quadratic linear quadrilaterals"},
                                                                                {31, "quadratic linear prisms"},
                                                                                {32, "biquadratic quadratic prisms"},
                                                                                {33, "biquadratic quadratic hexahedra"},
                                                                                {34, "biquadratic triangles"},
                                                                                {35, "cubic lines"},
                                                                                {36, "quadratic polygons"},
                                                                                {42, "polyhedra"},
                                                                                {70, "Lagrange quadrilaterals"},
                                                                                {72, "Lagrange hexahedra"},
                                                                                {73, "Lagrange prisms"},
                                                                                {74, "Lagrange pyramids"},
                                                                                {75, "Bezier curves"},
                                                                                {76, "Bezier triangles"},
                                                                                {77, "Bezier quadrilaterals"},
                                                                                {78, "Bezier tetrahedra"}}};
    for (const auto& [number, name] : names)
        if (number == type) return std::string(name);
    return "cells of VTK's type " + std::to_string(type);
}

template <class T>
Outcome<Buffer<T>> whole(const Numbers& numbers, T otherwise, const Execution& execution) {
    return std::visit(
        [&]<class From>(const Buffer<From>& values) {
            return map_each(
                execution, values.size(), [&](std::size_t i) { return whole_number<T>(values[i]).value_or(otherwise); },
                row_grain);
        },
        numbers);
}

/// Joins the pieces of a file. Each piece counts its points, and its entries of `connectivity`, from 0. This function
/// adds the numbers of all earlier pieces.
void join_pieces(const File& file, Buffer<std::uint64_t>& ends, Buffer<std::uint32_t>& connectivity) {
    std::uint64_t cell = 0, entry = 0, point = 0;
    for (const PieceSize& piece : file.pieces) {
        const std::uint64_t before = entry;
        for (std::uint64_t c = 0; c < piece.cells && cell < ends.size(); ++c, ++cell) ends[cell] += before;
        if (piece.cells > 0) entry = ends[cell - 1];
        for (std::uint64_t e = before; e < entry && e < connectivity.size(); ++e)
            connectivity[e] =
                connectivity[e] < piece.points ? static_cast<std::uint32_t>(connectivity[e] + point) : VertexId().value;
        point += piece.points;
    }
}

template <class T>
Outcome<Buffer<T>> read_whole(const File& file, std::string_view name, std::uint64_t rows, T otherwise,
                              const Execution& execution) {
    for (const DataArray& array : file.cell_arrays)
        if (array.name == name) {
            const auto numbers = read_array(file, array, rows, execution);
            if (!numbers) return fail(numbers.error());
            return whole(*numbers, otherwise, execution);
        }
    return damaged(file, 0, "Cells have no array " + std::string(name));
}

Outcome<Buffer<std::uint8_t>> read_ghosts(const File& file, const Execution& execution) {
    for (const DataArray& array : file.cell_data) {
        if (array.name != ghost_array || array.components != 1 || !is_number(array)) continue;
        const auto numbers = read_array(file, array, file.cells, execution);
        if (!numbers) return fail(numbers.error());
        return whole<std::uint8_t>(*numbers, 0, execution);
    }
    return Buffer<std::uint8_t>{};
}

Outcome<Buffer<std::uint64_t>> starts_of(const File& file, const Buffer<std::uint64_t>& ends, std::size_t entries,
                                         std::size_t at) {
    Buffer<std::uint64_t> starts(ends.size() + 1);
    starts[0] = 0;
    for (std::size_t c = 0; c < ends.size(); ++c) {
        if (ends[c] < starts[c] || ends[c] > entries)
            return damaged(file, at, "the offset of cell " + std::to_string(c + 1) + " is wrong");
        starts[c + 1] = ends[c];
    }
    if (starts.back() != entries)
        return damaged(file, at,
                       "connectivity has " + std::to_string(entries) + " entries, but the offsets end at " +
                           std::to_string(starts.back()));
    return starts;
}

class Sorter {
  public:
    Sorter(const File& file, std::size_t at, Buffer<std::uint8_t> ghosts)
        : file_(file), at_(at), ghosts_(std::move(ghosts)) {}

    Outcome<Done> add(std::size_t cell, std::uint64_t type, std::size_t nodes) {
        constexpr std::uint8_t duplicate = 1, hidden = 32;
        if (cell < ghosts_.size() && (ghosts_[cell] & (duplicate | hidden)) != 0) {
            ++left_out_ghosts_;
            return Done{};
        }
        if (type == vertex_cell || type == vertices_cell) {
            ++vertices_;
            return Done{};
        }
        const Kind* const kind = find_kind(type);
        if (!kind) {
            refused_.count(plural_of(type));
            return Done{};
        }
        const bool quadratic = nodes == kind->quadratic_nodes, linear = nodes == kind->nodes;
        if (!quadratic && !linear && type >= first_lagrange && nodes > kind->quadratic_nodes) {
            refused_.count("Lagrange cells of degree 3 and higher");
            return Done{};
        }
        if ((!quadratic && !linear) || nodes == 0)
            return damaged(file_, at_,
                           "cell " + std::to_string(cell + 1) + " is of VTK's type " + std::to_string(type) +
                               ", but has " + std::to_string(nodes) + " nodes");
        of_kind_[static_cast<std::size_t>(3 - kind->dimension) * 2 + (quadratic ? 0 : 1)].push_back(
            static_cast<std::uint32_t>(cell));
        return Done{};
    }

    Outcome<Done> finish(Cells& cells, UnsupportedCells unsupported_cells, std::vector<Notice>& notices) && {
        if (auto supported = refused_.verdict(place(file_, at_), unsupported_cells); !supported) return supported;
        cells.unsupported_cells = refused_.counts();
        if (left_out_ghosts_ > 0)
            notices.push_back({std::to_string(left_out_ghosts_) + " ghost cells (vtkGhostType) were left out"});
        if (vertices_ > 0) notices.push_back({std::to_string(vertices_) + " cells that are vertices were left out"});
        Buffer<std::uint32_t> order;
        for (std::size_t kind = 0; kind < Cells::kinds; ++kind) {
            order.insert(order.end(), of_kind_[kind].begin(), of_kind_[kind].end());
            cells.of_kind[kind] = std::move(of_kind_[kind]);
        }
        cells.order = std::move(order);
        return Done{};
    }

  private:
    const File& file_;
    std::size_t at_;
    UnsupportedItems refused_;
    Buffer<std::uint8_t> ghosts_;
    std::size_t vertices_ = 0, left_out_ghosts_ = 0;
    std::array<Buffer<std::uint32_t>, Cells::kinds> of_kind_;
};

template <int K, int Nodes>
Outcome<Done> fill(const File& file, const Cells& cells, std::size_t kind, listing::Rows<Nodes>& rows,
                   const Execution& execution) {
    const Column<std::uint32_t>& from = cells.of_kind[kind];
    rows.origin = {simplex_name<K>, [from](std::size_t row) { return std::uint64_t{from[row]} + 1; },
                   [where = place(file, cells.at)](std::size_t) { return where; }};
    auto nodes = map_each(
        execution, from.size(),
        [&](std::size_t i) {
            std::array<VertexId, Nodes> simplex;
            for (std::size_t n = 0; n < Nodes; ++n) simplex[n].value = cells.connectivity[cells.starts[from[i]] + n];
            return simplex;
        },
        row_grain);
    if (!nodes) return fail(std::move(nodes.error()));
    rows.nodes = std::move(*nodes);
    return Done{};
}

}  // namespace

Outcome<Buffer<Vec<3>>> read_points(const File& file, const Execution& execution) {
    if (file.points == 0) return Buffer<Vec<3>>{};
    if (file.points > max_entities)
        return fail(ErrorKind::unsupported, "has more points than 32 bits can number", file.name);
    if (file.point_arrays.empty()) return damaged(file, 0, "Points have no array");
    const DataArray& array = file.point_arrays.front();
    const auto numbers = read_array(file, array, file.points, execution);
    if (!numbers) return fail(numbers.error());
    // The sizes are divided because the product 3 × `file.points` could overflow.
    if (array.components != 3 || size_of(*numbers) % 3 != 0 || size_of(*numbers) / 3 != file.points)
        return damaged(file, array.at,
                       "the Piece has " + std::to_string(file.points) + " points, but " +
                           std::to_string(size_of(*numbers)) + " coordinates, " + std::to_string(array.components) +
                           " each");
    return std::visit(
        [&](const auto& values) {
            return map_each(
                execution, file.points,
                [&](std::size_t v) {
                    Vec<3> p;
                    for (std::size_t c = 0; c < 3; ++c) p[static_cast<int>(c)] = static_cast<double>(values[3 * v + c]);
                    return p;
                },
                row_grain);
        },
        *numbers);
}

Outcome<Cells> read_cells(const File& file, UnsupportedCells unsupported_cells, std::vector<Notice>& notices,
                          const Execution& execution) {
    Cells cells;
    if (!file.cell_arrays.empty()) cells.at = file.cell_arrays.front().at;
    if (file.cells == 0) return cells;
    const auto types = read_whole<std::uint64_t>(file, "types", file.cells, 0, execution);
    if (!types) return fail(types.error());
    auto offsets = read_whole(file, "offsets", file.cells, std::numeric_limits<std::uint64_t>::max(), execution);
    if (!offsets) return fail(offsets.error());
    if (types->size() != file.cells || offsets->size() != file.cells)
        return damaged(file, cells.at,
                       "the Piece has " + std::to_string(file.cells) + " cells, but " + std::to_string(types->size()) +
                           " types and " + std::to_string(offsets->size()) + " offsets");
    if (file.cells > max_entities)
        return fail(ErrorKind::unsupported, "has more cells than 32 bits can number", place(file, cells.at));
    const bool joined = file.pieces.size() > 1;
    const std::uint64_t room = joined ? std::numeric_limits<std::uint64_t>::max() : offsets->back();
    auto connectivity = read_whole(file, "connectivity", room, VertexId().value, execution);
    if (!connectivity) return fail(connectivity.error());
    if (joined) join_pieces(file, *offsets, *connectivity);
    auto starts = starts_of(file, *offsets, connectivity->size(), cells.at);
    if (!starts) return fail(std::move(starts.error()));
    cells.starts = std::move(*starts);
    cells.connectivity = std::move(*connectivity);
    auto ghosts = read_ghosts(file, execution);
    if (!ghosts) return fail(std::move(ghosts.error()));
    Sorter sorter(file, cells.at, std::move(*ghosts));
    for (std::size_t c = 0; c < types->size(); ++c) {
        auto added = sorter.add(c, (*types)[c], cells.starts[c + 1] - cells.starts[c]);
        if (!added) return fail(std::move(added.error()));
    }
    return std::move(sorter).finish(cells, unsupported_cells, notices).map([&](Done) { return std::move(cells); });
}

Outcome<Done> place_cells(const File& file, const Cells& cells, listing::Mesh<3>& mesh, const Execution& execution) {
    std::size_t kind = 0;
    const auto both = [&]<int K>(listing::Simplices<K>& simplices) {
        return fill<K>(file, cells, kind++, simplices.curved, execution).and_then([&](Done) {
            return fill<K>(file, cells, kind++, simplices.straight, execution);
        });
    };
    return both(mesh.elements).and_then([&](Done) { return both(mesh.facets); }).and_then([&](Done) {
        return both(mesh.edges);
    });
}

}  // namespace camber::vtu
