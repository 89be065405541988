module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <tuple>
#include <vector>
module camber.cavity;
import camber.core;
import :starring;

namespace camber {

template <int D>
StarFailure Starring<D>::run() {
    out_.clear();
    using Step = StarFailure (Starring::*)();
    constexpr std::array<Step, 2> taking{&Starring::take_parts, &Starring::open_faces};
    constexpr std::array<Step, 8> joining{
        &Starring::vertices,    &Starring::faces_at_point, &Starring::facets,         &Starring::lines,
        &Starring::ball_around, &Starring::nothing_exists, &Starring::faces_complete, &Starring::surface_at_point};
    for (const Step step : taking)
        if (const StarFailure failure = (this->*step)(); failure != StarFailure::none) return failure;
    collect_boundary();
    if (is_ball_inside()) {
        w_.to_point.assign(out_.boundary.size(), {.is_there = true});
        return StarFailure::none;
    }
    for (const Step step : joining)
        if (const StarFailure failure = (this->*step)(); failure != StarFailure::none) return failure;
    return line_at_point();
}

template <int D>
bool Starring<D>::is_ball_inside() const {
    if (!point_.valid() || mesh_.states[point_].place != VertexPlace::inside) return false;
    if (!cavity_.facets.empty() || !cavity_.lines.empty() || !out_.kept.empty()) return false;
    // Each element gives the one face that is opposite the point.
    return out_.joined.size() == cavity_.elements.size() &&
           std::ranges::all_of(out_.joined, [&](const ElementFace& open) {
               return mesh_.elements.vertices[open.element][static_cast<int>(open.opposite)] == point_;
           });
}

template <int D>
StarFailure Starring<D>::take_parts() {
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
        // Between frozen vertices the mesh may touch itself: the edge can be of elements that no walk finds.
        const bool held = std::ranges::all_of(mesh_.edges[mesh_.lines[l]],
                                              [&](VertexId v) { return mesh_.states[v].marks.has(Mark::frozen); });
        if (held || mesh_.line_marks[l].has(Mark::required)) return StarFailure::required;
        w_.lines.put(l, i);
    }
    return StarFailure::none;
}

template <int D>
StarFailure Starring<D>::open_faces() {
    for (const ElementId e : cavity_.elements) {
        const auto& v = mesh_.elements.vertices[e];
        const int held = point_.valid() ? local_vertex(v, point_) : -1;
        for (int face = 0; face <= D; ++face) {
            if (!is_open(e, face)) continue;
            const ElementFace open{e, static_cast<std::uint32_t>(face)};
            (held >= 0 && held != face ? out_.kept : out_.joined).push_back(open);
        }
    }
    return out_.joined.empty() ? StarFailure::empty : StarFailure::none;
}

template <int D>
void Starring<D>::collect_boundary() {
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
StarFailure Starring<D>::vertices() {
    w_.to_point.assign(out_.boundary.size(), {});
    for (const ElementId e : cavity_.elements) {
        const auto& simplex = mesh_.elements.vertices[e];
        const bool holds_point = point_.valid() && local_vertex(simplex, point_) >= 0;
        for (const VertexId v : simplex) {
            if (v == point_) continue;
            const std::uint32_t at = w_.vertices.find(v);
            if (at == nothing)
                out_.vanishing.push_back(v);
            else if (holds_point)
                w_.to_point[at].is_there = true;
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
StarFailure Starring<D>::faces_at_point() {
    return find_faces<D>(mesh_.elements.vertices, mesh_.edges_of, out_, point_, w_.names, w_.faces) ? StarFailure::none
                                                                                                    : StarFailure::ball;
}

template <int D>
Reference Starring<D>::reference_beside(const StarFace::Side& side) const {
    const ElementFace& open = (side.kept ? out_.kept : out_.joined)[side.of];
    if (!side.kept) return mesh_.elements.references[open.element];
    const FaceNeighbour across = mesh_.face_neighbours[open.element][static_cast<int>(open.opposite)];
    return across.is_element() ? mesh_.elements.references[across.element()] : nowhere;
}

template <int D>
StarFailure Starring<D>::faces_complete() {
    for (const StarFace& face : w_.faces) {
        const bool is_kept = face.sides[0].kept || (face.count == 2 && face.sides[1].kept);
        if (face.facet != nothing) {
            const bool two_sided = mesh_.sides[out_.facets[face.facet].facet][1].valid();
            if (is_kept || face.count != (two_sided ? 2 : 1)) return StarFailure::surface;
            continue;
        }
        if (face.count != 2) return StarFailure::surface;
        if (face.sides[0].kept && face.sides[1].kept) return StarFailure::ball;
        const Reference a = reference_beside(face.sides[0]);
        const Reference b = reference_beside(face.sides[1]);
        if (a != b && a != nowhere && b != nowhere) return StarFailure::surface;
    }
    return StarFailure::none;
}

template <int D>
StarFailure Starring<D>::ball_around() {
    Groups groups(w_.groups, out_.joined.size());
    bool has_border = false;
    for (const StarFace& face : w_.faces) {
        if (face.count < 2 || face.sides[0].kept || face.sides[1].kept) {
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
bool Starring<D>::is_beside_one_part() {
    // Elements that do not hold the point stay alone in their groups.
    Groups groups(w_.groups, cavity_.elements.size());
    std::size_t alone = 0;
    for (std::uint32_t i = 0; i < cavity_.elements.size(); ++i) {
        const ElementId e = cavity_.elements[i];
        const int held = local_vertex(mesh_.elements.vertices[e], point_);
        if (held < 0) ++alone;
        for (int face = 0; held >= 0 && face <= D; ++face) {
            if (face == held || is_open(e, face)) continue;
            const ElementId next = element_across(mesh_, e, face);
            if (const std::uint32_t at = next.valid() ? w_.elements.find(next) : nothing; at != nothing)
                groups.join(i, at);
        }
    }
    return groups.count() == alone + 1;
}

template <int D>
StarFailure Starring<D>::nothing_exists() {
    if (!point_.valid()) return StarFailure::none;
    ball(mesh_, point_, w_.outside);
    if (!is_beside_one_part()) return StarFailure::ball;
    for (const ElementId e : w_.outside) {
        if (w_.elements.contains(e)) continue;
        const auto& v = mesh_.elements.vertices[e];
        const int held = local_vertex(v, point_);
        for (int i = 0; i <= D; ++i) {
            if (i == held) continue;
            const std::uint32_t at = w_.vertices.find(v[i]);
            if (at != nothing && !w_.to_point[at].is_there) return StarFailure::exists;
            // The face opposite local vertex i.
            const ElementFace beside{e, static_cast<std::uint32_t>(i)};
            const std::uint32_t face =
                w_.names.find(side_without<D>(mesh_.elements.vertices, mesh_.edges_of, beside, held));
            if (face == nothing) continue;
            const auto& sides = w_.faces[face].sides;
            if (!sides[0].kept && !(w_.faces[face].count == 2 && sides[1].kept)) return StarFailure::exists;
        }
    }
    return StarFailure::none;
}

template <int D>
StarFailure star(const DynamicMesh<D>& mesh, const Cavity<D>& cavity, VertexId point, StarWorkspace<D>& workspace,
                 Star<D>& out) {
    return Starring<D>(mesh, cavity, point, workspace, out).run();
}

#define CAMBER_INSTANTIATE(D)                                                                                     \
    template StarFailure star<D>(const DynamicMesh<D>&, const Cavity<D>&, VertexId, StarWorkspace<D>&, Star<D>&); \
    template class Starring<D>;

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
