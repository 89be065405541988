// Closest points on faces and edges. Searches start in cells of the parameter range.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>
#include <vector>
#include "occ/kernel.hpp"
module camber.cad;
import camber.core;
import camber.box_tree;
import camber.surface;
import :parts;

namespace camber {

namespace {

/// Number of sample intervals per direction in a cell. `between_samples`: margin of the cell's box, relative to the
/// diagonal of the box of the samples.
constexpr std::size_t samples = 4;
constexpr double between_samples = 0.1;

Box<3> widened(Box<3> box) {
    const double by = between_samples * box.diagonal();
    for (std::size_t k = 0; k < 3; ++k) {
        box.low[k] -= by;
        box.high[k] += by;
    }
    return box;
}

EntityCells finished(std::vector<Cell> cells, const std::vector<Box<3>>& boxes) {
    EntityCells out;
    out.boxes.reserve(boxes.size());
    for (const Box<3>& box : boxes) {
        out.bounds.include(box);
        out.boxes.push_back(widened(box));
        out.reach.include(out.boxes.back());
    }
    out.cells = std::move(cells);
    out.tree = BoxTree<3>(out.boxes);
    return out;
}

OrientedBox oriented_box(const std::vector<Vec<3>>& points, const occ::SurfaceJet& middle) {
    constexpr double around = 0.1;
    OrientedBox box;
    const Vec<3> u = vec(middle.u), normal = cross(u, vec(middle.v));
    if (!(norm(u) > 0) || !(norm(normal) > 0)) {
        for (std::size_t k = 0; k < 3; ++k) box.axes[k][static_cast<int>(k)] = 1;
    } else {
        box.axes[0] = normalised(u);
        box.axes[2] = normalised(normal);
        box.axes[1] = cross(box.axes[2], box.axes[0]);
    }
    Box<3> along;
    for (const Vec<3>& p : points)
        along.include(Vec<3>{{dot(p, box.axes[0]), dot(p, box.axes[1]), dot(p, box.axes[2])}});
    const double thickness = along.high[2] - along.low[2];
    for (std::size_t k = 0; k < 3; ++k) {
        const int i = static_cast<int>(k);
        box.centre += 0.5 * (along.low[i] + along.high[i]) * box.axes[k];
        const double length = along.high[i] - along.low[i];
        const double more = k < 2 ? around * length + thickness : around * along.diagonal();
        box.half[k] = 0.5 * length + more;
    }
    return box;
}

double between(double low, double high, std::size_t i, std::size_t n) {
    return low + (high - low) * static_cast<double>(i) / static_cast<double>(n);
}

}  // namespace

EntityCells cells_of_face(const occ::Kernel& kernel, std::size_t face) {
    const occ::FaceFacts& facts = kernel.faces[face];
    std::vector<Cell> cells;
    std::vector<Box<3>> boxes;
    std::vector<OrientedBox> oriented;
    cells.reserve(facts.cells[0] * facts.cells[1]);
    boxes.reserve(cells.capacity());
    for (std::size_t i = 0; i < facts.cells[0]; ++i)
        for (std::size_t j = 0; j < facts.cells[1]; ++j) {
            Cell cell;
            for (std::size_t k = 0; k < 2; ++k) {
                const std::size_t at = k == 0 ? i : j;
                cell.low[k] = between(facts.low[k], facts.high[k], at, facts.cells[k]);
                cell.high[k] = between(facts.low[k], facts.high[k], at + 1, facts.cells[k]);
            }
            Box<3> box;
            std::vector<Vec<3>> points;
            occ::SurfaceJet middle{};
            for (std::size_t a = 0; a <= samples; ++a)
                for (std::size_t b = 0; b <= samples; ++b) {
                    const occ::SurfaceJet jet = kernel.on_surface(face, between(cell.low[0], cell.high[0], a, samples),
                                                                  between(cell.low[1], cell.high[1], b, samples));
                    points.push_back(vec(jet.point));
                    box.include(points.back());
                    if (2 * a == samples && 2 * b == samples) middle = jet;
                }
            cells.push_back(cell);
            boxes.push_back(box);
            oriented.push_back(oriented_box(points, middle));
        }
    EntityCells out = finished(std::move(cells), boxes);
    out.oriented = std::move(oriented);
    return out;
}

EntityCells cells_of_edge(const occ::Kernel& kernel, std::size_t edge) {
    const occ::EdgeFacts& facts = kernel.edges[edge];
    std::vector<Cell> cells;
    std::vector<Box<3>> boxes;
    cells.reserve(facts.cells);
    boxes.reserve(facts.cells);
    for (std::size_t i = 0; i < facts.cells; ++i) {
        Cell cell;
        cell.low[0] = between(facts.first, facts.last, i, facts.cells);
        cell.high[0] = between(facts.first, facts.last, i + 1, facts.cells);
        Box<3> box;
        for (std::size_t a = 0; a <= 2 * samples; ++a)
            box.include(vec(kernel.on_curve(edge, between(cell.low[0], cell.high[0], a, 2 * samples)).point));
        cells.push_back(cell);
        boxes.push_back(box);
    }
    return finished(std::move(cells), boxes);
}

double least_distance(const CadParts& parts, std::size_t face, const Vec<3>& p) {
    const EntityCells& cells = parts.faces[face];
    const auto nearest = cells.tree.nearest(p, [&](std::size_t i) {
        return std::max(cells.boxes[i].distance_squared(p), cells.oriented[i].distance_squared(p));
    });
    return std::sqrt(std::max(nearest.distance_squared, cells.reach.distance_squared(p)));
}

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

struct ClosedFoot {
    double distance = 0;
    Parameters uv{};
};
ClosedFoot closed_foot(const occ::ClosedForm& form, const Vec<3>& p) {
    using Kind = occ::ClosedForm::Kind;
    const Vec<3> q = (1 / form.scale) * p - vec(form.origin);
    const double x = dot(q, vec(form.x)), y = dot(q, vec(form.y)), z = dot(q, vec(form.z));
    if (form.kind == Kind::plane) return {form.scale * std::abs(z), {x, y}};
    const double around = atan2(y, x), off_axis = hypot(x, y);
    if (form.kind == Kind::cylinder) return {form.scale * std::abs(off_axis - form.major), {around, z}};
    if (form.kind == Kind::sphere)
        return {form.scale * std::abs(hypot(off_axis, z) - form.major), {around, atan2(z, off_axis)}};
    const double off_circle = off_axis - form.major;
    return {form.scale * std::abs(hypot(off_circle, z) - form.minor), {around, atan2(z, off_circle)}};
}

Parameters clamped(const Parameters& uv, const Cell& within) {
    return {std::clamp(uv[0], within.low[0], within.high[0]), std::clamp(uv[1], within.low[1], within.high[1])};
}

/// A step of both surface parameters. `active`: the parameter is at its bound, and the distance would decrease beyond
/// the bound.
struct Step {
    Parameters change{};
    std::array<bool, 2> active{};
};

/// Newton step that reduces ½|S(u, v) − p|² for the face's surface S. Parameters at active bounds stay fixed. The
/// Gauss-Newton matrix is used where the function is not convex. A small multiple of the trace keeps the matrix regular
/// at poles.
Step step(const OnSurface& from, const Cell& within, const Vec<3>& p) {
    const occ::SurfaceJet& jet = from.jet;
    const Vec<3> r = from.point() - p, u = vec(jet.u), v = vec(jet.v);
    const Parameters slope{dot(r, u), dot(r, v)};
    const double guu = dot(u, u), guv = dot(u, v), gvv = dot(v, v);
    const double huu = guu + dot(r, vec(jet.uu)), huv = guv + dot(r, vec(jet.uv)), hvv = gvv + dot(r, vec(jet.vv));
    Step out;
    for (std::size_t k = 0; k < 2; ++k)
        out.active[k] = (from.uv[k] <= within.low[k] && slope[k] > 0) || (from.uv[k] >= within.high[k] && slope[k] < 0);
    constexpr double convex = 0.1, least = 1e-14;
    const bool whole = huu > convex * guu && hvv > convex * gvv && huu * hvv - huv * huv > convex * convex * guu * gvv;
    const double ridge = least * (guu + gvv);
    const double a = (whole ? huu : guu) + ridge, b = whole ? huv : guv, c = (whole ? hvv : gvv) + ridge;
    const double det = a * c - b * b;
    if (out.active[0] || out.active[1] || !(det > 0))
        out.change = {out.active[0] ? 0 : -slope[0] / a, out.active[1] ? 0 : -slope[1] / c};
    else
        out.change = {(b * slope[1] - c * slope[0]) / det, (b * slope[0] - a * slope[1]) / det};
    return out;
}

bool continues_beyond_cell(const Step& step, const Parameters& uv, const occ::FaceFacts& facts) {
    for (std::size_t k = 0; k < 2; ++k)
        if (step.active[k] && uv[k] > facts.low[k] && uv[k] < facts.high[k]) return true;
    return false;
}

OnSurface nearest_within(const CadParts& parts, std::size_t face, const Parameters& from, const Cell& within,
                         const Vec<3>& p) {
    constexpr int max_steps = 40, max_pressed = 2;
    const double tiny = rounding(parts, p);
    OnSurface best = at(parts, face, from, p);
    int pressed = 0;
    for (int n = 0; n < max_steps; ++n) {
        const auto [change, active] = step(best, within, p);
        if (!std::isfinite(change[0]) || !std::isfinite(change[1])) break;
        pressed = continues_beyond_cell({change, active}, best.uv, parts.kernel->faces[face]) ? pressed + 1 : 0;
        if (pressed == max_pressed) break;
        OnSurface next = at(parts, face, clamped({best.uv[0] + change[0], best.uv[1] + change[1]}, within), p);
        // An increase within rounding is accepted: in the last steps, rounding hides the decrease of the distance (see
        // `nearest_between`).
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

double turned(double x, double low, double high, double period) {
    if (!(period > 0)) return x;
    return x - period * std::round((x - 0.5 * (low + high)) / period);
}

Cell whole(const occ::FaceFacts& facts) {
    Cell cell{facts.low, facts.high};
    for (std::size_t k = 0; k < 2; ++k)
        if (facts.period[k] > 0) {
            cell.low[k] -= facts.period[k];
            cell.high[k] += facts.period[k];
        }
    return cell;
}

Parameters turned(const Parameters& uv, const occ::FaceFacts& facts) {
    Parameters out;
    for (std::size_t k = 0; k < 2; ++k) out[k] = turned(uv[k], facts.low[k], facts.high[k], facts.period[k]);
    return out;
}

std::size_t cell_of(const occ::FaceFacts& facts, const Parameters& uv) {
    std::array<std::size_t, 2> cell{};
    for (std::size_t k = 0; k < 2; ++k) {
        const double count = static_cast<double>(facts.cells[k]);
        const double at = (uv[k] - facts.low[k]) / (facts.high[k] - facts.low[k]) * count;
        cell[k] = at > 0 ? static_cast<std::size_t>(std::min(at, count - 1)) : 0;
    }
    return cell[0] * facts.cells[1] + cell[1];
}

bool is_converged(const CadParts& parts, const OnSurface& place, const Cell& within, const Vec<3>& p) {
    constexpr double nothing = 1e-9;  // largest step that counts as none, relative to the model's size
    const Parameters change = step(place, within, p).change;
    return norm(change[0] * vec(place.jet.u) + change[1] * vec(place.jet.v)) <= nothing * parts.size;
}

/// Returns the closest point of the face's surface within the face's parameter bounds; bounds of closed-form surfaces
/// are ignored. `near`: parameters at which the search starts, or null. Cells with boxes nearer than the point found
/// are searched too.
OnSurface nearest(const CadParts& parts, std::size_t face, const Vec<3>& p, const Parameters* near) {
    const occ::FaceFacts& facts = parts.kernel->faces[face];
    OnSurface best;
    if (facts.has_closed_form) {
        best = at(parts, face, parts.kernel->nearest_parameters(face, p.c), p);
    } else {
        const EntityCells& cells = parts.faces[face];
        const double rounding_squared = 16 * rounding(parts, p) * rounding(parts, p);
        std::size_t settled = cells.cells.size();
        if (near != nullptr) {
            best = nearest_within(parts, face, clamped(*near, whole(facts)), whole(facts), p);
            if (!std::isfinite(best.distance_squared))
                best = {};
            else if (is_converged(parts, best, whole(facts), p))
                settled = cell_of(facts, turned(best.uv, facts));
        }
        bool is_from_cell = false;
        const auto look_into = [&](std::size_t i) {
            const double beyond = std::max(cells.boxes[i].distance_squared(p), cells.oriented[i].distance_squared(p));
            if (i == settled || beyond >= best.distance_squared || best.distance_squared <= rounding_squared)
                return std::max(beyond, best.distance_squared);
            const Cell& cell = cells.cells[i];
            const Parameters middle{0.5 * (cell.low[0] + cell.high[0]), 0.5 * (cell.low[1] + cell.high[1])};
            const OnSurface here = nearest_within(parts, face, middle, cell, p);
            if (here.distance_squared < best.distance_squared) {
                best = here;
                is_from_cell = true;
            }
            return here.distance_squared;
        };
        if (best.distance_squared > rounding_squared) (void)cells.tree.nearest(p, look_into, best.distance_squared);
        if (is_from_cell) best = nearest_within(parts, face, best.uv, whole(facts), p);
    }
    best.uv = turned(best.uv, facts);
    return best;
}

struct OnEdge {
    std::size_t edge = 0;
    CadFoot foot;
};

std::optional<OnEdge> nearest_edge(const CadModel& model, std::size_t face, const Vec<3>& p) {
    const CadParts& parts = model.parts();
    std::optional<OnEdge> best;
    for (const std::size_t edge : parts.kernel->faces[face].edges) {
        if (best && parts.edges[edge].reach.distance_squared(p) > best->foot.distance * best->foot.distance) continue;
        const CadFoot foot = closest_on_edge(model, edge, p);
        if (!best || foot.distance < best->foot.distance) best = OnEdge{edge, foot};
    }
    return best;
}

CadFoot foot_of(const CadModel& model, std::size_t face, const OnSurface& found, const Vec<3>& p) {
    const double distance = std::sqrt(found.distance_squared);
    const bool is_present = distance <= 4 * rounding(model.parts(), p);
    return {is_present ? p : found.point(), point_on_face(model, face, found.uv).normal, found.uv,
            is_present ? 0 : distance};
}

/// True if `found`, the closest point of the surface, is also the closest point of the face: it is on the face, or an
/// edge is as near. Edges are tested before OpenCASCADE, which is slowest for points on edges.
bool is_on_face(const CadModel& model, std::size_t face, const OnSurface& found, const Vec<3>& p) {
    const CadParts& parts = model.parts();
    if (const auto known = parts.kernel->has_if_known(face, found.uv[0], found.uv[1])) return *known;
    const auto is_as_near = [&](std::size_t edge) {
        return parts.edges[edge].reach.distance_squared(p) <= found.distance_squared &&
               closest_on_edge(model, edge, p).distance <= std::sqrt(found.distance_squared);
    };
    const auto& edges = parts.kernel->faces[face].edges;
    return std::any_of(edges.begin(), edges.end(), is_as_near) || parts.kernel->has(face, found.uv[0], found.uv[1]);
}

/// Closest point of a face. `edge`: the edge that contains this point, if the closest point of the untrimmed surface is
/// outside the face.
struct OnFace {
    CadFoot foot;
    std::optional<std::size_t> edge;
    double on_edge = 0;  ///< parameter of the point on `edge`
};

OnFace closest(const CadModel& model, std::size_t face, const Vec<3>& p, const Parameters* near) {
    const CadParts& parts = model.parts();
    const OnSurface found = nearest(parts, face, p, near);
    if (is_on_face(model, face, found, p)) return {foot_of(model, face, found, p), {}};
    const auto edge = nearest_edge(model, face, p);
    // A point on an edge may be off the face by rounding; the surface is then as near as the edge.
    if (!edge || edge->foot.distance <= std::sqrt(found.distance_squared)) return {foot_of(model, face, found, p), {}};
    const OnSurface below = nearest(parts, face, edge->foot.point, near);
    return {{edge->foot.point, point_on_face(model, face, below.uv).normal, below.uv, edge->foot.distance},
            edge->edge,
            edge->foot.parameters[0]};
}

}  // namespace

CadFoot closest_on_face(const CadModel& model, std::size_t face, const Vec<3>& p) {
    return closest(model, face, p, nullptr).foot;
}

CadFoot closest_on_face(const CadModel& model, std::size_t face, const Vec<3>& p, const Parameters& near) {
    return closest(model, face, p, &near).foot;
}

FaceDistances::FaceDistances(const CadModel& model, std::size_t face, const Parameters* start)
    : model_(&model), face_(face) {
    if (start == nullptr) return;
    last_ = place_at({}, clamped(*start, whole(model.parts().kernel->faces[face])));
    last_->from = vec(last_->jet.point);
}

FaceDistances::Place FaceDistances::place_at(const Vec<3>& from, const Parameters& uv) const {
    return {from, uv, model_->parts().kernel->on_surface(face_, uv[0], uv[1])};
}

void FaceDistances::set_start(const Vec<3>& p) {
    if (!first_of_row_ || !(norm_squared(first_of_row_->from - p) < norm_squared(last_->from - p))) return;
    last_ = first_of_row_;
    first_of_row_.reset();  // `remember` stores p as the first point of a row
}

void FaceDistances::remember(const Place& place) {
    last_ = place;
    if (!first_of_row_) first_of_row_ = last_;
}

double FaceDistances::distance(const Vec<3>& p) {
    set_start(p);
    const CadFoot foot = closest(*model_, face_, p, last_ ? &last_->uv : nullptr).foot;
    remember(place_at(p, foot.parameters));
    return foot.distance;
}

/// True if the face is within the distance `bound` of p. The surface point at `uv` is within this distance, but may be
/// outside the face. Edges are tested first, because OpenCASCADE is slower.
bool FaceDistances::is_face_within(double bound, const Vec<3>& p, const std::array<double, 2>& uv) {
    const occ::Kernel& kernel = *model_->parts().kernel;
    const Parameters own = turned(uv, kernel.faces[face_]);
    if (const auto known = kernel.has_if_known(face_, own[0], own[1])) return *known;
    return is_edge_within(bound, p) || kernel.has(face_, own[0], own[1]);
}

bool FaceDistances::is_surface_within(double bound, const Vec<3>& p) {
    constexpr int max_steps = 3;
    const CadParts& parts = model_->parts();
    const occ::FaceFacts& facts = parts.kernel->faces[face_];
    if (facts.has_closed_form) {
        const ClosedFoot foot = closed_foot(facts.form, p);
        return foot.distance <= bound && is_face_within(bound, p, foot.uv);
    }
    if (!last_) return false;
    set_start(p);
    OnSurface here{last_->uv, last_->jet, norm_squared(vec(last_->jet.point) - p)};
    const Cell within = whole(facts);
    for (int n = 0; n < max_steps; ++n) {
        const Parameters change = step(here, within, p).change;
        if (!std::isfinite(change[0]) || !std::isfinite(change[1])) break;
        here = at(parts, face_, clamped({here.uv[0] + change[0], here.uv[1] + change[1]}, within), p);
        if (here.distance_squared > bound * bound) continue;
        if (!is_face_within(bound, p, here.uv)) return false;
        remember({p, here.uv, here.jet});
        return true;
    }
    return false;
}

bool FaceDistances::is_edge_within(double bound, const Vec<3>& p) {
    if (edge_ && search_edge_within(bound, p)) return true;
    const CadParts& parts = model_->parts();
    double least = std::numeric_limits<double>::infinity();
    for (const std::size_t edge : parts.kernel->faces[face_].edges) {
        const EntityCells& cells = parts.edges[edge];
        const auto piece =
            cells.tree.nearest(p, [&](std::size_t i) { return cells.boxes[i].distance_squared(p); }, least);
        if (!(piece.distance_squared < least)) continue;
        least = piece.distance_squared;
        edge_ = edge;
        on_edge_ = 0.5 * (cells.cells[piece.item].low[0] + cells.cells[piece.item].high[0]);
    }
    return least <= bound * bound && search_edge_within(bound, p);
}

bool FaceDistances::search_edge_within(double bound, const Vec<3>& p) {
    constexpr int max_steps = 4;
    const occ::EdgeFacts& facts = model_->parts().kernel->edges[*edge_];
    for (int n = 0; n < max_steps; ++n) {
        const occ::CurveJet jet = model_->parts().kernel->on_curve(*edge_, on_edge_);
        const Vec<3> r = vec(jet.point) - p, first = vec(jet.first);
        if (norm_squared(r) <= bound * bound) return true;
        const double t = std::clamp(on_edge_ - dot(r, first) / norm_squared(first), facts.first, facts.last);
        if (!std::isfinite(t)) break;
        on_edge_ = t;
    }
    return false;
}

std::optional<double> FaceDistances::distance_beyond(double bound, const Vec<3>& p) {
    const double most = std::max(bound, 4 * rounding(model_->parts(), p));
    if (is_surface_within(most, p) || is_edge_within(most, p)) return std::nullopt;
    ++searches_;
    const OnFace found = closest(*model_, face_, p, nullptr);
    remember(place_at(p, found.foot.parameters));
    if (found.edge) {
        edge_ = found.edge;
        on_edge_ = found.on_edge;
    }
    if (found.foot.distance > bound) return found.foot.distance;
    return std::nullopt;
}

EntityPoint<3> point_on_face(const CadModel& model, std::size_t face, const std::array<double, 2>& uv) {
    constexpr double negligible = 1e-9;
    const occ::FaceFacts& facts = model.parts().kernel->faces[face];
    const occ::SurfaceJet jet = model.parts().kernel->on_surface(face, uv[0], uv[1]);
    const Vec<3> u = vec(jet.u), v = vec(jet.v);
    Vec<3> along_u = u, along_v = v;
    // At a pole the derivative around the pole vanishes. Slightly inside the face, that derivative has the direction of
    // the mixed derivative.
    const auto inwards = [&](std::size_t k) { return uv[k] < 0.5 * (facts.low[k] + facts.high[k]) ? 1.0 : -1.0; };
    const auto reach = [&](std::size_t k) { return facts.high[k] - facts.low[k]; };
    if (norm(u) * reach(0) <= negligible * norm(v) * reach(1)) along_u = inwards(1) * vec(jet.uv);
    if (norm(v) * reach(1) <= negligible * norm(u) * reach(0)) along_v = inwards(0) * vec(jet.uv);
    const Vec<3> normal = normalised(cross(along_u, along_v));
    return {vec(jet.point), {u, v}, facts.is_reversed ? -normal : normal};
}

namespace {

struct OnCurve {
    double t = 0;
    occ::CurveJet jet{};
    double distance_squared = std::numeric_limits<double>::infinity();

    [[nodiscard]] Vec<3> point() const { return vec(jet.point); }
};

OnCurve point_on_curve(const CadParts& parts, std::size_t edge, double t, const Vec<3>& p) {
    const occ::CurveJet jet = parts.kernel->on_curve(edge, t);
    return {t, jet, norm_squared(vec(jet.point) - p)};
}

/// Solves (c(t) − p) · c'(t) = 0 for the edge's curve c and t from `low` to `high`. Uses Newton's method, or the
/// Gauss-Newton method where |c − p|² is not convex.
OnCurve nearest_between(const CadParts& parts, std::size_t edge, double low, double high, const Vec<3>& p) {
    constexpr int max_steps = 30;
    const double tiny = rounding(parts, p);
    OnCurve best = point_on_curve(parts, edge, 0.5 * (low + high), p);
    for (int step = 0; step < max_steps; ++step) {
        const Vec<3> r = best.point() - p, first = vec(best.jet.first);
        const double gauss = dot(first, first), slope = dot(r, first);
        if (!(gauss > 0)) break;
        const double whole = gauss + dot(r, vec(best.jet.second));
        const double change = -slope / (whole > 0.1 * gauss ? whole : gauss);
        double t = std::clamp(best.t + change, low, high);
        OnCurve next = point_on_curve(parts, edge, t, p);
        // An increase within rounding is accepted: squared distances do not show changes of t below the square root of
        // rounding.
        const double most = best.distance_squared * (1 + 1e-13) + tiny * tiny;
        for (int halving = 0; halving < 6 && next.distance_squared > most; ++halving) {
            t = 0.5 * (t + best.t);
            next = point_on_curve(parts, edge, t, p);
        }
        if (next.distance_squared > most) break;
        const double moved = std::abs(t - best.t) * std::sqrt(gauss);
        best = next;
        if (moved <= tiny) break;
    }
    return best;
}

OnCurve nearest_on_curve(const CadParts& parts, std::size_t edge, const Vec<3>& p) {
    const EntityCells& cells = parts.edges[edge];
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
    const OnCurve found = nearest_on_curve(parts, edge, p);
    const double distance = std::sqrt(found.distance_squared);
    if (distance <= 4 * rounding(parts, p)) return {p, {}, {found.t, 0}, 0};
    return {found.point(), {}, {found.t, 0}, distance};
}

EntityPoint<3> point_on_edge(const CadModel& model, std::size_t edge, double t) {
    const occ::CurveJet jet = model.parts().kernel->on_curve(edge, t);
    return {vec(jet.point), {vec(jet.first), {}}, {}};
}

}  // namespace camber
