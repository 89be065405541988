module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
module camber.run;
import camber.core;
import camber.drawing;
import camber.io;
import camber.validity;
import :picture;
import :picture_values;
import :solution;

namespace camber::run {

namespace {

PictureColour usual_colour(const PictureInputs& inputs, int degree) {
    if (inputs.solution) return PictureColour::solution;
    if (inputs.metric) return PictureColour::anisotropy;
    return degree == 2 ? PictureColour::scaled_jacobian : PictureColour::quality;
}

/// Obliquely from in front, or onto the faces that a cut uncovers.
View usual_view(const std::optional<Cut<3>>& cut) {
    if (!cut) return view_from(Vec<3>{{1, -1.6, 0.9}});
    const Vec<3> n = normalised(cut->normal);
    const View straight = view_from(n);
    return view_from(n - 0.45 * straight.right + 0.35 * straight.up);
}
template <int D>
View view_of(const PictureChoice& choice) {
    if constexpr (D == 2)
        return View{};
    else
        return choice.from ? view_from(*choice.from) : usual_view(choice.cut);
}

template <int D>
Cut<D> cut_in(const Cut<3>& cut) {
    Cut<D> own{{}, cut.offset};
    for (int i = 0; i < D; ++i) own.normal[i] = cut.normal[i];
    return own;
}

/// Where the middle of the reference element is.
template <int K, int D>
Vec<3> middle_of(const QuadraticMesh<D>& mesh, const SimplexVertices<K>& vertices,
                 const std::array<EdgeId, edges_per_simplex<K>>& edges) {
    std::array<double, K + 1> xi{};
    xi.fill(1.0 / (K + 1));
    Vec<3> middle{};
    for (const VertexId v : vertices) middle += vertex_shape(xi[0]) * in_space(mesh.linear.points[v]);
    for (const EdgeId e : edges) middle += edge_shape<K>(xi, 0) * in_space(mesh.mid_nodes[e].point);
    return middle;
}
template <int D>
Vec<3> middle_of(const QuadraticMesh<D>& mesh, std::size_t e) {
    if (is_surface_alone(mesh.linear))
        return middle_of<D - 1>(mesh, mesh.linear.facets.vertices[e], mesh.edges.of_facets[e]);
    return middle_of<D>(mesh, mesh.linear.elements.vertices[e], mesh.edges.of_elements[e]);
}

/// The worst first.
std::vector<std::uint32_t> worst_of(const Column<float>& goodness, std::size_t count) {
    std::vector<std::uint32_t> order(goodness.size());
    std::iota(order.begin(), order.end(), 0U);
    const auto key = [&](std::uint32_t e) { return std::isnan(goodness[e]) ? -HUGE_VALF : goodness[e]; };
    const std::size_t shown = std::min(count, order.size());
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(shown), order.end(),
                      [&](std::uint32_t a, std::uint32_t b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
    order.resize(shown);
    return order;
}

template <int D>
Outcome<Scene> picture(const PictureInputs& inputs, const PictureChoice& choice, int degree,
                       const Execution& execution) {
    const auto mesh = of_degree_2<D>(inputs.mesh.mesh, part_of(execution, 0, 0.2));
    if (!mesh) return fail(mesh.error());
    Column<std::uint8_t> kept;
    if (choice.cut) {
        auto found = kept_by(cut_in<D>(*choice.cut), mesh->linear, without_progress(execution));
        if (!found) return fail(found.error());
        kept = std::move(*found);
    }
    const auto faces = faces_to_draw(*mesh, kept.view(), part_of(execution, 0.2, 0.5));
    if (!faces) return fail(faces.error());
    auto values = picture_values(*mesh, choice.colour.value_or(usual_colour(inputs, degree)), inputs,
                                 part_of(execution, 0.5, 0.8));
    if (!values) return fail(values.error());
    PictureOptions options{choice.width,
                           choice.height,
                           choice.background,
                           choice.edges,
                           std::move(values->colouring),
                           std::move(values->title),
                           view_of<D>(choice),
                           choice.zoom};
    std::vector<std::uint32_t> worst;
    if (choice.worst > 0) {
        const auto goodness = element_goodness(*mesh, degree, part_of(execution, 0.8, 0.9));
        if (!goodness) return fail(goodness.error());
        worst = worst_of(*goodness, choice.worst);
        for (std::size_t i = 0; i < worst.size(); ++i)
            options.pointers.push_back({middle_of(*mesh, worst[i]), std::to_string(i + 1)});
        std::sort(worst.begin(), worst.end());
    }
    return make_scene(*mesh, faces->view(), values->of_face, worst, std::move(options), part_of(execution, 0.9, 1));
}

}  // namespace

Outcome<Scene> picture_of(const PictureInputs& inputs, const PictureChoice& choice, const Execution& execution) {
    return std::visit(
        [&]<class Mesh>(const Mesh&) {
            return picture<Mesh::dimension>(inputs, choice, std::is_same_v<Mesh, LinearMesh<Mesh::dimension>> ? 1 : 2,
                                            execution);
        },
        inputs.mesh.mesh);
}

}  // namespace camber::run
