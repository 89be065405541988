// Checks on a sample of facets that a CAD model belongs to the mesh, and finds the unit of the mesh.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>
#include "occ/kernel.hpp"
module camber.cad;
import camber.core;
import camber.surface;
import :parts;

namespace camber {

namespace {

struct SampledReference {
    Reference reference = 0;
    std::size_t count = 0;  ///< number of all facets of the reference
    std::vector<FacetId> facets;
};

/// Share of the sampled facets that is off the model. A facet counts with the share of its vertices that are farther
/// from its best face than half of its longest edge. It counts fully if its best face is transverse to it.
struct SampleVerdict {
    double share = 0;  ///< share of all facets, estimated from the sample
    std::size_t off_count = 0, facets = 0;
    const SampledReference* lost = nullptr;  ///< reference with the largest share off the model, if above one half;
                                             ///< else null
    std::size_t worst_off_count = 0;
    FacetId farthest;

    [[nodiscard]] bool fits() const {
        constexpr double most = 0.1;
        return share <= most && lost == nullptr;
    }
};

/// Minimum number of sampled facets of each reference, and total number if there are few references.
constexpr std::size_t min_of_each = 24, target_count = 512;

struct FacetCheck {
    double share = 0, distance = 0;
};

bool is_beyond(const CadModel& model, std::size_t face, const Vec<3>& p, double distance) {
    return model.parts().faces[face].reach.distance_squared(p) > distance * distance ||
           least_distance(model.parts(), face, p) > distance;
}
bool is_beyond(const CadModel& model, std::size_t curve, const Vec<2>& p, double distance) {
    return in_plane(model.parts().edges[curve].reach).distance_squared(p) > distance * distance;
}
double away_from_box(const CadModel& model, std::size_t face, const Vec<3>& p) {
    return std::sqrt(model.parts().faces[face].reach.distance_squared(p));
}
double away_from_box(const CadModel& model, std::size_t curve, const Vec<2>& p) {
    return std::sqrt(in_plane(model.parts().edges[curve].reach).distance_squared(p));
}
template <int D>
double away_from(const CadModel& model, std::size_t face, const Vec<D>& p) {
    return closest_on_virtual_face(model, face, p).foot.distance;
}

double sine_between(const CadModel& model, std::size_t face, const std::array<Vec<3>, 3>& c) {
    const Vec<3> normal = normalised(cross(c[1] - c[0], c[2] - c[0]));
    return norm(cross(normal, closest_on_virtual_face(model, face, (c[0] + c[1] + c[2]) / 3).foot.normal));
}
double sine_between(const CadModel& model, std::size_t curve, const std::array<Vec<2>, 2>& ends) {
    const Vec<2> normal = closest_on_virtual_face(model, curve, midpoint(ends[0], ends[1])).foot.normal;
    return std::abs(dot(normalised(ends[1] - ends[0]), normal));
}

template <int D>
FacetCheck check_facet(const CadModel& model, std::span<const std::size_t> candidates,
                       const std::array<Vec<D>, D>& corners) {
    constexpr double across = 0.9, far = 0.5;
    const double longest = longest_side(corners);
    // Boxes are compared before distances, because searches from far away are slow.
    const bool is_unassociated = std::all_of(corners.begin(), corners.end(), [&](const Vec<D>& p) {
        return std::all_of(candidates.begin(), candidates.end(),
                           [&](std::size_t face) { return is_beyond(model, face, p, far * longest); });
    });
    if (is_unassociated) {
        double beyond = std::numeric_limits<double>::infinity();
        for (const std::size_t face : candidates) beyond = std::min(beyond, away_from_box(model, face, corners[0]));
        return {1, beyond};
    }
    const std::size_t face = best_fit<D>(model, candidates, corners).face;
    FacetCheck out;
    for (const Vec<D>& p : corners) {
        const double away = away_from(model, face, p);
        out.distance = std::max(out.distance, away);
        out.share += away <= far * longest ? 0 : 1.0 / D;
    }
    if (out.share < 1 && sine_between(model, face, corners) > across) out.share = 1;
    return out;
}

template <int D>
std::vector<SampledReference> sampled(const LinearMesh<D>& mesh, std::span<const Reference> excluded) {
    std::map<Reference, std::vector<FacetId>> all;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        const Reference reference = mesh.facets.references[f];
        if (!std::binary_search(excluded.begin(), excluded.end(), reference)) all[reference].push_back(FacetId(f));
    }
    std::vector<SampledReference> sample;
    for (const auto& [reference, facets] : all) {
        const std::size_t most = std::max(min_of_each, target_count / all.size()), count = facets.size();
        const std::size_t taken = std::min(count, most);
        SampledReference some{reference, count, {}};
        some.facets.reserve(taken);
        for (std::size_t i = 0; i < taken; ++i) some.facets.push_back(facets[i * count / taken]);
        sample.push_back(std::move(some));
    }
    return sample;
}

template <int D>
Outcome<SampleVerdict> sample_verdict(const LinearMesh<D>& mesh, const CadModel& model,
                                      std::span<const SampledReference> sample, std::span<const std::size_t> candidates,
                                      double factor, const Execution& execution) {
    constexpr double half = 0.5;
    std::vector<FacetId> facets;
    for (const auto& some : sample) facets.insert(facets.end(), some.facets.begin(), some.facets.end());
    const auto looked = map_each(
        execution, facets.size(),
        [&](std::size_t i) {
            auto corners = facet_site(mesh, facets[i]).corners;
            for (Vec<D>& p : corners) p = factor * p;
            return check_facet<D>(model, candidates, corners);
        },
        4);
    if (!looked) return fail(looked.error());
    SampleVerdict verdict;
    verdict.facets = facets.size();
    double strays = 0, all = 0, farthest = -1, max_lost = half;
    std::size_t i = 0;
    for (const auto& some : sample) {
        double share = 0;
        std::size_t touched = 0;
        for (const FacetId f : some.facets) {
            const FacetCheck& facet = (*looked)[i++];
            share += facet.share;
            touched += facet.share > 0 ? 1 : 0;
            if (facet.share == 0 || facet.distance <= farthest) continue;
            farthest = facet.distance;
            verdict.farthest = f;
        }
        share /= static_cast<double>(some.facets.size());
        strays += share * static_cast<double>(some.count);
        all += static_cast<double>(some.count);
        verdict.off_count += touched;
        if (share <= max_lost) continue;
        max_lost = share;
        verdict.lost = &some;
        verdict.worst_off_count = touched;
    }
    verdict.share = all > 0 ? strays / all : 0;
    return verdict;
}

template <int D, class IsPart>
Box<D> box_of(const LinearMesh<D>& mesh, IsPart&& is_part) {
    Box<D> box;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        if (is_part(f))
            for (const VertexId v : mesh.facets.vertices[f]) box.include(mesh.points[v]);
    return box;
}

Box<3> box_of_face(const CadParts& parts, std::size_t face) {
    constexpr std::size_t places = 16;
    const occ::FaceFacts& facts = parts.kernel->faces[face];
    if (facts.is_plane) return parts.faces[face].bounds;  // for a plane, these are the bounds of its edges
    Box<3> box;
    for (const std::size_t edge : facts.edges) box.include(parts.edges[edge].bounds);
    const auto at = [&](std::size_t k, std::size_t i) {
        return facts.low[k] + (facts.high[k] - facts.low[k]) * static_cast<double>(i) / places;
    };
    for (std::size_t i = 0; i <= places; ++i)
        for (std::size_t j = 0; j <= places; ++j)
            if (parts.kernel->has(face, at(0, i), at(1, j)))
                box.include(vec(parts.kernel->on_surface(face, at(0, i), at(1, j)).point));
    return box;
}

/// Box of the edges of faces and of sampled points on the faces. Boxes of parameter ranges would be too large for
/// obliquely trimmed faces.
template <int D>
Box<D> box_of(const CadParts& parts, std::span<const std::size_t> faces) {
    Box<D> box;
    for (const std::size_t face : faces) {
        if constexpr (D == 2)
            box.include(in_plane(parts.edges[face].bounds));
        else
            box.include(box_of_face(parts, face));
    }
    return box;
}

/// True if the boxes agree within a tenth of the mesh's diagonal. They may differ because the mesh has chords instead
/// of curves.
template <int D>
bool agree(const Box<D>& mesh, const Box<D>& model, double factor) {
    const double most = match_tolerance * mesh.diagonal();
    for (std::size_t k = 0; k < D; ++k)
        if (std::abs(mesh.low[k] - factor * model.low[k]) > most ||
            std::abs(mesh.high[k] - factor * model.high[k]) > most)
            return false;
    return true;
}

std::string text(const Vec<2>& p) {
    std::array<char, 128> out{};
    std::snprintf(out.data(), out.size(), "(%.5g, %.5g)", p[0], p[1]);
    return out.data();
}
std::string text(const Vec<3>& p) {
    std::array<char, 128> out{};
    std::snprintf(out.data(), out.size(), "(%.5g, %.5g, %.5g)", p[0], p[1], p[2]);
    return out.data();
}
template <int D>
std::string text(const Box<D>& box) {
    return text(box.low) + " to " + text(box.high);
}

std::string text(double x) {
    std::array<char, 32> out{};
    std::snprintf(out.data(), out.size(), "%.3g", x);
    return out.data();
}

template <class Fits>
Outcome<std::vector<CadUnit>> fitting_units(const CadParts& parts, Fits&& fits) {
    const double here = parts.kernel->millimetres;
    std::vector<CadUnit> found;
    for (const auto& [unit, word] : words(CadUnit{})) {
        if (millimetres_of(unit) == 0 || millimetres_of(unit) == here) continue;
        const Outcome<bool> does_fit = fits(millimetres_of(unit) / here);
        if (!does_fit) return fail(does_fit.error());
        if (*does_fit) found.push_back(unit);
    }
    return found;
}

template <int D>
Outcome<std::vector<CadUnit>> units_of_sample(const LinearMesh<D>& mesh, const CadModel& model,
                                              std::span<const SampledReference> sample,
                                              std::span<const std::size_t> candidates, const Execution& execution) {
    return fitting_units(model.parts(), [&](double factor) -> Outcome<bool> {
        const auto scaled = sample_verdict<D>(mesh, model, sample, candidates, factor, execution);
        if (!scaled) return fail(scaled.error());
        return scaled->fits();
    });
}

std::optional<std::string> suggested_unit(const std::vector<CadUnit>& units) {
    if (units.empty()) return std::nullopt;
    return std::string(word_of(units.front()));
}

std::string remedy(const std::optional<std::string>& unit, bool is_whole) {
    if (unit) return "the mesh is in " + *unit + ": give that as the unit of the CAD model";
    return std::string("give the CAD model of ") + (is_whole ? "this mesh" : "these references") +
           " at the position of the mesh. If the file's unit is not the mesh's, give the mesh's unit. If the model "
           "covers only a part of the boundary, give the references of that part";
}

const char* subject(bool is_whole) {
    return is_whole ? "the mesh's boundary" : "the part of the mesh's boundary that belongs to the CAD model";
}

template <int D>
double distance_from(const CadModel& model, std::span<const std::size_t> candidates, const Vec<D>& p) {
    if constexpr (D == 2)
        return closest_on_curve(model, *nearest_curve(model, candidates, p), p).distance;
    else
        return closest_on_face(model, *nearest_face(model, candidates, p), p).distance;
}

template <int D>
std::pair<VertexId, double> farthest_corner(const LinearMesh<D>& mesh, const CadModel& model,
                                            std::span<const std::size_t> candidates, FacetId facet) {
    std::pair<VertexId, double> found{mesh.facets.vertices[facet][0], 0};
    for (const VertexId v : mesh.facets.vertices[facet])
        if (const double away = distance_from<D>(model, candidates, mesh.points[v]); away > found.second)
            found = {v, away};
    return found;
}

template <int D>
bool is_within_material(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls, FacetId facet) {
    const auto& corners = mesh.facets.vertices[facet];
    std::vector<Reference> sides;
    for (const ElementId e : balls[corners[0]]) {
        const auto& vertices = mesh.elements.vertices[e];
        const bool has_facet = std::all_of(corners.begin(), corners.end(), [&](VertexId v) {
            return std::find(vertices.begin(), vertices.end(), v) != vertices.end();
        });
        if (has_facet) sides.push_back(mesh.elements.references[e]);
    }
    return sides.size() == 2 && sides[0] == sides[1];
}

template <int D>
bool is_within_material(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls, Reference reference) {
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        if (mesh.facets.references[f] == reference && !is_within_material(mesh, balls, FacetId(f))) return false;
    return true;
}

template <int D>
bool is_off(const LinearMesh<D>& mesh, const CadModel& model, std::span<const std::size_t> candidates, FacetId facet) {
    const auto corners = facet_site(mesh, facet).corners;
    const double most = off_limit * longest_side(corners);
    return std::any_of(corners.begin(), corners.end(), [&](const Vec<D>& p) {
        return !candidates.empty() && distance_from(model, candidates, p) > most;
    });
}

std::string off_facets_text(const auto& verdict, const char* facets) {
    const bool is_one = verdict.share <= 0.1 && verdict.lost != nullptr;
    const auto counted = [&](std::size_t off_count, std::size_t all) {
        return std::to_string(off_count) + " of the " + std::to_string(all) + " " + facets;
    };
    const std::string details = is_one ? counted(verdict.worst_off_count, verdict.lost->facets.size()) +
                                             " of reference " + std::to_string(verdict.lost->reference)
                                       : counted(verdict.off_count, verdict.facets);
    return details + " in the sample do not lie on it";
}

}  // namespace

