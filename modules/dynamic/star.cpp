module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <tuple>
#include <vector>
module camber.dynamic;
import camber.core;

namespace camber {

namespace {

constexpr std::uint32_t nothing = 0xffffffffU;

/// Items that hang together (union and find).
class Groups {
  public:
    Groups(std::vector<std::uint32_t>& storage, std::size_t n) : of_(storage), count_(n) {
        of_.resize(n);
        std::iota(of_.begin(), of_.end(), 0U);
    }
    void join(std::uint32_t i, std::uint32_t j) {
        const std::uint32_t a = root(i);
        const std::uint32_t b = root(j);
        if (a == b) return;
        of_[std::max(a, b)] = std::min(a, b);
        --count_;
    }
    [[nodiscard]] std::size_t count() const { return count_; }

  private:
    [[nodiscard]] std::uint32_t root(std::uint32_t i) {
        while (of_[i] != i) i = of_[i] = of_[of_[i]];
        return i;
    }
    std::vector<std::uint32_t>& of_;
    std::size_t count_;
};

template <int D>
class Starring {
  public:
    Starring(const DynamicMesh<D>& mesh, const CavityParts<D>& cavity, VertexId point, StarWorkspace<D>& workspace,
             Star<D>& out)
        : mesh_(mesh), cavity_(cavity), point_(point), w_(workspace), out_(out) {}

    [[nodiscard]] StarFailure run() {
        out_.clear();
        using Step = StarFailure (Starring::*)();
        constexpr std::array<Step, 10> steps{
            &Starring::take_parts,     &Starring::open_faces,      &Starring::vertices,    &Starring::faces_at_point,
            &Starring::facets,         &Starring::lines,           &Starring::ball_around, &Starring::nothing_exists,
            &Starring::faces_complete, &Starring::surface_at_point};
        for (const Step step : steps)
            if (const StarFailure failure = (this->*step)(); failure != StarFailure::none) return failure;
        return line_at_point();
    }

  private:
    /// The cavity as sets; what may not go is not in it.
    StarFailure take_parts() {
        w_.elements.clear();
        w_.facets.clear();
        w_.lines.clear();
        if (point_.valid() && mesh_.states[point_].marks.has(Mark::held)) return StarFailure::required;
        for (const ElementId e : cavity_.elements) {
            if (mesh_.elements.marks[e].has(Mark::required)) return StarFailure::required;
            w_.elements.put(e, 0);
        }
        for (const FacetId f : cavity_.facets) {
            if (mesh_.facets.marks[f].has(Mark::required)) return StarFailure::required;
            for (const ElementId side : mesh_.sides[f])
                if (side.valid() && !w_.elements.contains(side)) return StarFailure::surface;
            w_.facets.put(f, 0);
        }
        for (const LineId l : cavity_.lines) {
            // Between held vertices the mesh may touch itself: the edge can be of elements that no walk finds.
            const bool held = std::ranges::all_of(mesh_.edges[mesh_.lines[l]],
                                                  [&](VertexId v) { return mesh_.states[v].marks.has(Mark::held); });
            if (held || mesh_.line_marks[l].has(Mark::required)) return StarFailure::required;
            w_.lines.put(l, 0);
        }
        return StarFailure::none;
    }

    [[nodiscard]] bool is_open(ElementId e, int face) const {
        const Across across = mesh_.across[e][face];
        if (across.is_facet()) return !w_.facets.contains(across.facet());
        return !across.valid() || !w_.elements.contains(across.element());
    }
    StarFailure open_faces() {
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

    StarFailure vertices() {
        w_.vertices.clear();
        for (const ElementFace& open : out_.joined)
            for (int i = 0; i <= D; ++i) {
                if (i == static_cast<int>(open.opposite)) continue;
                const VertexId v = mesh_.elements.vertices[open.element][i];
                const auto next = static_cast<std::uint32_t>(out_.boundary.size());
                if (w_.vertices.put(v, next) == next) out_.boundary.push_back(v);
            }
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
            if (state.place == VertexPlace::corner || state.marks.has(Mark::required) || state.marks.has(Mark::held))
                return StarFailure::required;
        }
        return StarFailure::none;
    }

