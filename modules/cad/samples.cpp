module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "occ/kernel.hpp"
module camber.cad;
import camber.core;
import camber.surface;
import :in_plane;
import :parts;

namespace camber {

namespace {

/// Points of one entity, and what each stands for.
struct Samples {
    std::vector<Vec<3>> points;
    std::vector<double> weights;
};

double middle_of(double low, double high, std::size_t i, std::size_t n) {
    return low + (high - low) * (static_cast<double>(i) + 0.5) / static_cast<double>(n);
}

/// A grid of n by m parameters; those that the face has.
Samples grid_on_face(const CadModel& model, std::size_t face, std::size_t n, std::size_t m) {
    const occ::Kernel& kernel = *model.parts().kernel;
    const occ::FaceFacts& facts = kernel.faces[face];
    const double cell = (facts.high[0] - facts.low[0]) / static_cast<double>(n) * (facts.high[1] - facts.low[1]) /
                        static_cast<double>(m);
    Samples out;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < m; ++j) {
            const double u = middle_of(facts.low[0], facts.high[0], i, n);
            const double v = middle_of(facts.low[1], facts.high[1], j, m);
            if (!kernel.has(face, u, v)) continue;
            const occ::SurfaceJet jet = kernel.on_surface(face, u, v);
            out.points.push_back(vec(jet.point));
            out.weights.push_back(norm(cross(vec(jet.u), vec(jet.v))) * cell);
        }
    return out;
}

double area_of(const Samples& samples) {
    double area = 0;
    for (const double weight : samples.weights) area += weight;
    return area;
}

/// The longest of some lines along each parameter of a face.
std::array<double, 2> extents_of(const CadModel& model, std::size_t face) {
    constexpr std::size_t lines = 3, pieces = 16;
    const occ::Kernel& kernel = *model.parts().kernel;
    const occ::FaceFacts& facts = kernel.faces[face];
    std::array<double, 2> longest{};
    for (std::size_t k = 0; k < 2; ++k)
        for (std::size_t line = 0; line < lines; ++line) {
            double length = 0;
            for (std::size_t i = 0; i < pieces; ++i) {
                std::array<double, 2> uv{};
                uv[k] = middle_of(facts.low[k], facts.high[k], i, pieces);
                uv[1 - k] = middle_of(facts.low[1 - k], facts.high[1 - k], line, lines);
                const occ::SurfaceJet jet = kernel.on_surface(face, uv[0], uv[1]);
                length += norm(vec(k == 0 ? jet.u : jet.v)) * (facts.high[k] - facts.low[k]) / pieces;
            }
            longest[k] = std::max(longest[k], length);
        }
    return longest;
}

/// As many parts of a length as are about so long, within limits.
std::size_t parts_of(double length, double step, std::size_t least, std::size_t most) {
    if (!(step > 0) || !(length > 0)) return least;
    return static_cast<std::size_t>(
        std::clamp(std::ceil(length / step), static_cast<double>(least), static_cast<double>(most)));
}

Samples of_face(const CadModel& model, std::size_t face, double step) {
    constexpr std::size_t least = 6, most = 1024, finer = 8, finest = 512;
    const auto extents = extents_of(model, face);
    const std::size_t n = parts_of(extents[0], step, least, most), m = parts_of(extents[1], step, least, most);
    Samples samples = grid_on_face(model, face, n, m);
    if (!samples.points.empty()) return samples;
    // A face so narrow, or so broken, that it has none of them: a finer grid, which costs no more than others.
    return grid_on_face(model, face, std::min(finer * n, finest), std::min(finer * m, finest));
}

Samples of_edge(const CadModel& model, std::size_t edge, double step) {
    constexpr std::size_t least = 16, most = 65536;
    const occ::Kernel& kernel = *model.parts().kernel;
    const occ::EdgeFacts& facts = kernel.edges[edge];
    const auto at = [&](std::size_t n, std::size_t i, Samples& out) {
        const occ::CurveJet jet = kernel.on_curve(edge, middle_of(facts.first, facts.last, i, n));
        out.points.push_back(vec(jet.point));
        out.weights.push_back(norm(vec(jet.first)) * (facts.last - facts.first) / static_cast<double>(n));
    };
    Samples few;
    for (std::size_t i = 0; i < least; ++i) at(least, i, few);
    const std::size_t n = parts_of(area_of(few), step, least, most);
    Samples out;
    for (std::size_t i = 0; i < n; ++i) at(n, i, out);
    return out;
}

void append(GeometrySamples<3>& to, const GeometryEntity& entity, const Samples& samples) {
    if (samples.points.empty()) return;
    to.begin(entity);
    for (std::size_t i = 0; i < samples.points.size(); ++i) to.add(samples.points[i], samples.weights[i]);
}

/// Between the first two faces around an edge.
GeometryEntity curve(const occ::EdgeFacts& facts, std::size_t edge) {
    std::array<std::int64_t, 2> sides{GeometryEntity::unnumbered, GeometryEntity::unnumbered};
    for (std::size_t i = 0; i < 2 && i < facts.faces.size(); ++i) sides[i] = static_cast<std::int64_t>(facts.faces[i]);
    if (sides[1] != GeometryEntity::unnumbered && sides[1] < sides[0]) std::swap(sides[0], sides[1]);
    return {GeometryKind::curve, static_cast<std::int64_t>(edge), sides};
}

}  // namespace

