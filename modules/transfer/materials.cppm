module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.transfer:materials;
import camber.core;
import camber.bezier;
import camber.interpolation;
import :transferred;

namespace camber {

template <int D, int K>
inline constexpr int field_nodes = K == 1 ? D + 1 : quadratic_nodes<D>;

/// Lagrange functions of degree K, for vertices, then for edges in the order of `local_edges`.
template <int D, int K>
[[nodiscard]] constexpr std::array<double, field_nodes<D, K>> lagrange(const Barycentric<D>& xi) {
    std::array<double, field_nodes<D, K>> phi{};
    for (int i = 0; i <= D; ++i) phi[i] = K == 1 ? xi[i] : vertex_shape(xi[i]);
    if constexpr (K == 2)
        for (int e = 0; e < edges_per_simplex<D>; ++e) phi[D + 1 + e] = edge_shape<D>(xi, e);
    return phi;
}

/// Node numbers of an element: vertices, then (number of vertices) + (number of the edge).
template <int D, int K>
[[nodiscard]] std::array<std::size_t, field_nodes<D, K>> nodes_of(const QuadraticMesh<D>& mesh, std::size_t e) {
    std::array<std::size_t, field_nodes<D, K>> nodes{};
    for (int i = 0; i <= D; ++i) nodes[i] = mesh.linear.elements.vertices[e][i].index();
    if constexpr (K == 2)
        for (int k = 0; k < edges_per_simplex<D>; ++k)
            nodes[D + 1 + k] = mesh.linear.points.size() + mesh.edges.of_elements[e][k].index();
    return nodes;
}

template <int D>
[[nodiscard]] const Vec<D>& place_of(const QuadraticMesh<D>& mesh, std::size_t n) {
    const std::size_t vertices = mesh.linear.points.size();
    return n < vertices ? mesh.linear.points[n] : mesh.mid_nodes[n - vertices].point;
}

/// The map F of an element relative to its vertex 0, so that rounding errors are relative to the element's size.
template <int D>
struct ElementMap {
    Vec<D> origin;
    QuadraticSimplex<D, D> relative;
    bool is_straight = true;  ///< F is affine: all edge nodes are bitwise the midpoints of their chords

    [[nodiscard]] Vec<D> at(const Barycentric<D>& xi) const { return origin + relative.point(xi); }
    [[nodiscard]] double determinant(const Barycentric<D>& xi) const { return det(Mat<D>{relative.derivatives(xi)}); }
};

template <int D>
[[nodiscard]] ElementMap<D> element_map(const QuadraticMesh<D>& mesh, std::size_t e) {
    ElementMap<D> map;
    const auto& v = mesh.linear.elements.vertices[e];
    map.origin = mesh.linear.points[v[0]];
    auto& control = map.relative.control;
    for (int i = 0; i <= D; ++i) control[i] = mesh.linear.points[v[i]] - map.origin;
    for (int k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        const Vec<D>& node = mesh.mid_nodes[mesh.edges.of_elements[e][k]].point;
        const bool is_middle = node == midpoint(mesh.linear.points[v[i]], mesh.linear.points[v[j]]);
        // Far from the origin, a rounded midpoint is not the midpoint of the coordinate differences.
        control[D + 1 + k] = is_middle
                                 ? midpoint(control[i], control[j])
                                 : control_point(control[i], LagrangeNode<D>{node - map.origin}, control[j]).point;
        map.is_straight = map.is_straight && is_middle;
    }
    return map;
}

inline constexpr std::uint32_t none = 0xffffffffU;

/// Materials of two meshes: the references that both meshes have, if each mesh has several references. All other
/// elements belong to the last material, `rest`.
template <int D>
class Materials {
  public:
    Materials(const LinearMesh<D>& old_mesh, const LinearMesh<D>& new_mesh) {
        const auto old_references = references_of(old_mesh), new_references = references_of(new_mesh);
        if (old_references.size() <= 1 || new_references.size() <= 1) return;
        for (const Reference r : old_references)
            if (std::ranges::find(new_references, r) != new_references.end()) shared_.push_back(r);
    }

    [[nodiscard]] std::size_t of(Reference reference) const {
        const auto at = std::ranges::lower_bound(shared_, reference);
        return at != shared_.end() && *at == reference ? static_cast<std::size_t>(at - shared_.begin()) : rest();
    }
    [[nodiscard]] std::size_t of(const LinearMesh<D>& mesh, std::size_t e) const {
        return shared_.empty() ? 0 : of(mesh.elements.references[e]);
    }
    [[nodiscard]] std::size_t rest() const { return shared_.size(); }
    [[nodiscard]] std::size_t size() const { return shared_.size() + 1; }
    [[nodiscard]] std::optional<Reference> reference(std::size_t material) const {
        if (material == rest()) return std::nullopt;
        return shared_[material];
    }

