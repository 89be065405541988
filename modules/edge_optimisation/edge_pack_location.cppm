module;
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
module camber.edge_optimisation:edge_pack_location;
import camber.core;
import camber.metric;
import :edge_pack_objective;

namespace camber {

/// Location of points of parabolas outside the elements around their chord: eight walks at a time, from each point's
/// last element.

inline constexpr std::size_t max_points = 12;

/// One element per lane with its data, reused between evaluations.
template <int D>
struct ElementsPack {
    std::array<ElementId, pack_size> element{};
    std::array<VecPack<D>, D + 1> corner{};
    SymPack<D> log_metric{};
    std::array<SymPack<D>, D> change{};
    std::array<VecPack<D>, D + 1> slope{};  ///< ∇u as in ElementFrame
    Pack tolerance{};
    Mask slim{};  ///< slim element: ElementFrame computes the coordinates
};
template <int D>
using PointElements = std::array<ElementsPack<D>, max_points>;

template <int D>
[[gnu::always_inline]] inline void measure(const StraightBack<D>& back, ElementsPack<D>& e) {
    MatPack<D> sides;
    Pack lengths_squared = packed(1);
    for (int n = 0; n < D; ++n) {
        for (int i = 0; i < D; ++i) sides(i, n) = e.corner[n + 1][i] - e.corner[0][i];
        lengths_squared *= dot(sides.column[n], sides.column[n]);
    }
    if constexpr (D == 2) {
        e.slope[1] = {{sides(1, 1), -sides(0, 1)}};
        e.slope[2] = {{-sides(1, 0), sides(0, 0)}};
    } else {
        e.slope[1] = cross(sides.column[1], sides.column[2]);
        e.slope[2] = cross(sides.column[2], sides.column[0]);
        e.slope[3] = cross(sides.column[0], sides.column[1]);
    }
    const Pack determinant = dot(e.slope[1], sides.column[0]);
    const Pack condition = lengths_squared / (determinant * determinant);
    const Pack scale = 1 / determinant;
    for (int i = 0; i < D; ++i) {
        e.slope[0][i] = packed(0);
        for (int n = 1; n <= D; ++n) {
            e.slope[n][i] *= scale;
            e.slope[0][i] -= e.slope[n][i];
        }
    }
    e.tolerance = select(condition < 1e4, packed(1e-12), min(1e-14 * sqrt(condition), packed(1e-4)));
    e.slim = ~(condition < 1e8);
    if (!any(e.slim)) return;
    for (int lane = 0; lane < pack_size; ++lane) {
        if (e.slim[lane] == 0) continue;
        const ElementFrame<D> frame(back.mesh, e.element[lane]);
        for (int n = 0; n <= D; ++n) put(e.slope[n], lane, frame.gradient[n]);
        e.tolerance[lane] = frame.tolerance();
    }
}

template <class Use>
[[gnu::always_inline]] inline void each_lane(Mask mask, const Use& use) {
    using Flags = bool __attribute__((ext_vector_type(8)));
    for (unsigned bits = __builtin_bit_cast(std::uint8_t, __builtin_convertvector(mask, Flags)); bits != 0;
         bits &= bits - 1)
        use(std::countr_zero(bits));
}

[[nodiscard, gnu::always_inline]] inline std::size_t count_of(Mask mask) {
    std::size_t n = 0;
    for (int lane = 0; lane < pack_size; ++lane) n += mask[lane] != 0;
    return n;
}

/// Sets the element of a lane; `measure` must follow.
template <int D>
[[gnu::always_inline]] inline void read_corners(const StraightBack<D>& back, ElementsPack<D>& e, int lane) {
    const auto& v = back.mesh.elements.vertices[e.element[lane]];
    for (int n = 0; n <= D; ++n) put(e.corner[n], lane, back.mesh.points[v[n]]);
}
template <int D>
[[gnu::always_inline]] inline void read_logs(const StraightBack<D>& back, ElementsPack<D>& e, Mask lanes) {
    each_lane(lanes, [&](int lane) __attribute__((always_inline)) {
        const auto& v = back.mesh.elements.vertices[e.element[lane]];
        const Sym<D>& first = back.log_metrics[v[0]].l;
        put(e.log_metric, lane, first);
        for (int n = 0; n < D; ++n) {
            const Sym<D>& other = back.log_metrics[v[n + 1]].l;
            for (int k = 0; k < sym_size<D>; ++k) e.change[n].c[k][lane] = other.c[k] - first.c[k];
        }
    });
}

template <int D>
[[nodiscard, gnu::always_inline]] inline ElementsPack<D> entered(const StraightBack<D>& back,
                                                                 const std::array<ElementId, pack_size>& elements) {
    ElementsPack<D> e{.element = elements};
    for (int lane = 0; lane < pack_size; ++lane) read_corners(back, e, lane);
    measure(back, e);
    read_logs(back, e, Mask(-1));
    return e;
}
template <int D>
[[gnu::always_inline]] inline void enter_lanes(const StraightBack<D>& back, ElementsPack<D>& e,
                                               const std::array<ElementId, pack_size>& elements, Mask lanes) {
    each_lane(lanes, [&](int lane) __attribute__((always_inline)) {
        e.element[lane] = elements[lane];
        read_corners(back, e, lane);
    });
    measure(back, e);
    read_logs(back, e, lanes);
}
template <int D>
[[gnu::always_inline]] inline void choose(Mask mask, ElementsPack<D>& to, const ElementsPack<D>& from) {
    each_lane(mask, [&](int lane) __attribute__((always_inline)) { to.element[lane] = from.element[lane]; });
    choose(mask, to.log_metric, from.log_metric);
    for (int n = 0; n < D; ++n) choose(mask, to.change[n], from.change[n]);
    for (int n = 0; n <= D; ++n) {
        choose(mask, to.corner[n], from.corner[n]);
        choose(mask, to.slope[n], from.slope[n]);
    }
    to.tolerance = select(mask, from.tolerance, to.tolerance);
    to.slim = mask ? from.slim : to.slim;
}

template <int D>
[[nodiscard, gnu::always_inline]] inline std::array<Pack, D + 1> coordinates_in(const StraightBack<D>& back,
                                                                                const ElementsPack<D>& e,
                                                                                const VecPack<D>& x) {
    std::array<Pack, D + 1> u;  // NOLINT(*-pro-type-member-init): filled right after
    VecPack<D> from;
    for (int i = 0; i < D; ++i) from[i] = x[i] - e.corner[0][i];
    u[0] = packed(1);
    for (int n = 1; n <= D; ++n) {
        u[n] = dot(e.slope[n], from);
        u[0] -= u[n];
    }
    if (!any(e.slim)) return u;
    for (int lane = 0; lane < pack_size; ++lane) {
        if (e.slim[lane] == 0) continue;
        Vec<D> p;
        for (int i = 0; i < D; ++i) p[i] = x[i][lane];
        const auto by_frame = ElementFrame<D>(back.mesh, e.element[lane]).barycentrics(p);
        for (int n = 0; n <= D; ++n) u[n][lane] = by_frame[n];
    }
    return u;
}

/// Marks of lanes with a point that was not located, and of lanes with a point outside the boundary.
struct WalkMarks {
    Mask lost{}, outside{};
};

/// Coordinates of points in their elements. For points outside the boundary: coordinates of their projections onto it,
/// and the normal there.
template <int D>
struct LocatedPack {
    std::array<Pack, D + 1> u{};
    VecPack<D> normal;
};

struct LaneFace {
    int lane, opposite;
};

template <int D>
[[gnu::always_inline]] inline void cross_face(const StraightBack<D>& back, LaneFace face, ElementsPack<D>& elements,
                                              VecPack<D>& x, LocatedPack<D>& place, WalkMarks& marks) {
    const auto [lane, lowest] = face;
    const ElementId next = back.neighbours[elements.element[lane].index()][lowest];
    if (next.valid()) {
        elements.element[lane] = next;
        return;
    }
    const VecPack<D>& slope = elements.slope[lowest];
    double squared = 0;
    for (int i = 0; i < D; ++i) squared += slope[i][lane] * slope[i][lane];
    const double height = place.u[lowest][lane];
    for (int i = 0; i < D; ++i) {
        place.normal[i][lane] = slope[i][lane];
        x[i][lane] -= height / squared * slope[i][lane];
    }
    marks.outside[lane] = -1;
}

/// Walks from `elements` to the points x, in lanes that are not lost; a walk that meets the boundary follows it. All
/// points walk together, which hides memory latency.
template <int D>
[[gnu::always_inline]] inline void locate(const StraightBack<D>& back, std::span<ElementsPack<D>> elements,
                                          std::span<VecPack<D>> x, std::span<LocatedPack<D>> places, WalkMarks& marks) {
    std::array<Mask, max_points> moved{};
    std::array<Mask, max_points> open{};
    for (std::size_t q = 0; q < x.size(); ++q) {
        places[q] = {coordinates_in(back, elements[q], x[q]), {}};
        open[q] = Mask(-1);
    }
    for (int step = 0; step <= 64; ++step) {
        Mask walking{};
        for (std::size_t q = 0; q < x.size(); ++q) {
            if (!any(open[q])) continue;
            Pack least = places[q].u[0];
            Mask lowest{};
            for (int n = 1; n <= D; ++n) {
                lowest = places[q].u[n] < least ? Mask(n) : lowest;
                least = min(places[q].u[n], least);
            }
            open[q] = ~marks.lost & ~(least >= -elements[q].tolerance);
            walking |= open[q];
            if (step == 64) continue;
            each_lane(open[q], [&](int lane) __attribute__((always_inline)) {
                cross_face(back, {lane, static_cast<int>(lowest[lane])}, elements[q], x[q], places[q], marks);
                read_corners(back, elements[q], lane);
            });
        }
        if (!any(walking)) break;
        if (step == 64) {
            marks.lost |= walking;
            break;
        }
        for (std::size_t q = 0; q < x.size(); ++q) {
            if (!any(open[q])) continue;
            moved[q] |= open[q];
            measure(back, elements[q]);
            places[q].u = coordinates_in(back, elements[q], x[q]);
        }
    }
    for (std::size_t q = 0; q < x.size(); ++q) read_logs(back, elements[q], moved[q]);
}

template <int D>
[[nodiscard, gnu::always_inline]] inline SymPack<D> log_metric_at(const ElementsPack<D>& e,
                                                                  const std::array<Pack, D + 1>& u) {
    SymPack<D> l = e.log_metric;
    for (int n = 0; n < D; ++n)
        for (int k = 0; k < sym_size<D>; ++k) l.c[k] += u[n + 1] * e.change[n].c[k];
    return l;
}

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

/// Outside the boundary the field is constant along the normal.
template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> slope_across(const ElementsPack<D>& elements,
                                                                 const VecPack<D>& normal, const SymPack<D>& adjoint) {
    VecPack<D> across;
    for (int n = 0; n < D; ++n) {
        const Pack by_n = inner(adjoint, elements.change[n]);
        for (int i = 0; i < D; ++i) across[i] += by_n * elements.slope[n + 1][i];
    }
    const Pack squared = dot(normal, normal);
    const Pack along = select(squared > 0, dot(across, normal) / squared, packed(0));
    for (int i = 0; i < D; ++i) across[i] -= along * normal[i];
    return across;
}

template <int D>
struct CurvePack {
    const ChordFrame<D>& frame;
    const VecPack<D>& y;

