module;
#include <algorithm>
#include <array>
#include <cstddef>
export module camber.metric:edge_pack_location;
import camber.core;
import :edge_pack_objective;
import :edge_wedge;
import :element_frame;
import :packs;
import :quadrature;
import :straight_back;

namespace camber {

/// Where a parabola leaves the elements around its chord, its points are located: eight walks at a time, each from
/// where that point was before.

/// The points of a rule along eight edges: in which elements they lie.
inline constexpr std::size_t most_points = 12;
using PointElements = std::array<std::array<ElementId, pack_size>, most_points>;

/// The coordinates of a point in an element, as Frame has them.
template <int D>
struct CoordinatesPack {
    std::array<VecPack<D>, D + 1> gradient;
    std::array<Pack, D + 1> u{};
    Pack tolerance{};
};

template <int D>
[[nodiscard, gnu::always_inline]] inline CoordinatesPack<D> coordinates_in(
    const StraightBack<D>& back, const std::array<ElementId, pack_size>& elements, const VecPack<D>& x) {
    CoordinatesPack<D> c;
    std::array<VecPack<D>, D + 1> corner;
    for (int lane = 0; lane < pack_size; ++lane) {
        const auto& v = back.mesh.elements.vertices[elements[lane]];
        for (int i = 0; i <= D; ++i) put(corner[i], lane, back.mesh.points[v[i]]);
    }
    MatPack<D> sides;
    Pack lengths_squared = packed(1);
    for (int n = 0; n < D; ++n) {
        for (int i = 0; i < D; ++i) sides(i, n) = corner[n + 1][i] - corner[0][i];
        lengths_squared *= dot(sides.column[n], sides.column[n]);
    }
    if constexpr (D == 2) {
        c.gradient[1] = {{sides(1, 1), -sides(0, 1)}};
        c.gradient[2] = {{-sides(1, 0), sides(0, 0)}};
    } else {
        c.gradient[1] = cross(sides.column[1], sides.column[2]);
        c.gradient[2] = cross(sides.column[2], sides.column[0]);
        c.gradient[3] = cross(sides.column[0], sides.column[1]);
    }
    const Pack determinant = dot(c.gradient[1], sides.column[0]);
    const Pack condition = lengths_squared / (determinant * determinant);
    const Pack scale = 1 / determinant;
    VecPack<D> from;
    for (int i = 0; i < D; ++i) {
        from[i] = x[i] - corner[0][i];
        c.gradient[0][i] = packed(0);
        for (int n = 1; n <= D; ++n) {
            c.gradient[n][i] *= scale;
            c.gradient[0][i] -= c.gradient[n][i];
        }
    }
    c.u[0] = packed(1);
    for (int n = 1; n <= D; ++n) {
        c.u[n] = dot(c.gradient[n], from);
        c.u[0] -= c.u[n];
    }
    c.tolerance = select(condition < 1e4, packed(1e-12), min(1e-14 * sqrt(condition), packed(1e-4)));
    const Mask slim = ~(condition < 1e8);
    if (any(slim))
        for (int lane = 0; lane < pack_size; ++lane) {
            if (slim[lane] == 0) continue;
            const Frame<D> frame(back.mesh, elements[lane]);
            Vec<D> p;
            for (int i = 0; i < D; ++i) p[i] = x[i][lane];
            const auto u = frame.barycentrics(p);
            for (int n = 0; n <= D; ++n) {
                put(c.gradient[n], lane, frame.gradient[n]);
                c.u[n][lane] = u[n];
            }
            c.tolerance[lane] = frame.tolerance();
        }
    return c;
}

/// What walks met: lanes whose place was not found, lanes beyond the boundary.
struct WalkMarks {
    Mask lost{}, outside{};
};

/// Coordinates of the place that stands for a point; the normal of the boundary where that is not the point itself.
template <int D>
struct LocatedPack {
    CoordinatesPack<D> at;
    VecPack<D> normal;
};

/// By walks from `elements`. A walk that comes to the boundary goes on along it: to the point's foot on that face.
template <int D>
[[nodiscard, gnu::always_inline]] inline LocatedPack<D> located(const StraightBack<D>& back,
                                                                std::array<ElementId, pack_size>& elements,
                                                                VecPack<D> x, WalkMarks& marks) {
    LocatedPack<D> out{coordinates_in(back, elements, x), {}};
    for (int step = 0;; ++step) {
        Pack least = out.at.u[0];
        for (int n = 1; n <= D; ++n) least = min(least, out.at.u[n]);
        const Mask open = ~marks.lost & ~(least >= -out.at.tolerance);
        if (!any(open)) return out;
        if (step == 64) {
            marks.lost |= open;
            return out;
        }
        for (int lane = 0; lane < pack_size; ++lane) {
            if (open[lane] == 0) continue;
            int lowest = 0;
            for (int n = 1; n <= D; ++n)
                if (out.at.u[n][lane] < out.at.u[lowest][lane]) lowest = n;
            const ElementId next = back.neighbours[elements[lane].index()][lowest];
            if (next.valid()) {
                elements[lane] = next;
                continue;
            }
            double squared = 0;
            for (int i = 0; i < D; ++i) squared += out.at.gradient[lowest][i][lane] * out.at.gradient[lowest][i][lane];
            for (int i = 0; i < D; ++i) {
                const double normal = out.at.gradient[lowest][i][lane];
                out.normal[i][lane] = normal;
                x[i][lane] -= out.at.u[lowest][lane] / squared * normal;
            }
            marks.outside[lane] = -1;
        }
        out.at = coordinates_in(back, elements, x);
    }
}

/// log M at the corners of elements, less that at the first.
template <int D>
struct CornerLogs {
    SymPack<D> first;
    std::array<SymPack<D>, D> change;
};
template <int D>
[[nodiscard, gnu::always_inline]] inline CornerLogs<D> corner_logs(const StraightBack<D>& back,
                                                                   const std::array<ElementId, pack_size>& elements) {
    CornerLogs<D> logs;
    for (int lane = 0; lane < pack_size; ++lane) {
        const auto& v = back.mesh.elements.vertices[elements[lane]];
        put(logs.first, lane, back.log_metrics[v[0]].l);
        for (int n = 0; n < D; ++n) put(logs.change[n], lane, back.log_metrics[v[n + 1]].l);
    }
    for (int n = 0; n < D; ++n)
        for (int k = 0; k < sym_size<D>; ++k) logs.change[n].c[k] -= logs.first.c[k];
    return logs;
}
template <int D>
[[nodiscard, gnu::always_inline]] inline SymPack<D> log_metric_at(const CornerLogs<D>& logs,
                                                                  const CoordinatesPack<D>& at) {
    SymPack<D> l = logs.first;
    for (int n = 0; n < D; ++n)
        for (int k = 0; k < sym_size<D>; ++k) l.c[k] += at.u[n + 1] * logs.change[n].c[k];
    return l;
}

/// The point of the curve at t.
template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> place_at(const ChordFrame<D>& f, const VecPack<D>& offset,
                                                             double t) {
    VecPack<D> along;
    for (int i = 0; i < D; ++i) along[i] = (t - 0.5) * f.chord[i] + (4 * t * (1 - t)) * offset[i];
    VecPack<D> x = times(f.axes, along);
    for (int i = 0; i < D; ++i) x[i] += f.middle[i];
    return x;
}

template <int D>
[[nodiscard, gnu::always_inline]] inline MatPack<D> transposed(const MatPack<D>& m) {
    MatPack<D> t;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) t(i, j) = m(j, i);
    return t;
}

