module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <tuple>
#include <utility>
#include <vector>
module camber.surface;
import camber.core;

namespace camber {

namespace {

double degrees_between(const Vec<3>& a, const Vec<3>& b) {
    return atan2(norm(cross(a, b)), dot(a, b)) * 180 / std::numbers::pi;
}

/// Places where facets turn by an angle that is near a limit.
template <int D>
void add_turns(const LinearMesh<D>& mesh, const std::vector<Hinge<D>>& hinges, const InspectionLimits& limits,
               std::vector<Suspect<D>>& out) {
    for (const Hinge<D>& hinge : hinges) {
        if (hinge.facets.size() != 2) continue;
        const double turn = turn_at(mesh, hinge);
        const bool by_angle =
            !hinge.is_listed && mesh.facets.references[hinge.facets[0]] == mesh.facets.references[hinge.facets[1]];
        const auto add = [&](Suspicion what) {
            Suspect<D> suspect{what, turn, midpoint(mesh.points[hinge.ends[0]], mesh.points[hinge.ends[1]]), {}, {}};
            suspect.vertices.assign(hinge.ends.begin(), D == 3 ? hinge.ends.end() : hinge.ends.begin() + 1);
            suspect.facets = hinge.facets;
            out.push_back(std::move(suspect));
        };
        if (turn >= limits.knife_edge)
            add(Suspicion::knife_edge);
        else if (!hinge.is_ridge && turn >= limits.near * limits.ridge_angle)
            add(Suspicion::near_ridge);
        else if (hinge.is_ridge && by_angle && turn <= limits.ridge_angle / limits.near)
            add(Suspicion::mild_ridge);
    }
}

/// Of each fan the normal by angles of its facets, so that it does not depend on how they are cut.
std::vector<Vec<3>> normals_of(const LinearMesh<3>& mesh, const Fans& fans) {
    std::vector<Vec<3>> normals(fans.size());
    for (std::size_t fan = 0; fan < fans.size(); ++fan) {
        for (const FacetId f : fans.facets[fan]) {
            const auto& v = mesh.facets.vertices[f];
            const std::size_t i = corner_of(v, fans.vertices[fan]);
            const Vec<3> a = mesh.points[v[(i + 1) % 3]] - mesh.points[v[i]];
            const Vec<3> b = mesh.points[v[(i + 2) % 3]] - mesh.points[v[i]];
            normals[fan] += degrees_between(a, b) * unit_or(area_vector(mesh, fans, f), Vec<3>{});
        }
        normals[fan] = unit_or(normals[fan], Vec<3>{});
    }
    return normals;
}

void add_fans(const LinearMesh<3>& mesh, const Fans& fans, std::span<const Vec<3>> normals,
              const InspectionLimits& limits, std::vector<Suspect<3>>& out) {
    constexpr double even = 0.7;  // a cone's facets are about equally steep
    for (std::size_t fan = 0; fan < fans.size(); ++fan) {
        double least = 180, most = 0;
        for (const FacetId f : fans.facets[fan]) {
            const double turn = degrees_between(area_vector(mesh, fans, f), normals[fan]);
            least = std::fmin(least, turn);
            most = std::fmax(most, turn);
        }
        if (most < limits.normals) continue;
        const auto facets = fans.facets[fan];
        out.push_back({least > even * most ? Suspicion::tip : Suspicion::spread_normals,
                       most,
                       mesh.points[fans.vertices[fan]],
                       {fans.vertices[fan]},
                       {facets.begin(), facets.end()}});
    }
}

/// Facets that stand out of what their vertices agree on; at tips all do.
void add_facets(const LinearMesh<3>& mesh, const Fans& fans, std::span<const Vec<3>> normals,
                const InspectionLimits& limits, std::vector<Suspect<3>>& out) {
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        const Vec<3> own = area_vector(mesh, fans, FacetId(f));
        Vec<3> mean, centre;
        for (std::size_t i = 0; i < 3; ++i) {
            mean += normals[fans.of_facets[f][i]];
            centre += mesh.points[mesh.facets.vertices[f][i]] / 3;
        }
        const double turn = degrees_between(own, mean);
        if (turn < limits.normals) continue;
        const auto& v = mesh.facets.vertices[f];
        out.push_back({Suspicion::turned_facet, turn, centre, {v.begin(), v.end()}, {FacetId(f)}});
    }
}

}  // namespace

template <int D>
Outcome<std::vector<Suspect<D>>> find_suspects(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                               const Features<D>& features, const std::vector<Hinge<D>>& hinges,
                                               const InspectionLimits& limits, const Execution& execution) {
    std::vector<Suspect<D>> out;
    add_turns(mesh, hinges, limits, out);
    if constexpr (D == 3) {
        const auto shells = facet_shells(edges, without_progress(execution));
        if (!shells) return fail(shells.error());
        const auto fans = find_fans(mesh, edges, features, *shells, execution);
        if (!fans) return fail(fans.error());
        const auto normals = normals_of(mesh, *fans);
        add_fans(mesh, *fans, normals, limits, out);
        add_facets(mesh, *fans, normals, limits, out);
    }
    const auto place = [](const Suspect<D>& s) {
        return std::tuple(s.what, s.what == Suspicion::mild_ridge ? s.degrees : -s.degrees, s.facets.front());
    };
    std::stable_sort(out.begin(), out.end(),
                     [&](const Suspect<D>& a, const Suspect<D>& b) { return place(a) < place(b); });
    return out;
}

#define CAMBER_INSTANTIATE(D)                                                                                 \
    template Outcome<std::vector<Suspect<D>>> find_suspects(const LinearMesh<D>&, const EdgeSet<D>&,          \
                                                            const Features<D>&, const std::vector<Hinge<D>>&, \
                                                            const InspectionLimits&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
