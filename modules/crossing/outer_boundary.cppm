module;
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>
module camber.crossing:outer_boundary;
import camber.core;
import camber.box_tree;
import camber.bezier;
import :crossings;
import :net;
import :planar;

/// The outer boundary of a mesh, its parts, and the number of elements at the inner side of each part.
namespace camber {

inline constexpr std::uint32_t no_boundary_row = 0xffffffffU;

/// A face that belongs to one element only, with outward normal.
template <int D>
struct OuterFacet {
    NodalFacet<D> nodes;
    std::array<VertexId, D> vertices;
    ElementId element;
};

template <int D>
[[nodiscard]] inline NodalFacet<D> turned(NodalFacet<D> facet) {
    std::swap(facet.nodes[0], facet.nodes[1]);
    if constexpr (D == 3) std::swap(facet.nodes[4], facet.nodes[5]);  // edges e12 and e20; e01 is unchanged
    return facet;
}

template <std::size_t N, class Item>
[[nodiscard]] inline std::array<Item, N> sorted(std::array<Item, N> items) {
    std::sort(items.begin(), items.end());
    return items;
}

template <std::size_t N, class Item>
[[nodiscard]] inline bool is_odd(const std::array<Item, N>& items) {
    int inversions = 0;
    for (std::size_t i = 0; i < N; ++i)
        for (std::size_t j = 0; j < i; ++j) inversions += items[i] < items[j] ? 1 : 0;
    return inversions % 2 == 1;
}

/// Contact of two touching facets; none for curved facets that are not coplanar.
[[nodiscard]] inline std::optional<Contact> contact_of(const NodalFacet<2>& first, const NodalFacet<2>& second) {
    return is_straight(first) && is_straight(second) ? contact_of_straight(first, second) : std::nullopt;
}
[[nodiscard]] inline std::optional<Contact> contact_of(const NodalFacet<3>& first, const NodalFacet<3>& second) {
    if (is_straight(first) && is_straight(second)) return contact_of_straight(first, second);
    const auto pair = net_pair(first, second);
    if (!pair || !are_in_one_plane(first, second)) return {};
    const int axis = best_axis(pair->first, pair->second);
    const int of_first = orientation_of(pair->first, axis), of_second = orientation_of(pair->second, axis);
    if (of_first == 0 || of_second == 0) return {};
    return of_first == of_second ? Contact::inside : Contact::opposite;
}

template <int D>
struct PointOnFacet {
    Vec<D> point, normal;
};
[[nodiscard]] inline PointOnFacet<2> point_on(const NodalFacet<2>& facet, const std::array<double, 2>& w) {
    const auto& [a, b, m] = facet.nodes;
    const Vec<2> point = w[0] * (2 * w[0] - 1) * a + w[1] * (2 * w[1] - 1) * b + 4 * w[0] * w[1] * m;
    const Vec<2> along = (4 * w[1] - 1) * b - (4 * w[0] - 1) * a + 4 * (w[0] - w[1]) * m;
    return {point, {{along[1], -along[0]}}};
}
[[nodiscard]] inline PointOnFacet<3> point_on(const NodalFacet<3>& facet, const std::array<double, 3>& w) {
    Vec<3> point{};
    std::array<Vec<3>, 3> slope{};  // derivatives by barycentric coordinates
    for (int i = 0; i < 3; ++i) {
        point += w[i] * (2 * w[i] - 1) * facet.nodes[i];
        slope[i] += (4 * w[i] - 1) * facet.nodes[i];
    }
    for (int e = 0; e < 3; ++e) {
        const auto [i, j] = local_edges<2>[e];
        point += 4 * w[i] * w[j] * facet.nodes[3 + e];
        slope[i] += 4 * w[j] * facet.nodes[3 + e];
        slope[j] += 4 * w[i] * facet.nodes[3 + e];
    }
    return {point, cross(slope[1] - slope[0], slope[2] - slope[0])};
}

/// Irregular barycentric coordinates of witness points, so that rays rarely hit mesh edges.
template <int D>
inline constexpr std::array<std::array<double, D>, 3> witness_weights = [] {
    if constexpr (D == 2)
        return std::array<std::array<double, 2>, 3>{{{0.5137, 0.4863}, {0.2893, 0.7107}, {0.7741, 0.2259}}};
    else
        return std::array<std::array<double, 3>, 3>{
            {{0.3517, 0.3089, 0.3394}, {0.5309, 0.2711, 0.198}, {0.1873, 0.2416, 0.5711}}};
}();
/// Distances of ray starts from the facet, relative to the facet's size. Smaller distances resolve curved facets
/// better.
inline constexpr std::array witness_distances{0x1p-7, 0x1p-13, 0x1p-19};
/// Maximum number of facets that are tried for each boundary part.
inline constexpr std::size_t max_trials = 4;

template <int D>
struct Witness {
    int covers = 0;  ///< number of elements that contain `point`; 0: undecided
    std::uint32_t facet = no_boundary_row;
    Vec<D> point{};
};

template <int D>
class OuterBoundary {
  public:
    explicit OuterBoundary(std::vector<OuterFacet<D>> facets)
        : facets_(std::move(facets)), is_cancelled_(facets_.size(), 0), is_touched_(facets_.size(), 0) {
        find_places();
    }

