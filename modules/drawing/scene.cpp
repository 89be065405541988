module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
module camber.drawing;
import camber.core;

namespace camber {

namespace {

/// Room for the mesh: the legend has its own at the right.
PaperFrame frame_of(const PictureOptions& o) {
    const auto w = static_cast<double>(o.width), h = static_cast<double>(o.height);
    const double margin = 0.04 * std::min(w, h), legend = o.has_legend() ? legend_width(o) : 0;
    return {margin, margin, std::max(w - 2 * margin - legend, 1.0), std::max(h - 2 * margin, 1.0)};
}

Vec<3> in_view(const View& view, const Vec<3>& p) {
    return {{dot(view.right, p), dot(view.up, p), dot(view.towards, p)}};
}

/// Of the nodes: the margin has room for what bows beyond them.
template <int D>
Box<3> box_of(const QuadraticMesh<D>& mesh, std::span<const Face> faces, const View& view) {
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
Outcome<Scene> make_scene(const QuadraticMesh<D>& mesh, std::span<const Face> faces, const FaceValues& values,
                          std::span<const std::uint32_t> marked, PictureOptions options, const Execution& execution) {
    if (faces.empty())
        return fail(ErrorKind::input, "there is nothing to draw: no element, or the cut takes all of them", {}, {},
                    "cut elsewhere, or not at all; camber info tells the mesh's box");
    return guarded([&]() -> Outcome<Scene> {
        const View& view = options.view;
        const Box<3> box = options.zoom ? box_of(*options.zoom, view) : box_of(mesh, faces, view);
        const PaperProjection projection = fitted(view, box, frame_of(options));
        Buffer<std::uint32_t> of_edges(mesh.edges.size());
        std::fill(of_edges.begin(), of_edges.end(), 0U);
        const std::size_t vertices = mesh.linear.points.size();
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
            // In 2D nothing lies before anything else, but what is marked is to be seen.
            if (D == 2 && patch.is_marked)
                for (Vec<3>& node : patch.nodes) node[2] += 1;
            return patch;
        });
        if (!patches) return fail(patches.error());
        const bool is_solid = D == 3 && mesh.linear.elements.size() > 0;
        return Scene{std::move(options), projection, is_solid ? VisibleSides::outer : VisibleSides::both,
                     D == 3 ? Lighting::lit : Lighting::flat, std::move(*patches)};
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                \
    template Outcome<Scene> make_scene<D>(const QuadraticMesh<D>&, std::span<const Face>, const FaceValues&, \
                                          std::span<const std::uint32_t>, PictureOptions, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