  private:
    static std::vector<Reference> references_of(const LinearMesh<D>& mesh) {
        std::vector<Reference> all;
        for (const Reference r : mesh.elements.references)
            if (all.empty() || all.back() != r) all.push_back(r);
        std::ranges::sort(all);
        const auto twice = std::ranges::unique(all);
        all.erase(twice.begin(), twice.end());
        return all;
    }

    std::vector<Reference> shared_;  ///< ascending
};

class NodeMaterials {
  public:
    template <int D>
    NodeMaterials(const QuadraticMesh<D>& mesh, const Materials<D>& materials)
        : first_(mesh.linear.points.size() + mesh.edges.size(), none), rest_(materials.rest()) {
        for (std::size_t e = 0; e < mesh.linear.elements.size(); ++e) {
            const auto material = static_cast<std::uint32_t>(materials.of(mesh.linear, e));
            for (const std::size_t n : nodes_of<D, 2>(mesh, e))
                if (first_[n] == none)
                    first_[n] = material;
                else if (first_[n] != material)
                    others_.emplace_back(static_cast<std::uint32_t>(n), material);
        }
        std::ranges::sort(others_);
        const auto twice = std::ranges::unique(others_);
        others_.erase(twice.begin(), twice.end());
    }

    /// Calls `visit(material)` for the materials of node n until it returns true. A node without elements has the
    /// material `rest`.
    template <class Visit>
    void visit(std::size_t n, Visit&& visit) const {
        if (visit(first_[n] == none ? rest_ : first_[n])) return;
        const auto begin = std::ranges::lower_bound(others_, std::pair(static_cast<std::uint32_t>(n), 0U));
        for (auto at = begin; at != others_.end() && at->first == n; ++at)
            if (visit(std::size_t{at->second})) return;
    }

  private:
    Buffer<std::uint32_t> first_;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> others_;  ///< further materials of interface nodes: (node,
                                                                   ///< material), ascending
    std::size_t rest_;
};

/// Compensated sum (Neumaier 1974) of values, and the sum of their absolute values.
struct Sum {
    double total = 0, rest = 0, size = 0;

    void add(double x) {
        const double next = total + x;
        rest += std::abs(total) >= std::abs(x) ? (total - next) + x : (x - next) + total;
        total = next;
        size += std::abs(x);
    }
    [[nodiscard]] double value() const { return total + rest; }
};

/// Adds numbers by group; `no_group` marks slots (elements of a list) that are skipped. `terms(slot, out)` writes the
/// `columns` numbers of a slot. It runs in parallel, but its numbers are added in slot order.
inline constexpr std::uint32_t no_group = 0xffffffffU;
template <class Terms>
[[nodiscard]] Outcome<std::vector<Sum>> sums_by_group(std::span<const std::uint32_t> group_of, std::size_t groups,
                                                      std::size_t columns, const Terms& terms,
                                                      const Execution& execution) {
    constexpr std::size_t block = 65536;
    std::vector<Sum> sums(groups * columns);
    Buffer<double> buffer(block * columns);
    for (std::size_t begin = 0; begin < group_of.size(); begin += block) {
        const std::size_t n = begin + block < group_of.size() ? block : group_of.size() - begin;
        auto done = each(execution, n,
                         [&](std::size_t i) { terms(begin + i, std::span(buffer).subspan(i * columns, columns)); });
        if (!done) return fail(done.error());
        for (std::size_t i = 0; i < n; ++i) {
            if (group_of[begin + i] == no_group) continue;
            Sum* const here = sums.data() + group_of[begin + i] * columns;
            for (std::size_t c = 0; c < columns; ++c) here[c].add(buffer[i * columns + c]);
        }
    }
    return sums;
}

/// Bitwise equal nodes and elements of two meshes. Nodes are numbered as in fields of degree 2: vertices, then edges.
struct CommonParts {
    Buffer<std::uint32_t> old_node;     ///< for each new node: the old node at its position, or `none`
    Buffer<std::uint32_t> old_element;  ///< for each new element: the old one with equal nodes and material, or `none`
    Buffer<std::uint8_t> is_preserved;  ///< for each old element: true if a new element equals it
};

/// Finds the common nodes and elements. If several old nodes are at a position (a crack), a new node there gets the
/// node of an unchanged element, or else the first node. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<CommonParts> find_common(const QuadraticMesh<D>& old_mesh, const QuadraticMesh<D>& new_mesh,
                                               const Materials<D>& materials, const Execution& execution);

template <int D>
[[nodiscard]] Outcome<Done> check_input(const QuadraticMesh<D>& old_mesh, std::span<const TransferField> fields,
                                        const QuadraticMesh<D>& new_mesh, const TransferOptions& options,
                                        const Execution& execution);

