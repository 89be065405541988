module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "occ/kernel.hpp"
module camber.cad;
import camber.core;
import camber.surface;
import :parts;

namespace camber {

namespace {

struct OnCurve {
    double t = 0;
    occ::CurveJet jet{};
    double distance_squared = std::numeric_limits<double>::infinity();

    [[nodiscard]] Vec<3> point() const { return vec(jet.point); }
};

OnCurve at(const CadParts& parts, std::size_t edge, double t, const Vec<3>& p) {
    const occ::CurveJet jet = parts.kernel->on_curve(edge, t);
    return {t, jet, norm_squared(vec(jet.point) - p)};
}

/// Newton on (c(t) − p)·c'(t) = 0 between two parameters; where |c − p|² is not convex, by its Gauss part.
OnCurve nearest_between(const CadParts& parts, std::size_t edge, double low, double high, const Vec<3>& p) {
    constexpr int max_steps = 30;
    const double tiny = rounding(parts, p);
    OnCurve best = at(parts, edge, 0.5 * (low + high), p);
    for (int step = 0; step < max_steps; ++step) {
        const Vec<3> r = best.point() - p, first = vec(best.jet.first);
        const double gauss = dot(first, first), slope = dot(r, first);
        if (!(gauss > 0)) break;
        const double whole = gauss + dot(r, vec(best.jet.second));
        const double change = -slope / (whole > 0.1 * gauss ? whole : gauss);
        double t = std::clamp(best.t + change, low, high);
        OnCurve next = at(parts, edge, t, p);
        // A squared distance hides what is below the root of its rounding: the last steps look as if they led nowhere.
        const double most = best.distance_squared * (1 + 1e-13) + tiny * tiny;
        for (int halving = 0; halving < 6 && next.distance_squared > most; ++halving) {
            t = 0.5 * (t + best.t);
            next = at(parts, edge, t, p);
        }
        if (next.distance_squared > most) break;
        const double moved = std::abs(t - best.t) * std::sqrt(gauss);
        best = next;
        if (moved <= tiny) break;
    }
    return best;
}

/// The nearest of all cells; those whose box is farther away than what is found are left out.
OnCurve nearest(const CadParts& parts, std::size_t edge, const Vec<3>& p) {
    const Cells& cells = parts.edges[edge];
    OnCurve best;
    (void)cells.tree.nearest(p, [&](std::size_t i) {
        const double beyond = cells.boxes[i].distance_squared(p);
        if (beyond >= best.distance_squared) return beyond;
        const OnCurve here = nearest_between(parts, edge, cells.cells[i].low[0], cells.cells[i].high[0], p);
        if (here.distance_squared < best.distance_squared) best = here;
        return here.distance_squared;
    });
    return best;
}

}  // namespace

CadFoot closest_on_edge(const CadModel& model, std::size_t edge, const Vec<3>& p) {
    const CadParts& parts = model.parts();
    const OnCurve found = nearest(parts, edge, p);
    const double distance = std::sqrt(found.distance_squared);
    if (distance <= 4 * rounding(parts, p)) return {p, {}, {found.t, 0}, 0};
    return {found.point(), {}, {found.t, 0}, distance};
}

EntityPoint<3> point_on_edge(const CadModel& model, std::size_t edge, double t) {
    const occ::CurveJet jet = model.parts().kernel->on_curve(edge, t);
    return {vec(jet.point), {vec(jet.first), {}}, {}};
}

}  // namespace camber
