module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>
#include <range/v3/action/sort.hpp>
#include <range/v3/action/unique.hpp>
module camber.soundness;
import camber.core;
import camber.validity;

namespace camber {

namespace {

constexpr std::uint32_t dropped = no_element;

Buffer<std::uint32_t> renumbered(const Buffer<std::uint32_t>& twins) {
    Buffer<std::uint32_t> numbers(twins.size());
    std::uint32_t next = 0;
    for (std::size_t i = 0; i < twins.size(); ++i) numbers[i] = twins[i] == no_element ? next++ : dropped;
    return numbers;
}

template <class T>
Column<T> selected(const Column<T>& items, const Buffer<std::uint32_t>& numbers) {
    if (items.empty()) return items;  // an optional column may be empty
    Buffer<T> out;
    out.reserve(items.size());
    for (std::size_t i = 0; i < items.size(); ++i)
        if (numbers[i] != dropped) out.push_back(items[i]);
    return out;
}

/// Replaces old indices by new numbers. A removed duplicate gets the number of the item that it repeats.
Column<std::uint32_t> indices(const Column<std::uint32_t>& old, const Buffer<std::uint32_t>& numbers,
                              const Buffer<std::uint32_t>& twins) {
    Buffer<std::uint32_t> out;
    out.reserve(old.size());
    for (const std::uint32_t i : old) out.push_back(numbers[twins[i] == no_element ? i : twins[i]]);
    out |= ranges::actions::sort | ranges::actions::unique;
    return out;
}

/// Previous local index of each local edge after an exchange of the first two vertices.
template <int K>
inline constexpr auto edges_after_swap = [] {
    std::array<int, edges_per_simplex<K>> from{};
    const auto swapped = [](int v) { return v < 2 ? 1 - v : v; };
    for (int e = 0; e < edges_per_simplex<K>; ++e)
        for (int f = 0; f < edges_per_simplex<K>; ++f) {
            const auto [a, b] = local_edges<K>[e];
            const auto [c, d] = local_edges<K>[f];
            const int p = swapped(a), q = swapped(b);
            if ((p == c && q == d) || (p == d && q == c)) from[e] = f;
        }
    return from;
}();

template <int D>
struct Plan {
    Buffer<std::uint32_t> elements, facets;
    Buffer<SimplexVertices<D - 1>> added;
    Buffer<Reference> added_references;
};

template <int D>
std::vector<Reference> references_in_use(const LinearMesh<D>& mesh) {
    std::vector<Reference> used(mesh.facets.references.begin(), mesh.facets.references.end());
    for (const Group& group : mesh.groups)
        if (group.dimension == D - 1) used.push_back(group.reference);
    used |= ranges::actions::sort | ranges::actions::unique;
    return used;
}

Reference unused_reference(const std::vector<Reference>& used) {
    const Reference highest = used.empty() ? 0 : *std::max_element(used.begin(), used.end());
    if (highest < std::numeric_limits<Reference>::max()) return std::max(0, highest) + 1;
    Reference free = 1;
    while (std::find(used.begin(), used.end(), free) != used.end()) ++free;
    return free;
}

struct MissingFaces {
    const Buffer<std::uint8_t>& bits;
    Defect defect;
};

template <int D>
void add_faces(const LinearMesh<D>& mesh, const Examination<D>& x, const MissingFaces& missing,
               std::vector<Reference>& used, Plan<D>& work, std::vector<std::string>& notices) {
    const auto& [bits, defect] = missing;
    if (x.soundness[defect].count == 0) return;
    const Reference reference = unused_reference(used);
    used.push_back(reference);
    const std::size_t before = work.added.size();
    for (std::size_t e = 0; e < bits.size(); ++e) {
        auto element = mesh.elements.vertices[e];
        if (x.turned[e] == 1) std::swap(element[0], element[1]);
        // After the swap, the faces opposite the first two vertices are exchanged.
        for (int i = 0; i <= D; ++i) {
            const int old = x.turned[e] == 1 && i < 2 ? 1 - i : i;
            if (((bits[e] >> static_cast<unsigned>(old)) & 1U) != 0) work.added.push_back(face_of<D>(element, i));
        }
    }
    work.added_references.resize(work.added.size(), reference);
    const std::size_t added = work.added.size() - before;
    notices.push_back(sentence(x.soundness, defect) + ": added " + std::to_string(added) + " " + simplex_name<D - 1> +
                      (added == 1 ? "" : "s") + " of reference " + std::to_string(reference));
}

template <class T>
Column<T> joined(Column<T> items, const Buffer<T>& more) {
    if (more.empty()) return items;
    Buffer<T> all = take(std::move(items));
    all.insert(all.end(), more.begin(), more.end());
    return all;
}

template <int D>
Plan<D> plan(const LinearMesh<D>& mesh, const Examination<D>& x, std::vector<std::string>& notices) {
    const Soundness& s = x.soundness;
    const auto say = [&](Defect defect, const char* done) {
        if (s[defect].count > 0) notices.push_back(sentence(s, defect) + done);
    };
    Plan<D> work{renumbered(x.element_twins), renumbered(x.facet_twins), {}, {}};
    say(Defect::repeated_element, ": dropped");
    say(Defect::repeated_facet, ": dropped");
    say(Defect::reversed_element, ": turned");
    std::vector<Reference> used = references_in_use(mesh);
    const Defect unlisted = mesh.facets.vertices.empty() ? Defect::no_facets : Defect::missing_facet;
    add_faces(mesh, x, {x.unlisted, unlisted}, used, work, notices);
    add_faces(mesh, x, {x.interfaces, Defect::missing_interface}, used, work, notices);
    say(Defect::unused_vertex, ": kept");
    for (const Defect defect : {Defect::slit_vertex, Defect::inner_facet, Defect::crowded_edge, Defect::pinched_vertex,
                                Defect::isolated_edge})
        say(defect, "");
    return work;
}

bool any(const Buffer<std::uint8_t>& marks) {
    return std::any_of(marks.begin(), marks.end(), [](std::uint8_t m) { return m != 0; });
}

template <int D>
LinearMesh<D> mended(LinearMesh<D> mesh, const Examination<D>& x, const Plan<D>& work) {
    if (any(x.turned)) {
        auto elements = take(std::move(mesh.elements.vertices));
        for (std::size_t e = 0; e < elements.size(); ++e)
            if (x.turned[e] == 1) std::swap(elements[e][0], elements[e][1]);
        mesh.elements.vertices = std::move(elements);
    }
    if (x.soundness[Defect::repeated_element].count > 0) {
        mesh.elements.vertices = selected(mesh.elements.vertices, work.elements);
        mesh.elements.references = selected(mesh.elements.references, work.elements);
        mesh.elements.entities = selected(mesh.elements.entities, work.elements);
        mesh.elements.required = indices(mesh.elements.required, work.elements, x.element_twins);
    }
    if (x.soundness[Defect::repeated_facet].count > 0) {
        mesh.facets.vertices = selected(mesh.facets.vertices, work.facets);
        mesh.facets.references = selected(mesh.facets.references, work.facets);
        mesh.facets.entities = selected(mesh.facets.entities, work.facets);
        mesh.facets.required = indices(mesh.facets.required, work.facets, x.facet_twins);
        if constexpr (D == 2) mesh.ridges = indices(mesh.ridges, work.facets, x.facet_twins);
    }
    mesh.facets.vertices = joined(std::move(mesh.facets.vertices), work.added);
    mesh.facets.references = joined(std::move(mesh.facets.references), work.added_references);
    if (!mesh.facets.entities.empty())
        mesh.facets.entities = joined(std::move(mesh.facets.entities), Buffer<Reference>(work.added.size(), 0));
    return mesh;
}

template <int D>
EdgeSet<D> mended(EdgeSet<D> edges, const Examination<D>& x, const Plan<D>& work) {
    if (any(x.turned)) {
        auto of = take(std::move(edges.of_elements));
        for (std::size_t e = 0; e < of.size(); ++e) {
            if (x.turned[e] == 0) continue;
            const auto old = of[e];
            for (std::size_t k = 0; k < old.size(); ++k)
                of[e][k] = old[static_cast<std::size_t>(edges_after_swap<D>[k])];
        }
        edges.of_elements = std::move(of);
    }
    if (x.soundness[Defect::repeated_element].count > 0) edges.of_elements = selected(edges.of_elements, work.elements);
    if (x.soundness[Defect::repeated_facet].count > 0) edges.of_facets = selected(edges.of_facets, work.facets);
    Buffer<std::array<EdgeId, edges_per_simplex<D - 1>>> added;
    added.reserve(work.added.size());
    for (const auto& facet : work.added) {
        std::array<EdgeId, edges_per_simplex<D - 1>> of;
        for (std::size_t k = 0; k < of.size(); ++k) {
            const auto [a, b] = local_edges<D - 1>[k];
            of[k] = find_edge(edges, facet[static_cast<std::size_t>(a)], facet[static_cast<std::size_t>(b)]);
        }
        added.push_back(of);
    }
    edges.of_facets = joined(std::move(edges.of_facets), added);
    return edges;
}

template <int D>
Buffer<std::uint32_t> without_isolated(const Examination<D>& x) {
    Buffer<std::uint32_t> numbers(x.sides.size());
    std::uint32_t next = 0;
    for (std::size_t f = 0; f < numbers.size(); ++f) numbers[f] = x.sides[f][0] == no_element ? dropped : next++;
    return numbers;
}

Column<std::uint32_t> selected_indices(const Column<std::uint32_t>& old, const Buffer<std::uint32_t>& numbers) {
    Buffer<std::uint32_t> out;
    for (const std::uint32_t i : old)
        if (numbers[i] != dropped) out.push_back(numbers[i]);
    return out;
}

template <int D>
LinearMesh<D> without_isolated(LinearMesh<D> mesh, const Examination<D>& x) {
    const Buffer<std::uint32_t> numbers = without_isolated(x);
    mesh.facets.vertices = selected(mesh.facets.vertices, numbers);
    mesh.facets.references = selected(mesh.facets.references, numbers);
    mesh.facets.entities = selected(mesh.facets.entities, numbers);
    mesh.facets.required = selected_indices(mesh.facets.required, numbers);
    if constexpr (D == 2) mesh.ridges = selected_indices(mesh.ridges, numbers);
    return mesh;
}

template <int D>
Outcome<QuadraticMesh<D>> without_isolated(QuadraticMesh<D> mesh, const Examination<D>& x, const Execution& execution) {
    LinearMesh<D> linear = without_isolated(std::move(mesh.linear), x);
    auto edges = unique_edges(linear, execution);
    if (!edges) return fail(std::move(edges.error()));
    auto nodes = map_each(
        execution, edges->size(),
        [&](std::size_t e) {
            const auto& [a, b] = edges->vertices[e];
            return mesh.mid_nodes[find_edge(mesh.edges, a, b)];
        },
        4096);
    if (!nodes) return fail(std::move(nodes.error()));
    return QuadraticMesh<D>{std::move(linear), std::move(*edges), std::move(*nodes)};
}

template <int D>
Outcome<Mesh<D>> without_isolated(Mesh<D> mesh, const Examination<D>& x, const Execution& execution) {
    if (mesh.degree == 1) return as_mesh(without_isolated(straight_simplices(std::move(mesh)), x));
    return as_quadratic(std::move(mesh))
        .and_then([&](QuadraticMesh<D> quadratic) { return without_isolated(std::move(quadratic), x, execution); })
        .map([](QuadraticMesh<D> result) { return as_mesh(std::move(result)); });
}

template <int D>
Outcome<Examination<D>> examined(Mesh<D>& mesh, std::vector<std::string>& notices, const Execution& execution) {
    auto x = examine_all(mesh, execution);
    if (!x || x->soundness[Defect::isolated_facet].count == 0) return x;
    notices.push_back(sentence(x->soundness, Defect::isolated_facet) + ": dropped");
    auto result = without_isolated(std::move(mesh), *x, without_progress(execution));
    if (!result) return fail(std::move(result.error()));
    mesh = std::move(*result);
    return examine_all(mesh, without_progress(execution));
}

template <int D>
Mesh<D> mended(Mesh<D> mesh, const Examination<D>& x, const Plan<D>& work) {
    MeshEntities<D>& entities = mesh.entities;
    const bool is_curved = mesh.degree == 2;
    auto nodes = std::move(mesh.edge_nodes);
    EdgeSet<D> edges{.vertices = std::move(entities.edges),
                     .of_elements = std::move(entities.edges_of_elements.template of<simplex<D>>().ids),
                     .of_facets = std::move(entities.edges_of_facets.template of<simplex<D - 1>>().ids),
                     .of_edges = std::move(entities.edges_of_edges)};
    LinearMesh<D> linear = mended(straight_simplices(std::move(mesh)), x, work);
    if (!is_curved) return as_mesh(std::move(linear));
    return as_mesh(QuadraticMesh<D>{std::move(linear), mended(std::move(edges), x, work), std::move(nodes)});
}

}  // namespace

template <int D>
Outcome<Prepared<D>> prepare(Mesh<D> mesh, const Execution& execution) {
    return guarded([&]() -> Outcome<Prepared<D>> {
        Prepared<D> prepared;
        const auto x = examined(mesh, prepared.notices, execution);
        if (!x) return fail(x.error());
        if (auto error = refusal(x->soundness)) return fail(std::move(*error));
        const Plan<D> work = plan(straight_simplices(mesh), *x, prepared.notices);
        prepared.mesh = mended(std::move(mesh), *x, work);
        return prepared;
    });
}

template Outcome<Prepared<2>> prepare<2>(Mesh<2>, const Execution&);
template Outcome<Prepared<3>> prepare<3>(Mesh<3>, const Execution&);

}  // namespace camber
