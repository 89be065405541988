// Checks inputs, finds common elements and calls the transfer method.
module;
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.transfer;
import camber.core;
import camber.bezier;
import :materials;
import :projection;

namespace camber {

template <int D>
Outcome<Transferred> transfer(const QuadraticMesh<D>& old_mesh, std::span<const TransferField> fields,
                              const QuadraticMesh<D>& new_mesh, const TransferOptions& options,
                              const Execution& execution) {
    return guarded([&]() -> Outcome<Transferred> {
        if (auto sound = check_input(old_mesh, fields, new_mesh, options, without_progress(execution)); !sound)
            return fail(sound.error());
        if (fields.empty()) return Transferred{};
        const Materials<D> materials(old_mesh.linear, new_mesh.linear);
        const auto same = find_common(old_mesh, new_mesh, materials, part_of(execution, 0, 0.1));
        if (!same) return fail(same.error());
        const auto sources = Sources<D>::make(old_mesh, materials, requested_materials(new_mesh, materials),
                                              part_of(execution, 0.1, 0.2));
        if (!sources) return fail(sources.error());
        const TransferMeshes<D> meshes{old_mesh, new_mesh, materials, *same, *sources};
        auto values = interpolate(meshes, fields, part_of(execution, 0.2, 0.5));
        if (!values) return fail(values.error());
        const Buffer<std::uint32_t> near = std::move(values->near);
        const Changed changed = find_changed(old_mesh, new_mesh, *same);
        if (options.method == TransferMethod::conserve) {
            const ProjectionInput<D> scene{meshes, changed, near, options};
            values = conserve(scene, fields, std::move(*values), part_of(execution, 0.5, 0.95));
            if (!values) return fail(values.error());
        }
        Transferred out{{}, std::move(values->statistics)};
        out.statistics.changed_elements = changed.new_elements.size();
        for (std::size_t f = 0; f < fields.size(); ++f)
            out.fields.push_back({fields[f].components, fields[f].degree, std::move(values->values[f])});
        auto integrals =
            total_integrals<D>(old_mesh, fields, new_mesh, out.fields, materials, part_of(execution, 0.95, 1));
        if (!integrals) return fail(integrals.error());
        out.statistics.integrals = std::move(*integrals);
        return out;
    });
}

namespace {

template <int D>
Entity entity_of(const QuadraticMesh<D>& mesh, std::size_t n) {
    const std::size_t vertices = mesh.linear.points.size();
    if (n < vertices) return {"vertex", n + 1};
    return {"edge", n - vertices + 1};
}

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
        return fail(ErrorKind::unsupported, name + " has more nodes than 32 bits can number", {}, {}, "split it");
    const auto bad = first_bad(nodes, [&](std::size_t n) { return !is_finite(place_of(mesh, n)); }, execution);
    if (!bad) return fail(bad.error());
    if (*bad == nodes) return Done{};
    return fail(ErrorKind::input, "a coordinate of its node is not finite", name, entity_of(mesh, *bad),
                "give finite coordinates");
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
                    name, {},
                    field.degree == 1 ? "give one row per vertex" : "give one row per vertex, then one per edge");
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
                    {}, "fields can be transferred only between volume meshes");
    return Done{};
}

namespace {

template <int D>
std::array<std::uint64_t, D> bits_of(const Vec<D>& p) {
    std::array<std::uint64_t, D> bits{};
    for (int i = 0; i < D; ++i) bits[i] = std::bit_cast<std::uint64_t>(p[i] + 0.0);
    return bits;
}

/// Key of an element: for each vertex, the first old node at its position; ascending.
template <int D>
using Corners = std::array<std::uint64_t, D + 1>;

template <class KeyOf>
RowTable table_of(std::size_t n, const KeyOf& key) {
    RowTable table(n);
    for (std::size_t i = 0; i < n; ++i) {
        const auto own = key(i);
        table.insert(hash_of(own), static_cast<std::uint32_t>(i),
                     [&](std::uint32_t other) { return key(other) == own; });
    }
    return table;
}

template <int D>
class Matching {
  public:
    Matching(const QuadraticMesh<D>& old_mesh, const QuadraticMesh<D>& new_mesh, const Materials<D>& materials)
        : old_(old_mesh),
          new_(new_mesh),
          materials_(materials),
          nodes_(table_of(old_mesh.linear.points.size() + old_mesh.edges.size(), place())),
          first_(first_nodes()),
          elements_(table_of(old_mesh.linear.elements.size(), old_corners())) {}

    [[nodiscard]] std::uint32_t node(std::size_t n) const { return node_at(place_of(new_, n)); }

