// Associates the boundary of a mesh with faces, edges and vertices of a model.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>
#include "occ/kernel.hpp"
module camber.cad;
import camber.core;
import camber.surface;
import :parts;

namespace camber {

std::vector<std::size_t> faces_of(const CadAssociation& association, std::span<const FacetId> facets) {
    std::vector<std::size_t> faces;
    faces.reserve(facets.size());
    for (const FacetId f : facets)
        if (association.faces[f] != no_face) faces.push_back(association.faces[f]);
    std::sort(faces.begin(), faces.end());
    faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
    return faces;
}

namespace {

bool is_unsure(const CadFit& fit) { return fit.face != no_face && fit.second <= ambiguity_ratio * fit.fit_error; }
/// True if another face fits the facet nearly as well as the best one and does not meet it smoothly.
bool is_ambiguous(const CadFit& fit) { return fit.face != no_face && fit.other <= ambiguity_ratio * fit.fit_error; }

template <int D>
std::array<Vec<D>, D> corners_of(const LinearMesh<D>& mesh, std::size_t f) {
    return facet_site(mesh, FacetId(f)).corners;
}

/// Key of facets that belong together: their reference, and the mesher's entity if known.
using Class = std::pair<Reference, Reference>;
template <int D>
Class class_of(const LinearMesh<D>& mesh, std::size_t f) {
    return {mesh.facets.references[f], mesh.facets.entities.empty() ? 0 : mesh.facets.entities[f]};
}

/// Returns the face of each class that has one: at least 90 % of its unambiguous facets fit this face.
template <int D>
std::map<Class, std::size_t> faces_of_classes(const LinearMesh<D>& mesh, std::span<const CadFit> fits) {
    constexpr double nearly_all = 0.9;
    std::map<Class, std::map<std::size_t, std::size_t>> counts;
    for (std::size_t f = 0; f < fits.size(); ++f)
        if (fits[f].face != no_face && !is_unsure(fits[f])) ++counts[class_of(mesh, f)][fits[f].face];
    std::map<Class, std::size_t> out;
    for (const auto& [key, faces] : counts) {
        std::size_t all = 0;
        for (const auto& [face, count] : faces) all += count;
        for (const auto& [face, count] : faces)
            if (static_cast<double>(count) >= nearly_all * static_cast<double>(all)) out[key] = face;
    }
    return out;
}

template <int D>
Buffer<std::uint32_t> chosen(const LinearMesh<D>& mesh, const CadModel& model, std::span<const CadFit> fits,
                             CadAssociation& out) {
    const auto of_classes = faces_of_classes(mesh, fits);
    Buffer<std::uint32_t> faces(fits.size());
    for (std::size_t f = 0; f < fits.size(); ++f) {
        faces[f] = static_cast<std::uint32_t>(fits[f].face);
        out.coincident_facets += fits[f].has_twin ? 1 : 0;
        if (!is_unsure(fits[f])) continue;
        out.ambiguous_facets += is_ambiguous(fits[f]) ? 1 : 0;
        const auto known = of_classes.find(class_of(mesh, f));
        if (known == of_classes.end()) continue;
        const std::array<std::size_t, 1> one_entity{known->second};
        if (best_fit<D>(model, one_entity, corners_of<D>(mesh, f)).fit_error > ambiguity_ratio * fits[f].fit_error)
            continue;
        faces[f] = static_cast<std::uint32_t>(known->second);
        out.settled_facets += is_ambiguous(fits[f]) ? 1 : 0;
    }
    return faces;
}

Buffer<std::array<double, 2>> middles_of(std::span<const CadFit> fits) {
    Buffer<std::array<double, 2>> middles(fits.size());
    for (std::size_t f = 0; f < fits.size(); ++f) middles[f] = fits[f].middle;
    return middles;
}

template <int D>
void list_references(const LinearMesh<D>& mesh, CadAssociation& out) {
    std::map<Reference, std::vector<std::size_t>> faces;
    for (std::size_t f = 0; f < out.faces.size(); ++f)
        if (out.faces[f] != no_face) faces[mesh.facets.references[f]].push_back(out.faces[f]);
    for (auto& [reference, list] : faces) {
        std::sort(list.begin(), list.end());
        list.erase(std::unique(list.begin(), list.end()), list.end());
        out.of_references.emplace_back(reference, std::move(list));
    }
}

struct EntityMatch {
    std::int64_t entity = -1;  ///< model edge or vertex; −1: none
    std::uint32_t faces = 0;
    double distance = 0;
    double nearest = 0;  ///< distance from the nearest face; small if the mesh omits a fillet, even if the fillet's
                         ///< edges are far
    bool is_ambiguous = false, is_corner = false, is_off = false;
    bool is_detached = false;      ///< the vertex is far from the common edge or vertex of its faces
    bool is_within_group = false;  ///< not on an edge; all its faces belong to one virtual face
    EdgeLengthsAt edges = {};
    std::vector<std::pair<std::size_t, double>> off = {};  ///< for vertices: faces farther than `off_limit`, with their
                                                           ///< distances
};

template <int D>
EntityMatch match_faces(const CadModel& model, std::span<const std::size_t> faces, const Vec<D>& p,
                        const EdgeLengthsAt& edges) {
    EntityMatch out{.faces = static_cast<std::uint32_t>(faces.size()),
                    .nearest = std::numeric_limits<double>::infinity(),
                    .edges = edges};
    for (const std::size_t face : faces) {
        const double away = closest_on_virtual_face(model, face, p).foot.distance;
        out.distance = std::max(out.distance, away);
        out.nearest = std::min(out.nearest, away);
        if (!(away <= off_limit * edges.shortest)) out.off.emplace_back(face, away);
    }
    return out;
}

EntityMatch match_vertex(const CadModel& model, std::span<const std::size_t> faces, const Vec<3>& p, double size,
                         const EdgeLengthsAt& edges) {
    EntityMatch out = match_faces<3>(model, faces, p, edges);
    if (faces.size() == 1) return out;
    const double reach = match_tolerance * size;
    const Junction at = junction_at_vertex(model, faces, p, {reach, smooth_reach * edges.shortest});
    if (at.is_within_group) {
        out.distance = at.distance;
        out.is_within_group = true;
        return out;
    }
    out.is_corner = at.on == Junction::On::vertex && at.distance <= reach;
    const bool is_at_edge = at.on == Junction::On::edge && (faces.size() == 2 || at.distance <= reach);
    if (out.is_corner || is_at_edge) {
        out.entity = static_cast<std::int64_t>(at.number);
        out.distance = at.distance;
        return out;
    }
    if (faces.size() == 2) return out;
    // The vertex may lie inside an edge that has more than two faces.
    const auto edge = edge_between(model, faces, std::span(&p, 1));
    out.is_ambiguous = !edge || closest_on_edge(model, *edge, p).distance > coincidence_tolerance(model.parts());
    return out;
}

EntityMatch match_vertex(const CadModel& model, std::span<const std::size_t> curves, const Vec<2>& p, double size,
                         const EdgeLengthsAt& edges) {
    EntityMatch out = match_faces<2>(model, curves, p, edges);
    const auto vertex = end_between(model, curves, p);
    const double away = vertex ? distance(vertex_in_plane(model, *vertex), p) : size;
    const auto is_joined = [&](std::size_t curve) {
        return model.parts().virtual_curves.are_joined(curves.front(), curve);
    };
    const bool is_smooth = curves.size() > 1 && std::all_of(curves.begin(), curves.end(), is_joined);
    out.is_corner = away <= (is_smooth ? smooth_reach * edges.shortest : match_tolerance * size);
    out.is_within_group = is_smooth && !out.is_corner;
    out.is_ambiguous = !out.is_corner && curves.size() > 1 && !out.is_within_group;
    if (out.is_within_group) out.distance = out.nearest;
    if (!out.is_corner) return out;
    out.entity = static_cast<std::int64_t>(*vertex);
    out.distance = away;
    return out;
}

/// Finds the rim edge of a face for a mesh edge that has the face on one side and facets off the model on the other
/// side.
EntityMatch match_rim(const CadModel& model, std::span<const std::size_t> face, const std::array<Vec<3>, 2>& ends) {
    const auto edge = edge_between(model, face, ends);
    if (!edge) return {};
    const double away =
        std::max(closest_on_edge(model, *edge, ends[0]).distance, closest_on_edge(model, *edge, ends[1]).distance);
    if (away > match_tolerance * distance(ends[0], ends[1])) return {};
    return {.entity = static_cast<std::int64_t>(*edge), .faces = 1, .distance = away};
}

EntityMatch match_edge(const CadModel& model, std::span<const std::size_t> faces, const std::array<Vec<3>, 2>& ends) {
    const double reach = match_tolerance * distance(ends[0], ends[1]);
    const Junction at = junction_at(model, faces, ends, reach_along(ends));
    EntityMatch out{.faces = static_cast<std::uint32_t>(faces.size()), .is_within_group = at.is_within_group};
    if (at.is_within_group) return out;
    out.is_ambiguous = at.on == Junction::On::nothing || at.distance > reach;
    if (at.on == Junction::On::nothing) return out;
    out.entity = static_cast<std::int64_t>(at.number);
    out.distance = at.distance;
    return out;
}

std::size_t count_distinct(std::vector<std::int64_t> entities) {
    std::sort(entities.begin(), entities.end());
    return static_cast<std::size_t>(std::unique(entities.begin(), entities.end()) - entities.begin());
}

struct Fits {
    std::map<std::size_t, VertexFit> faces, edges;
};

void add_vertex(const CadModel& model, VertexId v, std::span<const std::size_t> faces, const EntityMatch& met,
                bool is_3d, Fits& fits) {
    for (const std::size_t face : faces) {
        const auto off = std::find_if(met.off.begin(), met.off.end(), [&](const auto& o) { return o.first == face; });
        fits.faces[face].add(v, off == met.off.end() ? 0 : off->second, met.edges);
    }
    const bool is_on_edge = is_3d && faces.size() == 2 && met.entity >= 0 && !met.is_corner;
    if (is_on_edge && !model.parts().virtual_faces.are_joined(faces[0], faces[1]))
        fits.edges[static_cast<std::size_t>(met.entity)].add(v, met.distance, met.edges);
}

std::optional<CadFitError> fit_error_of(const Fits& fits, std::size_t facet_vertices) {
    std::optional<CadFitError> worst;
    std::pair<double, double> largest;
    const auto compare = [&](const std::map<std::size_t, VertexFit>& some, bool is_edge) {
        for (const auto& [number, fit] : some) {
            const std::pair far(static_cast<double>(fit.off) / static_cast<double>(fit.vertices), fit.largest);
            if (!fit.is_refused(facet_vertices) || (worst && far <= largest)) continue;
            largest = far;
            worst = CadFitError{is_edge, number, fit};
        }
    };
    compare(fits.faces, false);
    compare(fits.edges, true);
    return worst;
}

using Pairs = std::vector<std::array<std::size_t, 2>>;

void add_pairs(std::span<const std::size_t> faces, Pairs& pairs) {
    for (const std::size_t face : faces.subspan(1)) pairs.push_back({faces.front(), face});
}

template <int D>
Outcome<Done> match_vertices(const LinearMesh<D>& mesh, const CadModel& model, const Execution& execution,
                             CadAssociation& out, Pairs& pairs) {
    const auto around = facet_balls(mesh, without_progress(execution));
    if (!around) return fail(around.error());
    const auto met = map_each(execution, mesh.points.size(), [&](std::size_t v) -> EntityMatch {
        const auto facets = (*around)[v];
        if (facets.empty()) return {};
        const auto faces = faces_of(out, facets);
        if (faces.empty()) return {};
        const auto corners = corners_of<D>(mesh, facets.front().index());
        const double size = distance(corners[0], corners[1]);
        EntityMatch met = match_vertex(model, faces, mesh.points[v], size, edge_lengths_at(mesh, facets, VertexId(v)));
        double longest = 0;
        for (const FacetId f : facets) longest = std::max(longest, longest_side(corners_of<D>(mesh, f.index())));
        met.is_off = !(met.nearest <= stray_limit * longest);
        met.is_detached = met.entity >= 0 && met.faces > 1 && !(met.distance <= stray_limit * longest);
        return met;
    });
    if (!met) return fail(met.error());
    Fits fits;
    std::vector<std::int64_t> corners;
    std::pair<bool, double> farthest;  // detached vertices count as farther than all others
    for (std::size_t v = 0; v < met->size(); ++v) {
        const EntityMatch& m = (*met)[v];
        if (const std::pair far(m.is_detached, m.distance); far > farthest) {
            farthest = far;
            out.largest_vertex_distance = m.distance;
            out.farthest_vertex = VertexId(v);
        }
        out.vertices += m.faces > 0 ? 1 : 0;
        out.off_vertices += m.is_off ? 1 : 0;
        out.detached_vertices += m.is_detached ? 1 : 0;
        out.ambiguous_vertices += m.is_ambiguous ? 1 : 0;
        if (m.faces > 0) {
            const auto faces = faces_of(out, (*around)[v]);
            add_vertex(model, VertexId(v), faces, m, D == 3, fits);
            if (D == 2 && m.is_within_group) add_pairs(faces, pairs);
        }
        if (!m.is_corner) continue;
        corners.push_back(m.entity);
        out.corners.push_back(VertexId(v));
    }
    out.vertices_met = count_distinct(std::move(corners));
    out.fit_error = fit_error_of(fits, D);
    return Done{};
}

Outcome<Done> match_edges(const LinearMesh<3>& mesh, const EdgeSet<3>& edges, const CadModel& model,
                          const Execution& execution, CadAssociation& out, Pairs& pairs) {
    const auto shells = facet_shells(edges, without_progress(execution));
    if (!shells) return fail(shells.error());
    const auto met = map_each(execution, edges.size(), [&](std::size_t e) -> EntityMatch {
        const auto facets = (*shells)[e];
        const auto faces = faces_of(out, facets);
        const std::array ends{mesh.points[edges.vertices[e][0]], mesh.points[edges.vertices[e][1]]};
        if (faces.size() >= 2) return match_edge(model, faces, ends);
        const auto is_unassociated = [&](FacetId f) { return out.faces[f] == no_face; };
        const bool is_rim = faces.size() == 1 && std::any_of(facets.begin(), facets.end(), is_unassociated);
        return is_rim ? match_rim(model, faces, ends) : EntityMatch{};
    });
    if (!met) return fail(met.error());
    std::vector<std::int64_t> curves;
    for (std::size_t e = 0; e < met->size(); ++e) {
        const EntityMatch& m = (*met)[e];
        out.ambiguous_edges += m.is_ambiguous ? 1 : 0;
        if (m.is_within_group) add_pairs(faces_of(out, (*shells)[e]), pairs);
        if (m.entity < 0) continue;
        curves.push_back(m.entity);
        if (m.faces >= 2 && !m.is_ambiguous) out.ridges.push_back(EdgeId(e));
    }
    out.edges_met = count_distinct(std::move(curves));
    return Done{};
}

void count_matched(const CadModel& model, CadAssociation& out) {
    std::vector<std::int64_t> faces;
    for (const auto& [reference, curves] : out.of_references)
        for (const std::size_t curve : curves)
            for (const std::size_t face : model.parts().kernel->edges[curve].faces)
                faces.push_back(static_cast<std::int64_t>(face));
    out.edges_met = out.faces_met;
    out.faces_met = count_distinct(std::move(faces));
}

template <int D>
Outcome<Done> check_kind(const CadModel& model) {
    if constexpr (D == 2) return check_flatness(model);
    if (model.faces() > 0) return Done{};
    return fail(ErrorKind::input, "the model has no faces", {}, {}, "export its solids or its shells");
}

}  // namespace

template <int D>
Outcome<CadAssociation> associate(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const CadModel& model,
                                  const Execution& execution) {
    return associate(mesh, edges, model, {}, execution);
}

template <int D>
Outcome<CadAssociation> associate(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const CadModel& model,
                                  std::span<const Reference> excluded, const Execution& execution) {
    if (auto fits = check_kind<D>(model); !fits) return fail(fits.error());
    const auto is_on_model = [&](std::size_t f) {
        return !std::binary_search(excluded.begin(), excluded.end(), mesh.facets.references[f]);
    };
    if (mesh.facets.size() == 0)
        return fail(ErrorKind::input,
                    "the mesh has no boundary that could lie on the CAD "
                    "model");
    return guarded([&]() -> Outcome<CadAssociation> {
        const std::vector<std::size_t> all = candidates<D>(model);
        if (auto fit = check_sample<D>(mesh, model, all, excluded, without_progress(execution)); !fit)
            return fail(fit.error());
        const auto fits = map_each(
            part_of(execution, 0, 0.7), mesh.facets.size(),
            [&](std::size_t f) {
                return is_on_model(f) ? best_fit<D>(model, all, corners_of<D>(mesh, f)) : CadFit{.face = no_face};
            },
            16);
        if (!fits) return fail(fits.error());
        CadAssociation out;
        out.faces = chosen<D>(mesh, model, *fits, out);
        if constexpr (D == 3) out.middles = middles_of(*fits);
        list_references(mesh, out);
        out.facets = static_cast<std::size_t>(
            std::count_if(out.faces.begin(), out.faces.end(), [](std::uint32_t face) { return face != no_face; }));
        std::vector<std::int64_t> met_faces;
        for (const auto& [reference, faces] : out.of_references)
            met_faces.insert(met_faces.end(), faces.begin(), faces.end());
        out.faces_met = count_distinct(std::move(met_faces));
        Pairs pairs;
        if (auto met = match_vertices(mesh, model, part_of(execution, 0.7, 0.9), out, pairs); !met)
            return fail(met.error());
        if (auto agreed = check_part(mesh, model, out); !agreed) return fail(agreed.error());
        if constexpr (D == 2) {
            count_matched(model, out);
        } else if (auto met = match_edges(mesh, edges, model, part_of(execution, 0.9, 1), out, pairs); !met) {
            return fail(met.error());
        }
        if (auto found = find_spans<D>(mesh, model, *fits, pairs, without_progress(execution), out); !found)
            return fail(found.error());
        return out;
    });
}

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// Returns max d(vertex) + d(middle) + longest side · sin θ, with the distance d from the face and the angle θ between
/// the normals of facet and face. A result above `enough` is only a lower bound. `foot`: closest point to the middle.
double fit_error(const CadModel& model, std::size_t face, const std::array<Vec<3>, 3>& corners, const CadFoot& foot,
                 double enough) {
    const Vec<3> normal = normalised(cross(corners[1] - corners[0], corners[2] - corners[0]));
    double sum = foot.distance + longest_side(corners) * norm(cross(normal, foot.normal));
    double farthest = 0;
    for (const Vec<3>& corner : corners) {
        if (sum + farthest > enough) return sum + farthest;
        farthest = std::max(farthest, closest_on_face(model, face, corner, foot.parameters).distance);
    }
    return sum + farthest;
}

bool coincide(const CadModel& model, std::size_t a, std::size_t b, const std::array<Vec<3>, 3>& corners) {
    constexpr double same = 1e-6, parallel = 1e-3;
    const double most = same * longest_side(corners);
    const Vec<3> middle = (corners[0] + corners[1] + corners[2]) / 3;
    const CadFoot on_a = closest_on_face(model, a, middle), on_b = closest_on_face(model, b, middle);
    if (distance(on_a.point, on_b.point) > most || norm(cross(on_a.normal, on_b.normal)) > parallel) return false;
    return std::all_of(corners.begin(), corners.end(), [&](const Vec<3>& p) {
        return distance(closest_on_face(model, a, p).point, closest_on_face(model, b, p).point) <= most;
    });
}

/// Calls visit(face) for each face of `candidates` (ascending) whose box is within the distance most() of p. Near faces
/// usually come first. Each visit may decrease most().
template <class Most, class Visit>
void visit_near(const CadModel& model, std::span<const std::size_t> candidates, const Vec<3>& p, Most&& most,
                Visit&& visit) {
    const CadParts& parts = model.parts();
    const bool is_all = candidates.size() == model.faces();
    (void)parts.tree_of_faces.nearest(p, [&](std::size_t face) {
        const bool is_candidate = is_all || std::binary_search(candidates.begin(), candidates.end(), face);
        if (is_candidate && !(std::sqrt(parts.faces[face].reach.distance_squared(p)) > most())) visit(face);
        return most() * most();
    });
}

double farthest_from(const CadModel& model, std::size_t edge, std::span<const Vec<3>> points) {
    double farthest = 0;
    for (const Vec<3>& p : points) farthest = std::max(farthest, closest_on_edge(model, edge, p).distance);
    return farthest;
}

bool bounds(const occ::EdgeFacts& edge, std::size_t face) {
    return std::find(edge.faces.begin(), edge.faces.end(), face) != edge.faces.end();
}

}  // namespace

