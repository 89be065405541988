module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
module camber.soundness;
import camber.core;
import camber.validity;
import :examination;

namespace camber {

namespace {

/// For each simplex the first earlier one of the same vertices.
template <class Id, std::size_t N>
Outcome<Buffer<std::uint32_t>> twins(const Column<std::array<VertexId, N>>& simplices, const Incidence<Id>& around,
                                     const Execution& execution) {
    return map_each(execution, simplices.size(), [&](std::size_t i) {
        for (const Id other : around[loneliest(simplices[i], around)]) {
            if (other.index() >= i) break;
            if (has_all(simplices[other], simplices[i])) return other.value;
        }
        return nobody;
    });
}

/// FaceNeighbour each face of each element the other one that counts.
template <int D>
Outcome<Buffer<std::array<std::uint32_t, D + 1>>> across(const LinearMesh<D>& mesh, const Examination<D>& x,
                                                         const Execution& execution) {
    auto links = map_each(part_of(execution, 0, 0.26), mesh.elements.size(), [](std::size_t) {
        std::array<std::uint32_t, D + 1> none{};
        none.fill(nobody);
        return none;
    });
    if (!links) return links;
    auto done = each_face(mesh, x.elements_of, part_of(execution, 0.26, 1), [&](std::span<const FaceAround<D>> on) {
        for (const auto& [others, face] : on) {
            std::uint32_t& link = (*links)[face.element.index()][face.opposite];
            for (const FaceAround<D>& other : on) {
                const ElementId beside = other.face.element;
                if (beside == face.element || !x.element_counts(beside.index())) continue;
                link = link == nobody ? beside.value : several;
            }
        }
    });
    if (!done) return fail(done.error());
    return links;
}

template <int D>
bool is_listed(const LinearMesh<D>& mesh, const Examination<D>& x, const SimplexVertices<D - 1>& face) {
    const auto around = x.facets_of[loneliest(face, x.facets_of)];
    return std::any_of(around.begin(), around.end(), [&](FacetId f) { return has_all(mesh.facets.vertices[f], face); });
}

/// The faces that are not listed as facets and for which wanted(the element across) holds, as bits.
template <int D, class Wanted>
std::uint8_t unlisted_faces(const LinearMesh<D>& mesh, const Examination<D>& x, std::size_t e, Wanted&& wanted) {
    std::uint8_t bits = 0;
    for (int i = 0; i <= D; ++i)
        if (wanted(x.neighbours[e][i]) && !is_listed(mesh, x, face_of<D>(mesh.elements.vertices[e], i)))
            bits = static_cast<std::uint8_t>(bits | (1U << i));
    return bits;
}

template <int D>
std::array<std::uint32_t, 2> elements_beside(const LinearMesh<D>& mesh, const Examination<D>& x, std::size_t f) {
    std::array<std::uint32_t, 2> sides{nobody, nobody};
    const auto& facet = mesh.facets.vertices[f];
    for (const ElementId e : x.elements_of[loneliest(facet, x.elements_of)]) {
        if (!x.element_counts(e.index()) || !has_all(mesh.elements.vertices[e], facet)) continue;
        if (sides[0] == nobody)
            sides[0] = e.value;
        else if (sides[1] == nobody)
            sides[1] = e.value;
    }
    return sides;
}

/// Repeated and contradicting simplices.
template <int K>
Outcome<std::array<Finding, 2>> repeats(const Simplices<K>& simplices, const Buffer<std::uint32_t>& twin,
                                        const Execution& execution) {
    std::array<Finding, 2> found;
    for (const bool same : {true, false}) {
        auto counted = count(execution, simplices.size(), [&](std::size_t i) {
            return twin[i] != nobody && (simplices.references[i] == simplices.references[twin[i]]) == same;
        });
        if (!counted) return fail(counted.error());
        if (counted->count > 0) counted->other = twin[counted->first - 1] + std::size_t{1};
        found[same ? 0 : 1] = *counted;
    }
    return found;
}

template <int D>
Outcome<Done> count_faces(const LinearMesh<D>& mesh, Examination<D>& x, const Execution& execution) {
    const auto enter = [&](Defect defect, std::size_t n, auto&& chosen) -> Outcome<Done> {
        auto found = count(execution, n, chosen);
        if (!found) return fail(found.error());
        x[defect] = *found;
        return Done{};
    };
    const std::size_t elements = mesh.elements.size(), facets = elements == 0 ? 0 : mesh.facets.size();
    const bool any_listed = !mesh.facets.vertices.empty();
    return enter(Defect::crowded_face, elements,
                 [&](std::size_t e) {
                     const auto& of = x.neighbours[e];
                     return x.element_counts(e) && std::find(of.begin(), of.end(), several) != of.end();
                 })
        .and_then([&](Done) {
            return enter(any_listed ? Defect::missing_facet : Defect::no_facets, elements,
                         [&](std::size_t e) { return x.unlisted[e] != 0; });
        })
        .and_then([&](Done) {
            return enter(Defect::missing_interface, elements, [&](std::size_t e) { return x.interfaces[e] != 0; });
        })
        .and_then([&](Done) {
            return enter(Defect::stray_facet, facets,
                         [&](std::size_t f) { return x.facet_counts(f) && x.sides[f][0] == nobody; });
        })
        .and_then([&](Done) {
            return enter(Defect::inner_facet, facets, [&](std::size_t f) {
                const auto& [a, b] = x.sides[f];
                return x.facet_counts(f) && b != nobody && mesh.elements.references[a] == mesh.elements.references[b];
            });
        });
}

}  // namespace

template <int D>
Outcome<Done> examine_faces(const LinearMesh<D>& mesh, Examination<D>& x, const Execution& execution) {
    const std::size_t n = mesh.elements.size();
    const Execution quiet = without_progress(execution);
    auto element_twins = twins(mesh.elements.vertices, x.elements_of, part_of(execution, 0, 0.25));
    if (!element_twins) return fail(element_twins.error());
    x.element_twins = std::move(*element_twins);
    auto facet_twins = twins(mesh.facets.vertices, x.facets_of, quiet);
    if (!facet_twins) return fail(facet_twins.error());
    x.facet_twins = std::move(*facet_twins);

    auto neighbours = across(mesh, x, part_of(execution, 0.25, 0.91));
    if (!neighbours) return fail(neighbours.error());
    x.neighbours = std::move(*neighbours);
    auto sides = map_each(quiet, mesh.facets.size(), [&](std::size_t f) { return elements_beside(mesh, x, f); });
    if (!sides) return fail(sides.error());
    x.sides = std::move(*sides);
    auto unlisted = map_each(part_of(execution, 0.91, 0.95), n, [&](std::size_t e) {
        if (!x.element_counts(e)) return std::uint8_t{0};
        return unlisted_faces(mesh, x, e, [](std::uint32_t other) { return other == nobody; });
    });
    if (!unlisted) return fail(unlisted.error());
    x.unlisted = std::move(*unlisted);
    auto interfaces = map_each(part_of(execution, 0.95, 1), n, [&](std::size_t e) {
        if (!x.element_counts(e)) return std::uint8_t{0};
        return unlisted_faces(mesh, x, e, [&](std::uint32_t other) {
            return other < several && other > e && mesh.elements.references[other] != mesh.elements.references[e];
        });
    });
    if (!interfaces) return fail(interfaces.error());
    x.interfaces = std::move(*interfaces);

    auto elements = repeats(mesh.elements, x.element_twins, quiet);
    if (!elements) return fail(elements.error());
    auto facets = repeats(mesh.facets, x.facet_twins, quiet);
    if (!facets) return fail(facets.error());
    x[Defect::repeated_element] = (*elements)[0];
    x[Defect::contradicting_element] = (*elements)[1];
    x[Defect::repeated_facet] = (*facets)[0];
    x[Defect::contradicting_facet] = (*facets)[1];
    return count_faces(mesh, x, quiet);
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<Done> examine_faces<D>(const LinearMesh<D>&, Examination<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
