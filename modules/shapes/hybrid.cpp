// Generates boxes, plates and shells with elements of several shapes.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>
module camber.shapes;
import camber.core;
import :prism_rows;

namespace camber {

namespace {

template <int D>
class MeshParts {
  public:
    VertexId add(const Vec<D>& p) {
        points_.push_back(p);
        return VertexId(points_.size() - 1);
    }
    template <Shape shape>
    void add(const ShapeVertices<shape>& vertices) {
        elements_.template of<shape>().rows.push_back(vertices);
    }
    [[nodiscard]] const Buffer<Vec<D>>& points() const { return points_; }

    template <class Of>
    [[nodiscard]] Mesh<D> finish(Of&& reference) && {
        Mesh<D> mesh;
        add_facets(mesh, reference);
        each_shape<D>([&]<Shape shape>() {
            auto& rows = elements_.template of<shape>().rows;
            auto& cells = mesh.elements.template of<shape>();
            cells.references = Buffer<Reference>(rows.size(), 1);
            cells.vertices = std::move(rows);
        });
        mesh.point_references = Buffer<Reference>(points_.size(), 0);
        mesh.points = std::move(points_);
        return mesh;
    }

  private:
    template <Shape shape>
    struct Rows {
        Buffer<ShapeVertices<shape>> rows;
    };

    template <class Of>
    void add_facets(Mesh<D>& mesh, Of&& reference) {
        std::map<std::vector<VertexId>, std::vector<VertexId>> open;  // sides that were found in only one element so
                                                                      // far; key: their sorted vertices
        const auto meet = [&](const std::vector<VertexId>& side) {
            auto key = side;
            std::ranges::sort(key);
            if (auto [at, is_new] = open.emplace(key, side); !is_new) open.erase(at);
        };
        each_shape<D>([&]<Shape shape>() {
            constexpr const ShapeTable& table = shape_table<shape>;
            for (const auto& vertices : elements_.template of<shape>().rows)
                for (int f = 0; f < (D == 2 ? table.edge_count : table.face_count); ++f) {
                    std::vector<VertexId> side;
                    if constexpr (D == 2)
                        side = {vertices[table.edges[f][0]], vertices[table.edges[f][1]]};
                    else
                        for (int c = 0; c < (table.faces[f].shape == Shape::triangle ? 3 : 4); ++c)
                            side.push_back(vertices[table.faces[f].corners[c]]);
                    meet(side);
                }
        });
        each_shape<D - 1>([&]<Shape shape>() {
            constexpr std::size_t corners = shape_table<shape>.corner_count;
            Buffer<ShapeVertices<shape>> rows;
            Buffer<Reference> references;
            for (const auto& [key, side] : open) {
                if (side.size() != corners) continue;
                ShapeVertices<shape> row;
                std::ranges::copy(side, row.begin());
                rows.push_back(row);
                Vec<D> mean;
                for (const VertexId v : side) mean += (1.0 / corners) * points_[v.index()];
                references.push_back(reference(mean));
            }
            auto& facets = mesh.facets.template of<shape>();
            facets.vertices = std::move(rows);
            facets.references = std::move(references);
        });
    }