CadFit best_face(const CadModel& model, std::span<const std::size_t> faces, const std::array<Vec<3>, 3>& corners) {
    const Vec<3> middle = (corners[0] + corners[1] + corners[2]) / 3;
    // Only faces with a fit error of at most twice that of the best face are needed. Fit errors of coincident faces
    // differ by rounding.
    const double rounding = 1e-6 * longest_side(corners);
    struct Fit {
        double fit_error = 0;
        std::size_t face = 0;
        std::array<double, 2> middle{};
    };
    std::vector<Fit> fits;
    double enough = infinite;
    visit_near(
        model, faces, middle, [&] { return enough; },
        [&](std::size_t face) {
            const CadFoot foot = closest_on_face(model, face, middle);
            const double here = fit_error(model, face, corners, foot, enough);
            if (!(here <= enough)) return;
            fits.push_back({here, face, foot.parameters});
            enough = std::min(enough, std::max(ambiguity_ratio * here, here + rounding));
        });
    // No face was accepted, because all distances are NaN.
    if (fits.empty()) return {.face = faces.front(), .fit_error = infinite, .second = infinite, .other = infinite};
    std::sort(fits.begin(), fits.end(), [](const Fit& a, const Fit& b) {
        return std::pair(a.fit_error, a.face) < std::pair(b.fit_error, b.face);
    });
    const Fit& first = fits.front();
    CadFit best{.face = first.face,
                .fit_error = first.fit_error,
                .second = infinite,
                .other = infinite,
                .middle = first.middle};
    const VirtualFaces& joined = model.parts().virtual_faces;
    for (const Fit& fit : std::span(fits).subspan(1)) {
        if (fit.fit_error > enough) break;
        if (coincide(model, first.face, fit.face, corners)) {
            best.has_twin = true;
            if (fit.face > best.face) continue;
            best.face = fit.face;
            best.middle = fit.middle;
        } else {
            best.second = std::min(best.second, fit.fit_error);
            if (!joined.are_joined(first.face, fit.face)) best.other = std::min(best.other, fit.fit_error);
        }
    }
    return best;
}