    [[nodiscard]] const OuterFacet<D>& operator[](std::size_t f) const { return facets_[f]; }
    [[nodiscard]] bool is_cancelled(std::size_t f) const { return is_cancelled_[f] != 0; }
    [[nodiscard]] const std::vector<std::array<std::uint32_t, 2>>& overlapping() const { return overlapping_; }

    /// Removes facets at the same position with opposite normals: the sides of a slit, or of an interface between
    /// bodies. Facets with equal normals remain, because they belong to overlapping elements.
    void cancel() {
        std::vector<std::uint32_t> order(facets_.size());
        std::iota(order.begin(), order.end(), 0U);
        std::vector<std::array<std::uint32_t, D>> keys(facets_.size());
        for (std::size_t f = 0; f < facets_.size(); ++f) keys[f] = sorted(places_[f]);
        std::sort(order.begin(), order.end(),
                  [&](std::uint32_t a, std::uint32_t b) { return std::tie(keys[a], a) < std::tie(keys[b], b); });
        for (std::size_t first = 0, last = 0; first < order.size(); first = last) {
            while (last < order.size() && keys[order[last]] == keys[order[first]]) ++last;
            if (last - first > 1) cancel_among(std::span(order).subspan(first, last - first));
        }
    }

    void mark(const Crossings& crossings, std::span<const std::uint32_t> rows) {
        for (const FacetCrossing& pair : crossings.found) {
            const std::uint32_t f = rows[pair.first.index()], g = rows[pair.second.index()];
            if (f == no_boundary_row || g == no_boundary_row || is_cancelled(f) || is_cancelled(g)) continue;
            const std::uint8_t mark = pair.verdict == Crossing::crossing ? judged : touches;
            is_touched_[f] = std::max(is_touched_[f], mark);
            is_touched_[g] = std::max(is_touched_[g], mark);
            if (pair.verdict != Crossing::touching) continue;
            const auto contact = contact_of(facets_[f].nodes, facets_[g].nodes);
            if (contact == Contact::inside) enter_overlap(f, g);
            if (contact == Contact::opposite) {
                opposite_.push_back({f, g});
                opposite_.push_back({g, f});
            }
        }
        std::sort(opposite_.begin(), opposite_.end());
    }

