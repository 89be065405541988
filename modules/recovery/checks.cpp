module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
module camber.recovery;
import camber.core;

namespace camber {

namespace {

/// The first of n for which `wrong`, or n.
template <class Wrong>
Outcome<std::size_t> first_where(std::size_t n, const Execution& execution, Wrong&& wrong) {
    return reduce_each(
        without_progress(execution), n, n,
        [&](std::size_t& found, std::size_t i) {
            if (found == n && wrong(i)) found = i;
        },
        [](std::size_t a, std::size_t b) { return std::min(a, b); });
}

template <int D>
Entity node_entity(const QuadraticMesh<D>& mesh, std::size_t node) {
    const std::size_t vertices = mesh.linear.points.size();
    return node < vertices ? Entity{"vertex", node + 1} : Entity{"edge", node - vertices + 1};
}

template <int D>
Outcome<int> degree_of(const QuadraticMesh<D>& mesh, std::span<const Column<double>> fields) {
    const std::size_t vertices = mesh.linear.points.size(), nodes = vertices + mesh.edges.size();
    int degree = 1;
    for (std::size_t f = 0; f < fields.size(); ++f) {
        const std::size_t n = fields[f].size();
        if (f == 0 && n != vertices) degree = 2;
        if (n != (degree == 1 ? vertices : nodes))
            return fail(ErrorKind::usage, "field " + std::to_string(f + 1) + " has " + std::to_string(n) + " values",
                        {}, {},
                        "give all fields of a call one a vertex (" + std::to_string(vertices) +
                            "), or one a vertex and one an edge (" + std::to_string(nodes) + ")");
    }
    if (degree == 2 &&
        (mesh.edges.of_elements.size() != mesh.linear.elements.size() || mesh.mid_nodes.size() != mesh.edges.size()))
        return fail(ErrorKind::input, "the edges of the mesh, or their nodes, are not those of its elements", {}, {},
                    "elevate it");
    return degree;
}

template <int D>
Outcome<Done> check_finite(const NodalMesh<D>& nodal, std::span<const Column<double>> fields,
                           const Execution& execution) {
    const QuadraticMesh<D>& mesh = nodal.mesh;
    const std::size_t nodes = mesh.linear.points.size() + (nodal.degree == 2 ? mesh.mid_nodes.size() : 0);
    const auto nowhere = first_where(
        nodes, execution, [&](std::size_t i) { return !is_finite(nodal.place(static_cast<std::uint32_t>(i))); });
    if (!nowhere) return fail(nowhere.error());
    if (*nowhere < nodes)
        return fail(ErrorKind::input, "has a coordinate that is not a finite number", {}, node_entity(mesh, *nowhere),
                    "repair the mesh");
    for (std::size_t f = 0; f < fields.size(); ++f) {
        const auto wrong = first_where(nodes, execution, [&](std::size_t i) { return !std::isfinite(fields[f][i]); });
        if (!wrong) return fail(wrong.error());
        if (*wrong < nodes)
            return fail(ErrorKind::usage, "the value of field " + std::to_string(f + 1) + " is not a finite number", {},
                        node_entity(mesh, *wrong), "give a solution that has converged");
    }
    return Done{};
}

}  // namespace

template <int D>
Outcome<CheckedNodes<D>> checked_nodes(const QuadraticMesh<D>& mesh, std::span<const Column<double>> fields,
                                       const Execution& execution) {
    const auto degree = degree_of(mesh, fields);
    if (!degree) return fail(degree.error());
    const auto& elements = mesh.linear.elements;
    if (auto one_each = check_materials(elements.references.size(), elements.size()); !one_each)
        return fail(one_each.error());
    auto around = balls(mesh.linear, without_progress(execution));
    if (!around) return fail(around.error());
    CheckedNodes<D> nodes{*degree, std::move(*around)};
    if (auto finite = check_finite(nodes.of(mesh), fields, execution); !finite) return fail(finite.error());
    return nodes;
}

template <int D>
Outcome<Done> check_results(const RecoveredDerivatives<D>& recovered, const Execution& execution) {
    const std::size_t rows = recovered.rows.size();
    for (std::size_t f = 0; f < recovered.fields.size(); ++f) {
        const auto& field = recovered.fields[f];
        const auto wrong = first_where(rows, execution, [&](std::size_t r) {
            const auto finite = [](const auto& t) {
                return std::all_of(t.c.begin(), t.c.end(), [](double c) { return std::isfinite(c); });
            };
            return !finite(field.gradients[r]) || !finite(field.hessians[r]) ||
                   (!field.thirds.empty() && !finite(field.thirds[r]));
        });
        if (!wrong) return fail(wrong.error());
        if (*wrong == rows) continue;
        const auto& offsets = recovered.rows.materials.offsets;
        const auto after = std::upper_bound(offsets.begin(), offsets.end(), *wrong);
        return fail(ErrorKind::usage,
                    "derivatives of field " + std::to_string(f + 1) + " are beyond the range of numbers", {},
                    Entity{"vertex", static_cast<std::size_t>(after - offsets.begin())},
                    "give the field, or the mesh, in other units");
    }
    return Done{};
}

#define CAMBER_INSTANTIATE(D)                                                                                    \
    template Outcome<CheckedNodes<D>> checked_nodes<D>(const QuadraticMesh<D>&, std::span<const Column<double>>, \
                                                       const Execution&);                                        \
    template Outcome<Done> check_results<D>(const RecoveredDerivatives<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
