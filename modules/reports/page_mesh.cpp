// Meshes in pages
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>
module camber.reports;
import camber.core;
import camber.recipes;
import camber.drawing;
import camber.bezier;
import camber.soundness;

namespace camber::run {

namespace {

/// Slice of [low, high] that contains x, from 0 to `most`.
int slice_of(double x, double low, double high, int most) {
    if (!(high > low)) return 0;
    const double part = (x - low) / (high - low) * (most + 1);
    return static_cast<int>(std::clamp(std::ceil(part) - 1, 0.0, static_cast<double>(most)));
}

template <int D, std::size_t N>
Vec<D> centroid_of(const LinearMesh<D>& mesh, const std::array<VertexId, N>& vertices) {
    Vec<D> sum;
    for (const VertexId v : vertices) sum += mesh.points[v];
    return sum / static_cast<double>(N);
}

template <int K, int D>
std::array<NodeNumber, 6> nodes_of_triangle(const Mesh<D>& mesh, const SimplexVertices<K>& vertices,
                                            const std::array<EdgeId, edges_per_simplex<K>>& edges,
                                            const std::array<int, 3>& corners) {
    std::array<NodeNumber, 6> nodes{};
    for (std::size_t i = 0; i < 3; ++i) {
        const int a = corners[i], b = corners[(i + 1) % 3];
        nodes[i] = vertices[static_cast<std::size_t>(a)].value;
        for (std::size_t e = 0; e < edges.size(); ++e)
            if (const auto [p, q] = local_edges<K>[e]; std::minmax(p, q) == std::minmax(a, b))
                nodes[3 + i] = static_cast<NodeNumber>(mesh.points.size() + edges[e].index());
    }
    return nodes;
}

std::array<NodeNumber, 6> nodes_of_face(const Mesh<3>& mesh, std::size_t e, int opposite) {
    return nodes_of_triangle<3>(mesh, mesh.elements.of<Shape::tetrahedron>().vertices[e],
                                mesh.entities.edges_of_elements.of<Shape::tetrahedron>().ids[e],
                                face_opposite<3>(opposite));
}

constexpr std::uint32_t nothing = std::numeric_limits<std::uint32_t>::max();
using Across = Buffer<std::array<std::uint32_t, 4>>;  ///< for each element and local face, the element on the other
                                                      ///< side or `nothing`

Outcome<Across> elements_across(const LinearMesh<3>& mesh, const Execution& execution) {
    const auto around = balls(mesh, part_of(execution, 0, 0.5));
    if (!around) return fail(around.error());
    Across across(mesh.elements.size());
    std::fill(across.begin(), across.end(), std::array{nothing, nothing, nothing, nothing});
    auto done = each_face<3>(mesh, *around, part_of(execution, 0.5, 1), [&](std::span<const FaceAround<3>> on) {
        if (on.size() != 2) return;
        for (const std::size_t i : {0, 1})
            across[on[i].face.element.index()][on[i].face.opposite] =
                static_cast<std::uint32_t>(on[1 - i].face.element.index());
    });
    if (!done) return fail(done.error());
    return across;
}

/// Calls visit(element, local face, neighbour) once for each inner face. The neighbour is the element on the other side
/// of the face.
template <class Visit>
void each_inner_face(const Across& across, Visit&& visit) {
    for (std::size_t e = 0; e < across.size(); ++e)
        for (int i = 0; i < 4; ++i)
            if (const std::uint32_t other = across[e][static_cast<std::size_t>(i)]; other != nothing && other > e)
                visit(e, i, other);
}

using StepCounts = std::array<std::array<std::size_t, cut_steps + 2>, 3>;

/// Number of inner faces that the cut at each step uncovers.
StepCounts uncovered_by_step(const Across& across, const Column<CutKeys>& keys) {
    StepCounts counts{};
    each_inner_face(across, [&](std::size_t e, int, std::uint32_t other) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto [first, last] = std::minmax(keys[e][axis], keys[other][axis]);
            ++counts[axis][first];
            --counts[axis][last];
        }
    });
    for (auto& along : counts)
        for (std::size_t s = 1; s < along.size(); ++s) along[s] += along[s - 1];
    return counts;
}