std::optional<std::size_t> nearest_face(const CadModel& model, std::span<const std::size_t> faces, const Vec<3>& p) {
    std::optional<std::size_t> best;
    double least = infinite;
    visit_near(
        model, faces, p, [&] { return least; },
        [&](std::size_t face) {
            const double distance = closest_on_face(model, face, p).distance;
            if (!(distance < least) && !(distance == least && best && face < *best)) return;
            least = distance;
            best = face;
        });
    return best;
}

namespace {

std::optional<std::size_t> edge_of_pair(const CadModel& model, std::size_t face, std::optional<std::size_t> other,
                                        std::span<const Vec<3>> points) {
    std::optional<std::size_t> best;
    double least = infinite;
    for (const std::size_t edge : model.parts().kernel->faces[face].edges) {
        if (other && !bounds(model.parts().kernel->edges[edge], *other)) continue;
        const double farthest = farthest_from(model, edge, points);
        if (farthest >= least) continue;
        least = farthest;
        best = edge;
    }
    return best;
}

std::optional<std::size_t> edge_through(const CadModel& model, std::span<const std::size_t> faces,
                                        std::span<const Vec<3>> points) {
    for (const std::size_t face : faces)
        if (const auto edge = edge_of_pair(model, face, std::nullopt, points))
            if (farthest_from(model, *edge, points) <= coincidence_tolerance(model.parts())) return edge;
    return std::nullopt;
}

}  // namespace