/// ⟨adjoint, ∂ log M⟩ where a point was located. Beyond the boundary the field is constant along the normal.
template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> slope_across(const LocatedPack<D>& place, const CornerLogs<D>& logs,
                                                                 const SymPack<D>& adjoint) {
    VecPack<D> across;
    for (int n = 0; n < D; ++n) {
        const Pack by_n = inner(adjoint, logs.change[n]);
        for (int i = 0; i < D; ++i) across[i] += by_n * place.at.gradient[n + 1][i];
    }
    const Pack squared = dot(place.normal, place.normal);
    const Pack along = select(squared > 0, dot(across, place.normal) / squared, packed(0));
    for (int i = 0; i < D; ++i) across[i] -= along * place.normal[i];
    return across;
}

/// Energy and length with their gradients in the unit frame, each point in its element.
template <int D>
[[nodiscard, gnu::always_inline]] inline EdgeValues<D> located_values(const StraightBack<D>& back,
                                                                      const ChordFrame<D>& f, const VecPack<D>& y,
                                                                      const Quadrature& rule, PointElements& elements,
                                                                      WalkMarks& marks) {
    VecPack<D> offset;
    for (int i = 0; i < D; ++i) offset[i] = f.scale[i] * y[i];
    EdgeValues<D> out{};
    const MatPack<D> back_to_space = transposed(f.axes);
    // Two points at a time, as in each_point.
    for (std::size_t first = 0; first < rule.size(); first += 2) {
        const std::size_t count = std::min<std::size_t>(2, rule.size() - first);
        std::array<LocatedPack<D>, 2> place;
        std::array<CornerLogs<D>, 2> logs;
        std::array<SymPack<D>, 2> log_metric;
        for (std::size_t n = 0; n < count; ++n) {
            const double t = rule.t[first + n];
            place[n] = located(back, elements[first + n], place_at(f, offset, t), marks);
            logs[n] = corner_logs(back, elements[first + n]);
            log_metric[n] = congruence_transposed(f.axes, log_metric_at(logs[n], place[n].at));
            SymPack<D> bulge = log_metric[n];
            for (int k = 0; k < sym_size<D>; ++k) bulge.c[k] -= f.log_metric.c[k] + t * f.change.c[k];
            out.bulge = max(out.bulge, inner(bulge, bulge));
        }
        if (count == 1) log_metric[1] = log_metric[0];
        const auto systems = log_eigen_systems<D, 2>(log_metric);
        for (std::size_t n = 0; n < count; ++n) {
            const double t = rule.t[first + n];
            const double w = rule.w[first + n];
            const PointPack<D> point = measured_point(f, systems[n], offset, t);
            VecPack<D> moved;
            for (int i = 0; i < D; ++i) moved[i] = point.values[i] * point.velocity[i];
            moved = times(point.log_metric.vectors, moved);
            const SymPack<D> adjoint = congruence_transposed(back_to_space, adjoint_of(point));
            const VecPack<D> across = in_frame(f, slope_across(place[n], logs[n], adjoint));
            const Pack root = sqrt(point.squared);
            const Pack half = select(root > 0, 0.5 / root, packed(0));
            out.energy += w * point.squared;
            out.length += w * root;
            for (int i = 0; i < D; ++i) {
                const Pack slope = w * ((8 * (1 - 2 * t)) * f.scale[i] * moved[i] + (4 * t * (1 - t)) * across[i]);
                out.energy_gradient[i] += slope;
                out.length_gradient[i] += half * slope;
            }
        }
    }
    return out;
}

/// Energy and length alone; elements(q) holds where the walk to a point begins, and then where it ended.
template <int D, class Elements>
[[nodiscard, gnu::always_inline]] inline EdgeValues<D> located_lengths(const StraightBack<D>& back,
                                                                       const ChordFrame<D>& f, const VecPack<D>& y,
                                                                       const Quadrature& rule, const Elements& elements,
                                                                       WalkMarks& marks) {
    VecPack<D> offset;
    for (int i = 0; i < D; ++i) offset[i] = f.scale[i] * y[i];
    EdgeValues<D> out{};
    for (std::size_t q = 0; q < rule.size(); ++q) {
        std::array<ElementId, pack_size>& within = elements(q);
        const LocatedPack<D> found = located(back, within, place_at(f, offset, rule.t[q]), marks);
        const SymPack<D> log_metric = log_metric_at(corner_logs(back, within), found.at);
        const Pack squared = decomposed(f, congruence_transposed(f.axes, log_metric), offset, rule.t[q]).squared;
        out.energy += rule.w[q] * squared;
        out.length += rule.w[q] * sqrt(squared);
    }
    return out;
}

}  // namespace camber
