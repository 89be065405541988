module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "occ/kernel.hpp"
module camber.cad;
import camber.core;
import camber.surface;
import :in_plane;
import :parts;
import :virtual_faces;

namespace camber {

namespace {

/// Faces that are joined with others, each set named by its lowest face.
class JoinedFaces {
  public:
    explicit JoinedFaces(std::size_t faces) : lowest_(faces) {
        std::iota(lowest_.begin(), lowest_.end(), std::size_t{0});
    }
    void join(std::size_t a, std::size_t b) {
        a = find(a);
        b = find(b);
        lowest_[std::max(a, b)] = std::min(a, b);
    }
    /// The sets of more than one face, rising.
    [[nodiscard]] std::vector<std::vector<std::size_t>> lists() {
        std::map<std::size_t, std::vector<std::size_t>> sets;
        for (std::size_t face = 0; face < lowest_.size(); ++face) sets[find(face)].push_back(face);
        std::vector<std::vector<std::size_t>> out;
        for (auto& [lowest, faces] : sets)
            if (faces.size() > 1) out.push_back(std::move(faces));
        return out;
    }

  private:
    [[nodiscard]] std::size_t find(std::size_t face) {
        while (lowest_[face] != face) face = lowest_[face] = lowest_[lowest_[face]];
        return face;
    }
    std::vector<std::size_t> lowest_;
};

std::optional<std::size_t> nearest_of_all(const CadModel& model, std::span<const std::size_t> faces, const Vec<3>& p) {
    return nearest_face(model, faces, p);
}
std::optional<std::size_t> nearest_of_all(const CadModel& model, std::span<const std::size_t> curves, const Vec<2>& p) {
    return nearest_curve(model, curves, p);
}

Vec<3> in_space(const Vec<2>& p) { return {{p[0], p[1], 0}}; }
Vec<3> in_space(const Vec<3>& p) { return p; }

/// The faces on which the vertices of a facet lie, beyond the rim of its own.
struct Span {
    std::vector<std::array<std::size_t, 2>> pairs;  ///< faces that it joins
    std::optional<Vec<3>> ridge;                    ///< where it crosses a ridge of the model
};

/// Of a facet that does not fit its face closely.
template <int D>
Span span_of(const CadModel& model, std::span<const std::size_t> all, std::size_t face,
             const std::array<Vec<D>, D>& corners) {
    Span out;
    const double limit = off_limit * longest_side(corners);
    const VirtualFaces& groups = virtual_faces_of<D>(model.parts());
    for (const Vec<D>& p : corners) {
        const auto own = closest_on_virtual_face(model, face, p, [](std::size_t) { return false; });
        if (own.foot.distance <= limit) continue;
        const auto found = closest_on_virtual_face(model, face, p);
        for (const std::size_t other : found.through) out.pairs.push_back({other, found.face});
        if (out.ridge || found.foot.distance <= limit) continue;
        const auto other = nearest_of_all(model, all, p);
        if (!other || groups.are_joined(*other, face)) continue;
        const auto there = closest_on_virtual_face(model, *other, p, [](std::size_t) { return false; });
        if (there.foot.distance <= limit) out.ridge = in_space(found.foot.point);
    }
    return out;
}

}  // namespace

template <int D>
Outcome<Done> find_spans(const LinearMesh<D>& mesh, const CadModel& model, std::span<const CadFit> fits,
                         std::span<const std::array<std::size_t, 2>> pairs, const Execution& execution,
                         CadAssociation& association) {
    const std::vector<std::size_t> all = candidates<D>(model);
    const auto spans = map_each(
        execution, mesh.facets.size(),
        [&](std::size_t f) -> Span {
            const auto corners = facet_site(mesh, FacetId(f)).corners;
            if (association.faces[f] == no_face || fits[f].misfit <= off_limit * longest_side(corners)) return {};
            return span_of<D>(model, all, association.faces[f], corners);
        },
        16);
    if (!spans) return fail(spans.error());
    const VirtualFaces& groups = virtual_faces_of<D>(model.parts());
    JoinedFaces joined(groups.groups.size());
    for (const auto& [a, b] : pairs) {
        joined.join(a, b);
        // A sliver between them has no facets at this place, or it would be one of the pair.
        const auto& [near_a, near_b] = std::tie(groups.beside[a], groups.beside[b]);
        if (std::binary_search(near_a.begin(), near_a.end(), b)) continue;
        for (const std::size_t face : near_a)
            if (std::binary_search(near_b.begin(), near_b.end(), face)) joined.join(a, face);
    }
    std::vector<std::uint8_t> is_met(groups.groups.size(), 0);
    for (std::size_t f = 0; f < spans->size(); ++f) {
        const Span& span = (*spans)[f];
        if (association.faces[f] != no_face) is_met[association.faces[f]] = 1;
        for (const auto& [a, b] : span.pairs) joined.join(a, b);
        if (!span.ridge) continue;
        if (association.across.count++ > 0) continue;
        association.across.first = FacetId(f);
        association.across.place = *span.ridge;
    }
    // A mesh of all of the boundary covers the faces that it has no facets on with facets of their neighbours.
    if (association.facets == mesh.facets.size())
        for (const std::size_t face : all)
            for (const std::size_t other : groups.beside[face])
                if (is_met[face] == 0 && is_met[other] != 0) joined.join(face, other);
    association.joined = joined.lists();
    return Done{};
}

std::vector<std::uint32_t> joined_lists(const CadAssociation& association, std::size_t faces) {
    std::vector<std::uint32_t> lists(faces, no_face);
    for (std::size_t i = 0; i < association.joined.size(); ++i)
        for (const std::size_t face : association.joined[i]) lists[face] = static_cast<std::uint32_t>(i);
    return lists;
}

#define CAMBER_INSTANTIATE(D)                                                                            \
    template Outcome<Done> find_spans<D>(const LinearMesh<D>&, const CadModel&, std::span<const CadFit>, \
                                         std::span<const std::array<std::size_t, 2>>, const Execution&,  \
                                         CadAssociation&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
