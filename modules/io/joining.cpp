module;
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <span>
#include <unordered_map>
#include <utility>
#include <variant>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;
import :joining;

namespace camber::listing {

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

/// The point that each is joined to: itself, or the first at its place, if that is of another part.
template <int D>
Buffer<std::uint32_t> partners(const Mesh<D>& mesh, std::span<const std::size_t> ends) {
    std::unordered_map<std::array<double, D>, std::uint32_t, PlaceHash<D>> first;
    first.reserve(mesh.points.size());
    const auto part_of = [&](std::size_t p) { return std::upper_bound(ends.begin(), ends.end(), p) - ends.begin(); };
    Buffer<std::uint32_t> partner(mesh.points.size());
    for (std::size_t p = 0; p < partner.size(); ++p) {
        std::array<double, D> place{};
        for (int c = 0; c < D; ++c) place[static_cast<std::size_t>(c)] = mesh.points[p][c] + 0.0;  // −0 is 0
        const auto own = static_cast<std::uint32_t>(p);
        const auto [found, is_new] = first.try_emplace(place, own);
        partner[p] = !is_new && part_of(found->second) != part_of(p) ? found->second : own;
    }
    return partner;
}

template <class T>
FieldValues kept_rows(const Column<T>& values, const Buffer<std::uint32_t>& kept, std::size_t width) {
    Buffer<T> rows(kept.size() * width);
    for (std::size_t i = 0; i < kept.size(); ++i)
        for (std::size_t c = 0; c < width; ++c) rows[i * width + c] = values[kept[i] * width + c];
    return Column<T>(std::move(rows));
}

template <int D>
MeshFields kept_fields(const MeshFields& fields, const Buffer<std::uint32_t>& kept) {
    std::vector<MeshField> all;
    for (const MeshField& field : fields) {
        all.push_back(field);
        if (field.centring != Centring::node) continue;
        const auto width = static_cast<std::size_t>(values_per_vertex(field.kind, D));
        all.back().values =
            std::visit([&](const auto& values) { return kept_rows(values, kept, width); }, field.values);
    }
    return MeshFields(std::move(all));
}

/// New numbers in all simplices.
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

/// Leaves those points, in that order; `number`: the new one of each.
template <int D>
void keep(Mesh<D>& mesh, Buffer<std::uint32_t> rows, const Buffer<std::uint32_t>& number) {
    const auto kept = std::make_shared<Buffer<std::uint32_t>>(std::move(rows));
    renumber(mesh, number);
    Buffer<Vec<D>> points(kept->size());
    Buffer<Reference> references(kept->size());
    for (std::size_t i = 0; i < kept->size(); ++i) {
        points[i] = mesh.points[(*kept)[i]];
        references[i] = mesh.point_references[(*kept)[i]];
    }
    mesh.points = std::move(points);
    mesh.point_references = std::move(references);
    mesh.fields = kept_fields<D>(mesh.fields, *kept);
    mesh.number = [kept, before = std::move(mesh.number)](std::size_t point) -> std::uint64_t {
        return before ? before((*kept)[point]) : (*kept)[point] + std::uint64_t{1};
    };
}

}  // namespace

template <int D>
std::size_t join_coincident(Mesh<D>& mesh, std::span<const std::size_t> ends) {
    const Buffer<std::uint32_t> partner = partners(mesh, ends);
    Buffer<std::uint32_t> kept, number(partner.size());
    for (std::size_t p = 0; p < partner.size(); ++p)
        if (partner[p] == p) {
            number[p] = static_cast<std::uint32_t>(kept.size());
            kept.push_back(static_cast<std::uint32_t>(p));
        } else {
            number[p] = number[partner[p]];
        }
    const std::size_t joined = partner.size() - kept.size();
    if (joined > 0) keep(mesh, std::move(kept), number);
    return joined;
}

template <int D>
std::size_t join_numbered(Mesh<D>& mesh, std::span<const double> numbers) {
    Buffer<std::uint32_t> order(numbers.size()), kept, number(numbers.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t p, std::uint32_t q) { return numbers[p] < numbers[q]; });
    for (const std::uint32_t p : order) {
        if (kept.empty() || numbers[kept.back()] != numbers[p]) kept.push_back(p);
        number[p] = static_cast<std::uint32_t>(kept.size() - 1);
    }
    const std::size_t joined = order.size() - kept.size();
    keep(mesh, std::move(kept), number);
    return joined;
}

template std::size_t join_coincident<2>(Mesh<2>&, std::span<const std::size_t>);
template std::size_t join_coincident<3>(Mesh<3>&, std::span<const std::size_t>);
template std::size_t join_numbered<3>(Mesh<3>&, std::span<const double>);

}  // namespace camber::listing