template <int D>
Outcome<Done> check_sample(const LinearMesh<D>& mesh, const CadModel& model, std::span<const std::size_t> candidates,
                           std::span<const Reference> excluded, const Execution& execution) {
    const bool is_whole = excluded.empty();
    const auto sample = sampled(mesh, excluded);
    const auto verdict = sample_verdict<D>(mesh, model, sample, candidates, 1, execution);
    if (!verdict) return fail(verdict.error());
    if (verdict->fits()) return Done{};
    const auto units = units_of_sample(mesh, model, sample, candidates, execution);
    if (!units) return fail(units.error());
    const Box<D> of_part = box_of(mesh, [&](std::size_t f) {
        return !std::binary_search(excluded.begin(), excluded.end(), mesh.facets.references[f]);
    });
    const auto [vertex, away] = farthest_corner(mesh, model, candidates, verdict->farthest);
    return fail(ErrorKind::input,
                std::string(subject(is_whole)) + " reaches from " + text(of_part) + ", the CAD model from " +
                    text(box_of<D>(model.parts(), candidates)) + ": " +
                    off_facets_text(*verdict, D == 2 ? "edges" : "triangles") + ", the farthest by " + text(away),
                {}, Entity{"vertex", vertex.index() + 1}, remedy(suggested_unit(*units), is_whole));
}

