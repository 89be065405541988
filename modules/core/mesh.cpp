// Conversion between general and simplicial meshes, unique edges and faces, straight nodes of a degree.
module;
#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
module camber.core;

namespace camber {

namespace {

template <int K>
Cells<simplex<K>> cells_of(Simplices<K> simplices) {
    return {std::move(simplices.vertices), std::move(simplices.references), std::move(simplices.required),
            std::move(simplices.entities)};
}
template <int K>
Simplices<K> simplices_of(Cells<simplex<K>> cells) {
    return {std::move(cells.vertices), std::move(cells.references), std::move(cells.required),
            std::move(cells.entities)};
}

template <int D>
std::string list_others(const Mesh<D>& mesh) {
    std::array<std::size_t, 7> counts{};
    each_shape<D>([&]<Shape shape>() { counts[std::size_t(shape)] += mesh.elements.template of<shape>().size(); });
    each_shape<D - 1>([&]<Shape shape>() { counts[std::size_t(shape)] += mesh.facets.template of<shape>().size(); });
    std::string text;
    for (const Shape shape : {Shape::quadrilateral, Shape::prism, Shape::pyramid, Shape::hexahedron}) {
        const std::size_t n = counts[std::size_t(shape)];
        if (n == 0) continue;
        if (!text.empty()) text += ", ";
        text += std::to_string(n) + " " + (n == 1 ? name_of(shape) : plural_of(shape));
    }
    return text;
}

template <int D>
Outcome<Done> check_simplicial(const Mesh<D>& mesh, int degree) {
    if (mesh.degree != degree)
        return fail(ErrorKind::unsupported, "is of degree " + std::to_string(mesh.degree) +
                                                ", but this operation needs a mesh of degree " +
                                                std::to_string(degree));
    if (const std::string others = list_others(mesh); !others.empty())
        return fail(ErrorKind::unsupported, "has " + others + ", but this operation needs a mesh of simplices only");
    return Done{};
}

}  // namespace

template <int D>
Mesh<D> as_mesh(LinearMesh<D> linear) {
    Mesh<D> mesh;
    mesh.points = std::move(linear.points);
    mesh.point_references = std::move(linear.point_references);
    mesh.corners = std::move(linear.corners);
    mesh.required_vertices = std::move(linear.required_vertices);
    mesh.elements.template of<simplex<D>>() = cells_of<D>(std::move(linear.elements));
    mesh.facets.template of<simplex<D - 1>>() = cells_of<D - 1>(std::move(linear.facets));
    mesh.edges = cells_of<1>(std::move(linear.edges));
    mesh.ridges = std::move(linear.ridges);
    mesh.geometry = std::move(linear.geometry);
    mesh.groups = std::move(linear.groups);
    return mesh;
}

template <int D>
Mesh<D> as_mesh(QuadraticMesh<D> quadratic) {
    Mesh<D> mesh = as_mesh(std::move(quadratic.linear));
    mesh.degree = 2;
    mesh.edge_nodes = std::move(quadratic.mid_nodes);
    MeshEntities<D>& entities = mesh.entities;
    entities.edges = std::move(quadratic.edges.vertices);
    entities.edges_of_elements.template of<simplex<D>>().ids = std::move(quadratic.edges.of_elements);
    entities.edges_of_facets.template of<simplex<D - 1>>().ids = std::move(quadratic.edges.of_facets);
    entities.edges_of_edges = std::move(quadratic.edges.of_edges);
    return mesh;
}

template <int D>
LinearMesh<D> straight_simplices(Mesh<D> mesh) {
    return {.points = std::move(mesh.points),
            .point_references = std::move(mesh.point_references),
            .corners = std::move(mesh.corners),
            .required_vertices = std::move(mesh.required_vertices),
            .elements = simplices_of<D>(std::move(mesh.elements.template of<simplex<D>>())),
            .facets = simplices_of<D - 1>(std::move(mesh.facets.template of<simplex<D - 1>>())),
            .edges = simplices_of<1>(std::move(mesh.edges)),
            .ridges = std::move(mesh.ridges),
            .geometry = std::move(mesh.geometry),
            .groups = std::move(mesh.groups)};
}

template <int D>
Outcome<LinearMesh<D>> as_linear(Mesh<D> mesh) {
    if (auto fits = check_simplicial(mesh, 1); !fits) return fail(fits.error());
    return straight_simplices(std::move(mesh));
}

template <int D>
Outcome<QuadraticMesh<D>> as_quadratic(Mesh<D> mesh) {
    if (auto fits = check_simplicial(mesh, 2); !fits) return fail(fits.error());
    MeshEntities<D>& entities = mesh.entities;
    EdgeSet<D> edges{.vertices = std::move(entities.edges),
                     .of_elements = std::move(entities.edges_of_elements.template of<simplex<D>>().ids),
                     .of_facets = std::move(entities.edges_of_facets.template of<simplex<D - 1>>().ids),
                     .of_edges = std::move(entities.edges_of_edges)};
    auto nodes = std::move(mesh.edge_nodes);
    return QuadraticMesh<D>{straight_simplices(std::move(mesh)), std::move(edges), std::move(nodes)};
}

namespace {

// Unique edges and faces: edges or faces of cells with the same vertices become one entity.

/// An edge or face of a cell: its vertices without the lowest one, and its slot among the edges or faces of all cells.
template <std::size_t N>
struct Listed {
    std::array<VertexId, N - 1> others;
    std::uint32_t slot = 0;