/// Integrals of each field by material, in the old and in the new mesh. Materials without elements are not listed.
/// Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<std::vector<std::vector<MaterialIntegrals>>> total_integrals(
    const QuadraticMesh<D>& old_mesh, std::span<const TransferField> old_fields, const QuadraticMesh<D>& new_mesh,
    std::span<const TransferField> new_fields, const Materials<D>& materials, const Execution& execution);

/// Integrals ∫ φ_α |det J| of the Lagrange functions φ_α over each element. They are exact where det J > 0 (polynomial
/// of degree D + 2 at most).
template <int D, int K>
class Weights {
  public:
    using Functions = std::array<double, field_nodes<D, K>>;

    Weights() : rule_(conical_rule<D>(3)) {
        for (const auto& point : rule_) {
            functions_.push_back(lagrange<D, K>(point.xi));
            for (int i = 0; i < field_nodes<D, K>; ++i) reference_[i] += point.weight * functions_.back()[i];
        }
    }
    [[nodiscard]] Functions of(const QuadraticMesh<D>& mesh, std::size_t e) const {
        const ElementMap<D> map = element_map(mesh, e);
        Functions out{};
        if (map.is_straight) {
            const double determinant = std::abs(map.determinant(rule_[0].xi));
            for (int i = 0; i < field_nodes<D, K>; ++i) out[i] = determinant * reference_[i];
            return out;
        }
        for (std::size_t q = 0; q < rule_.size(); ++q) {
            const double weight = rule_[q].weight * std::abs(map.determinant(rule_[q].xi));
            for (int i = 0; i < field_nodes<D, K>; ++i) out[i] += weight * functions_[q][i];
        }
        return out;
    }

  private:
    std::vector<RulePoint<D>> rule_;
    std::vector<Functions> functions_;
    Functions reference_{};
};

struct NodalValues {
    std::span<const double> values;
    std::size_t components = 1;
};

/// Integrals of a field over elements, by group. `element(slot)` returns the element's number.
template <int D, int K, class ElementOf>
[[nodiscard]] Outcome<std::vector<Sum>> integrals_by_group(const QuadraticMesh<D>& mesh, const ElementOf& element,
                                                           std::span<const std::uint32_t> group_of, std::size_t groups,
                                                           const NodalValues& field, const Execution& execution) {
    const auto& [values, components] = field;
    const Weights<D, K> weights;
    return sums_by_group(
        group_of, groups, components,
        [&](std::size_t slot, std::span<double> out) {
            const std::size_t e = element(slot);
            const auto weight = weights.of(mesh, e);
            const auto nodes = nodes_of<D, K>(mesh, e);
            for (std::size_t c = 0; c < components; ++c) {
                out[c] = 0;
                for (std::size_t i = 0; i < nodes.size(); ++i) out[c] += weight[i] * values[nodes[i] * components + c];
            }
        },
        execution);
}

/// All fields of one degree, with their components side by side, because they share matrices.
struct Block {
    int degree = 2;
    std::vector<std::size_t> fields;
    std::size_t components = 0;
    Buffer<double> old_values, values;
};

/// `values` has the values of all fields at the new nodes.
[[nodiscard]] inline Block block_of(int degree, std::span<const TransferField> fields,
                                    const std::vector<Buffer<double>>& values) {
    Block block{.degree = degree, .fields = {}, .components = 0, .old_values = {}, .values = {}};
    std::size_t old_nodes = 0, new_nodes = 0;
    for (std::size_t f = 0; f < fields.size(); ++f) {
        if (fields[f].degree != degree) continue;
        const auto components = static_cast<std::size_t>(fields[f].components);
        block.fields.push_back(f);
        block.components += components;
        old_nodes = fields[f].values.size() / components;
        new_nodes = values[f].size() / components;
    }
    block.old_values = Buffer<double>(old_nodes * block.components);
    block.values = Buffer<double>(new_nodes * block.components);
    std::size_t first = 0;
    const auto put = [&](const auto& from, std::size_t components, Buffer<double>& to) {
        for (std::size_t n = 0; n * components < from.size(); ++n)
            std::copy_n(from.data() + n * components, components, to.data() + n * block.components + first);
    };
    for (const std::size_t f : block.fields) {
        const auto components = static_cast<std::size_t>(fields[f].components);
        put(fields[f].values, components, block.old_values);
        put(values[f], components, block.values);
        first += components;
    }
    return block;
}

inline void put_back(const Block& block, std::span<const TransferField> fields, std::vector<Buffer<double>>& values) {
    std::size_t first = 0;
    for (const std::size_t f : block.fields) {
        const auto components = static_cast<std::size_t>(fields[f].components);
        for (std::size_t n = 0; n * components < values[f].size(); ++n)
            std::copy_n(block.values.data() + n * block.components + first, components,
                        values[f].data() + n * components);
        first += components;
    }
}

}  // namespace camber