std::optional<std::size_t> edge_between(const CadModel& model, std::span<const std::size_t> faces,
                                        std::span<const Vec<3>> points) {
    if (faces.size() == 1) return edge_of_pair(model, faces.front(), std::nullopt, points);
    for (std::size_t i = 0; i < faces.size(); ++i)
        for (std::size_t j = i + 1; j < faces.size(); ++j)
            if (const auto edge = edge_of_pair(model, faces[i], faces[j], points)) return edge;
    return edge_through(model, faces, points);
}

std::optional<std::size_t> vertex_between(const CadModel& model, std::span<const std::size_t> faces, const Vec<3>& p) {
    std::optional<std::size_t> best;
    double least = infinite;
    for (const std::size_t face : faces)
        for (const std::size_t edge : model.parts().kernel->faces[face].edges)
            for (const std::size_t vertex : model.parts().kernel->edges[edge].vertices)
                if (const double d = distance(model.vertex(vertex), p); d < least) {
                    least = d;
                    best = vertex;
                }
    return best;
}

#define CAMBER_INSTANTIATE(D)                                                                               \
    template Outcome<CadAssociation> associate<D>(const LinearMesh<D>&, const EdgeSet<D>&, const CadModel&, \
                                                  const Execution&);                                        \
    template Outcome<CadAssociation> associate<D>(const LinearMesh<D>&, const EdgeSet<D>&, const CadModel&, \
                                                  std::span<const Reference>, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