    /// Old element with the nodes and material of new element e, or `none`.
    [[nodiscard]] std::uint32_t element(std::size_t e, const Buffer<std::uint32_t>& old_node) const {
        Corners<D> corners{};
        for (int i = 0; i <= D; ++i) {
            const std::uint32_t node = old_node[new_.linear.elements.vertices[e][i].index()];
            if (node == none) return none;
            corners[i] = node;
        }
        std::ranges::sort(corners);
        const auto key = old_corners();
        const std::uint32_t found =
            elements_.find(hash_of(corners), [&](std::uint32_t other) { return key(other) == corners; });
        if (found == none || materials_.of(old_.linear, found) != materials_.of(new_.linear, e)) return none;
        for (const std::uint32_t node : counterparts(e, found))
            if (node == none) return none;
        return found;
    }

    /// For two elements with the same vertices, returns the old node at the position of each new node; `none` where
    /// there is no such node.
    [[nodiscard]] auto counterparts(std::size_t e, std::size_t found) const {
        const auto own_nodes = nodes_of<D, 2>(new_, e), counterpart = nodes_of<D, 2>(old_, found);
        std::array<std::uint32_t, quadratic_nodes<D>> out{};
        for (std::size_t i = 0; i < own_nodes.size(); ++i) {
            out[i] = none;
            const std::size_t begin = i <= D ? 0 : D + 1, end = i <= D ? D + 1 : own_nodes.size();
            for (std::size_t j = begin; j < end; ++j)
                if (place_of(new_, own_nodes[i]) == place_of(old_, counterpart[j]))
                    out[i] = static_cast<std::uint32_t>(counterpart[j]);
        }
        return out;
    }

  private:
    [[nodiscard]] auto place() const {
        return [this](std::size_t n) { return bits_of(place_of(old_, n)); };
    }
    [[nodiscard]] std::uint32_t node_at(const Vec<D>& p) const {
        const auto bits = bits_of(p);
        return nodes_.find(hash_of(bits), [&](std::uint32_t other) { return bits_of(place_of(old_, other)) == bits; });
    }
    [[nodiscard]] Buffer<std::uint32_t> first_nodes() const {
        Buffer<std::uint32_t> first(old_.linear.points.size());
        for (std::size_t v = 0; v < first.size(); ++v) first[v] = node_at(old_.linear.points[v]);
        return first;
    }
    [[nodiscard]] auto old_corners() const {
        return [this](std::size_t e) {
            Corners<D> corners{};
            for (int i = 0; i <= D; ++i) corners[i] = first_[old_.linear.elements.vertices[e][i].index()];
            std::ranges::sort(corners);
            return corners;
        };
    }

    const QuadraticMesh<D>& old_;
    const QuadraticMesh<D>& new_;
    const Materials<D>& materials_;
    RowTable nodes_;
    Buffer<std::uint32_t> first_;  ///< for each old vertex: the first old node at its position
    RowTable elements_;
};

}  // namespace

template <int D>
Outcome<CommonParts> find_common(const QuadraticMesh<D>& old_mesh, const QuadraticMesh<D>& new_mesh,
                                 const Materials<D>& materials, const Execution& execution) {
    return guarded([&]() -> Outcome<CommonParts> {
        const Matching<D> matching(old_mesh, new_mesh, materials);
        auto nodes = map_each(part_of(execution, 0.2, 0.6), node_count_of(new_mesh, 2),
                              [&](std::size_t n) { return matching.node(n); });
        if (!nodes) return fail(nodes.error());
        auto elements = map_each(part_of(execution, 0.6, 1), new_mesh.linear.elements.size(),
                                 [&](std::size_t e) { return matching.element(e, *nodes); });
        if (!elements) return fail(elements.error());
        CommonParts same{std::move(*nodes), std::move(*elements), {}};
        same.is_preserved.assign(old_mesh.linear.elements.size(), 0);
        for (std::size_t e = 0; e < same.old_element.size(); ++e) {
            const std::uint32_t found = same.old_element[e];
            if (found == none) continue;
            same.is_preserved[found] = 1;
            const auto own_nodes = nodes_of<D, 2>(new_mesh, e);
            const auto counterpart = matching.counterparts(e, found);
            for (std::size_t i = 0; i < own_nodes.size(); ++i) same.old_node[own_nodes[i]] = counterpart[i];
        }
        return same;
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                     \
    template Outcome<Transferred> transfer<D>(const QuadraticMesh<D>&, std::span<const TransferField>,            \
                                              const QuadraticMesh<D>&, const TransferOptions&, const Execution&); \
    template Outcome<Done> check_input<D>(const QuadraticMesh<D>&, std::span<const TransferField>,                \
                                          const QuadraticMesh<D>&, const TransferOptions&, const Execution&);     \
    template Outcome<CommonParts> find_common<D>(const QuadraticMesh<D>&, const QuadraticMesh<D>&,                \
                                                 const Materials<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
