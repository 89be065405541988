// Joins the faces of a cavity to a point, with facets and lines.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>
module camber.cavity;
import camber.core;

namespace camber {

template <int D>
StarFailure StarBuilder<D>::run() {
    out_.clear();
    using Step = StarFailure (StarBuilder::*)();
    constexpr std::array<Step, 2> taking{&StarBuilder::take_parts, &StarBuilder::open_faces};
    constexpr std::array<Step, 8> joining{&StarBuilder::vertices,       &StarBuilder::faces_at_point,
                                          &StarBuilder::facets,         &StarBuilder::lines,
                                          &StarBuilder::ball_around,    &StarBuilder::check_existing,
                                          &StarBuilder::faces_complete, &StarBuilder::surface_at_point};
    for (const Step step : taking)
        if (const StarFailure failure = (this->*step)(); failure != StarFailure::none) return failure;
    collect_boundary();
    if (is_ball_inside()) {
        w_.to_point.assign(out_.boundary.size(), {.is_present = true});
        return StarFailure::none;
    }
    for (const Step step : joining)
        if (const StarFailure failure = (this->*step)(); failure != StarFailure::none) return failure;
    return line_at_point();
}

template <int D>
bool StarBuilder<D>::is_ball_inside() const {
    if (!point_.valid() || mesh_.states[point_].place != VertexPlace::inside) return false;
    if (!cavity_.facets.empty() || !cavity_.lines.empty() || !out_.preserved.empty()) return false;
    // Each element must have one open face, the one opposite the point.
    return out_.joined.size() == cavity_.elements.size() &&
           std::ranges::all_of(out_.joined, [&](const ElementFace& open) {
               return mesh_.elements.vertices[open.element][static_cast<int>(open.opposite)] == point_;
           });
}

template <int D>
StarFailure StarBuilder<D>::take_parts() {
    w_.elements.clear();
    w_.facets.clear();
    w_.lines.clear();
    if (point_.valid() && mesh_.states[point_].marks.has(Mark::frozen)) return StarFailure::required;
    for (std::uint32_t i = 0; i < cavity_.elements.size(); ++i) {
        const ElementId e = cavity_.elements[i];
        if (mesh_.elements.marks[e].has(Mark::required)) return StarFailure::required;
        w_.elements.put(e, i);
    }
    for (std::uint32_t i = 0; i < cavity_.facets.size(); ++i) {
        const FacetId f = cavity_.facets[i];
        if (mesh_.is_free(f) || !mesh_.sides[f][0].valid()) return StarFailure::surface;
        if (mesh_.facets.marks[f].has(Mark::required)) return StarFailure::required;
        for (const ElementId side : mesh_.sides[f])
            if (side.valid() && !w_.elements.contains(side)) return StarFailure::surface;
        w_.facets.put(f, i);
    }
    for (std::uint32_t i = 0; i < cavity_.lines.size(); ++i) {
        const LineId l = cavity_.lines[i];
        if (mesh_.is_free(l)) return StarFailure::line;
        // If both ends are frozen, the mesh may touch itself, and a walk may miss elements of the edge.
        const bool is_frozen = std::ranges::all_of(mesh_.edges[mesh_.lines[l]],
                                                   [&](VertexId v) { return mesh_.states[v].marks.has(Mark::frozen); });
        if (is_frozen || mesh_.line_marks[l].has(Mark::required)) return StarFailure::required;
        w_.lines.put(l, i);
    }
    return StarFailure::none;
}

template <int D>
StarFailure StarBuilder<D>::open_faces() {
    for (const ElementId e : cavity_.elements) {
        const auto& v = mesh_.elements.vertices[e];
        const int point_index = point_.valid() ? local_vertex(v, point_) : -1;
        for (int face = 0; face <= D; ++face) {
            if (!is_open(e, face)) continue;
            const ElementFace open{e, static_cast<std::uint32_t>(face)};
            (point_index >= 0 && point_index != face ? out_.preserved : out_.joined).push_back(open);
        }
    }
    return out_.joined.empty() ? StarFailure::empty : StarFailure::none;
}

template <int D>
void StarBuilder<D>::collect_boundary() {
    w_.vertices.clear();
    for (const ElementFace& open : out_.joined)
        for (int i = 0; i <= D; ++i) {
            if (i == static_cast<int>(open.opposite)) continue;
            const VertexId v = mesh_.elements.vertices[open.element][i];
            const auto next = static_cast<std::uint32_t>(out_.boundary.size());
            if (w_.vertices.put(v, next) == next) out_.boundary.push_back(v);
        }
}

template <int D>
StarFailure StarBuilder<D>::vertices() {
    w_.to_point.assign(out_.boundary.size(), {});
    for (const ElementId e : cavity_.elements) {
        const auto& simplex = mesh_.elements.vertices[e];
        const bool contains_point = point_.valid() && local_vertex(simplex, point_) >= 0;
        for (const VertexId v : simplex) {
            if (v == point_) continue;
            const std::uint32_t at = w_.vertices.find(v);
            if (at == none_found)
                out_.vanishing.push_back(v);
            else if (contains_point)
                w_.to_point[at].is_present = true;
        }
    }
    std::sort(out_.vanishing.begin(), out_.vanishing.end());
    out_.vanishing.erase(std::unique(out_.vanishing.begin(), out_.vanishing.end()), out_.vanishing.end());
    for (const VertexId v : out_.vanishing) {
        const VertexState& state = mesh_.states[v];
        if (state.place == VertexPlace::corner || state.marks.has(Mark::required) || state.marks.has(Mark::frozen))
            return StarFailure::required;
    }
    return StarFailure::none;
}

template <int D>
StarFailure StarBuilder<D>::faces_at_point() {
    return find_faces<D>(mesh_.elements.vertices, mesh_.edges_of, out_, point_, w_.names, w_.faces) ? StarFailure::none
                                                                                                    : StarFailure::ball;
}

template <int D>
Reference StarBuilder<D>::reference_beside(const StarFace::Side& side) const {
    const ElementFace& open = (side.preserved ? out_.preserved : out_.joined)[side.of];
    if (!side.preserved) return mesh_.elements.references[open.element];
    const FaceNeighbour across = mesh_.face_neighbours[open.element][static_cast<int>(open.opposite)];
    return across.is_element() ? mesh_.elements.references[across.element()] : no_reference;
}

template <int D>
StarFailure StarBuilder<D>::faces_complete() {
    for (const StarFace& face : w_.faces) {
        const bool is_preserved = face.sides[0].preserved || (face.count == 2 && face.sides[1].preserved);
        if (face.facet != none_found) {
            const bool two_sided = mesh_.sides[out_.facets[face.facet].facet][1].valid();
            if (is_preserved || face.count != (two_sided ? 2 : 1)) return StarFailure::surface;
            continue;
        }
        if (face.count != 2) return StarFailure::surface;
        if (face.sides[0].preserved && face.sides[1].preserved) return StarFailure::ball;
        const Reference a = reference_beside(face.sides[0]);
        const Reference b = reference_beside(face.sides[1]);
        if (a != b && a != no_reference && b != no_reference) return StarFailure::surface;
    }
    return StarFailure::none;
}

template <int D>
StarFailure StarBuilder<D>::ball_around() {
    Groups groups(w_.groups, out_.joined.size());
    bool has_border = false;
    for (const StarFace& face : w_.faces) {
        if (face.count < 2 || face.sides[0].preserved || face.sides[1].preserved) {
            has_border = true;
            continue;
        }
        groups.join(face.sides[0].of, face.sides[1].of);
    }
    const auto count = [](const auto& items) { return static_cast<std::ptrdiff_t>(items.size()); };
    const std::ptrdiff_t euler = D == 3 ? count(out_.boundary) - count(w_.faces) + count(out_.joined)
                                        : count(out_.boundary) - count(out_.joined);
    const std::ptrdiff_t expected = has_border ? 1 : D == 3 ? 2 : 0;
    return groups.count() == 1 && euler == expected ? StarFailure::none : StarFailure::ball;
}

template <int D>
bool StarBuilder<D>::is_beside_one_part() {
    // Each element that does not contain the point stays alone in its group. The others must form one group.
    Groups groups(w_.groups, cavity_.elements.size());
    std::size_t alone = 0;
    for (std::uint32_t i = 0; i < cavity_.elements.size(); ++i) {
        const ElementId e = cavity_.elements[i];
        const int point_index = local_vertex(mesh_.elements.vertices[e], point_);
        if (point_index < 0) ++alone;
        for (int face = 0; point_index >= 0 && face <= D; ++face) {
            if (face == point_index || is_open(e, face)) continue;
            const ElementId next = element_across(mesh_, e, face);
            if (const std::uint32_t at = next.valid() ? w_.elements.find(next) : none_found; at != none_found)
                groups.join(i, at);
        }
    }
    return groups.count() == alone + 1;
}

template <int D>
StarFailure StarBuilder<D>::check_existing() {
    if (!point_.valid()) return StarFailure::none;
    ball(mesh_, point_, w_.outside);
    if (!is_beside_one_part()) return StarFailure::ball;
    for (const ElementId e : w_.outside) {
        if (w_.elements.contains(e)) continue;
        const auto& v = mesh_.elements.vertices[e];
        const int point_index = local_vertex(v, point_);
        for (int i = 0; i <= D; ++i) {
            if (i == point_index) continue;
            const std::uint32_t at = w_.vertices.find(v[i]);
            if (at != none_found && !w_.to_point[at].is_present) return StarFailure::exists;
            // `beside`: the face opposite local vertex i.
            const ElementFace beside{e, static_cast<std::uint32_t>(i)};
            const std::uint32_t face =
                w_.names.find(side_without<D>(mesh_.elements.vertices, mesh_.edges_of, beside, point_index));
            if (face == none_found) continue;
            const auto& sides = w_.faces[face].sides;
            if (!sides[0].preserved && !(w_.faces[face].count == 2 && sides[1].preserved)) return StarFailure::exists;
        }
    }
    return StarFailure::none;
}

template <int D>
StarFailure star(const DynamicMesh<D>& mesh, const Cavity<D>& cavity, VertexId point, StarWorkspace<D>& workspace,
                 Star<D>& out) {
    return StarBuilder<D>(mesh, cavity, point, workspace, out).run();
}

template <int D>
void StarBuilder<D>::preserve_facet_at(EdgeId edge) {
    for (const VertexId v : mesh_.edges[edge])
        if (const std::uint32_t at = w_.vertices.find(v); at != none_found) w_.to_point[at].preserves_facet = true;
}

template <int D>
void StarBuilder<D>::list_facet_sides() {
    w_.open_sides.clear();
    for (const FacetId f : cavity_.facets)
        for (std::uint32_t k = 0; k < D; ++k) {
            const Reference reference = mesh_.facets.references[f];
            if constexpr (D == 3) {
                const EdgeId edge = facet_edge(mesh_, f, static_cast<int>(k));
                const LineId line = mesh_.line_of[edge];
                if (line.valid() && w_.lines.contains(line)) {
                    preserve_facet_at(edge);
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
bool StarBuilder<D>::is_inside(std::span<const OpenSide> sides, std::size_t first, std::size_t last) const {
    return last - first == 2 && (!sides[first].is_line || (D == 2 && contains_point(sides[first].name)));
}

template <int D>
bool StarBuilder<D>::pieces_have_sides() {
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
    // `sides` omits sides on removed lines. A facet with fewer than D sides in `sides` therefore has a side on a
    // removed line, which counts as border.
    std::vector<std::uint8_t> listed(cavity_.facets.size(), 0);
    for (const OpenSide& side : sides) ++listed[index(side)];
    for (std::uint32_t f = 0; f < listed.size(); ++f)
        if (listed[f] < D) has_side[groups.root(f)] = 1;
    for (std::uint32_t f = 0; f < listed.size(); ++f)
        if (has_side[groups.root(f)] == 0) return false;
    return true;
}

template <int D>
StarFailure StarBuilder<D>::facets() {
    list_facet_sides();
    for (const FacetId f : cavity_.facets)
        for (const VertexId v : mesh_.facets.vertices[f])
            if (const std::uint32_t at = w_.vertices.find(v); at != none_found) w_.to_point[at].lost_facet = true;
    const auto& sides = w_.open_sides;
    for (std::size_t i = 0, next = 0; i < sides.size(); i = next) {
        next = i + 1;
        while (next < sides.size() && sides[next].name == sides[i].name && sides[next].reference == sides[i].reference)
            ++next;
        if (next - i > 2) return StarFailure::surface;
        if (is_inside(sides, i, next)) continue;
        if (next - i == 2) return StarFailure::surface;
        for (const VertexId v : vertices_of(sides[i].name))
            if (const std::uint32_t at = w_.vertices.find(v); at != none_found) w_.to_point[at].preserves_facet = true;
        if (contains_point(sides[i].name)) continue;
        const std::uint32_t at = w_.names.find(sides[i].name);
        if (at == none_found || w_.faces[at].facet != none_found) return StarFailure::surface;
        w_.faces[at].facet = static_cast<std::uint32_t>(out_.facets.size());
        out_.facets.push_back(sides[i].facet);
    }
    if (!pieces_have_sides()) return StarFailure::surface;
    // A vertex that stays must remain on its surface.
    for (const auto& vertex : w_.to_point)
        if (vertex.lost_facet && !vertex.preserves_facet) return StarFailure::surface;
    return StarFailure::none;
}

template <int D>
bool StarBuilder<D>::count_facet(const SimplexVertices<D - 1>& facet, Reference reference) {
    ++facets_at_point_;
    bool fits = true;
    for (const VertexId v : facet) {
        if (v == point_) continue;
        const std::uint32_t at = w_.vertices.find(v);
        if (at == none_found) continue;
        auto& edge = w_.to_point[at];
        if (!edge.is_line && edge.facets > 0 && edge.reference != reference) fits = false;
        ++edge.facets;
        edge.reference = reference;
    }
    return fits;
}

template <int D>
void StarBuilder<D>::count_before(const SimplexVertices<D - 1>& facet) {
    for (const VertexId v : facet)
        if (const std::uint32_t at = v == point_ ? none_found : w_.vertices.find(v); at != none_found)
            ++w_.to_point[at].before;
}

template <int D>
bool StarBuilder<D>::lines_preserve_facets() {
    for (const auto& [line, opposite] : out_.lines) {
        const auto& ends = mesh_.edges[mesh_.lines[line]];
        if (ends[opposite] == point_)
            continue;  // the line at the point exists again after the operation, and its facets are counted already
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
StarFailure StarBuilder<D>::surface_at_point() {
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
    if (D == 3 && !lines_preserve_facets()) return StarFailure::surface;
    if (facets_at_point_ > 0) out_.place = VertexPlace::surface;
    // The new facets at a new point must form one fan around it.
    if (!point_.valid()) return D == 2 || is_one_fan() ? StarFailure::none : StarFailure::surface;
    // An existing point stays on its surfaces, and gets no others.
    if (D == 2) passed_before_ = before;
    if ((before > 0) != (facets_at_point_ > 0)) return StarFailure::surface;
    if (out_.facets.empty()) return StarFailure::none;
    if (!was_touched) return StarFailure::surface;
    return D == 3 && mesh_.states[point_].place == VertexPlace::surface && !is_one_fan() ? StarFailure::surface
                                                                                         : StarFailure::none;
}

template <int D>
bool StarBuilder<D>::is_one_fan() {
    Groups groups(w_.groups, out_.facets.size());
    for (std::uint32_t i = 0; i < out_.facets.size(); ++i)
        for (std::uint32_t j = 0; j < i; ++j)
            if (share_a_vertex(out_.facets[i], out_.facets[j])) groups.join(i, j);
    return out_.facets.empty() || groups.count() == 1;
}

template <int D>
bool StarBuilder<D>::share_a_vertex(const JoinedFacet& a, const JoinedFacet& b) const {
    const auto& v = mesh_.facets.vertices[a.facet];
    const auto& w = mesh_.facets.vertices[b.facet];
    for (std::size_t i = 0; i < v.size(); ++i)
        for (std::size_t j = 0; j < w.size(); ++j)
            if (i != a.opposite && j != b.opposite && v[i] == w[j]) return true;
    return false;
}

template <int D>
bool StarBuilder<D>::survives(EdgeId edge) const {
    if constexpr (D == 3) {
        const auto& [a, b] = mesh_.edges[edge];
        if (a == point_) return w_.vertices.contains(b);
        if (b == point_) return w_.vertices.contains(a);
        return w_.names.contains(edge);
    } else {
        static_cast<void>(edge);
        return true;
    }
}

template <int D>
void StarBuilder<D>::has_line(EdgeId edge) {
    const auto& [a, b] = mesh_.edges[edge];
    if (const std::uint32_t at = w_.vertices.find(a == point_ ? b : a); at != none_found)
        w_.to_point[at].is_line = true;
}

template <int D>
bool StarBuilder<D>::pieces_have_ends(std::span<const LineAt> ends) {
    Groups groups(w_.groups, cavity_.lines.size());
    std::vector<std::uint8_t> has_end(cavity_.lines.size(), 0);
    const auto index = [&](const LineAt& end) { return w_.lines.find(end.line.line); };
    for (std::size_t i = 1; i < ends.size(); ++i)
        if (ends[i].vertex == ends[i - 1].vertex) groups.join(index(ends[i]), index(ends[i - 1]));
    for (const LineAt& end : ends)
        if (end.vertex == point_ || w_.vertices.contains(end.vertex)) has_end[groups.root(index(end))] = 1;
    for (std::uint32_t l = 0; l < cavity_.lines.size(); ++l)
        if (has_end[groups.root(l)] == 0) return false;
    return true;
}

template <int D>
StarFailure StarBuilder<D>::lines() {
    if constexpr (D == 3) {
        std::size_t met = 0;  // number of removed lines found in the cavity
        std::vector<std::uint8_t> is_met(cavity_.lines.size(), 0);
        for (const ElementId e : cavity_.elements)
            for (const EdgeId edge : mesh_.edges_of[e])
                if (const LineId line = mesh_.line_of[edge]; line.valid()) {
                    const std::uint32_t at = w_.lines.find(line);
                    const bool removed = at != none_found;
                    if (removed && is_met[at] == 0) is_met[at] = 1, ++met;
                    const bool of_point = mesh_.edges[edge][0] == point_ || mesh_.edges[edge][1] == point_;
                    if (survives(edge) ? removed && !of_point : !removed) return StarFailure::line;
                    if (of_point && !removed) has_line(edge);
                }
        if (met != cavity_.lines.size()) return StarFailure::line;
        if (cavity_.lines.empty()) return StarFailure::none;
        std::vector<LineAt> ends;
        ends.reserve(2 * cavity_.lines.size());
        for (const LineId l : cavity_.lines)
            for (std::uint32_t k = 0; k < 2; ++k)
                ends.push_back({mesh_.edges[mesh_.lines[l]][1 - k], mesh_.line_references[l], {l, k}});
        std::sort(ends.begin(), ends.end(), [](const LineAt& a, const LineAt& b) {
            return std::tie(a.vertex, a.reference, a.line.line) < std::tie(b.vertex, b.reference, b.line.line);
        });
        if (!pieces_have_ends(ends)) return StarFailure::line;
        for (std::size_t i = 0, next = 0; i < ends.size(); i = next) {
            next = i + 1;
            while (next < ends.size() && ends[next].vertex == ends[i].vertex) ++next;
            const VertexId v = ends[i].vertex;
            if (v == point_) continue;
            const bool stays = w_.vertices.contains(v);
            const bool through = next - i == 2 && ends[i].reference == ends[i + 1].reference;
            // Exactly two removed lines of one reference must meet at a vanishing vertex. Exactly one removed line may
            // end at a vertex that stays; the new line joins this vertex to the point.
            if (stays ? next - i != 1 : !through) return StarFailure::line;
            if (!stays) continue;
            auto& edge = w_.to_point[w_.vertices.find(v)];
            if (edge.is_line) return StarFailure::line;
            edge.is_line = true;
            out_.lines.push_back(ends[i].line);
        }
    }
    return StarFailure::none;
}

template <int D>
StarFailure StarBuilder<D>::line_at_point() {
    if constexpr (D == 3) {
        for (const JoinedLine& joined : out_.lines) meet(mesh_.line_references[joined.line]);
        if (point_.valid()) {
            lines_with(mesh_, w_.outside, point_, w_.lines_at_point);
            passed_before_ = w_.lines_at_point.size();
            for (const LineId l : w_.lines_at_point)
                if (!w_.lines.contains(l)) meet(mesh_.line_references[l]);
        }
    }
    constexpr VertexPlace through = D == 3 ? VertexPlace::line : VertexPlace::surface;
    if (point_.valid()) {
        const VertexPlace now = mesh_.states[point_].place;
        const bool passes = passing_ == 2 && !mixed_;
        if (now == VertexPlace::corner) return passing_ == passed_before_ ? StarFailure::none : StarFailure::line;
        return (now == through ? passes : passing_ == 0) ? StarFailure::none : StarFailure::line;
    }
    if (passing_ == 0) return StarFailure::none;
    out_.place = through;
    return passing_ == 2 && !mixed_ ? StarFailure::none : StarFailure::line;
}

#define CAMBER_INSTANTIATE(D) \
    template StarFailure star<D>(const DynamicMesh<D>&, const Cavity<D>&, VertexId, StarWorkspace<D>&, Star<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
