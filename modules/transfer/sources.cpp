module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
module camber.transfer;
import :key_table;
import :materials;
import :simplex;
import :sources;
import camber.core;
import camber.bezier;
import camber.metric;

namespace camber {

namespace {

/// Some elements of a mesh with the vertices and edges that they have, numbered anew; `number` is all invalid, before
/// and after.
template <int D>
QuadraticMesh<D> part_of_mesh(const QuadraticMesh<D>& mesh, const std::vector<std::uint32_t>& elements,
                              Buffer<VertexId>& number) {
    Buffer<Vec<D>> points;
    Buffer<SimplexVertices<D>> simplices(elements.size());
    Buffer<std::array<EdgeId, edges_per_simplex<D>>> of_elements(elements.size());
    Buffer<Reference> references(elements.size());
    std::vector<VertexId> used;
    for (std::size_t i = 0; i < elements.size(); ++i) {
        for (int k = 0; k <= D; ++k) {
            const VertexId v = mesh.linear.elements.vertices[elements[i]][k];
            VertexId& mine = number[v.index()];
            if (!mine.valid()) {
                mine = VertexId(points.size());
                points.push_back(mesh.linear.points[v]);
                used.push_back(v);
            }
            simplices[i][k] = mine;
        }
        of_elements[i] = mesh.edges.of_elements[elements[i]];
        references[i] = mesh.linear.elements.references[elements[i]];
    }
    for (const VertexId v : used) number[v.index()] = {};
    QuadraticMesh<D> part;
    part.linear.points = std::move(points);
    part.linear.elements.vertices = std::move(simplices);
    part.linear.elements.references = std::move(references);
    part.edges.of_elements = std::move(of_elements);
    part.mid_nodes = mesh.mid_nodes;  // edges keep their numbers: location asks for nothing else of them
    return part;
}

template <int D>
bool is_near(const QuadraticMesh<D>& mesh, std::size_t e, const Vec<D>& p) {
    Box<D> box;
    for (const VertexId v : mesh.linear.elements.vertices[e]) box.include(mesh.linear.points[v]);
    const Vec<D> size = box.high - box.low;
    return box.distance_squared(p) <= 4 * norm_squared(size);
}

}  // namespace

template <int D>
Outcome<Done> Sources<D>::add_part(const QuadraticMesh<D>& mesh, std::size_t material,
                                   const std::vector<std::uint32_t>& elements, Buffer<VertexId>& number,
                                   const Execution& execution) {
    const bool is_all = elements.empty();
    QuadraticMesh<D> part = is_all ? mesh : part_of_mesh(mesh, elements, number);
    const auto around = balls(part.linear, execution);
    if (!around) return fail(around.error());
    auto locator = make_curved_locator(std::move(part), *around, execution);
    if (!locator) return fail(locator.error());
    parts_[material].locator = std::move(*locator);
    if (is_all) return Done{};
    for (std::size_t i = 0; i < elements.size(); ++i) number_in_part_[elements[i]] = static_cast<std::uint32_t>(i);
    parts_[material].elements = Buffer<std::uint32_t>(elements.begin(), elements.end());
    return Done{};
}

template <int D>
Outcome<Sources<D>> Sources<D>::make(const QuadraticMesh<D>& mesh, const Materials<D>& materials,
                                     const std::vector<std::uint8_t>& is_asked, const Execution& execution) {
    const Execution quiet = without_progress(execution);
    return guarded([&]() -> Outcome<Sources> {
        Sources sources;
        sources.parts_.resize(materials.size());
        std::vector<std::vector<std::uint32_t>> elements(materials.size());
        Buffer<VertexId> number;
        if (materials.size() > 1) {
            const std::size_t n = mesh.linear.elements.size();
            sources.number_in_part_.assign(n, none);
            sources.material_.assign(n, none);
            number.assign(mesh.linear.points.size(), VertexId{});
            for (std::size_t e = 0; e < n; ++e) {
                const std::size_t material = materials.of(mesh.linear, e);
                sources.material_[e] = static_cast<std::uint32_t>(material);
                if (material != materials.rest()) elements[material].push_back(static_cast<std::uint32_t>(e));
            }
        }
        for (std::size_t m = 0; m < materials.size(); ++m) {
            if (is_asked[m] == 0) continue;
            if (auto added = sources.add_part(mesh, m, elements[m], number, quiet); !added) return fail(added.error());
            report_progress(execution, m + 1, materials.size());
        }
        return sources;
    });
}

template <int D>
ElementId Sources<D>::hint_in(const Part& part, std::size_t material, const Vec<D>& p, std::uint32_t hint) const {
    if (hint == none) return part.locator.hint_for(p);
    ElementId near(hint);
    if (!part.elements.empty()) {
        if (material_[hint] != material) return part.locator.hint_for(p);
        near = ElementId(number_in_part_[hint]);
    }
    return is_near(part.locator.mesh, near.index(), p) ? near : part.locator.hint_for(p);
}

template <int D>
OldPlace<D> Sources<D>::find(const Vec<D>& p, std::size_t material, std::uint32_t hint) const {
    const Part& part = parts_[material];
    const Location<D> found = part.locator.locate(p, hint_in(part, material, p, hint));
    OldPlace<D> place{.element = found.element.value, .xi = found.xi, .placement = found.placement};
    if (found.placement != Placement::inside) {
        const ElementMap<D> map = element_map(part.locator.mesh, found.element.index());
        place.distance = norm(p - map.origin - map.relative.point(found.xi));
    }
    if (!part.elements.empty()) place.element = part.elements[place.element];
    return place;
}

template <int D>
std::uint32_t Sources<D>::across(std::size_t material, std::uint32_t element, std::size_t opposite) const {
    const Part& part = parts_[material];
    const bool is_all = part.elements.empty();
    const ElementId next = part.locator.neighbours[is_all ? element : number_in_part_[element]][opposite];
    if (!next.valid()) return none;
    return is_all ? next.value : part.elements[next.index()];
}

#define CAMBER_INSTANTIATE(D) template class Sources<D>;

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