    /// Returns the walls: boundary parts connected by edges (2D: vertices) of exactly two facets, without other
    /// contacts. The number of elements at the inner side is constant on a wall. A facet that others touch is a wall
    /// alone. Facets that cross others, or are known to be inside other elements, are excluded. None if the boundary is
    /// open.
    [[nodiscard]] std::optional<std::vector<std::vector<std::uint32_t>>> walls() const {
        std::vector<std::uint32_t> parent(facets_.size());
        std::iota(parent.begin(), parent.end(), 0U);
        const auto root = [&](std::uint32_t f) {
            while (parent[f] != f) f = parent[f] = parent[parent[f]];
            return f;
        };
        std::vector<Rim> rims = all_rims();
        std::sort(rims.begin(), rims.end(), [](const Rim& a, const Rim& b) {
            return std::tie(a.key, a.facet, a.local) < std::tie(b.key, b.facet, b.local);
        });
        for (std::size_t first = 0, last = 0; first < rims.size(); first = last) {
            int sum = 0;
            for (; last < rims.size() && rims[last].key == rims[first].key; ++last) sum += rims[last].sign;
            if (sum != 0) return {};
            if (last - first != 2) continue;
            const Rim &a = rims[first], &b = rims[first + 1];
            if (is_touched_[a.facet] != 0 || is_touched_[b.facet] != 0 || !(middle(a) == middle(b))) continue;
            parent[std::max(root(a.facet), root(b.facet))] = std::min(root(a.facet), root(b.facet));
        }
        std::vector<std::vector<std::uint32_t>> parts;
        std::vector<std::uint32_t> part(facets_.size(), no_boundary_row);
        for (std::uint32_t f = 0; f < facets_.size(); ++f) {
            if (is_cancelled(f) || is_touched_[f] == judged) continue;
            const std::uint32_t r = root(f);
            if (part[r] == no_boundary_row) {
                part[r] = static_cast<std::uint32_t>(parts.size());
                parts.emplace_back();
            }
            parts[part[r]].push_back(f);
        }
        return parts;
    }

    void index() {
        std::vector<Box<D>> boxes;
        for (std::uint32_t f = 0; f < facets_.size(); ++f) {
            if (is_cancelled(f)) continue;
            boxes.push_back(box_of(facets_[f].nodes));
            of_tree_.push_back(f);
        }
        tree_ = BoxTree<D>(std::span<const Box<D>>(boxes));
    }

    [[nodiscard]] Witness<D> witness(const std::vector<std::uint32_t>& wall) const {
        const std::size_t step = std::max<std::size_t>(1, wall.size() / max_trials);
        for (std::size_t trial = 0; trial < max_trials && trial * step < wall.size(); ++trial)
            for (const auto& weights : witness_weights<D>)
                for (const double distance : witness_distances) {
                    const Witness<D> found = try_witness(wall[trial * step], weights, distance);
                    if (found.covers > 0) return found;
                }
        return {};
    }

  private:
    /// An edge (2D: vertex) of a facet. `key` has the ids of its vertex positions.
    struct Rim {
        std::array<std::uint32_t, D - 1> key{};
        std::uint32_t facet = 0;
        std::int8_t local = 0, sign = 1;
    };
    static constexpr std::uint8_t touches = 1, judged = 2;

    void enter_overlap(std::uint32_t f, std::uint32_t g) {
        overlapping_.push_back({f, g});
        is_touched_[f] = is_touched_[g] = judged;
    }

    void find_places() {
        places_.resize(facets_.size());
        RowTable table(D * facets_.size());
        const auto point = [&](std::uint32_t row) -> const Vec<D>& { return facets_[row / D].nodes.nodes[row % D]; };
        for (std::uint32_t row = 0; row < D * facets_.size(); ++row) {
            std::array<std::uint64_t, D> bits{};
            for (int i = 0; i < D; ++i)
                bits[i] = std::bit_cast<std::uint64_t>(point(row)[i] + 0.0);  // adding 0 replaces −0 by 0
            places_[row / D][row % D] =
                table.insert(hash_of(bits), row, [&](std::uint32_t other) { return point(other) == point(row); });
        }
    }

    [[nodiscard]] const Vec<D>& mid_node(std::uint32_t f, int e) const { return facets_[f].nodes.nodes[D + e]; }

    [[nodiscard]] bool have_same_nodes(std::uint32_t f, std::uint32_t g) const {
        for (int e = 0; e < edges_per_simplex<D - 1>; ++e)
            for (int k = 0; k < edges_per_simplex<D - 1>; ++k) {
                const auto ends = [&](std::uint32_t h, int l) {
                    return sorted(
                        std::array{places_[h][local_edges<D - 1>[l][0]], places_[h][local_edges<D - 1>[l][1]]});
                };
                if (ends(f, e) == ends(g, k) && !(mid_node(f, e) == mid_node(g, k))) return false;
            }
        return true;
    }

