module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>

#include "occ/kernel.hpp"
module camber.cad;
import camber.core;
import camber.surface;
import :parts;

namespace camber {

namespace {

using Parameters = std::array<double, 2>;

struct OnSurface {
    Parameters uv{};
    occ::SurfaceJet jet{};
    double distance_squared = std::numeric_limits<double>::infinity();

    [[nodiscard]] Vec<3> point() const { return vec(jet.point); }
};

OnSurface at(const CadParts& parts, std::size_t face, const Parameters& uv, const Vec<3>& p) {
    const occ::SurfaceJet jet = parts.kernel->on_surface(face, uv[0], uv[1]);
    return {uv, jet, norm_squared(vec(jet.point) - p)};
}

Parameters clamped(const Parameters& uv, const Cell& within) {
    return {std::clamp(uv[0], within.low[0], within.high[0]), std::clamp(uv[1], within.low[1], within.high[1])};
}

/// A step, and which coordinates are at a bound that the distance falls beyond.
struct Step {
    Parameters change{};
    std::array<bool, 2> held{};
};

/// Newton's for ½|S(u, v) − p|², in the coordinates that are not held; where that is not convex, that of its Gauss
/// part, which a small multiple of its trace keeps from being singular at poles.
Step step(const OnSurface& from, const Cell& within, const Vec<3>& p) {
    const occ::SurfaceJet& jet = from.jet;
    const Vec<3> r = from.point() - p, u = vec(jet.u), v = vec(jet.v);
    const Parameters slope{dot(r, u), dot(r, v)};
    const double guu = dot(u, u), guv = dot(u, v), gvv = dot(v, v);
    const double huu = guu + dot(r, vec(jet.uu)), huv = guv + dot(r, vec(jet.uv)), hvv = gvv + dot(r, vec(jet.vv));
    Step out;
    for (std::size_t k = 0; k < 2; ++k)
        out.held[k] = (from.uv[k] <= within.low[k] && slope[k] > 0) || (from.uv[k] >= within.high[k] && slope[k] < 0);
    constexpr double convex = 0.1, least = 1e-14;
    const bool whole = huu > convex * guu && hvv > convex * gvv && huu * hvv - huv * huv > convex * convex * guu * gvv;
    const double ridge = least * (guu + gvv);
    const double a = (whole ? huu : guu) + ridge, b = whole ? huv : guv, c = (whole ? hvv : gvv) + ridge;
    const double det = a * c - b * b;
    if (out.held[0] || out.held[1] || !(det > 0))
        out.change = {out.held[0] ? 0 : -slope[0] / a, out.held[1] ? 0 : -slope[1] / c};
    else
        out.change = {(b * slope[1] - c * slope[0]) / det, (b * slope[0] - a * slope[1]) / det};
    return out;
}

/// Whether a search is pressed against a bound of its cell beyond which the face goes on: what is nearest is there.
bool leads_on(const Step& step, const Parameters& uv, const occ::FaceFacts& facts) {
    for (std::size_t k = 0; k < 2; ++k)
        if (step.held[k] && uv[k] > facts.low[k] && uv[k] < facts.high[k]) return true;
    return false;
}

OnSurface nearest_within(const CadParts& parts, std::size_t face, const Parameters& from, const Cell& within,
                         const Vec<3>& p) {
    constexpr int max_steps = 40, max_pressed = 2;
    const double tiny = rounding(parts, p);
    OnSurface best = at(parts, face, from, p);
    int pressed = 0;
    for (int n = 0; n < max_steps; ++n) {
        const auto [change, held] = step(best, within, p);
        if (!std::isfinite(change[0]) || !std::isfinite(change[1])) break;
        pressed = leads_on({change, held}, best.uv, parts.kernel->faces[face]) ? pressed + 1 : 0;
        if (pressed == max_pressed) break;
        OnSurface next = at(parts, face, clamped({best.uv[0] + change[0], best.uv[1] + change[1]}, within), p);
        // As on an edge: the last steps look as if they led nowhere.
        const double most = best.distance_squared * (1 + 1e-13) + tiny * tiny;
        for (int halving = 0; halving < 6 && next.distance_squared > most; ++halving)
            next = at(parts, face, {0.5 * (next.uv[0] + best.uv[0]), 0.5 * (next.uv[1] + best.uv[1])}, p);
        if (next.distance_squared > most) break;
        const double moved =
            norm((next.uv[0] - best.uv[0]) * vec(best.jet.u) + (next.uv[1] - best.uv[1]) * vec(best.jet.v));
        best = next;
        if (moved <= tiny) break;
    }
    return best;
}

/// A parameter within its bounds, or by whole periods as near to them as can be.
double turned(double x, double low, double high, double period) {
    if (!(period > 0)) return x;
    return x - period * std::round((x - 0.5 * (low + high)) / period);
}

/// The bounds of a face in the directions in which its surface does not close.
Cell whole(const occ::FaceFacts& facts) {
    Cell cell{facts.low, facts.high};
    for (std::size_t k = 0; k < 2; ++k)
        if (facts.period[k] > 0) {
            cell.low[k] -= facts.period[k];
            cell.high[k] += facts.period[k];
        }
    return cell;
}

/// Of the surface within the bounds of the face's parameters; of one with a closed form, of the whole surface.
OnSurface nearest(const CadParts& parts, std::size_t face, const Vec<3>& p) {
    const occ::FaceFacts& facts = parts.kernel->faces[face];
    OnSurface best;
    if (facts.has_closed_form) {
        best = at(parts, face, parts.kernel->nearest_parameters(face, p.c), p);
    } else {
        const Cells& cells = parts.faces[face];
        (void)cells.tree.nearest(p, [&](std::size_t i) {
            const double beyond = cells.boxes[i].distance_squared(p);
            if (beyond >= best.distance_squared) return beyond;
            const Cell& cell = cells.cells[i];
            const Parameters middle{0.5 * (cell.low[0] + cell.high[0]), 0.5 * (cell.low[1] + cell.high[1])};
            const OnSurface here = nearest_within(parts, face, middle, cell, p);
            if (here.distance_squared < best.distance_squared) best = here;
            return here.distance_squared;
        });
        best = nearest_within(parts, face, best.uv, whole(facts), p);
    }
    for (std::size_t k = 0; k < 2; ++k) best.uv[k] = turned(best.uv[k], facts.low[k], facts.high[k], facts.period[k]);
    return best;
}

/// The nearest of a face's edges; nothing where it has none.
std::optional<CadFoot> nearest_edge(const CadModel& model, std::size_t face, const Vec<3>& p) {
    const CadParts& parts = model.parts();
    std::optional<CadFoot> best;
    for (const std::size_t edge : parts.kernel->faces[face].edges) {
        if (best && parts.edges[edge].reach.distance_squared(p) > best->distance * best->distance) continue;
        const CadFoot foot = closest_on_edge(model, edge, p);
        if (!best || foot.distance < best->distance) best = foot;
    }
    return best;
}

CadFoot foot_of(const CadModel& model, std::size_t face, const OnSurface& found, const Vec<3>& p) {
    const double distance = std::sqrt(found.distance_squared);
    const bool is_there = distance <= 4 * rounding(model.parts(), p);
    return {is_there ? p : found.point(), point_on_face(model, face, found.uv).normal, found.uv,
            is_there ? 0 : distance};
}

}  // namespace

CadFoot closest_on_face(const CadModel& model, std::size_t face, const Vec<3>& p) {
    const CadParts& parts = model.parts();
    const OnSurface found = nearest(parts, face, p);
    if (parts.kernel->has(face, found.uv[0], found.uv[1])) return foot_of(model, face, found, p);
    const auto edge = nearest_edge(model, face, p);
    // A point of an edge may be beyond the face by rounding, and its surface then is as near.
    if (!edge || edge->distance <= std::sqrt(found.distance_squared)) return foot_of(model, face, found, p);
    const OnSurface below = nearest(parts, face, edge->point);
    return {edge->point, point_on_face(model, face, below.uv).normal, below.uv, edge->distance};
}

EntityPoint<3> point_on_face(const CadModel& model, std::size_t face, const std::array<double, 2>& uv) {
    constexpr double unseen = 1e-9;
    const occ::FaceFacts& facts = model.parts().kernel->faces[face];
    const occ::SurfaceJet jet = model.parts().kernel->on_surface(face, uv[0], uv[1]);
    const Vec<3> u = vec(jet.u), v = vec(jet.v);
    Vec<3> along_u = u, along_v = v;
    // At a pole the derivative around it vanishes; a little way into the face it is that of the mixed one.
    const auto inwards = [&](std::size_t k) { return uv[k] < 0.5 * (facts.low[k] + facts.high[k]) ? 1.0 : -1.0; };
    const auto reach = [&](std::size_t k) { return facts.high[k] - facts.low[k]; };
    if (norm(u) * reach(0) <= unseen * norm(v) * reach(1)) along_u = inwards(1) * vec(jet.uv);
    if (norm(v) * reach(1) <= unseen * norm(u) * reach(0)) along_v = inwards(0) * vec(jet.uv);
    const Vec<3> normal = normalised(cross(along_u, along_v));
    return {vec(jet.point), {u, v}, facts.is_reversed ? -normal : normal};
}

std::optional<std::size_t> nearest_face(const CadModel& model, std::span<const std::size_t> faces, const Vec<3>& p) {
    std::optional<std::size_t> best;
    double least = std::numeric_limits<double>::infinity();
    for (const std::size_t face : faces) {
        if (best && model.parts().faces[face].reach.distance_squared(p) > least * least) continue;
        const double distance = closest_on_face(model, face, p).distance;
        if (distance < least) {
            least = distance;
            best = face;
        }
    }
    return best;
}

}  // namespace camber
