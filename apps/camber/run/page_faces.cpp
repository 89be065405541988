module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.run;
import camber.core;
import camber.bezier;
import camber.drawing;
import camber.soundness;
import :check;
import :page;
import :page_arrays;
import :page_mesh;
import :page_parts;

namespace camber::run {

namespace {

/// Numbers anew, by first use.
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

/// Nodes of faces and their elements, by the numbers of the page.
template <int D>
class Numbered {
  public:
    explicit Numbered(PageMesh<D>& page)
        : page_(page), nodes_(page.mesh->linear.points.size() + page.mesh->edges.size()), elements_(page.keys.size()) {}

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

/// A node as the page has it: a vertex from the centre, a node of an edge from the middle of the chord.
template <int D>
Vec<D> told(const PageMesh<D>& page, NodeNumber n) {
    const QuadraticMesh<D>& mesh = *page.mesh;
    const std::size_t vertices = mesh.linear.points.size();
    if (n < vertices) return mesh.linear.points[n] - page.centre;
    const auto& [a, b] = mesh.edges.vertices[n - vertices];
    const Vec<D> off = mesh.mid_nodes[n - vertices].point - 0.5 * (mesh.linear.points[a] + mesh.linear.points[b]);
    const double chord = distance(mesh.linear.points[a], mesh.linear.points[b]);
    return norm(off) > 1e-7 * chord ? off : Vec<D>{};  // rounding, of which nothing is seen
}

template <int D>
PageArray node_array(const PageMesh<D>& page) {
    const std::size_t n = page.nodes.size(), vertices = page.mesh->linear.points.size();
    // Offsets of edges' nodes are small and may be rounded, vertices may not: a face would not meet its neighbour.
    std::vector<float> columns(n * D);
    for (std::size_t i = 0; i < n; ++i) {
        const Vec<D> place = told(page, page.nodes[i]);
        for (int axis = 0; axis < D; ++axis)
            columns[static_cast<std::size_t>(axis) * n + i] = page.nodes[i] < vertices
                                                                  ? static_cast<float>(place[axis])
                                                                  : rounded_float(static_cast<float>(place[axis]));
    }
    return array_of_floats("nodes", columns);
}

}  // namespace

template <int D>
Outcome<PageMesh<D>> page_mesh(const QuadraticMesh<D>& mesh, const CheckReport& report, const PageOptions& options,
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
        auto keys = cut_keys(mesh.linear, page.box, part_of(execution, 0.3, 0.4));
        if (!keys) return fail(keys.error());
        page.keys = std::move(*keys);
        page.inner.steps = every_step();
        if constexpr (D == 3)
            if (!is_surface_alone(mesh.linear)) {
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

#define CAMBER_INSTANTIATE(D)                                                                                   \
    template Outcome<PageMesh<D>> page_mesh<D>(const QuadraticMesh<D>&, const CheckReport&, const PageOptions&, \
                                               const Execution&);                                               \
    template std::vector<PageArray> arrays_of<D>(const PageMesh<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