template <>
Outcome<GeometrySamples<2>> samples_of<2>(const CadModel& model, std::size_t wanted, const Execution& execution) {
    constexpr double coarse = 0;  // some points a curve, which tell its length
    return guarded([&]() -> Outcome<GeometrySamples<2>> {
        const std::vector<std::size_t> curves = curves_of(model);
        double length = 0;
        for (const std::size_t e : curves) length += area_of(of_edge(model, e, coarse));
        const double step = length / static_cast<double>(std::max<std::size_t>(wanted, 1));
        const auto found = map_each(
            without_progress(execution), curves.size(), [&](std::size_t i) { return of_edge(model, curves[i], step); },
            1);
        if (!found) return fail(found.error());
        GeometrySamples<2> samples;
        for (std::size_t i = 0; i < curves.size(); ++i) {
            samples.begin(GeometryEntity::surface(static_cast<std::int64_t>(curves[i])));
            const auto& [points, weights] = (*found)[i];
            for (std::size_t k = 0; k < points.size(); ++k) samples.add(in_plane(points[k]), weights[k]);
        }
        return samples;
    });
}

template <>
Outcome<GeometrySamples<3>> samples_of<3>(const CadModel& model, std::size_t wanted, const Execution& execution) {
    constexpr std::size_t coarse = 16, closer_on_edges = 2;
    const occ::Kernel& kernel = *model.parts().kernel;
    return guarded([&]() -> Outcome<GeometrySamples<3>> {
        const auto areas = map_each(
            without_progress(execution), kernel.faces.size(),
            [&](std::size_t f) { return area_of(grid_on_face(model, f, coarse, coarse)); }, 1);
        if (!areas) return fail(areas.error());
        double area = 0;
        for (const double a : *areas) area += a;
        const double step = std::sqrt(area / static_cast<double>(std::max<std::size_t>(wanted, 1)));
        std::vector<Samples> faces(kernel.faces.size()), edges(kernel.edges.size());
        auto done = each(
            without_progress(execution), faces.size(), [&](std::size_t f) { faces[f] = of_face(model, f, step); }, 1);
        if (!done) return fail(done.error());
        done = each(
            without_progress(execution), edges.size(),
            [&](std::size_t e) { edges[e] = of_edge(model, e, step / closer_on_edges); }, 1);
        if (!done) return fail(done.error());
        GeometrySamples<3> samples;
        for (std::size_t f = 0; f < faces.size(); ++f)
            append(samples, GeometryEntity::surface(static_cast<std::int64_t>(f)), faces[f]);
        for (std::size_t e = 0; e < edges.size(); ++e) append(samples, curve(kernel.edges[e], e), edges[e]);
        return samples;
    });
}

}  // namespace camber
