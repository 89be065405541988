module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.recovery;
import camber.core;

namespace camber {

Outcome<Done> check_materials(std::size_t references, std::size_t elements) {
    if (references == elements) return Done{};
    return fail(ErrorKind::input,
                "there are " + std::to_string(references) + " references for " + std::to_string(elements) + " elements",
                {}, {}, "give each element the reference of its material");
}

namespace {

/// The references around a vertex, rising and each once.
template <int D>
void find_materials(const LinearMesh<D>& mesh, std::span<const ElementId> ball, std::vector<Reference>& materials) {
    materials.clear();
    for (const ElementId e : ball) {
        const Reference material = mesh.elements.references[e];
        // Nearly always there is one: looked at before it is put in order.
        if (std::find(materials.begin(), materials.end(), material) == materials.end()) materials.push_back(material);
    }
    std::sort(materials.begin(), materials.end());
}

template <int D>
Outcome<MaterialRows> rows_of(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                              const Execution& execution) {
    if (auto one_each = check_materials(mesh.elements.references.size(), mesh.elements.size()); !one_each)
        return fail(one_each.error());
    const std::size_t n = balls.size();
    Buffer<std::uint32_t> offsets(n + 1);
    offsets[0] = 0;
    constexpr std::size_t grain = 4096;
    std::vector<std::vector<Reference>> kept((n + grain - 1) / grain);
    auto found = each_chunk(
        without_progress(execution), n,
        [&](std::size_t begin, std::size_t end) {
            std::vector<Reference> materials;
            auto& all = kept[begin / grain];
            for (std::size_t v = begin; v < end; ++v) {
                find_materials(mesh, balls[v], materials);
                offsets[v + 1] = static_cast<std::uint32_t>(materials.size());
                all.insert(all.end(), materials.begin(), materials.end());
            }
        },
        grain);
    if (!found) return fail(found.error());
    std::size_t total = 0;
    for (const auto& chunk : kept) total += chunk.size();
    if (total > max_entities)
        return fail(ErrorKind::unsupported, "a mesh of " + std::to_string(total) + " sides of vertices is too large");
    for (std::size_t v = 0; v < n; ++v) offsets[v + 1] += offsets[v];
    Buffer<Reference> materials;
    materials.reserve(total);
    for (const auto& chunk : kept) materials.insert(materials.end(), chunk.begin(), chunk.end());
    return MaterialRows{{std::move(offsets), std::move(materials)}};
}

template <int D>
Outcome<Buffer<std::uint8_t>> find_boundary_rows(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                 const MaterialRows& rows, const Execution& execution) {
    const auto across = neighbours(mesh, balls, execution);
    if (!across) return fail(across.error());
    const auto& materials = mesh.elements.references;
    Buffer<std::uint8_t> marks(rows.size(), 0);
    auto marked = each(execution, balls.size(), [&](std::size_t i) {
        const VertexId v(i);
        for (const ElementId e : balls[v])
            for (int f = 0; f <= D; ++f) {
                const ElementId other = (*across)[e][f];
                if (mesh.elements.vertices[e][f] != v && (!other.valid() || materials[other] != materials[e]))
                    marks[*rows.row(v, materials[e])] = 1;
            }
    });
    if (!marked) return fail(marked.error());
    return marks;
}

}  // namespace

template <int D>
Outcome<MaterialRows> material_rows(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                    const Execution& execution) {
    return guarded([&] { return rows_of(mesh, balls, execution); });
}

template <int D>
Outcome<Buffer<std::uint8_t>> boundary_rows(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                            const MaterialRows& rows, const Execution& execution) {
    return guarded([&] { return find_boundary_rows(mesh, balls, rows, execution); });
}

#define CAMBER_INSTANTIATE(D)                                                                                  \
    template Outcome<MaterialRows> material_rows<D>(const LinearMesh<D>&, const Incidence<ElementId>&,         \
                                                    const Execution&);                                         \
    template Outcome<Buffer<std::uint8_t>> boundary_rows<D>(const LinearMesh<D>&, const Incidence<ElementId>&, \
                                                            const MaterialRows&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
