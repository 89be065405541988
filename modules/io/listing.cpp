// Checks the contents of files, finds mid nodes, and joins coincident points.
module;
#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <variant>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;

namespace camber::listing {

namespace {

template <int D>
Outcome<Done> check_points(const Mesh<D>& mesh, const Execution& execution) {
    FirstErrorRow first;
    auto done = each(
        execution, mesh.points.size(),
        [&](std::size_t v) {
            if (!is_finite(mesh.points[v])) first.note(v);
        },
        row_grain);
    if (!done || !first.any()) return done;
    return fail(ErrorKind::input, "a coordinate is infinite or not a number", mesh.name,
                Entity{"vertex", mesh.number_of(VertexId(first.row()))},
                "the program that wrote the file failed there. Write it again");
}

enum class ListingError { none, unknown_point, repeated };

template <std::size_t N>
ListingError error_of_row(const std::array<VertexId, N>& nodes, std::size_t points) {
    for (std::size_t n = 0; n < N; ++n) {
        if (!nodes[n].valid() || nodes[n].index() >= points) return ListingError::unknown_point;
        for (std::size_t m = 0; m < n; ++m)
            if (nodes[m] == nodes[n]) return ListingError::repeated;
    }
    return ListingError::none;
}

template <int N>
Outcome<Done> check_rows(const std::string& name, const Rows<N>& rows, std::size_t points, const Execution& execution) {
    FirstErrorRow first;
    auto done = each(
        execution, rows.size(),
        [&](std::size_t i) {
            if (error_of_row(rows.nodes[i], points) != ListingError::none) first.note(i);
        },
        row_grain);
    if (!done || !first.any()) return done;
    const std::size_t i = first.row();
    const bool repeated = error_of_row(rows.nodes[i], points) == ListingError::repeated;
    return fail(ErrorKind::input, repeated ? "a node occurs twice" : "a node is not one of those that the file lists",
                rows.origin.place ? rows.origin.place(i) : name, Entity{rows.origin.noun, rows.origin.number_of(i)},
                repeated ? "remove it: it has no volume" : "the file is damaged, or was joined from two files");
}

}  // namespace

template <int D>
Outcome<Done> check(const Mesh<D>& mesh, const Execution& execution) {
    return check_points(mesh, execution).and_then([&](Done) {
        return for_each_dimension(mesh, [&](const auto& kind) {
            return check_rows(mesh.name, kind.curved, mesh.points.size(), execution).and_then([&](Done) {
                return check_rows(mesh.name, kind.straight, mesh.points.size(), execution);
            });
        });
    });
}

template <int K>
Outcome<Done> reorder(Buffer<std::array<VertexId, quadratic_nodes<K>>>& simplices, const NodeOrder<K>& order,
                      const Execution& execution) {
    return each(
        execution, simplices.size(),
        [&](std::size_t i) {
            const auto before = simplices[i];
            for (std::size_t n = 0; n < order.size(); ++n) simplices[i][order[n]] = before[n];
        },
        4096);
}

template Outcome<Done> reorder<1>(Buffer<std::array<VertexId, 3>>&, const NodeOrder<1>&, const Execution&);
template Outcome<Done> reorder<2>(Buffer<std::array<VertexId, 6>>&, const NodeOrder<2>&, const Execution&);
template Outcome<Done> reorder<3>(Buffer<std::array<VertexId, 10>>&, const NodeOrder<3>&, const Execution&);
template Outcome<Done> check<2>(const Mesh<2>&, const Execution&);
template Outcome<Done> check<3>(const Mesh<3>&, const Execution&);

// Mid nodes are assigned to edges. All simplices of a file must agree on them.

namespace {

template <class T>
void atomic_min(T& target, T value) {
    const std::atomic_ref<T> shared(target);
    T observed = shared.load(std::memory_order_relaxed);
    while (value < observed && !shared.compare_exchange_weak(observed, value, std::memory_order_relaxed)) {
    }
}

template <int K, int D>
EdgeId edge_at(const EdgeSet<D>& edges, std::size_t i, int k) {
    if constexpr (K == D)
        return edges.of_elements[i][k];
    else if constexpr (K == D - 1)
        return edges.of_facets[i][k];
    else
        return edges.of_edges[i];
}

template <int K, int D, class F>
Outcome<Done> for_each_mid_node(const Simplices<K>& kind, const EdgeSet<D>& edges, const Execution& execution, F&& f) {
    return each(
        execution, kind.curved.size(),
        [&](std::size_t i) {
            for (int k = 0; k < edges_per_simplex<K>; ++k)
                f(edge_at<K, D>(edges, i, k), kind.curved.nodes[i][K + 1 + k], i);
        },
        row_grain);
}

template <int D>
Outcome<MidNodes> lowest_mid_nodes(const Mesh<D>& raw, const EdgeSet<D>& edges, const Execution& execution) {
    MidNodes mid{Buffer<std::uint32_t>(edges.size()), Buffer<std::uint32_t>(raw.points.size())};
    for (std::uint32_t& v : mid.of_edge) v = none;
    for (std::uint32_t& e : mid.edge_of) e = none;
    auto listed = for_each_dimension(raw, [&]<int K>(const Simplices<K>& kind) {
        return for_each_mid_node<K, D>(kind, edges, execution, [&](EdgeId e, VertexId v, std::size_t) {
            atomic_min(mid.of_edge[e.index()], v.value);
            atomic_min(mid.edge_of[v.index()], e.value);
        });
    });
    if (!listed) return fail(std::move(listed.error()));
    return mid;
}

template <int K, int D>
auto disagreement(const Mesh<D>& raw, const Simplices<K>& kind, const EdgeSet<D>& edges, const MidNodes& mid,
                  const Renumbering& numbers, std::size_t i) {
    const Simplex here{&kind.curved.origin, i};
    const Entity entity{simplex_name<K>, here.origin->number_of(i)};
    const auto number = [&](std::size_t index) { return std::to_string(raw.number_of(VertexId(index))); };
    std::string text;
    for (int k = 0; k < edges_per_simplex<K> && text.empty(); ++k) {
        const EdgeId e = edge_at<K, D>(edges, i, k);
        const VertexId v = kind.curved.nodes[i][K + 1 + k];
        const VertexId first(std::size_t{mid.of_edge[e.index()]});
        const bool two_nodes = first != v;
        if (!two_nodes && mid.edge_of[v.index()] == e.value) continue;
        const EdgeId shown = two_nodes ? e : EdgeId(std::size_t{mid.edge_of[v.index()]});
        const VertexId other_node = two_nodes ? first : v;
        const Simplex other = find_simplex(raw, [&]<int L>(const auto& nodes) {
            for (std::size_t n = L + 1; n < nodes.size(); ++n) {
                const auto& [a, b] = local_edges<L>[n - L - 1];
                if (nodes[n] != other_node) continue;
                const std::uint32_t p = numbers.to_mesh[nodes[a].index()], q = numbers.to_mesh[nodes[b].index()];
                const auto& [low, high] = edges.vertices[shown];
                if ((p == low.value && q == high.value) || (q == low.value && p == high.value)) return true;
            }
            return false;
        });
        const auto& [low, high] = edges.vertices[e];
        const std::string edge = "the edge between vertices " + number(numbers.to_file[low.index()]) + " and " +
                                 number(numbers.to_file[high.index()]);
        text = two_nodes
                   ? edge + " has mid node " + number(v.index()) + " here and " + number(first.index()) + " in " +
                         other.text()
                   : "mid node " + number(v.index()) + " of " + edge + " belongs to another edge in " + other.text();
    }
    return fail(ErrorKind::input, text, here.where(raw.name), entity,
                "the file is damaged, or was joined from two "
                "files");
}

template <int D>
Outcome<Done> check_agreement(const Mesh<D>& raw, const EdgeSet<D>& edges, const MidNodes& mid,
                              const Renumbering& numbers, const Execution& execution) {
    return for_each_dimension(raw, [&]<int K>(const Simplices<K>& kind) -> Outcome<Done> {
        FirstErrorRow first;
        auto observed = for_each_mid_node<K, D>(kind, edges, execution, [&](EdgeId e, VertexId v, std::size_t i) {
            if (mid.of_edge[e.index()] != v.value || mid.edge_of[v.index()] != e.value) first.note(i);
        });
        if (!observed || !first.any()) return observed;
        return disagreement<K, D>(raw, kind, edges, mid, numbers, first.row());
    });
}

}  // namespace

template <int D>
Outcome<MidNodes> mid_nodes_of(const Mesh<D>& raw, const EdgeSet<D>& edges, const Renumbering& numbers,
                               const Execution& execution) {
    auto mid = lowest_mid_nodes(raw, edges, execution);
    if (!mid) return mid;
    auto agreed = check_agreement(raw, edges, *mid, numbers, execution);
    if (!agreed) return fail(std::move(agreed.error()));
    return mid;
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<MidNodes> mid_nodes_of<D>(const Mesh<D>&, const EdgeSet<D>&, const Renumbering&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

namespace {

template <int D>
struct PlaceHash {
    std::size_t operator()(const std::array<double, D>& place) const {
        std::uint64_t h = 0;
        for (const double x : place) {
            h = (h ^ std::bit_cast<std::uint64_t>(x)) * 0x9e3779b97f4a7c15U;
            h ^= h >> 29U;
        }
        return static_cast<std::size_t>(h);
    }
};

/// Finds the points that `join_coincident` merges. Entry p is the first point at the position of point p if the two
/// points belong to different parts of the file, else p.
template <int D>
Buffer<std::uint32_t> partners(const Mesh<D>& mesh, std::span<const std::size_t> ends) {
    std::unordered_map<std::array<double, D>, std::uint32_t, PlaceHash<D>> first;
    first.reserve(mesh.points.size());
    const auto part_of = [&](std::size_t p) { return std::upper_bound(ends.begin(), ends.end(), p) - ends.begin(); };
    Buffer<std::uint32_t> partner(mesh.points.size());
    for (std::size_t p = 0; p < partner.size(); ++p) {
        std::array<double, D> place{};
        for (int c = 0; c < D; ++c) place[static_cast<std::size_t>(c)] = mesh.points[p][c] + 0.0;  // turns −0 into 0
        const auto own = static_cast<std::uint32_t>(p);
        const auto [found, is_new] = first.try_emplace(place, own);
        partner[p] = !is_new && part_of(found->second) != part_of(p) ? found->second : own;
    }
    return partner;
}

template <class T>
FieldValues selected_rows(const Column<T>& values, const Buffer<std::uint32_t>& selected, std::size_t width) {
    Buffer<T> rows(selected.size() * width);
    for (std::size_t i = 0; i < selected.size(); ++i)
        for (std::size_t c = 0; c < width; ++c) rows[i * width + c] = values[selected[i] * width + c];
    return Column<T>(std::move(rows));
}

template <int D>
MeshFields selected_fields(const MeshFields& fields, const Buffer<std::uint32_t>& selected) {
    std::vector<MeshField> all;
    for (const MeshField& field : fields) {
        all.push_back(field);
        if (field.centring != Centring::node) continue;
        const auto width = static_cast<std::size_t>(values_per_vertex(field.kind, D));
        all.back().values =
            std::visit([&](const auto& values) { return selected_rows(values, selected, width); }, field.values);
    }
    return MeshFields(std::move(all));
}

template <int D>
void renumber(Mesh<D>& mesh, const Buffer<std::uint32_t>& number) {
    const auto of_rows = [&](auto& rows) {
        for (auto& nodes : rows.nodes)
            for (VertexId& v : nodes) v = VertexId(std::size_t{number[v.index()]});
    };
    const auto of_kind = [&](auto& kind) {
        of_rows(kind.straight);
        of_rows(kind.curved);
    };
    of_kind(mesh.elements);
    of_kind(mesh.facets);
    if constexpr (D == 3) of_kind(mesh.edges);
}

template <int D>
void select_rows(Mesh<D>& mesh, Buffer<std::uint32_t> rows, const Buffer<std::uint32_t>& number) {
    const auto selected = std::make_shared<Buffer<std::uint32_t>>(std::move(rows));
    renumber(mesh, number);
    Buffer<Vec<D>> points(selected->size());
    Buffer<Reference> references(selected->size());
    for (std::size_t i = 0; i < selected->size(); ++i) {
        points[i] = mesh.points[(*selected)[i]];
        references[i] = mesh.point_references[(*selected)[i]];
    }
    mesh.points = std::move(points);
    mesh.point_references = std::move(references);
    mesh.fields = selected_fields<D>(mesh.fields, *selected);
    mesh.number = [selected, before = std::move(mesh.number)](std::size_t point) -> std::uint64_t {
        return before ? before((*selected)[point]) : (*selected)[point] + std::uint64_t{1};
    };
}

}  // namespace

template <int D>
std::size_t join_coincident(Mesh<D>& mesh, std::span<const std::size_t> ends) {
    const Buffer<std::uint32_t> partner = partners(mesh, ends);
    Buffer<std::uint32_t> selected, number(partner.size());
    for (std::size_t p = 0; p < partner.size(); ++p)
        if (partner[p] == p) {
            number[p] = static_cast<std::uint32_t>(selected.size());
            selected.push_back(static_cast<std::uint32_t>(p));
        } else {
            number[p] = number[partner[p]];
        }
    const std::size_t joined = partner.size() - selected.size();
    if (joined > 0) select_rows(mesh, std::move(selected), number);
    return joined;
}

template <int D>
std::size_t join_numbered(Mesh<D>& mesh, std::span<const double> numbers) {
    Buffer<std::uint32_t> order(numbers.size()), selected, number(numbers.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t p, std::uint32_t q) { return numbers[p] < numbers[q]; });
    for (const std::uint32_t p : order) {
        if (selected.empty() || numbers[selected.back()] != numbers[p]) selected.push_back(p);
        number[p] = static_cast<std::uint32_t>(selected.size() - 1);
    }
    const std::size_t joined = order.size() - selected.size();
    select_rows(mesh, std::move(selected), number);
    return joined;
}

template std::size_t join_coincident<2>(Mesh<2>&, std::span<const std::size_t>);
template std::size_t join_coincident<3>(Mesh<3>&, std::span<const std::size_t>);
template std::size_t join_numbered<3>(Mesh<3>&, std::span<const double>);

}  // namespace camber::listing
