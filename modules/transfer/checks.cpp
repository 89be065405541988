module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
module camber.transfer;
import :checks;
import :fields;
import :key_table;
import :simplex;
import :transferred;
import camber.core;

namespace camber {

namespace {

/// A node as files number it.
template <int D>
Entity entity_of(const QuadraticMesh<D>& mesh, std::size_t n) {
    const std::size_t vertices = mesh.linear.points.size();
    if (n < vertices) return {"vertex", n + 1};
    return {"edge", n - vertices + 1};
}

/// The lowest i < n that is bad, or n.
template <class IsBad>
Outcome<std::size_t> first_bad(std::size_t n, const IsBad& is_bad, const Execution& execution) {
    return reduce_each(
        execution, n, n, [&](std::size_t& first, std::size_t i) { first = is_bad(i) ? std::min(first, i) : first; },
        [](std::size_t a, std::size_t b) { return std::min(a, b); });
}

template <int D>
Outcome<Done> check_mesh(const QuadraticMesh<D>& mesh, const std::string& name, const Execution& execution) {
    if (mesh.mid_nodes.size() != mesh.edges.size() || mesh.edges.of_elements.size() != mesh.linear.elements.size() ||
        mesh.linear.elements.references.size() != mesh.linear.elements.size())
        return fail(ErrorKind::usage,
                    name + " has " + std::to_string(mesh.mid_nodes.size()) + " edges' nodes and " +
                        std::to_string(mesh.edges.of_elements.size()) + " elements' edges for " +
                        std::to_string(mesh.edges.size()) + " edges and " +
                        std::to_string(mesh.linear.elements.size()) + " elements",
                    {}, {}, "make the mesh with `elevate`");
    const std::size_t nodes = node_count_of(mesh, 2);
    if (nodes >= none || mesh.linear.elements.size() >= none)
        return fail(ErrorKind::unsupported, name + " has more nodes than 32 bits count", {}, {}, "split it");
    const auto bad = first_bad(nodes, [&](std::size_t n) { return !is_finite(place_of(mesh, n)); }, execution);
    if (!bad) return fail(bad.error());
    if (*bad == nodes) return Done{};
    return fail(ErrorKind::input, "a coordinate of its node is not finite", name, entity_of(mesh, *bad),
                "give it a place");
}

template <int D>
Outcome<Done> check_field(const QuadraticMesh<D>& mesh, const TransferField& field, std::size_t number,
                          const Execution& execution) {
    const std::string name = "field " + std::to_string(number);
    if (field.degree != 1 && field.degree != 2)
        return fail(ErrorKind::usage, "a degree of " + std::to_string(field.degree), name, {}, "give 1 or 2");
    if (field.components < 1)
        return fail(ErrorKind::usage, std::to_string(field.components) + " components", name, {}, "give at least 1");
    const std::size_t nodes = node_count_of(mesh, field.degree);
    const auto components = static_cast<std::size_t>(field.components);
    if (field.values.size() != nodes * components)
        return fail(ErrorKind::usage,
                    std::to_string(field.values.size()) + " values for " + std::to_string(nodes) + " nodes of " +
                        std::to_string(components) + " components",
                    name, {}, field.degree == 1 ? "give a row a vertex" : "give a row a vertex, then one an edge");
    const auto bad =
        first_bad(field.values.size(), [&](std::size_t i) { return !std::isfinite(field.values[i]); }, execution);
    if (!bad) return fail(bad.error());
    if (*bad == field.values.size()) return Done{};
    return fail(ErrorKind::input, "component " + std::to_string(*bad % components + 1) + " is not finite", name,
                entity_of(mesh, *bad / components), "give the field a value at every node");
}

}  // namespace

template <int D>
Outcome<Done> check_input(const QuadraticMesh<D>& old_mesh, std::span<const TransferField> fields,
                          const QuadraticMesh<D>& new_mesh, const TransferOptions& options,
                          const Execution& execution) {
    if (auto limits = check_limits(options); !limits) return limits;
    if (auto sound = check_mesh(old_mesh, "the old mesh", execution); !sound) return sound;
    if (auto sound = check_mesh(new_mesh, "the new mesh", execution); !sound) return sound;
    for (std::size_t f = 0; f < fields.size(); ++f)
        if (auto sound = check_field(old_mesh, fields[f], f + 1, execution); !sound) return sound;
    if (old_mesh.linear.elements.size() == 0 && node_count_of(new_mesh, 2) > 0 && !fields.empty())
        return fail(ErrorKind::input, std::string("it has no ") + (D == 2 ? "triangles" : "tetrahedra"), "the old mesh",
                    {}, "a field is transferred between meshes of the volume");
    return Done{};
}

#define CAMBER_INSTANTIATE(D)                                                                      \
    template Outcome<Done> check_input<D>(const QuadraticMesh<D>&, std::span<const TransferField>, \
                                          const QuadraticMesh<D>&, const TransferOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
