module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <tuple>
#include <vector>
module camber.cavity;
import camber.core;
import :starring;

namespace camber {

template <int D>
void Starring<D>::keep_facet_at(EdgeId edge) {
    for (const VertexId v : mesh_.edges[edge])
        if (const std::uint32_t at = w_.vertices.find(v); at != nothing) w_.to_point[at].keeps_facet = true;
}

template <int D>
void Starring<D>::list_facet_sides() {
    w_.open_sides.clear();
    for (const FacetId f : cavity_.facets)
        for (std::uint32_t k = 0; k < D; ++k) {
            const Reference reference = mesh_.facets.references[f];
            if constexpr (D == 3) {
                const EdgeId edge = facet_edge(mesh_, f, static_cast<int>(k));
                const LineId line = mesh_.line_of[edge];
                if (line.valid() && w_.lines.contains(line)) {
                    keep_facet_at(edge);
                    continue;
                }
                w_.open_sides.push_back({edge, reference, {f, k}, line.valid()});
            } else {
                const VertexId v = mesh_.facets.vertices[f][1 - k];
                w_.open_sides.push_back({v, reference, {f, k}, mesh_.states[v].place == VertexPlace::corner});
            }
        }
    std::sort(w_.open_sides.begin(), w_.open_sides.end(), [](const auto& a, const auto& b) {
        return std::tie(a.name, a.reference, a.facet.facet) < std::tie(b.name, b.reference, b.facet.facet);
    });
}

template <int D>
bool Starring<D>::is_inside(std::span<const OpenSide> sides, std::size_t first, std::size_t last) const {
    return last - first == 2 && (!sides[first].is_line || (D == 2 && holds_point(sides[first].name)));
}

template <int D>
bool Starring<D>::pieces_have_sides() {
    const auto& sides = w_.open_sides;
    const auto index = [&](const OpenSide& side) { return w_.facets.find(side.facet.facet); };
    Groups groups(w_.groups, cavity_.facets.size());
    std::vector<std::uint8_t> has_side(cavity_.facets.size(), 0);
    for (const int pass : {0, 1})
        for (std::size_t i = 0, next = 0; i < sides.size(); i = next) {
            next = i + 1;
            while (next < sides.size() && sides[next].name == sides[i].name &&
                   sides[next].reference == sides[i].reference)
                ++next;
            if (is_inside(sides, i, next)) {
                if (pass == 0) groups.join(index(sides[i]), index(sides[i + 1]));
            } else if (pass == 1) {
                has_side[groups.root(index(sides[i]))] = 1;
            }
        }
    // Sides on lines that go as well are not listed: a facet with fewer than all has one.
    std::vector<std::uint8_t> listed(cavity_.facets.size(), 0);
    for (const OpenSide& side : sides) ++listed[index(side)];
    for (std::uint32_t f = 0; f < listed.size(); ++f)
        if (listed[f] < D) has_side[groups.root(f)] = 1;
    for (std::uint32_t f = 0; f < listed.size(); ++f)
        if (has_side[groups.root(f)] == 0) return false;
    return true;
}

template <int D>
StarFailure Starring<D>::facets() {
    list_facet_sides();
    for (const FacetId f : cavity_.facets)
        for (const VertexId v : mesh_.facets.vertices[f])
            if (const std::uint32_t at = w_.vertices.find(v); at != nothing) w_.to_point[at].lost_facet = true;
    const auto& sides = w_.open_sides;
    for (std::size_t i = 0, next = 0; i < sides.size(); i = next) {
        next = i + 1;
        while (next < sides.size() && sides[next].name == sides[i].name && sides[next].reference == sides[i].reference)
            ++next;
        if (next - i > 2) return StarFailure::surface;
        if (is_inside(sides, i, next)) continue;
        if (next - i == 2) return StarFailure::surface;
        for (const VertexId v : vertices_of(sides[i].name))
            if (const std::uint32_t at = w_.vertices.find(v); at != nothing) w_.to_point[at].keeps_facet = true;
        if (holds_point(sides[i].name)) continue;
        const std::uint32_t at = w_.names.find(sides[i].name);
        if (at == nothing || w_.faces[at].facet != nothing) return StarFailure::surface;
        w_.faces[at].facet = static_cast<std::uint32_t>(out_.facets.size());
        out_.facets.push_back(sides[i].facet);
    }
    if (!pieces_have_sides()) return StarFailure::surface;
    // A vertex that stays, stays on its surface.
    for (const auto& vertex : w_.to_point)
        if (vertex.lost_facet && !vertex.keeps_facet) return StarFailure::surface;
    return StarFailure::none;
}

template <int D>
bool Starring<D>::count_facet(const SimplexVertices<D - 1>& facet, Reference reference) {
    ++facets_at_point_;
    bool fits = true;
    for (const VertexId v : facet) {
        if (v == point_) continue;
        const std::uint32_t at = w_.vertices.find(v);
        if (at == nothing) continue;
        auto& edge = w_.to_point[at];
        if (!edge.is_line && edge.facets > 0 && edge.reference != reference) fits = false;
        ++edge.facets;
        edge.reference = reference;
    }
    return fits;
}

template <int D>
void Starring<D>::count_before(const SimplexVertices<D - 1>& facet) {
    for (const VertexId v : facet)
        if (const std::uint32_t at = v == point_ ? nothing : w_.vertices.find(v); at != nothing)
            ++w_.to_point[at].before;
}

template <int D>
bool Starring<D>::lines_keep_their_facets() {
    for (const auto& [line, opposite] : out_.lines) {
        const auto& ends = mesh_.edges[mesh_.lines[line]];
        if (ends[opposite] == point_) continue;  // made again: counted
        const auto is_on_line = [&](FacetId f) {
            const auto& v = mesh_.facets.vertices[f];
            return local_vertex(v, ends[0]) >= 0 && local_vertex(v, ends[1]) >= 0;
        };
        w_.to_point[w_.vertices.find(ends[1 - opposite])].before =
            static_cast<std::uint8_t>(std::ranges::count_if(cavity_.facets, is_on_line));
    }
    return std::ranges::all_of(w_.to_point,
                               [](const auto& edge) { return !edge.is_line || edge.facets == edge.before; });
}

template <int D>
StarFailure Starring<D>::surface_at_point() {
    facets_at_point_ = 0;
    bool fits = true;
    bool was_touched = false;
    std::size_t before = 0;
    if (point_.valid())
        for (const ElementId e : w_.outside)
            for (int face = 0; face <= D; ++face) {
                const FacetId f = facet_at(mesh_, e, face);
                if (!f.valid() || mesh_.sides[f][0] != e || mesh_.elements.vertices[e][face] == point_) continue;
                ++before;
                if (D == 3) count_before(mesh_.facets.vertices[f]);
                if (w_.facets.contains(f)) {
                    was_touched = true;
                    continue;
                }
                fits = count_facet(mesh_.facets.vertices[f], mesh_.facets.references[f]) && fits;
                if (D == 2) meet(mesh_.facets.references[f]);
            }
    for (const JoinedFacet& joined : out_.facets) {
        SimplexVertices<D - 1> v = mesh_.facets.vertices[joined.facet];
        v[joined.opposite] = point_;
        fits = count_facet(v, mesh_.facets.references[joined.facet]) && fits;
        if (D == 2) meet(mesh_.facets.references[joined.facet]);
    }
    if (!fits) return StarFailure::surface;
    if (D == 3)
        for (const auto& edge : w_.to_point)
            if (!edge.is_line && edge.facets != 0 && edge.facets != 2) return StarFailure::surface;
    if (D == 3 && !lines_keep_their_facets()) return StarFailure::surface;
    if (facets_at_point_ > 0) out_.place = VertexPlace::surface;
    // A new point is on one piece of surfaces.
    if (!point_.valid()) return D == 2 || is_one_fan() ? StarFailure::none : StarFailure::surface;
    // A point of surfaces stays on those that it was on, and comes on no other.
    if (D == 2) passed_before_ = before;
    if ((before > 0) != (facets_at_point_ > 0)) return StarFailure::surface;
    if (out_.facets.empty()) return StarFailure::none;
    if (!was_touched) return StarFailure::surface;
    return D == 3 && mesh_.states[point_].place == VertexPlace::surface && !is_one_fan() ? StarFailure::surface
                                                                                         : StarFailure::none;
}

template <int D>
bool Starring<D>::is_one_fan() {
    Groups groups(w_.groups, out_.facets.size());
    for (std::uint32_t i = 0; i < out_.facets.size(); ++i)
        for (std::uint32_t j = 0; j < i; ++j)
            if (share_a_vertex(out_.facets[i], out_.facets[j])) groups.join(i, j);
    return out_.facets.empty() || groups.count() == 1;
}

template <int D>
bool Starring<D>::share_a_vertex(const JoinedFacet& a, const JoinedFacet& b) const {
    const auto& v = mesh_.facets.vertices[a.facet];
    const auto& w = mesh_.facets.vertices[b.facet];
    for (std::size_t i = 0; i < v.size(); ++i)
        for (std::size_t j = 0; j < w.size(); ++j)
            if (i != a.opposite && j != b.opposite && v[i] == w[j]) return true;
    return false;
}

#define CAMBER_INSTANTIATE(D) template class Starring<D>;

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