    StarFailure faces_at_point() {
        return find_faces<D>(mesh_.elements.vertices, mesh_.edges_of, out_, point_, w_.names, w_.faces)
                   ? StarFailure::none
                   : StarFailure::ball;
    }

    /// A vertex on a line that goes is on the border of its patch.
    void keep_facet_at(EdgeId edge) {
        for (const VertexId v : mesh_.edges[edge])
            if (const std::uint32_t at = w_.vertices.find(v); at != nothing) w_.to_point[at].keeps_facet = true;
    }
    /// The sides of removed facets (3D: edges; 2D: vertices), but for those on lines that go as well.
    void list_facet_sides() {
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
    [[nodiscard]] auto vertices_of(SideId<D> side) const {
        if constexpr (D == 2)
            return std::array{side};
        else
            return mesh_.edges[side];
    }
    [[nodiscard]] bool holds_point(SideId<D> side) const {
        return point_.valid() && std::ranges::count(vertices_of(side), point_) > 0;
    }
    /// What two removed facets of one reference share is inside of their patch, unless a line that stays runs there;
    /// what is left bounds it (paper §1.3: faces are joined before elements).
    StarFailure facets() {
        list_facet_sides();
        for (const FacetId f : cavity_.facets)
            for (const VertexId v : mesh_.facets.vertices[f])
                if (const std::uint32_t at = w_.vertices.find(v); at != nothing) w_.to_point[at].lost_facet = true;
        const auto& sides = w_.open_sides;
        for (std::size_t i = 0, next = 0; i < sides.size(); i = next) {
            next = i + 1;
            while (next < sides.size() && sides[next].name == sides[i].name &&
                   sides[next].reference == sides[i].reference)
                ++next;
            if (next - i > 2) return StarFailure::surface;
            if (next - i == 2 && !sides[i].is_line) continue;
            if (next - i == 2) return StarFailure::surface;
            for (const VertexId v : vertices_of(sides[i].name))
                if (const std::uint32_t at = w_.vertices.find(v); at != nothing) w_.to_point[at].keeps_facet = true;
            if (holds_point(sides[i].name)) continue;
            const std::uint32_t at = w_.names.find(sides[i].name);
            if (at == nothing || w_.faces[at].facet != nothing) return StarFailure::surface;
            w_.faces[at].facet = static_cast<std::uint32_t>(out_.facets.size());
            out_.facets.push_back(sides[i].facet);
        }
        // A vertex that stays, stays on its surface.
        for (const auto& vertex : w_.to_point)
            if (vertex.lost_facet && !vertex.keeps_facet) return StarFailure::surface;
        return StarFailure::none;
    }

    [[nodiscard]] Reference reference_beside(const StarFace::Side& side) const {
        const ElementFace& open = (side.kept ? out_.kept : out_.joined)[side.of];
        if (!side.kept) return mesh_.elements.references[open.element];
        const Across across = mesh_.across[open.element][static_cast<int>(open.opposite)];
        return across.is_element() ? mesh_.elements.references[across.element()] : nowhere;
    }
    static constexpr Reference nowhere = std::numeric_limits<Reference>::min();
    /// Every face at the point has an element on both sides, or on one and is a facet of the boundary; materials meet
    /// in facets only.
    StarFailure faces_complete() {
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

    /// An edge of the cavity that the mesh will have afterwards (3D).
    [[nodiscard]] bool survives(EdgeId edge) const {
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
    /// An edge from the point to the cavity's boundary that has a line of its own already.
    void has_line(EdgeId edge) {
        const auto& [a, b] = mesh_.edges[edge];
        if (const std::uint32_t at = w_.vertices.find(a == point_ ? b : a); at != nothing)
            w_.to_point[at].is_line = true;
    }
    struct LineAt {
        VertexId vertex;
        Reference reference = 0;
        JoinedLine line;
    };
    StarFailure lines() {
        if constexpr (D == 3) {
            for (const ElementId e : cavity_.elements)
                for (const EdgeId edge : mesh_.edges_of[e])
                    if (const LineId line = mesh_.line_of[edge]; line.valid()) {
                        const bool removed = w_.lines.contains(line);
                        const bool of_point = mesh_.edges[edge][0] == point_ || mesh_.edges[edge][1] == point_;
                        if (survives(edge) ? removed && !of_point : !removed) return StarFailure::line;
                        if (of_point && !removed) has_line(edge);
                    }
            if (cavity_.lines.empty()) return StarFailure::none;
            std::vector<LineAt> ends;
            ends.reserve(2 * cavity_.lines.size());
            for (const LineId l : cavity_.lines)
                for (std::uint32_t k = 0; k < 2; ++k)
                    ends.push_back({mesh_.edges[mesh_.lines[l]][1 - k], mesh_.line_references[l], {l, k}});
            std::sort(ends.begin(), ends.end(), [](const LineAt& a, const LineAt& b) {
                return std::tie(a.vertex, a.reference, a.line.line) < std::tie(b.vertex, b.reference, b.line.line);
            });
            for (std::size_t i = 0, next = 0; i < ends.size(); i = next) {
                next = i + 1;
                while (next < ends.size() && ends[next].vertex == ends[i].vertex) ++next;
                const VertexId v = ends[i].vertex;
                if (v == point_) continue;
                const bool stays = w_.vertices.contains(v);
                const bool through = next - i == 2 && ends[i].reference == ends[i + 1].reference;
                // A line that goes on through a vertex goes with it; one that ends there is joined to the point.
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

    /// V − E + F of the faces that are joined, and whether they hang together: a sphere around the point, or a disc
    /// beside it (2D: a closed chain, or an open one).
    StarFailure ball_around() {
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

    /// The cavity's elements at a point of the mesh hang together by their faces there: otherwise what is put in their
    /// place would tie the point's surroundings into a ring, or, where there is none, be tied to it by the point alone.
    [[nodiscard]] bool is_beside_one_part() {
        w_.at_point.clear();
        for (std::uint32_t i = 0; i < cavity_.elements.size(); ++i)
            if (local_vertex(mesh_.elements.vertices[cavity_.elements[i]], point_) >= 0) w_.at_point.push_back(i);
        if (w_.at_point.empty()) return false;
        Groups groups(w_.groups, w_.at_point.size());
        for (std::uint32_t i = 0; i < w_.at_point.size(); ++i) {
            const ElementId e = cavity_.elements[w_.at_point[i]];
            for (int face = 0; face <= D; ++face) {
                if (mesh_.elements.vertices[e][face] == point_ || is_open(e, face)) continue;
                const ElementId next = element_across(mesh_, e, face);
                for (std::uint32_t j = 0; j < i; ++j)
                    if (cavity_.elements[w_.at_point[j]] == next) groups.join(i, j);
            }
        }
        return groups.count() == 1;
    }
    /// Around a point of the mesh, outside of the cavity: none of the star's new edges and faces.
    StarFailure nothing_exists() {
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

    /// Counts a facet that has the point, on its edges there.
    template <class Vertices>
    [[nodiscard]] bool count_facet(const Vertices& others, Reference reference) {
        ++facets_at_point_;
        bool fits = true;
        for (const VertexId v : others) {
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
    /// Edges at the point that are no lines have no facets, or two of one reference; the point is on surfaces if it
    /// was.
    StarFailure surface_at_point() {
        facets_at_point_ = 0;
        bool fits = true;
        if (point_.valid())
            for (const ElementId e : w_.outside)
                for (int face = 0; face <= D; ++face) {
                    const FacetId f = facet_at(mesh_, e, face);
                    if (!f.valid() || w_.facets.contains(f) || mesh_.sides[f][0] != e ||
                        mesh_.elements.vertices[e][face] == point_)
                        continue;
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
        if (facets_at_point_ > 0) out_.place = VertexPlace::surface;
        if (!point_.valid()) return StarFailure::none;
        const VertexPlace now = mesh_.states[point_].place;
        if ((now == VertexPlace::inside) != (facets_at_point_ == 0) && now != VertexPlace::corner)
            return StarFailure::surface;
        return D == 3 && now == VertexPlace::surface && !out_.facets.empty() && !is_one_fan() ? StarFailure::surface
                                                                                              : StarFailure::none;
    }
    /// The sides that are joined to a point of a surface make one chain (3D): otherwise two surfaces would meet there.
    [[nodiscard]] bool is_one_fan() {
        Groups groups(w_.groups, out_.facets.size());
        for (std::uint32_t i = 0; i < out_.facets.size(); ++i)
            for (std::uint32_t j = 0; j < i; ++j)
                if (share_a_vertex(out_.facets[i], out_.facets[j])) groups.join(i, j);
        return groups.count() == 1;
    }
    [[nodiscard]] bool share_a_vertex(const JoinedFacet& a, const JoinedFacet& b) const {
        const auto& v = mesh_.facets.vertices[a.facet];
        const auto& w = mesh_.facets.vertices[b.facet];
        for (std::size_t i = 0; i < v.size(); ++i)
            for (std::size_t j = 0; j < w.size(); ++j)
                if (i != a.opposite && j != b.opposite && v[i] == w[j]) return true;
        return false;
    }

    /// What passes through the point: lines (3D), facets (2D).
    void meet(Reference reference) {
        mixed_ = mixed_ || (passing_ > 0 && reference != passing_reference_);
        passing_reference_ = reference;
        ++passing_;
    }
    /// A line goes on through a point, with one reference, or is not there.
    StarFailure line_at_point() {
        if constexpr (D == 3) {
            for (const JoinedLine& joined : out_.lines) meet(mesh_.line_references[joined.line]);
            if (point_.valid()) {
                lines_with(mesh_, w_.outside, point_, w_.lines_at_point);
                for (const LineId l : w_.lines_at_point)
                    if (!w_.lines.contains(l)) meet(mesh_.line_references[l]);
            }
        }
        constexpr VertexPlace through = D == 3 ? VertexPlace::line : VertexPlace::surface;
        if (point_.valid()) {
            const VertexPlace now = mesh_.states[point_].place;
            const bool passes = passing_ == 2 && !mixed_;
            if (now == VertexPlace::corner) return StarFailure::none;
            return (now == through ? passes : passing_ == 0) ? StarFailure::none : StarFailure::line;
        }
        if (passing_ == 0) return StarFailure::none;
        out_.place = through;
        return passing_ == 2 && !mixed_ ? StarFailure::none : StarFailure::line;
    }

    std::size_t facets_at_point_ = 0;
    std::size_t passing_ = 0;
    Reference passing_reference_ = 0;
    bool mixed_ = false;
    const DynamicMesh<D>& mesh_;
    const CavityParts<D>& cavity_;
    VertexId point_;
    StarWorkspace<D>& w_;
    Star<D>& out_;
};

}  // namespace

template <int D>
StarFailure star(const DynamicMesh<D>& mesh, const CavityParts<D>& cavity, VertexId point, StarWorkspace<D>& workspace,
                 Star<D>& out) {
    return Starring<D>(mesh, cavity, point, workspace, out).run();
}

template StarFailure star<2>(const DynamicMesh<2>&, const CavityParts<2>&, VertexId, StarWorkspace<2>&, Star<2>&);
template StarFailure star<3>(const DynamicMesh<3>&, const CavityParts<3>&, VertexId, StarWorkspace<3>&, Star<3>&);

}  // namespace camber