/// Selects cut positions (steps) for all axes, as long as the inner faces that they uncover fit the budget. The first
/// is the middle of an axis, then come the quarters, the eighths, and so on. Once an axis has a position, it gets no
/// more after one that does not fit.
std::array<std::vector<int>, 3> steps_within(const StepCounts& counts, std::size_t budget) {
    std::array<std::vector<int>, 3> steps;
    std::array<bool, 3> is_full{};
    std::size_t used = 0;
    for (int stride = 128; stride >= 1; stride /= 2)
        for (int s = stride - 1; s < cut_steps; s += 2 * stride)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const std::size_t more = counts[axis][static_cast<std::size_t>(s)];
                if (more == 0 || is_full[axis]) continue;
                is_full[axis] = used + more > budget && !steps[axis].empty();
                if (used + more > budget) continue;
                used += more;
                steps[axis].push_back(s);
            }
    for (auto& along : steps) std::ranges::sort(along);
    return steps;
}

bool is_uncovered(const std::array<std::vector<int>, 3>& steps, const CutKeys& a, const CutKeys& b) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto [first, last] = std::minmax(a[axis], b[axis]);
        const auto step = std::ranges::lower_bound(steps[axis], first);
        if (step != steps[axis].end() && *step < last) return true;
    }
    return false;
}

std::uint32_t interleaved(const std::array<int, 3>& at) {
    std::uint32_t key = 0;
    for (int bit = 9; bit >= 0; --bit)
        for (const int x : at) key = key << 1 | (static_cast<std::uint32_t>(x) >> bit & 1U);
    return key;
}

template <int D>
Outcome<Column<CutKeys>> cut_keys(const LinearMesh<D>& mesh, const Box<D>& box, const Execution& execution) {
    const auto key = [&](const Vec<D>& c) {
        CutKeys keys{};
        for (int axis = 0; axis < D; ++axis)
            keys[static_cast<std::size_t>(axis)] =
                static_cast<std::uint8_t>(slice_of(c[axis], box.low[axis], box.high[axis], cut_steps));
        return keys;
    };
    auto keys = is_standalone_surface(mesh)
                    ? map_each(execution, mesh.facets.size(),
                               [&](std::size_t f) { return key(centroid_of(mesh, mesh.facets.vertices[f])); })
                    : map_each(execution, mesh.elements.size(),
                               [&](std::size_t e) { return key(centroid_of(mesh, mesh.elements.vertices[e])); });
    if (!keys) return fail(keys.error());
    return Column<CutKeys>(std::move(*keys));
}

std::array<std::vector<int>, 3> every_step() {
    std::array<std::vector<int>, 3> steps;
    for (auto& along : steps)
        for (int s = 0; s < cut_steps; ++s) along.push_back(s);
    return steps;
}

/// Returns all inner faces if there are at most `budget`. Otherwise it returns the faces between elements of different
/// references, if they fit. It then adds the faces that single cut positions uncover, as long as they fit; see
/// `steps_within`.
Outcome<InnerFaces> inner_faces(const Mesh<3>& mesh, const Column<CutKeys>& keys, std::size_t budget,
                                const Execution& execution) {
    return guarded([&]() -> Outcome<InnerFaces> {
        const LinearMesh<3> linear = straight_simplices(mesh);
        const auto across = elements_across(linear, execution);
        if (!across) return fail(across.error());
        const Column<Reference>& references = linear.elements.references;
        const auto is_between = [&](std::size_t e, std::uint32_t other) { return references[e] != references[other]; };
        InnerFaces inner;
        std::size_t between = 0;
        each_inner_face(*across, [&](std::size_t e, int, std::uint32_t other) {
            ++inner.all;
            between += is_between(e, other) ? 1 : 0;
        });
        const bool has_room = inner.all <= budget, has_between = between <= budget;
        inner.steps = has_room ? every_step()
                               : steps_within(uncovered_by_step(*across, keys), budget - (has_between ? between : 0));
        each_inner_face(*across, [&](std::size_t e, int i, std::uint32_t other) {
            if (has_room || (has_between && is_between(e, other)) || is_uncovered(inner.steps, keys[e], keys[other]))
                inner.faces.push_back({nodes_of_face(mesh, e, i), static_cast<std::uint32_t>(e), other});
        });
        return inner;
    });
}