template <int D>
Outcome<CadModel> in_unit_of(const LinearMesh<D>& mesh, const CadModel& model, std::span<const Reference> excluded,
                             const Execution& execution) {
    return guarded([&]() -> Outcome<CadModel> {
        const std::vector<std::size_t> all = candidates<D>(model);
        const auto sample = sampled(mesh, excluded);
        if (all.empty() || sample.empty()) return model;
        const auto own = sample_verdict<D>(mesh, model, sample, all, 1, execution);
        if (!own) return fail(own.error());
        if (own->fits()) return model;
        const auto units = units_of_sample(mesh, model, sample, all, execution);
        if (!units) return fail(units.error());
        return units->size() == 1 ? in_unit(model, units->front()) : model;
    });
}

template <int D>
Outcome<std::vector<Reference>> references_within_materials(const LinearMesh<D>& mesh, const CadModel& model,
                                                            std::span<const Reference> excluded,
                                                            const Execution& execution) {
    return guarded([&]() -> Outcome<std::vector<Reference>> {
        const auto around = balls(mesh, execution);
        if (!around) return fail(around.error());
        const std::vector<std::size_t> all = candidates<D>(model);
        std::vector<Reference> found;
        for (const SampledReference& some : sampled(mesh, excluded)) {
            if (!is_within_material(mesh, *around, some.reference)) continue;
            const auto off = map_each(execution, some.facets.size(), [&](std::size_t i) -> std::uint8_t {
                return is_off<D>(mesh, model, all, some.facets[i]) ? 1 : 0;
            });
            if (!off) return fail(off.error());
            const auto count = static_cast<std::size_t>(std::count(off->begin(), off->end(), 1));
            if (all.empty() || 2 * count > some.facets.size()) found.push_back(some.reference);
        }
        return found;
    });
}