    void cancel_among(std::span<const std::uint32_t> same) {
        for (std::size_t i = 0; i < same.size(); ++i)
            for (std::size_t j = i + 1; j < same.size() && !is_cancelled(same[i]); ++j) {
                if (is_cancelled(same[j]) || is_odd(places_[same[i]]) == is_odd(places_[same[j]]) ||
                    !have_same_nodes(same[i], same[j]))
                    continue;
                is_cancelled_[same[i]] = is_cancelled_[same[j]] = 1;
            }
        for (std::size_t i = 0; i < same.size(); ++i)
            for (std::size_t j = i + 1; j < same.size(); ++j)
                if (!is_cancelled(same[i]) && !is_cancelled(same[j]) && have_same_nodes(same[i], same[j]))
                    enter_overlap(same[i], same[j]);
    }

    [[nodiscard]] std::vector<Rim> all_rims() const {
        std::vector<Rim> rims;
        rims.reserve(D * facets_.size());
        for (std::uint32_t f = 0; f < facets_.size(); ++f) {
            if (is_cancelled(f)) continue;
            if constexpr (D == 2) {
                for (std::int8_t i = 0; i < 2; ++i)
                    rims.push_back({{places_[f][i]}, f, i, static_cast<std::int8_t>(2 * i - 1)});
            } else {
                for (std::int8_t e = 0; e < 3; ++e) {
                    const std::uint32_t a = places_[f][local_edges<2>[e][0]], b = places_[f][local_edges<2>[e][1]];
                    rims.push_back({{std::min(a, b), std::max(a, b)}, f, e, static_cast<std::int8_t>(a < b ? 1 : -1)});
                }
            }
        }
        return rims;
    }

    [[nodiscard]] Vec<D> middle(const Rim& rim) const {
        if constexpr (D == 3) return mid_node(rim.facet, rim.local);
        return {};
    }

    [[nodiscard]] bool are_opposite(std::uint32_t f, std::uint32_t g) const {
        return std::binary_search(opposite_.begin(), opposite_.end(), std::array{f, g});
    }

    /// Counts the elements at the facet's inner side: 1 for its own element, plus the signed hits of an outward ray on
    /// facets beyond it.
    [[nodiscard]] Witness<D> try_witness(std::uint32_t f, const std::array<double, D>& weights, double distance) const {
        const NodalFacet<D>& facet = facets_[f].nodes;
        const auto [p, normal] = point_on(facet, weights);
        int axis = 0;
        for (int c = 1; c < D; ++c)
            if (std::abs(normal[c]) > std::abs(normal[axis])) axis = c;
        const double depth = distance * box_of(facet).diagonal();
        if (!(depth > 0) || !is_finite(p) || normal[axis] == 0) return {};
        Ray<D> ray{p, axis, normal[axis] > 0 ? 1 : -1};
        ray.start[axis] -= ray.sign * depth;
        const RayCaster<D> caster(ray);
        const RayHits own = caster.hits(facet, {}, depth / 16);
        if (!own.certain || own.count != 1 || own.pieces != 1) return {};
        const RayRange at{own.nearest, own.farthest};
        Box<D> along;
        along.include(ray.start);
        (ray.sign > 0 ? along.high : along.low)[axis] = ray.sign * std::numeric_limits<double>::infinity();
        RayHits beyond;
        tree_.meeting(along, [&](std::size_t item) {
            const std::uint32_t g = of_tree_[item];
            if (g == f || !beyond.certain) return;
            // An opposite facet that has an area in common with facet f is at the same distance; it counts as beyond.
            beyond = beyond + caster.hits(facets_[g].nodes, are_opposite(f, g) ? RayRange{} : at);
        });
        if (!beyond.certain || 1 + beyond.count < 1) return {};
        ray.start[axis] += ray.sign * (std::max(beyond.before, 0.0) + own.nearest) / 2;
        return {1 + beyond.count, f, ray.start};
    }

    std::vector<OuterFacet<D>> facets_;
    std::vector<std::array<std::uint32_t, D>> places_;
    std::vector<std::uint8_t> is_cancelled_, is_touched_;
    std::vector<std::array<std::uint32_t, 2>> overlapping_, opposite_;
    BoxTree<D> tree_;
    std::vector<std::uint32_t> of_tree_;
};

}  // namespace camber