    Buffer<Vec<D>> points_;
    ByShape<D, Rows> elements_;
};

template <int D>
Reference side_of(const Vec<D>& p, const Vec<D>& high) {
    for (int i = 0; i < D; ++i) {
        if (p[i] < 1e-9) return 2 * i + 1;
        if (p[i] > high[i] - 1e-9) return 2 * i + 2;
    }
    return 0;
}

template <std::size_t N>
Outcome<Done> check_cells(const std::array<int, N>& cells) {
    if (std::ranges::any_of(cells, [](int n) { return n < 1; }))
        return fail(ErrorKind::usage, "a mesh needs at least one cell along each axis");
    double vertices = 1;
    for (const int n : cells) vertices *= n + 1.0;
    if (vertices > 1e8) return fail(ErrorKind::usage, "these meshes can have at most 1e8 vertices");
    return Done{};
}

template <int D>
std::vector<VertexId> add_lattice(MeshParts<D>& parts, const std::array<int, D>& cells, const Vec<D>& high) {
    std::vector<VertexId> vertices;
    std::array<int, 3> to{1, 1, 1};
    for (int d = 0; d < D; ++d) to[d] = cells[d] + 1;
    for (int k = 0; k < to[2]; ++k)
        for (int j = 0; j < to[1]; ++j)
            for (int i = 0; i < to[0]; ++i) {
                const std::array<int, 3> at{i, j, k};
                Vec<D> p;
                for (int d = 0; d < D; ++d) p[d] = high[d] * at[d] / cells[d];
                vertices.push_back(parts.add(p));
            }
    return vertices;
}

/// Vertices of cell (i, j) of a lattice, in the order of the nodes of a quadrilateral.
std::array<VertexId, 4> square(const std::vector<VertexId>& v, const std::array<int, 2>& cells, std::size_t i,
                               std::size_t j) {
    const std::size_t columns = cells[0] + std::size_t{1};
    const auto at = [&](std::size_t x, std::size_t y) { return v[(j + y) * columns + i + x]; };
    return {at(0, 0), at(1, 0), at(1, 1), at(0, 1)};
}
std::array<VertexId, 8> cube(const std::vector<VertexId>& v, const std::array<int, 3>& cells, std::size_t i,
                             std::size_t j, std::size_t k) {
    const std::size_t columns = cells[0] + std::size_t{1}, rows = cells[1] + std::size_t{1};
    const auto at = [&](std::size_t x, std::size_t y, std::size_t z) {
        return v[((k + z) * rows + j + y) * columns + i + x];
    };
    return {at(0, 0, 0), at(1, 0, 0), at(1, 1, 0), at(0, 1, 0), at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1)};
}

/// Cuts a quadrilateral at its lowest vertex, so that the elements on both sides agree.
std::array<std::array<VertexId, 3>, 2> halves(const std::array<VertexId, 4>& q) {
    const bool first = std::min(q[0], q[2]) < std::min(q[1], q[3]);
    if (first) return {{{q[0], q[1], q[2]}, {q[0], q[2], q[3]}}};
    return {{{q[0], q[1], q[3]}, {q[1], q[2], q[3]}}};
}

/// Splits a cube into tetrahedra between its centre and halves of its sides. With `has_pyramid`, a pyramid covers the
/// lower side.
void add_split_cube(MeshParts<3>& parts, const std::array<VertexId, 8>& corners, bool has_pyramid) {
    Vec<3> mean;
    for (const VertexId v : corners) mean += 0.125 * parts.points()[v.index()];
    const VertexId centre = parts.add(mean);
    for (int f = 0; f < 6; ++f) {
        std::array<VertexId, 4> side;  // counter-clockwise seen from the centre
        for (std::size_t c = 0; c < 4; ++c) side[c] = corners[shape_table<Shape::hexahedron>.faces[f].corners[3 - c]];
        if (f == 0 && has_pyramid)
            parts.add<Shape::pyramid>({side[0], side[1], side[2], side[3], centre});
        else
            for (const auto& [a, b, c] : halves(side)) parts.add<Shape::tetrahedron>({a, b, c, centre});
    }
}

bool is_cut(int i, int j) { return (i + j) % 3 == 2; }

}  // namespace

Outcome<Mesh<2>> generate_plate(const std::array<int, 2>& cells) {
    if (auto fits = check_cells(cells); !fits) return fail(fits.error());
    return guarded([&]() -> Outcome<Mesh<2>> {
        const Vec<2> high{{1, 1}};
        MeshParts<2> parts;
        const auto vertices = add_lattice<2>(parts, cells, high);
        for (int j = 0; j < cells[1]; ++j)
            for (int i = 0; i < cells[0]; ++i) {
                const auto corners = square(vertices, cells, i, j);
                if (is_cut(i, j))
                    for (const auto& half : halves(corners)) parts.add<Shape::triangle>(half);
                else
                    parts.add<Shape::quadrilateral>(corners);
            }
        return std::move(parts).finish([&](const Vec<2>& p) { return side_of(p, high); });
    });
}

Outcome<Mesh<3>> generate_plate_in_space(const std::array<int, 2>& cells) {
    const auto plate = generate_plate(cells);
    if (!plate) return fail(plate.error());
    return guarded([&]() -> Outcome<Mesh<3>> {
        Buffer<Vec<3>> points;
        for (const Vec<2>& p : plate->points) points.push_back({{p[0], p[1], 0}});
        Mesh<3> mesh;
        mesh.point_references = plate->point_references;
        mesh.points = std::move(points);
        each_shape<2>([&]<Shape shape>() { mesh.facets.of<shape>() = plate->elements.of<shape>(); });
        return mesh;
    });
}

Outcome<Mesh<3>> generate_hexahedra(const std::array<int, 3>& cells) {
    if (auto fits = check_cells(cells); !fits) return fail(fits.error());
    return guarded([&]() -> Outcome<Mesh<3>> {
        const Vec<3> high{{1, 1, 1}};
        MeshParts<3> parts;
        const auto vertices = add_lattice<3>(parts, cells, high);
        for (int k = 0; k < cells[2]; ++k)
            for (int j = 0; j < cells[1]; ++j)
                for (int i = 0; i < cells[0]; ++i) parts.add<Shape::hexahedron>(cube(vertices, cells, i, j, k));
        return std::move(parts).finish([&](const Vec<3>& p) { return side_of(p, high); });
    });
}