    [[nodiscard]] bool precedes(const Listed& other) const {
        if constexpr (N == 2) return others[0] < other.others[0];
        if constexpr (N == 3) return pair() < other.pair();
        if constexpr (N == 4)
            return pair() != other.pair() ? pair() < other.pair() : others.back() < other.others.back();
        return false;
    }
    [[nodiscard]] std::uint64_t pair() const { return std::uint64_t{others[0].value} << 32U | others[1].value; }
};

template <std::size_t N>
struct UniqueEntities {
    Buffer<std::array<VertexId, N>> vertices;
    Buffer<std::uint32_t> ids;
};

/// `visit(f)` must call f(slot, vertices) for each slot in parallel, with the lowest vertex first.
template <std::size_t N, class Visit>
Outcome<UniqueEntities<N>> unique_entities(std::size_t slots, std::size_t points, Visit&& visit,
                                           const Execution& execution) {
    if (slots > max_entities)
        return fail(ErrorKind::unsupported, "has more than " + std::to_string(max_entities) + " edges or faces");
    using Vertices = std::array<VertexId, N>;
    const auto add = [](std::uint32_t& count) {
        return std::atomic_ref(count).fetch_add(1, std::memory_order_relaxed);
    };
    Buffer<std::uint32_t> offsets(points + 1, 0);
    auto done = visit([&](std::size_t, const Vertices& v) { add(offsets[v[0].index() + 1]); });
    if (!done) return fail(done.error());
    for (std::size_t v = 0; v < points; ++v) offsets[v + 1] += offsets[v];
    Buffer<std::uint32_t> cursor(offsets.begin(), offsets.end());
    Buffer<Listed<N>> listed(slots);
    done = visit([&](std::size_t slot, const Vertices& v) {
        Listed<N>& item = listed[add(cursor[v[0].index()])];
        std::copy(v.begin() + 1, v.end(), item.others.begin());
        item.slot = static_cast<std::uint32_t>(slot);
    });
    if (!done) return fail(done.error());
    Buffer<std::uint32_t> first(points + 1, 0);  // number of unique entities with a lower first vertex
    done = each(execution, points, [&](std::size_t v) {
        const auto begin = listed.begin() + offsets[v], end = listed.begin() + offsets[v + 1];
        std::sort(begin, end, [](const auto& a, const auto& b) { return a.precedes(b); });
        for (auto at = begin; at != end; ++at) first[v + 1] += at == begin || at->others != (at - 1)->others ? 1 : 0;
    });
    if (!done) return fail(done.error());
    for (std::size_t v = 0; v < points; ++v) first[v + 1] += first[v];
    UniqueEntities<N> out{Buffer<Vertices>(first[points]), Buffer<std::uint32_t>(slots)};
    done = each(execution, points, [&](std::size_t v) {
        std::uint32_t next = first[v];
        for (std::uint32_t i = offsets[v]; i < offsets[v + 1]; ++i) {
            if (i == offsets[v] || listed[i].others != listed[i - 1].others) {
                Vertices& vertices = out.vertices[next++];
                vertices[0] = VertexId(v);
                std::copy(listed[i].others.begin(), listed[i].others.end(), vertices.begin() + 1);
            }
            out.ids[listed[i].slot] = next - 1;
        }
    });
    if (!done) return fail(done.error());
    return out;
}

template <int D, class F>
void each_list(const Mesh<D>& mesh, F&& f) {
    each_shape<D>([&]<Shape shape>() { f.template operator()<shape>(mesh.elements.template of<shape>()); });
    each_shape<D - 1>([&]<Shape shape>() { f.template operator()<shape>(mesh.facets.template of<shape>()); });
    if constexpr (D == 3) f.template operator()<Shape::line>(mesh.edges);
}

template <int D>
Outcome<Done> check_vertices(const Mesh<D>& mesh, const Execution& execution) {
    Outcome<Done> result = Done{};
    each_list(mesh, [&]<Shape shape>(const Cells<shape>& cells) {
        if (!result) return;
        const std::size_t n = cells.size();
        const auto sorted = [&](std::size_t i) {
            auto v = cells.vertices[i];
            std::sort(v.begin(), v.end());
            return v;
        };
        const auto is_wrong = [&](std::size_t i) {
            const auto v = sorted(i);
            return v.back().index() >= mesh.points.size() || std::adjacent_find(v.begin(), v.end()) != v.end();
        };
        const auto first = reduce_each(
            execution, n, n, [&](std::size_t& found, std::size_t i) { found = found == n && is_wrong(i) ? i : found; },
            [](std::size_t a, std::size_t b) { return std::min(a, b); });
        if (!first) {
            result = fail(first.error());
        } else if (*first < n) {
            const auto v = sorted(*first);
            const auto twice = std::adjacent_find(v.begin(), v.end());
            const bool exists = v.back().index() < mesh.points.size();
            const auto number = std::to_string((exists ? *twice : v.back()).index() + 1);
            result = fail(ErrorKind::input,
                          exists ? "names vertex " + number + " twice"
                                 : "names vertex " + number + " of " + std::to_string(mesh.points.size()),
                          {}, Entity{name_of(shape), *first + 1}, "remove it");
        }
    });
    return result;
}

template <int D>
Outcome<Done> add_edges(Mesh<D>& mesh, const Execution& execution) {
    std::size_t slots = 0;
    each_list(mesh,
              [&]<Shape shape>(const Cells<shape>& cells) { slots += cells.size() * shape_table<shape>.edge_count; });
    const auto visit = [&](auto&& f) {
        Outcome<Done> done = Done{};
        std::size_t first = 0;
        each_list(mesh, [&]<Shape shape>(const Cells<shape>& cells) {
            constexpr int count = shape_table<shape>.edge_count;
            if (done)
                done = each(execution, cells.size(), [&](std::size_t i) {
                    for (int e = 0; e < count; ++e) {
                        const auto& [a, b] = shape_table<shape>.edges[e];
                        const auto [low, high] = std::minmax(cells.vertices[i][a], cells.vertices[i][b]);
                        f(first + i * count + e, std::array{low, high});
                    }
                });
            first += cells.size() * count;
        });
        return done;
    };
    auto edges = unique_entities<2>(slots, mesh.points.size(), visit, execution);
    if (!edges) return fail(edges.error());
    std::size_t first = 0;
    Outcome<Done> done = Done{};
    const auto take_ids = [&]<Shape shape>(const Cells<shape>& cells, EdgesOfCells<shape>& of) {
        constexpr std::size_t count = shape_table<shape>.edge_count;
        Buffer<std::array<EdgeId, count>> ids(cells.size());
        if (done)
            done = each(execution, ids.size(), [&](std::size_t i) {
                for (std::size_t e = 0; e < count; ++e)
                    ids[i][e] = EdgeId(std::size_t{edges->ids[first + i * count + e]});
            });
        first += ids.size() * count;
        of.ids = std::move(ids);
    };
    MeshEntities<D>& of = mesh.entities;
    each_shape<D>([&]<Shape shape>() {
        take_ids.template operator()<shape>(mesh.elements.template of<shape>(),
                                            of.edges_of_elements.template of<shape>());
    });
    each_shape<D - 1>([&]<Shape shape>() {
        take_ids.template operator()<shape>(mesh.facets.template of<shape>(), of.edges_of_facets.template of<shape>());
    });
    if constexpr (D == 3) {
        Buffer<EdgeId> ids(mesh.edges.size());
        for (EdgeId& id : ids) id = EdgeId(std::size_t{edges->ids[first++]});
        of.edges_of_edges = std::move(ids);
    }
    of.edges = std::move(edges->vertices);
    return done;
}

template <Shape shape>
constexpr int face_count_of = shape_table<shape>.dimension == 3   ? shape_table<shape>.face_count
                              : shape_table<shape>.dimension == 2 ? 1
                                                                  : 0;
template <Shape shape>
constexpr ShapeFace face_at(int f) {
    if constexpr (shape_table<shape>.dimension == 3)
        return shape_table<shape>.faces[f];
    else
        return {shape, {0, 1, 2, 3}};
}

template <Shape shape, Shape face>
constexpr auto face_ranks = [] {
    std::array<int, 7> ranks{};
    for (int k = 0; k < face_count_of<shape>; ++k) ranks[k + 1] = ranks[k] + (face_at<shape>(k).shape == face ? 1 : 0);
    return ranks;
}();

template <Shape face>
Outcome<Buffer<ShapeVertices<face>>> add_faces(Mesh<3>& mesh, const Execution& execution) {
    constexpr std::size_t corners = shape_table<face>.corner_count;
    const auto each_slot = [&](auto&& f) {  // calls f(cells, cell, face of the cell, slot)
        Outcome<Done> done = Done{};
        std::size_t first = 0;
        each_list(mesh, [&]<Shape shape>(const Cells<shape>& cells) {
            constexpr auto& ranks = face_ranks<shape, face>;
            constexpr int count = ranks[face_count_of<shape>];
            if (count > 0 && done)
                done = each(execution, cells.size(), [&](std::size_t i) {
                    for (int k = 0; k < face_count_of<shape>; ++k)
                        if (ranks[k] < ranks[k + 1])
                            f.template operator()<shape>(cells, i, k, first + i * count + ranks[k]);
                });
            first += cells.size() * count;
        });
        return done;
    };
    std::size_t slots = 0;
    each_list(mesh, [&]<Shape shape>(const Cells<shape>& cells) {
        slots += cells.size() * face_ranks<shape, face>[face_count_of<shape>];
    });
    const auto visit = [&](auto&& f) {
        return each_slot([&]<Shape shape>(const Cells<shape>& cells, std::size_t i, int k, std::size_t slot) {
            const auto& at = face_at<shape>(k).corners;
            ShapeVertices<face> vertices, sorted;
            for (std::size_t c = 0; c < corners; ++c) vertices[c] = cells.vertices[i][at[c]];
            const auto order = corners_by_orientation(face, orientation_of(vertices));
            for (std::size_t c = 0; c < corners; ++c) sorted[c] = vertices[order[c]];
            f(slot, sorted);
        });
    };
    auto faces = unique_entities<corners>(slots, mesh.points.size(), visit, execution);
    if (!faces) return fail(faces.error());
    std::size_t first = 0;
    Outcome<Done> done = Done{};
    const auto take_ids = [&]<Shape shape>(const Cells<shape>& cells, FacesOfCells<shape>& of) {
        using Row = typename decltype(of.ids)::value_type;
        constexpr auto& ranks = face_ranks<shape, face>;
        constexpr std::size_t count = ranks[face_count_of<shape>];
        if constexpr (count > 0) {
            Buffer<Row> ids = of.ids.empty() ? Buffer<Row>(cells.size(), Row{}) : take(std::move(of.ids));
            if (done)
                done = each(execution, ids.size(), [&](std::size_t i) {
                    for (int k = 0; k < face_count_of<shape>; ++k)
                        if (ranks[k] < ranks[k + 1])
                            ids[i][k] = FaceId(std::size_t{faces->ids[first + i * count + ranks[k]]});
                });
            of.ids = std::move(ids);
            first += cells.size() * count;
        }
    };
    each_shape<3>([&]<Shape shape>() {
        take_ids.template operator()<shape>(mesh.elements.of<shape>(), mesh.entities.faces_of_elements.of<shape>());
    });
    each_shape<2>([&]<Shape shape>() {
        take_ids.template operator()<shape>(mesh.facets.of<shape>(), mesh.entities.faces_of_facets.of<shape>());
    });
    if (!done) return fail(done.error());
    return std::move(faces->vertices);
}

/// Values of the linear corner functions at each node of an element. Pyramids have the functions of the collapsed
/// hexahedron.
template <Shape shape, int degree>
constexpr auto corner_weights = [] {
    constexpr int corners = shape_table<shape>.corner_count;
    std::array<std::array<double, corners>, element_nodes<shape, degree>> weights{};
    for (std::size_t n = 0; n < weights.size(); ++n) {
        std::array<double, 3> x{};
        for (int d = 0; d < 3; ++d) x[d] = static_cast<double>(lagrange_nodes<shape, degree>[n][d]) / degree;
        const double rest = shape == Shape::pyramid ? 1 - x[2] : 1;  // side length of the cross-section at height x[2]
        for (int c = 0; c < corners; ++c) {
            const auto& at = shape_table<shape>.coordinates[c];
            double& w = weights[n][c] = 1;
            if constexpr (is_simplex(shape)) {
                w = at[0] + at[1] + at[2] == 0 ? 1 - x[0] - x[1] - x[2] : x[0] * at[0] + x[1] * at[1] + x[2] * at[2];
            } else if constexpr (shape == Shape::prism) {
                w = (at[0] + at[1] == 0 ? 1 - x[0] - x[1] : x[0] * at[0] + x[1] * at[1]) *
                    (at[2] == 1 ? x[2] : 1 - x[2]);
            } else if constexpr (shape == Shape::pyramid) {
                w = c == 4     ? x[2]
                    : rest > 0 ? (at[0] == 1 ? x[0] : rest - x[0]) * (at[1] == 1 ? x[1] : rest - x[1]) / rest
                               : 0;
            } else {
                for (int d = 0; d < shape_table<shape>.dimension; ++d) w *= at[d] == 1 ? x[d] : 1 - x[d];
            }
        }
    }
    return weights;
}();

template <Shape shape, int degree, int D, class Rows>
Outcome<Done> place_inner(const Mesh<D>& mesh, const Rows& rows, std::size_t first, Buffer<Vec<D>>& nodes,
                          const Execution& execution) {
    constexpr std::size_t count = inner_node_count(shape, degree), corners = shape_table<shape>.corner_count;
    if constexpr (count == 0) return Done{};
    return each(execution, rows.size(), [&](std::size_t i) {
        std::array<Vec<D>, corners> points;
        for (std::size_t c = 0; c < corners; ++c) points[c] = mesh.points[rows[i][c]];
        for (std::size_t n = 0; n < count; ++n) {
            Vec<D> p;
            for (std::size_t c = 0; c < corners; ++c)
                p += corner_weights<shape, degree>[element_nodes<shape, degree> - count + n][c] * points[c];
            nodes[first + i * count + n] = p;
        }
    });
}

template <int degree, int D>
Outcome<Done> place_straight_nodes(Mesh<D>& mesh, const Execution& execution) {
    const auto& [edges, triangles, quadrilaterals, of_elements, of_facets, of_edges, faces, facets] = mesh.entities;
    Buffer<LagrangeNode<D>> on_edges(edges.size() * (degree - 1));
    Outcome<Done> done = each(execution, edges.size(), [&](std::size_t e) {
        const Vec<D>&p = mesh.points[edges[e][0]], &q = mesh.points[edges[e][1]];
        for (int n = 1; n < degree; ++n) {
            const double t = static_cast<double>(n) / degree;
            on_edges[e * (degree - 1) + n - 1] = {2 * n == degree ? midpoint(p, q) : (1 - t) * p + t * q};
        }
    });
    if (!done) return done;
    const std::size_t of_triangles = triangles.size() * inner_node_count(Shape::triangle, degree);
    Buffer<Vec<D>> on_faces(of_triangles + quadrilaterals.size() * inner_node_count(Shape::quadrilateral, degree));
    done = place_inner<Shape::triangle, degree>(mesh, triangles, 0, on_faces, execution);
    if (!done) return done;
    done = place_inner<Shape::quadrilateral, degree>(mesh, quadrilaterals, of_triangles, on_faces, execution);
    std::size_t count = 0, first = 0;
    each_shape<D>(
        [&]<Shape shape>() { count += mesh.elements.template of<shape>().size() * inner_node_count(shape, degree); });
    Buffer<Vec<D>> inside(count);
    each_shape<D>([&]<Shape shape>() {
        const auto& rows = mesh.elements.template of<shape>().vertices;
        if (done) done = place_inner<shape, degree>(mesh, rows, first, inside, execution);
        first += rows.size() * inner_node_count(shape, degree);
    });
    mesh.degree = degree;
    mesh.edge_nodes = std::move(on_edges);
    mesh.face_nodes = std::move(on_faces);
    mesh.inner_nodes = std::move(inside);
    return done;
}

template <int D>
Outcome<Mesh<D>> with_degree(Mesh<D> mesh, int degree, const Execution& execution) {
    if (auto sound = check_vertices(mesh, execution); !sound) return fail(sound.error());
    if (auto done = add_edges(mesh, execution); !done) return fail(done.error());
    if constexpr (D == 3) {
        auto& of = mesh.entities;
        auto quadrilaterals = add_faces<Shape::quadrilateral>(mesh, execution);
        if (!quadrilaterals) return fail(quadrilaterals.error());
        of.quadrilaterals = std::move(*quadrilaterals);
        if (degree > 2) {
            auto triangles = add_faces<Shape::triangle>(mesh, execution);
            if (!triangles) return fail(triangles.error());
            of.triangles = std::move(*triangles);
        }
    }
    auto done = at_degree(degree, [&]<int k>() { return place_straight_nodes<k>(mesh, execution); });
    if (!done) return fail(done.error());
    return mesh;
}

}  // namespace

template <int D>
Outcome<Mesh<D>> elevate(Mesh<D> mesh, int degree, const Execution& execution) {
    if (mesh.degree != 1)
        return fail(ErrorKind::usage,
                    "is of degree " + std::to_string(mesh.degree) + ", but the degree can be raised only from 1");
    if (degree < 1 || degree > max_degree)
        return fail(ErrorKind::usage,
                    "the degree must be from 1 to " + std::to_string(max_degree) + ", got " + std::to_string(degree));
    mesh.entities = {};
    mesh.edge_nodes = {};
    mesh.face_nodes = mesh.inner_nodes = {};
    if (degree == 1) return mesh;
    return guarded([&] { return with_degree(std::move(mesh), degree, without_progress(execution)); });
}

#define CAMBER_INSTANTIATE(D)                                    \
    template Mesh<D> as_mesh<D>(LinearMesh<D>);                  \
    template Mesh<D> as_mesh<D>(QuadraticMesh<D>);               \
    template LinearMesh<D> straight_simplices<D>(Mesh<D>);       \
    template Outcome<LinearMesh<D>> as_linear<D>(Mesh<D>);       \
    template Outcome<QuadraticMesh<D>> as_quadratic<D>(Mesh<D>); \
    template Outcome<Mesh<D>> elevate<D>(Mesh<D>, int, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