template <int D>
Outcome<Done> check_part(const LinearMesh<D>& mesh, const CadModel& model, const CadAssociation& association) {
    const bool is_whole = association.facets == mesh.facets.size();
    const Box<D> of_part = box_of(mesh, [&](std::size_t f) { return association.faces[f] != no_face; });
    std::vector<std::size_t> faces;
    for (const auto& [reference, some] : association.of_references) faces.insert(faces.end(), some.begin(), some.end());
    std::sort(faces.begin(), faces.end());
    faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
    const Box<D> met = box_of<D>(model.parts(), faces);
    if (!agree(of_part, met, 1)) {
        const auto units = fitting_units(
            model.parts(), [&](double factor) -> Outcome<bool> { return agree(of_part, met, 1 / factor); });
        if (units && !units->empty())
            return fail(ErrorKind::input,
                        std::string(subject(is_whole)) + " reaches from " + text(of_part) +
                            ", the matching part of the CAD model from " + text(met),
                        {}, {}, remedy(suggested_unit(*units), is_whole));
    }
    if (association.detached_vertices > 0)
        return fail(ErrorKind::input,
                    std::to_string(association.detached_vertices) + " vertices of " + subject(is_whole) +
                        " are farther from the CAD edges between their CAD faces than their own edges are long, the "
                        "farthest by " +
                        text(association.largest_vertex_distance),
                    {}, Entity{"vertex", association.farthest_vertex.index() + 1}, remedy(std::nullopt, is_whole));
    constexpr double most = 0.1;
    const auto& [strays, all] = std::pair(association.off_vertices, association.vertices);
    if (static_cast<double>(strays) <= most * static_cast<double>(all)) return Done{};
    return fail(ErrorKind::input,
                std::to_string(strays) + " of the " + std::to_string(all) + " vertices of " + subject(is_whole) +
                    " are farther from the CAD model than their edges are long, the farthest by " +
                    text(association.largest_vertex_distance),
                {}, Entity{"vertex", association.farthest_vertex.index() + 1}, remedy(std::nullopt, is_whole));
}

#define CAMBER_INSTANTIATE(D)                                                                                   \
    template Outcome<CadModel> in_unit_of<D>(const LinearMesh<D>&, const CadModel&, std::span<const Reference>, \
                                             const Execution&);                                                 \
    template Outcome<Done> check_sample<D>(const LinearMesh<D>&, const CadModel&, std::span<const std::size_t>, \
                                           std::span<const Reference>, const Execution&);                       \
    template Outcome<std::vector<Reference>> references_within_materials<D>(                                    \
        const LinearMesh<D>&, const CadModel&, std::span<const Reference>, const Execution&);                   \
    template Outcome<Done> check_part<D>(const LinearMesh<D>&, const CadModel&, const CadAssociation&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