Outcome<Mesh<3>> generate_pyramids(const std::array<int, 3>& cells) {
    if (auto fits = check_cells(cells); !fits) return fail(fits.error());
    if (cells[2] < 3)
        return fail(ErrorKind::usage, "hexahedra, pyramids and tetrahedra need at least three cells along z");
    return guarded([&]() -> Outcome<Mesh<3>> {
        const Vec<3> high{{1, 1, 1}};
        MeshParts<3> parts;
        const auto vertices = add_lattice<3>(parts, cells, high);
        const int with_pyramids = cells[2] / 2;
        for (int k = 0; k < cells[2]; ++k)
            for (int j = 0; j < cells[1]; ++j)
                for (int i = 0; i < cells[0]; ++i) {
                    const auto corners = cube(vertices, cells, i, j, k);
                    if (k < with_pyramids)
                        parts.add<Shape::hexahedron>(corners);
                    else
                        add_split_cube(parts, corners, k == with_pyramids);
                }
        return std::move(parts).finish([&](const Vec<3>& p) { return side_of(p, high); });
    });
}

Outcome<Mesh<3>> generate_prisms(const ShellOptions<3>& options, const Execution& execution) {
    if (options.inner_layer.count < 1)
        return fail(ErrorKind::usage, "prisms need layers: set inner_layer/count to at least 1");
    if (auto fits = check_shell(options); !fits) return fail(fits.error());
    const double above = thickness(options.inner_layer);
    ShellOptions<3> outside = options;
    outside.inner_layer.count = 0;
    outside.inner_radius += above;
    const auto shell = generate(outside, execution);
    if (!shell) return fail(shell.error());
    return guarded([&]() -> Outcome<Mesh<3>> {
        MeshParts<3> parts;
        for (const Vec<3>& p : shell->points) parts.add(p);
        for (const auto& vertices : shell->elements.vertices) parts.add<Shape::tetrahedron>(vertices);
        // Layers grow inwards: each vertex of the tetrahedra's inner boundary gets a copy for the lower side of each
        // layer.
        const auto distances = layer_distances(options.inner_layer);
        std::map<VertexId, std::vector<VertexId>> columns;  // copies of each vertex, from the wall outwards
        const auto column = [&](VertexId v) -> const std::vector<VertexId>& {
            auto& rows = columns[v];
            if (!rows.empty()) return rows;
            const Vec<3> ray = normalised(shell->points[v] - options.centre);
            for (int k = 0; k < options.inner_layer.count; ++k)
                rows.push_back(
                    parts.add(options.centre + (options.inner_radius + (k == 0 ? 0 : distances[k - 1])) * ray));
            rows.push_back(v);
            return rows;
        };
        for (std::size_t f = 0; f < shell->facets.size(); ++f) {
            if (shell->facets.references[f] != options.inner_reference) continue;
            auto [a, b, c] = shell->facets.vertices[f];
            const auto& p = shell->points;
            if (dot(cross(p[b] - p[a], p[c] - p[a]), p[a] - options.centre) < 0) std::swap(b, c);
            for (std::size_t k = 0; k < distances.size(); ++k)
                parts.add<Shape::prism>(
                    {column(a)[k], column(b)[k], column(c)[k], column(a)[k + 1], column(b)[k + 1], column(c)[k + 1]});
        }
        const double between = 0.5 * (options.inner_radius + options.outer_radius);
        return std::move(parts).finish([&](const Vec<3>& p) {
            return norm(p - options.centre) < between ? options.inner_reference : options.outer_reference;
        });
    });
}

template <int D>
Mesh<D> bend(Mesh<D> mesh, double share) {
    Vec<D> low = mesh.points.empty() ? Vec<D>{} : mesh.points[0], high = low;
    for (const Vec<D>& p : mesh.points)
        for (int d = 0; d < D; ++d) {
            low[d] = std::min(low[d], p[d]);
            high[d] = std::max(high[d], p[d]);
        }
    const double size = norm(high - low);
    if (!(size > 0)) return mesh;
    return map_nodes(std::move(mesh), [&](const Vec<D>& p) {
        const Vec<D> x = (6 / size) * (p - low);
        Vec<D> to = p;
        for (int d = 0; d < D; ++d) to[d] += share * size * sin(x[(d + 1) % D] + d) * cos(x[(d + D - 1) % D] - d);
        return to;
    });
}

template Mesh<2> bend<2>(Mesh<2>, double);
template Mesh<3> bend<3>(Mesh<3>, double);

}  // namespace camber