    [[nodiscard, gnu::always_inline]] inline VecPack<D> offset() const {
        VecPack<D> out;
        for (int i = 0; i < D; ++i) out[i] = frame.scale[i] * y[i];
        return out;
    }
};

/// Evaluates the parabolas at located points; gradients are in the unit frame. Calls use(q, point, slope) for point q
/// of the rule. `slope`: gradient of the point's weight times l'ᵀ M l'.
template <int D, class Use>
[[nodiscard, gnu::always_inline]] inline EdgeValues<D> located_values(const StraightBack<D>& back,
                                                                      const CurvePack<D>& curve, const Quadrature& rule,
                                                                      PointElements<D>& elements, WalkMarks& marks,
                                                                      const Use& use) {
    const ChordFrame<D>& f = curve.frame;
    const VecPack<D> offset = curve.offset();
    EdgeValues<D> out{};
    const MatPack<D> back_to_space = transposed(f.axes);
    std::array<VecPack<D>, max_points> x;
    std::array<LocatedPack<D>, max_points> places;
    for (std::size_t q = 0; q < rule.size(); ++q) x[q] = place_at(f, offset, rule.t[q]);
    locate<D>(back, std::span(elements).first(rule.size()), std::span(x).first(rule.size()), places, marks);
    // Two points at a time, see each_point.
    for (std::size_t first = 0; first < rule.size(); first += 2) {
        const std::size_t count = std::min<std::size_t>(2, rule.size() - first);
        std::array<SymPack<D>, 2> log_metric;
        for (std::size_t n = 0; n < count; ++n) {
            const double t = rule.t[first + n];
            log_metric[n] = congruence_transposed(f.axes, log_metric_at<D>(elements[first + n], places[first + n].u));
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
            const VecPack<D> across = in_frame(f, slope_across(elements[first + n], places[first + n].normal, adjoint));
            const Pack root = sqrt(point.squared);
            const Pack half = select(root > 0, 0.5 / root, packed(0));
            out.energy += w * point.squared;
            out.length += w * root;
            VecPack<D> slope;
            for (int i = 0; i < D; ++i) {
                slope[i] = w * ((8 * (1 - 2 * t)) * f.scale[i] * moved[i] + (4 * t * (1 - t)) * across[i]);
                out.energy_gradient[i] += slope[i];
                out.length_gradient[i] += half * slope[i];
            }
            use(first + n, point, slope);
        }
    }
    return out;
}

template <int D>
[[nodiscard, gnu::always_inline]] inline EdgeValues<D> located_values(const StraightBack<D>& back,
                                                                      const CurvePack<D>& curve, const Quadrature& rule,
                                                                      PointElements<D>& elements, WalkMarks& marks) {
    return located_values(back, curve, rule, elements, marks,
                          [](std::size_t, const PointPack<D>&, const VecPack<D>&) __attribute__((always_inline)) {});
}

/// Computes lengths of parabolas at located points. `elements`: first elements of the walks; after the call, their last
/// elements.
template <int D>
[[nodiscard, gnu::always_inline]] inline EdgeValues<D> located_lengths(const StraightBack<D>& back,
                                                                       const CurvePack<D>& curve,
                                                                       const Quadrature& rule,
                                                                       ElementsPack<D>& elements, WalkMarks& marks) {
    const ChordFrame<D>& f = curve.frame;
    const VecPack<D> offset = curve.offset();
    EdgeValues<D> out{};
    for (std::size_t q = 0; q < rule.size(); ++q) {
        VecPack<D> x = place_at(f, offset, rule.t[q]);
        LocatedPack<D> found;
        locate<D>(back, {&elements, 1}, {&x, 1}, {&found, 1}, marks);
        const SymPack<D> log_metric = log_metric_at<D>(elements, found.u);
        const Pack squared = decomposed(f, congruence_transposed(f.axes, log_metric), offset, rule.t[q]).squared;
        out.energy += rule.w[q] * squared;
        out.length += rule.w[q] * sqrt(squared);
    }
    return out;
}

template <int D>
[[nodiscard, gnu::always_inline]] inline EdgeValues<D> located_lengths_beside(const StraightBack<D>& back,
                                                                              const CurvePack<D>& curve,
                                                                              const Quadrature& rule,
                                                                              PointElements<D>& elements,
                                                                              WalkMarks& marks) {
    const ChordFrame<D>& f = curve.frame;
    const VecPack<D> offset = curve.offset();
    EdgeValues<D> out{};
    std::array<VecPack<D>, max_points> x;
    std::array<LocatedPack<D>, max_points> places;
    for (std::size_t q = 0; q < rule.size(); ++q) x[q] = place_at(f, offset, rule.t[q]);
    locate<D>(back, std::span(elements).first(rule.size()), std::span(x).first(rule.size()), places, marks);
    for (std::size_t first = 0; first < rule.size(); first += 2) {
        const std::size_t last = std::min(first + 1, rule.size() - 1);
        const auto sampled = [&](std::size_t q) __attribute__((always_inline)) {
            return congruence_transposed(f.axes, log_metric_at<D>(elements[q], places[q].u));
        };
        const auto systems = log_eigen_systems<D, 2>({sampled(first), sampled(last)});
        for (std::size_t q = first; q <= last; ++q) {
            const Pack squared = measured_point(f, systems[q - first], offset, rule.t[q]).squared;
            out.energy += rule.w[q] * squared;
            out.length += rule.w[q] * sqrt(squared);
        }
    }
    return out;
}

}  // namespace camber
