// Colours, faces and scenes of pictures.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>
module camber.drawing;
import camber.core;

namespace camber {

namespace {

constexpr Colour rgb(std::uint32_t hexadecimal) {
    const auto part = [&](std::uint32_t shift) { return static_cast<double>((hexadecimal >> shift) & 0xffU) / 255; };
    return {part(16), part(8), part(0)};
}

// Colours from low to high values. Lightness increases along the plain ramp; the quality ramp goes from dark red over
// pale tones to blue.
constexpr std::array plain_ramp{rgb(0x2c2a6e), rgb(0x2c64a8), rgb(0x2f9fa6), rgb(0x8fca74), rgb(0xf7e26b)};
constexpr std::array quality_ramp{rgb(0x7d1630), rgb(0xd2553a), rgb(0xf0b867), rgb(0xcfe0c8), rgb(0x8fbfd0)};
constexpr std::array kinds{rgb(0x6ea6d7), rgb(0xf0a35e), rgb(0x7fc08a), rgb(0xd98a9c), rgb(0xb79bd6),
                           rgb(0xd6c35a), rgb(0x6fc2c2), rgb(0xc79a7b), rgb(0xa3b86c), rgb(0x9aa7b5)};

Colour along(const std::array<Colour, 5>& ramp, double place) {
    const double x = std::clamp(place, 0.0, 1.0) * 4;
    const auto i = std::min<std::size_t>(static_cast<std::size_t>(x), 3);
    return blend(ramp[i], ramp[i + 1], x - static_cast<double>(i));
}

}  // namespace

std::string hex(const Colour& colour) {
    constexpr char digits[] = "0123456789abcdef";
    std::string text = "#";
    for (const double part : {colour.red, colour.green, colour.blue}) {
        const auto byte = static_cast<std::size_t>(std::lround(std::clamp(part, 0.0, 1.0) * 255));
        text += digits[byte / 16];
        text += digits[byte % 16];
    }
    return text;
}

Theme theme_of(Background background) {
    if (background == Background::dark)
        return {rgb(0x14181f), rgb(0xdfe5ec), rgb(0x0d1117), rgb(0xb9c6d3), rgb(0x59616b), rgb(0xff4fa3)};
    return {rgb(0xffffff), rgb(0x23282f), rgb(0x1c2530), rgb(0xcbd8e4), rgb(0xb5b5b5), rgb(0xd5127f)};
}

double ColourRange::place_of(double value) const {
    if (!(high > low)) return 0.5;
    const double place = spacing == Spacing::linear ? (value - low) / (high - low) : log(value / low) / log(high / low);
    return std::clamp(place, 0.0, 1.0);
}
double ColourRange::value_at(double place) const {
    return spacing == Spacing::linear ? low + place * (high - low) : low * pow(high / low, place);
}

Colour colour_at(Ramp ramp, double place) { return along(ramp == Ramp::plain ? plain_ramp : quality_ramp, place); }
Colour colour_of_kind(std::size_t i) { return kinds[i % kinds.size()]; }

Colour colour_of(const Colouring& colouring, double value, const Theme& theme) {
    if (std::holds_alternative<OneColour>(colouring)) return theme.plain;
    if (const auto* range = std::get_if<ColourRange>(&colouring)) {
        // An infinite value gets the colour of an end of the ramp: minus infinity marks the worst quality.
        if (std::isnan(value)) return theme.missing;
        if (range->spacing == Spacing::logarithmic && !(value > 0)) return colour_at(range->ramp, 0);
        return colour_at(range->ramp, std::isinf(value) ? (value > 0 ? 1 : 0) : range->place_of(value));
    }
    const double place = std::round(value);
    const auto count = static_cast<double>(std::get<ColourKinds>(colouring).numbers.size());
    return place >= 0 && place < count ? colour_of_kind(static_cast<std::size_t>(place)) : theme.missing;
}

namespace {

template <int D>
bool is_of_facets(const LinearMesh<D>& mesh) {
    return D == 3 && mesh.elements.size() == 0;
}

template <int D, std::size_t N>
Vec<D> centroid(const LinearMesh<D>& mesh, const std::array<VertexId, N>& vertices) {
    Vec<D> sum{};
    for (const VertexId v : vertices) sum += mesh.points[v];
    return sum / static_cast<double>(N);
}

NodeNumber number_of(VertexId v) { return v.value; }

template <int K>
constexpr std::size_t local_edge(int a, int b) {
    for (std::size_t e = 0; e < local_edges<K>.size(); ++e)
        if ((local_edges<K>[e][0] == a && local_edges<K>[e][1] == b) ||
            (local_edges<K>[e][0] == b && local_edges<K>[e][1] == a))
            return e;
    return 0;
}

template <int K>
std::array<NodeNumber, 6> nodes_of(const SimplexVertices<K>& vertices,
                                   const std::array<EdgeId, edges_per_simplex<K>>& edges,
                                   const std::array<int, 3>& local, std::size_t vertex_count) {
    std::array<NodeNumber, 6> nodes{};
    for (std::size_t i = 0; i < 3; ++i) {
        nodes[i] = number_of(vertices[local[i]]);
        const std::size_t edge = local_edge<K>(local[i], local[(i + 1) % 3]);
        nodes[3 + i] = static_cast<NodeNumber>(vertex_count + edges[edge].index());
    }
    return nodes;
}

template <int K, class Edges>
Column<Face> whole_triangles(const Simplices<K>& triangles, const Edges& edges, std::size_t vertex_count,
                             std::span<const std::uint8_t> selected, FaceKind kind) {
    Buffer<Face> faces;
    faces.reserve(triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t)
        if (selected.empty() || selected[t] != 0)
            faces.push_back({nodes_of<K>(triangles.vertices[t], edges[t], {0, 1, 2}, vertex_count),
                             static_cast<std::uint32_t>(t), triangles.references[t], kind});
    return faces;
}

enum class FaceVisibility : std::uint8_t { no, boundary, uncovered, facet };
using FaceVisibilities = std::array<FaceVisibility, 4>;  ///< entry i: the face opposite local vertex i

std::optional<Reference> reference_of_facet(const LinearMesh<3>& mesh, const Incidence<FacetId>& facets,
                                            std::array<VertexId, 3> vertices) {
    std::sort(vertices.begin(), vertices.end());
    for (const FacetId f : facets[vertices[0]]) {
        auto other = mesh.facets.vertices[f];
        std::sort(other.begin(), other.end());
        if (other == vertices) return mesh.facets.references[f];
    }
    return {};
}

bool contains(const std::vector<Reference>& sorted, Reference reference) {
    return std::binary_search(sorted.begin(), sorted.end(), reference);
}

std::array<VertexId, 3> vertices_of_face(const LinearMesh<3>& mesh, std::size_t element, int opposite) {
    const auto local = face_opposite<3>(opposite);
    const auto& v = mesh.elements.vertices[element];
    return {v[local[0]], v[local[1]], v[local[2]]};
}

/// Several threads may write to the result, because each face belongs to one call of the visitor.
Outcome<Buffer<FaceVisibilities>> face_visibilities(const LinearMesh<3>& mesh, const Incidence<FacetId>& facets,
                                                    std::span<const std::uint8_t> selected, const DrawnGroups& groups,
                                                    const Execution& execution) {
    const auto balls_of = balls(mesh, part_of(execution, 0, 0.4));
    if (!balls_of) return fail(balls_of.error());
    Buffer<FaceVisibilities> visibility(mesh.elements.size());
    std::fill(visibility.begin(), visibility.end(), FaceVisibilities{});
    const auto is_selected = [&](const FaceAround<3>& f) {
        return selected.empty() || selected[f.face.element.index()] != 0;
    };
    const auto is_body = [&](const FaceAround<3>& f) {
        return is_selected(f) && (groups.bodies.empty() || groups.bodies[f.face.element.index()] != 0);
    };
    const auto show_facet = [&](std::span<const FaceAround<3>> on) {
        const auto f = std::find_if(on.begin(), on.end(), is_selected);
        if (f == on.end()) return;
        const auto reference =
            reference_of_facet(mesh, facets, vertices_of_face(mesh, f->face.element.index(), f->face.opposite));
        if ((reference || on.size() == 1) && contains(groups.shown, reference.value_or(0)))
            visibility[f->face.element.index()][f->face.opposite] = FaceVisibility::facet;
    };
    auto done = each_face<3>(mesh, *balls_of, part_of(execution, 0.4, 0.9), [&](std::span<const FaceAround<3>> on) {
        // In an invalid mesh, more than two elements may share a face. It is then drawn for each of them.
        if (!groups.shown.empty() && std::none_of(on.begin(), on.end(), is_body)) return show_facet(on);
        if (on.size() == 2 && is_body(on[0]) == is_body(on[1])) return;
        for (const FaceAround<3>& f : on)
            if (is_body(f))
                visibility[f.face.element.index()][f.face.opposite] =
                    on.size() == 1 ? FaceVisibility::boundary : FaceVisibility::uncovered;
    });
    if (!done) return fail(done.error());
    return visibility;
}

Outcome<Column<Face>> faces_of_tetrahedra(const QuadraticMesh<3>& mesh, std::span<const std::uint8_t> selected,
                                          const DrawnGroups& groups, const Execution& execution) {
    const LinearMesh<3>& linear = mesh.linear;
    const auto facets = facet_balls(linear, part_of(execution, 0, 0.1));
    if (!facets) return fail(facets.error());
    const auto visibility = face_visibilities(linear, *facets, selected, groups, part_of(execution, 0.1, 0.9));
    if (!visibility) return fail(visibility.error());
    const auto kind_of = [](FaceVisibility how) {
        return how == FaceVisibility::boundary ? FaceKind::boundary
               : how == FaceVisibility::facet  ? FaceKind::facet
                                               : FaceKind::uncovered;
    };
    Buffer<Face> faces;
    for (std::size_t e = 0; e < visibility->size(); ++e)
        for (int i = 0; i < 4; ++i) {
            const FaceVisibility how = (*visibility)[e][i];
            if (how == FaceVisibility::no) continue;
            const bool is_uncovered = how == FaceVisibility::uncovered;
            std::optional<Reference> facet;
            if (!is_uncovered || !groups.hidden.empty())
                facet = reference_of_facet(linear, *facets, vertices_of_face(linear, e, i));
            if ((!is_uncovered || facet) && contains(groups.hidden, facet.value_or(0))) continue;
            faces.push_back({nodes_of<3>(linear.elements.vertices[e], mesh.edges.of_elements[e], face_opposite<3>(i),
                                         linear.points.size()),
                             static_cast<std::uint32_t>(e),
                             is_uncovered ? linear.elements.references[e] : facet.value_or(0), kind_of(how)});
        }
    return Column<Face>(std::move(faces));
}

}  // namespace

template <int D>
Outcome<Column<std::uint8_t>> elements_inside_cut(const Cut<D>& cut, const Mesh<D>& whole, const Execution& execution) {
    const LinearMesh<D> mesh = straight_simplices(whole);
    const auto stays = [&](const Vec<D>& c) { return static_cast<std::uint8_t>(dot(cut.normal, c) <= cut.offset); };
    auto selected = is_of_facets(mesh)
                        ? map_each(execution, mesh.facets.size(),
                                   [&](std::size_t f) { return stays(centroid(mesh, mesh.facets.vertices[f])); })
                        : map_each(execution, mesh.elements.size(),
                                   [&](std::size_t e) { return stays(centroid(mesh, mesh.elements.vertices[e])); });
    if (!selected) return fail(selected.error());
    return Column<std::uint8_t>(std::move(*selected));
}

template <int D>
Outcome<Column<Face>> faces_to_draw(const Mesh<D>& mesh, std::span<const std::uint8_t> selected,
                                    const Execution& execution) {
    const auto quadratic = as_quadratic(mesh);
    if (!quadratic) return fail(quadratic.error());
    return guarded([&]() -> Outcome<Column<Face>> {
        const LinearMesh<D>& linear = quadratic->linear;
        if constexpr (D == 2)
            return whole_triangles<2>(linear.elements, quadratic->edges.of_elements, linear.points.size(), selected,
                                      FaceKind::plane);
        else if (is_of_facets(linear))
            return whole_triangles<2>(linear.facets, quadratic->edges.of_facets, linear.points.size(), selected,
                                      FaceKind::boundary);
        else
            return faces_of_tetrahedra(*quadratic, selected, {}, execution);
    });
}

Outcome<Column<Face>> faces_to_draw(const Mesh<3>& mesh, std::span<const std::uint8_t> selected,
                                    const DrawnGroups& groups, const Execution& execution) {
    const auto quadratic = as_quadratic(mesh);
    if (!quadratic) return fail(quadratic.error());
    return guarded([&] { return faces_of_tetrahedra(*quadratic, selected, groups, execution); });
}

template <int D>
Column<FaceEdge> edges_to_draw(const Mesh<D>& mesh, std::span<const Face> faces) {
    const std::size_t vertices = mesh.points.size();
    const auto& ends = mesh.entities.edges;
    Buffer<std::uint32_t> counts(ends.size());
    std::fill(counts.begin(), counts.end(), 0U);
    for (const Face& face : faces)
        for (std::size_t i = 3; i < 6; ++i) ++counts[face.nodes[i] - vertices];
    Buffer<FaceEdge> edges;
    for (std::size_t e = 0; e < counts.size(); ++e)
        if (counts[e] > 0)
            edges.push_back(
                {{number_of(ends[e][0]), number_of(ends[e][1]), static_cast<NodeNumber>(vertices + e)}, counts[e]});
    return edges;
}

namespace {

PaperFrame frame_of(const PictureOptions& o) {
    const auto w = static_cast<double>(o.width), h = static_cast<double>(o.height);
    const double margin = 0.04 * std::min(w, h), legend = o.has_legend() ? legend_width(o) : 0;
    return {margin, margin, std::max(w - 2 * margin - legend, 1.0), std::max(h - 2 * margin, 1.0)};
}

Vec<3> in_view(const View& view, const Vec<3>& p) {
    return {{dot(view.right, p), dot(view.up, p), dot(view.towards, p)}};
}

PaperFrame clip_of(const PaperFrame& frame) {
    const double side = std::min(frame.width, frame.height);
    return {frame.left + (frame.width - side) / 2, frame.top + (frame.height - side) / 2, side, side};
}

template <int D>
Box<3> box_of(const Mesh<D>& mesh, std::span<const Face> faces, const View& view) {
    Box<3> box;
    for (const Face& face : faces) {
        DrawnFace patch;
        for (std::size_t i = 0; i < 6; ++i) patch.nodes[i] = in_view(view, in_space(node_point(mesh, face.nodes[i])));
        for (std::size_t i = 0; i < 3; ++i) {
            box.include(patch.nodes[i]);
            box.include(patch.nodes[3 + i]);
        }
    }
    return box;
}

Box<3> box_of(const PictureOptions::Zoom& zoom, const View& view) {
    const Vec<3> c = in_view(view, zoom.centre);
    Box<3> box;
    for (const double sign : {-1.0, 1.0}) box.include(c + sign * zoom.radius * Vec<3>{{1, 1, 1}});
    return box;
}

LineKind line_kind(std::uint32_t faces) { return faces == 1 ? LineKind::rim : LineKind::shared; }

}  // namespace

template <int D>
Outcome<Scene> make_scene(const Mesh<D>& mesh, std::span<const Face> faces, const FaceValues& values,
                          std::span<const std::uint32_t> marked, PictureOptions options, const Execution& execution) {
    if (faces.empty())
        return fail(ErrorKind::input,
                    "there is nothing to draw: the mesh has no elements, or a cut or hidden groups remove all of them",
                    {}, {}, "cut elsewhere or show more groups; camber info prints the mesh's box and groups");
    return guarded([&]() -> Outcome<Scene> {
        const View& view = options.view;
        const Box<3> box = options.zoom ? box_of(*options.zoom, view) : box_of(mesh, faces, view);
        const PaperFrame frame = frame_of(options);
        const PaperProjection projection = fitted(view, box, frame);
        const auto clip = options.zoom ? std::optional(clip_of(frame)) : std::nullopt;
        Buffer<std::uint32_t> of_edges(mesh.entities.edges.size());
        std::fill(of_edges.begin(), of_edges.end(), 0U);
        const std::size_t vertices = mesh.points.size();
        for (const Face& face : faces)
            for (std::size_t i = 3; i < 6; ++i) ++of_edges[face.nodes[i] - vertices];
        auto patches = map_each(execution, faces.size(), [&](std::size_t f) {
            const Face& face = faces[f];
            DrawnFace patch;
            for (std::size_t i = 0; i < 6; ++i) patch.nodes[i] = projection(in_space(node_point(mesh, face.nodes[i])));
            patch.values = values(face);
            patch.face = static_cast<std::uint32_t>(f);
            patch.is_marked = std::binary_search(marked.begin(), marked.end(), face.element);
            if (options.edges == Edges::shown || patch.is_marked)
                for (std::size_t i = 0; i < 3; ++i) patch.lines[i] = line_kind(of_edges[face.nodes[3 + i] - vertices]);
            // Marked elements of a 2D mesh are moved nearer to the viewer, so that their lines are drawn last.
            if (D == 2 && patch.is_marked)
                for (Vec<3>& node : patch.nodes) node[2] += 1;
            return patch;
        });
        if (!patches) return fail(patches.error());
        const bool is_solid = D == 3 && count_elements(mesh) > 0;
        return Scene{std::move(options),
                     projection,
                     is_solid ? VisibleSides::outer : VisibleSides::both,
                     D == 3 ? Lighting::lit : Lighting::flat,
                     std::move(*patches),
                     clip};
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template Outcome<Column<std::uint8_t>> elements_inside_cut<D>(const Cut<D>&, const Mesh<D>&, const Execution&);   \
    template Outcome<Column<Face>> faces_to_draw<D>(const Mesh<D>&, std::span<const std::uint8_t>, const Execution&); \
    template Column<FaceEdge> edges_to_draw<D>(const Mesh<D>&, std::span<const Face>);                                \
    template Outcome<Scene> make_scene<D>(const Mesh<D>&, std::span<const Face>, const FaceValues&,                   \
                                          std::span<const std::uint32_t>, PictureOptions, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