/// Nodes of the faces of element e. A 2D element is its own only face.
template <int D>
std::vector<std::array<NodeNumber, 6>> faces_of_element(const Mesh<D>& mesh, std::size_t e) {
    const auto triangle = [&](const auto& cells, const auto& edges) {
        return nodes_of_triangle<2>(mesh, cells.template of<Shape::triangle>().vertices[e],
                                    edges.template of<Shape::triangle>().ids[e], {0, 1, 2});
    };
    if constexpr (D == 2) {
        return {triangle(mesh.elements, mesh.entities.edges_of_elements)};
    } else {
        if (is_standalone_surface(mesh)) return {triangle(mesh.facets, mesh.entities.edges_of_facets)};
        std::vector<std::array<NodeNumber, 6>> faces;
        faces.reserve(4);
        for (int i = 0; i < 4; ++i) faces.push_back(nodes_of_face(mesh, e, i));
        return faces;
    }
}

/// Sorts the faces along a Morton curve through their centroids. Adjacent faces then have similar numbers, which
/// compress better.
template <int D>
std::vector<Face> along_curve(const Mesh<D>& mesh, const Column<Face>& faces, const Box<D>& box) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> order(faces.size());
    for (std::size_t f = 0; f < faces.size(); ++f) {
        std::array<int, 3> at{};
        for (int axis = 0; axis < D; ++axis) {
            double sum = 0;
            for (std::size_t i = 0; i < 3; ++i) sum += node_point(mesh, faces[f].nodes[i])[axis];
            at[static_cast<std::size_t>(axis)] = slice_of(sum / 3, box.low[axis], box.high[axis], 1023);
        }
        order[f] = {interleaved(at), static_cast<std::uint32_t>(f)};
    }
    std::ranges::sort(order);
    std::vector<Face> sorted;
    sorted.reserve(faces.size());
    for (const auto& [key, f] : order) sorted.push_back(faces[f]);
    return sorted;
}

class Numbering {
  public:
    explicit Numbering(std::size_t items) : numbers_(items, unused) {}
    std::uint32_t of(std::size_t item) {
        if (numbers_[item] == unused) {
            numbers_[item] = static_cast<std::uint32_t>(items_.size());
            items_.push_back(static_cast<std::uint32_t>(item));
        }
        return numbers_[item];
    }
    [[nodiscard]] std::vector<std::uint32_t> items() && { return std::move(items_); }

  private:
    static constexpr std::uint32_t unused = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> numbers_, items_;
};

template <int D>
void set_size(PageMesh<D>& page) {
    page.centre = 0.5 * (page.box.low + page.box.high);
    for (const Face& face : page.outer)
        for (const NodeNumber n : face.nodes)
            page.radius = std::max(page.radius, distance(node_point(*page.mesh, n), page.centre));
    if (!(page.radius > 0)) page.radius = 1;
}

template <int D>
PageWorst worst_of(const PageMesh<D>& page, const ElementReport& report,
                   const std::vector<std::array<NodeNumber, 6>>& faces) {
    PageWorst worst{.first = page.worst_faces, .count = faces.size()};
    Box<D> box;
    for (const auto& nodes : faces)
        for (const NodeNumber n : nodes) box.include(node_point(*page.mesh, n));
    const Vec<D> centre = 0.5 * (box.low + box.high);
    for (int axis = 0; axis < D; ++axis)
        worst.centre[static_cast<std::size_t>(axis)] = centre[axis] - page.centre[axis];
    worst.radius = std::max(0.5 * distance(box.low, box.high), 1e-6 * page.radius);
    if (report.witness && report.witness->point.size() >= D) {
        worst.point.assign(3, 0.0);
        for (std::size_t axis = 0; axis < D; ++axis)
            worst.point[axis] = report.witness->point[axis] - page.centre[static_cast<int>(axis)];
    }
    return worst;
}

template <int D>
class Numbered {
  public:
    explicit Numbered(PageMesh<D>& page) : page_(page), nodes_(count_nodes(*page.mesh)), elements_(page.keys.size()) {}

    void add(const std::array<NodeNumber, 6>& nodes) {
        const std::size_t count = page_.degree == 2 ? 6 : 3;
        for (std::size_t i = 0; i < count; ++i) page_.face_nodes.push_back(nodes_.of(nodes[i]));
    }
    void add_owner(std::size_t element) { page_.owners.push_back(elements_.of(element)); }
    void finish() {
        page_.nodes = std::move(nodes_).items();
        page_.elements = std::move(elements_).items();
    }

  private:
    PageMesh<D>& page_;
    Numbering nodes_, elements_;
};

