module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>
module camber.distributed;
import camber.core;
import camber.bezier;
import camber.validity;
import :ringed_parts;
import :check_part;

namespace camber {

namespace {

auto unsound(const std::string& what, const char* kind, GlobalNumber row) {
    return fail(ErrorKind::input, what, {}, Entity{kind, row + 1},
                "camber convert IN -o OUT mends what can be mended; blocks take a mesh as it is");
}

/// The lowest row, over all chunks, at which something is wrong.
constexpr std::size_t none = static_cast<std::size_t>(-1);

template <int D>
Outcome<std::size_t> first_not_positive(const RingedPart<D>& part, const Execution& execution) {
    return reduce_each(
        execution, part.mesh.elements.size(), none,
        [&](std::size_t& first, std::size_t e) {
            const auto& vertices = part.mesh.elements.vertices[e];
            if (!part.owns(vertices)) return;
            std::array<Vec<D>, D + 1> corners;
            for (std::size_t i = 0; i <= D; ++i) corners[i] = part.mesh.points[vertices[i]];
            if (!(signed_volume<D>(corners) > 0)) first = std::min(first, e);
        },
        [](std::size_t a, std::size_t b) { return std::min(a, b); });
}

/// Vertices that rise.
template <std::size_t N>
std::array<VertexId, N> sorted(std::array<VertexId, N> simplex) {
    std::ranges::sort(simplex);
    return simplex;
}

template <int D>
std::vector<std::array<VertexId, D>> sorted_facets(const RingedPart<D>& part) {
    std::vector<std::array<VertexId, D>> facets;
    for (const auto& facet : part.mesh.facets.vertices) facets.push_back(sorted(facet));
    std::ranges::sort(facets);
    return facets;
}

}  // namespace

template <int D>
Outcome<Done> check_part(const RingedPart<D>& part, const Execution& execution) {
    const auto inverted = first_not_positive(part, execution);
    if (!inverted) return fail(inverted.error());
    if (*inverted != none) return unsound("is flat or inverted", simplex_name<D>, part.elements[*inverted]);
    const auto around = balls(part.mesh, execution);
    if (!around) return fail(around.error());
    const auto facets = sorted_facets(part);
    std::vector<FaceAround<D>> faces;
    for (VertexId v = part.first; v < part.last; v = VertexId(v.index() + 1)) {
        faces_around<D>(part.mesh, *around, v, faces);
        for (std::size_t first = 0, last = 0; first < faces.size(); first = last) {
            while (last < faces.size() && faces[last].others == faces[first].others) ++last;
            const GlobalNumber element = part.elements[faces[first].face.element];
            if (last - first > 2) return unsound("has a face that three elements share", simplex_name<D>, element);
            const auto reference_of = [&](std::size_t at) {
                return part.mesh.elements.references[faces[at].face.element];
            };
            const bool is_boundary = last - first == 1;
            if (!is_boundary && reference_of(first) == reference_of(first + 1)) continue;
            std::array<VertexId, D> facet;
            facet[0] = v;
            std::ranges::copy(faces[first].others, facet.begin() + 1);
            if (!std::ranges::binary_search(facets, sorted(facet)))
                return unsound(is_boundary ? "has a face on the boundary that the mesh lists no facet for"
                                           : "has a face towards another material that the mesh lists no facet for",
                               simplex_name<D>, element);
        }
    }
    return Done{};
}

#define CAMBER_INSTANTIATE(D) template Outcome<Done> check_part<D>(const RingedPart<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
