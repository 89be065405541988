module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "occ/kernel.hpp"
module camber.cad;
import camber.core;
import camber.surface;
import :in_plane;
import :parts;
import :sampled;
import :virtual_faces;

namespace camber {

namespace {

/// So many facets of each reference, and of all together where references are few.
constexpr std::size_t min_of_each = 24, wanted = 512;

/// How far a facet is from the model, and which share of it is astray.
struct Looked {
    double share = 0, distance = 0;
};

/// Whether a point is at least so far from a face, in 2D a curve, by boxes alone.
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

/// The sine of the angle between a facet and a face below its middle.
double sine_between(const CadModel& model, std::size_t face, const std::array<Vec<3>, 3>& c) {
    const Vec<3> normal = normalised(cross(c[1] - c[0], c[2] - c[0]));
    return norm(cross(normal, closest_on_virtual_face(model, face, (c[0] + c[1] + c[2]) / 3).foot.normal));
}
double sine_between(const CadModel& model, std::size_t curve, const std::array<Vec<2>, 2>& ends) {
    const Vec<2> normal = closest_on_virtual_face(model, curve, midpoint(ends[0], ends[1])).foot.normal;
    return std::abs(dot(normalised(ends[1] - ends[0]), normal));
}

template <int D>
Looked looked_at(const CadModel& model, std::span<const std::size_t> candidates, const std::array<Vec<D>, D>& corners) {
    constexpr double across = 0.9, far = 0.5;
    const double longest = longest_side(corners);
    // Boxes tell which vertices are elsewhere; searches from far away take long.
    const bool is_elsewhere = std::all_of(corners.begin(), corners.end(), [&](const Vec<D>& p) {
        return std::all_of(candidates.begin(), candidates.end(),
                           [&](std::size_t face) { return is_beyond(model, face, p, far * longest); });
    });
    if (is_elsewhere) {
        double beyond = std::numeric_limits<double>::infinity();
        for (const std::size_t face : candidates) beyond = std::min(beyond, away_from_box(model, face, corners[0]));
        return {1, beyond};
    }
    const std::size_t face = best_fit<D>(model, candidates, corners).face;
    Looked out;
    for (const Vec<D>& p : corners) {
        const double away = away_from(model, face, p);
        out.distance = std::max(out.distance, away);
        out.share += away <= far * longest ? 0 : 1.0 / D;
    }
    if (out.share < 1 && sine_between(model, face, corners) > across) out.share = 1;
    return out;
}

}  // namespace

template <int D>
std::vector<SampledReference> sampled(const LinearMesh<D>& mesh, std::span<const Reference> elsewhere) {
    std::map<Reference, std::vector<FacetId>> all;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        const Reference reference = mesh.facets.references[f];
        if (!std::binary_search(elsewhere.begin(), elsewhere.end(), reference)) all[reference].push_back(FacetId(f));
    }
    std::vector<SampledReference> sample;
    for (const auto& [reference, facets] : all) {
        const std::size_t most = std::max(min_of_each, wanted / all.size()), count = facets.size();
        const std::size_t taken = std::min(count, most);
        SampledReference some{reference, count, {}};
        some.facets.reserve(taken);
        for (std::size_t i = 0; i < taken; ++i) some.facets.push_back(facets[i * count / taken]);
        sample.push_back(std::move(some));
    }
    return sample;
}

template <int D>
Outcome<SampleVerdict> judged(const LinearMesh<D>& mesh, const CadModel& model,
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
            return looked_at<D>(model, candidates, corners);
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
            const Looked& facet = (*looked)[i++];
            share += facet.share;
            touched += facet.share > 0 ? 1 : 0;
            if (facet.share == 0 || facet.distance <= farthest) continue;
            farthest = facet.distance;
            verdict.farthest = f;
        }
        share /= static_cast<double>(some.facets.size());
        strays += share * static_cast<double>(some.count);
        all += static_cast<double>(some.count);
        verdict.astray += touched;
        if (share <= max_lost) continue;
        max_lost = share;
        verdict.lost = &some;
        verdict.lost_astray = touched;
    }
    verdict.share = all > 0 ? strays / all : 0;
    return verdict;
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template std::vector<SampledReference> sampled<D>(const LinearMesh<D>&, std::span<const Reference>);               \
    template Outcome<SampleVerdict> judged<D>(const LinearMesh<D>&, const CadModel&,                                   \
                                              std::span<const SampledReference>, std::span<const std::size_t>, double, \
                                              const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