template <int D>
void number(PageMesh<D>& page, const CheckReport& report) {
    Numbered<D> numbered(page);
    for (const Face& face : page.outer) {
        numbered.add(face.nodes);
        numbered.add_owner(face.element);
    }
    for (const InnerFace& face : page.inner.faces) {
        numbered.add(face.nodes);
        numbered.add_owner(face.element);
        numbered.add_owner(face.other);
    }
    for (const ElementReport& element : report.worst) {
        const auto faces = faces_of_element(*page.mesh, element.number - 1);
        page.worst.push_back(worst_of(page, element, faces));
        for (const auto& nodes : faces) {
            numbered.add(nodes);
            numbered.add_owner(element.number - 1);
        }
        page.worst_faces += faces.size();
    }
    numbered.finish();
}

/// Position of a node in the page: of a vertex relative to the centre, of an edge node relative to the chord's
/// midpoint.
template <int D>
Vec<D> page_position(const PageMesh<D>& page, NodeNumber n) {
    const Mesh<D>& mesh = *page.mesh;
    const std::size_t vertices = mesh.points.size();
    if (n < vertices) return mesh.points[n] - page.centre;
    const auto& [a, b] = mesh.entities.edges[n - vertices];
    const Vec<D> off = mesh.edge_nodes[n - vertices].point - 0.5 * (mesh.points[a] + mesh.points[b]);
    const double chord = distance(mesh.points[a], mesh.points[b]);
    return norm(off) > 1e-7 * chord ? off : Vec<D>{};  // smaller offsets are invisible rounding errors
}

template <int D>
PageArray node_array(const PageMesh<D>& page) {
    const std::size_t n = page.nodes.size(), vertices = page.mesh->points.size();
    // Offsets of edge nodes are small and may be rounded. Rounded vertices would cause gaps between faces.
    std::vector<float> columns(n * D);
    for (std::size_t i = 0; i < n; ++i) {
        const Vec<D> place = page_position(page, page.nodes[i]);
        for (int axis = 0; axis < D; ++axis)
            columns[static_cast<std::size_t>(axis) * n + i] = page.nodes[i] < vertices
                                                                  ? static_cast<float>(place[axis])
                                                                  : rounded_float(static_cast<float>(place[axis]));
    }
    return array_of_floats("nodes", columns);
}

}  // namespace

template <int D>
Outcome<PageMesh<D>> page_mesh(const Mesh<D>& mesh, const CheckReport& report, const PageOptions& options,
                               const Execution& execution) {
    return guarded([&]() -> Outcome<PageMesh<D>> {
        PageMesh<D> page{.mesh = &mesh, .degree = report.mesh.degree};
        const auto faces = faces_to_draw(mesh, {}, part_of(execution, 0, 0.3));
        if (!faces) return fail(faces.error());
        if (faces->empty())
            return fail(ErrorKind::input, "has no elements and no faces: there is nothing to show", {}, {},
                        "give a mesh with triangles or tetrahedra");
        for (const Face& face : *faces)
            for (std::size_t i = 0; i < 3; ++i) page.box.include(node_point(mesh, face.nodes[i]));
        page.outer = along_curve(mesh, *faces, page.box);
        set_size(page);
        auto keys = cut_keys(straight_simplices(mesh), page.box, part_of(execution, 0.3, 0.4));
        if (!keys) return fail(keys.error());
        page.keys = std::move(*keys);
        page.inner.steps = every_step();
        if constexpr (D == 3)
            if (!is_standalone_surface(mesh)) {
                auto inner = inner_faces(mesh, page.keys, options.inner_faces, part_of(execution, 0.4, 1));
                if (!inner) return fail(inner.error());
                page.inner = std::move(*inner);
            }
        number(page, report);
        return page;
    });
}

template <int D>
std::vector<PageArray> arrays_of(const PageMesh<D>& page) {
    const std::size_t elements = page.elements.size();
    PageArray keys{"keys", std::vector<std::uint8_t>(D * elements)};
    for (std::size_t axis = 0; axis < D; ++axis)
        for (std::size_t e = 0; e < elements; ++e) keys.bytes[axis * elements + e] = page.keys[page.elements[e]][axis];
    std::vector<PageArray> arrays;
    arrays.push_back(node_array(page));
    arrays.push_back(array_of_ids("faces", page.face_nodes));
    arrays.push_back(array_of_ids("owners", page.owners));
    arrays.push_back(std::move(keys));
    return arrays;
}

#define CAMBER_INSTANTIATE(D)                                                                          \
    template Outcome<PageMesh<D>> page_mesh<D>(const Mesh<D>&, const CheckReport&, const PageOptions&, \
                                               const Execution&);                                      \
    template std::vector<PageArray> arrays_of<D>(const PageMesh<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
