module;
#include <array>
#include <cstddef>
module camber.edge_optimisation:edge_pack_objective;
import camber.core;
import camber.metric;

namespace camber {

/// A shell element is a wedge around the chord. The coordinates of its vertices off the edge are 0 on its walls. While
/// the node's offset o stays in the wedge and changes the end coordinates by at least −1/4, the parabola chord +
/// 4t(1−t) o is in the element. There log M is (1−t) L_a + t L_b + 4t(1−t) Σ (∇u_v·o) L_v, without location or kinks.

template <int D>
struct ShellElementPack {
    std::array<VecPack<D>, D - 1> rise;  ///< gradient of the barycentric coordinate u of each vertex off the edge
    std::array<Pack, D - 1> along{};
    std::array<SymPack<D>, D - 1> change;  ///< for each of these vertices: log M minus its value at a
};

template <int D>
struct ChordPack {
    std::array<VertexId, pack_size> a, b;
    VecPack<D> origin, chord;
    SymPack<D> log_metric, change;  ///< log M at a, and its change from a to b
};

template <int D>
[[gnu::always_inline]] inline void put(VecPack<D>& v, int lane, const Vec<D>& x) {
    for (int i = 0; i < D; ++i) v[i][lane] = x[i];
}
template <int D>
[[gnu::always_inline]] inline void put(SymPack<D>& s, int lane, const Sym<D>& x) {
    for (int k = 0; k < sym_size<D>; ++k) s.c[k][lane] = x.c[k];
}

template <int D>
[[nodiscard, gnu::always_inline]] inline ChordPack<D> chords_of(const StraightBack<D>& back,
                                                                const std::array<VertexId, pack_size>& a,
                                                                const std::array<VertexId, pack_size>& b) {
    ChordPack<D> c{a, b, {}, {}, {}, {}};
    for (int lane = 0; lane < pack_size; ++lane) {
        put(c.origin, lane, back.mesh.points[a[lane]]);
        put(c.chord, lane, back.mesh.points[b[lane]]);
        put(c.log_metric, lane, back.log_metrics[a[lane]].l);
        put(c.change, lane, back.log_metrics[b[lane]].l);
    }
    for (int i = 0; i < D; ++i) c.chord[i] -= c.origin[i];
    for (int k = 0; k < sym_size<D>; ++k) c.change.c[k] -= c.log_metric.c[k];
    return c;
}

[[nodiscard, gnu::always_inline]] inline VecPack<3> cross(const VecPack<3>& a, const VecPack<3>& b) {
    return {{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}};
}

/// Computes the elements from components across the chord, which is accurate for needles too.
template <int D>
[[nodiscard, gnu::always_inline]] inline ShellElementPack<D> shell_elements(
    const StraightBack<D>& back, const ChordPack<D>& edges, const std::array<ElementId, pack_size>& elements) {
    ShellElementPack<D> w;
    std::array<VecPack<D>, D - 1> across;
    for (int lane = 0; lane < pack_size; ++lane) {
        // Vertices off the edge, found without branches, which would be mispredicted half of the time.
        std::array<VertexId, D + 2> off{};
        std::size_t count = 0;
        for (const VertexId v : back.mesh.elements.vertices[elements[lane]]) {
            off[count] = v;
            count +=
                static_cast<std::size_t>(static_cast<int>(v != edges.a[lane]) & static_cast<int>(v != edges.b[lane]));
        }
        for (int n = 0; n < D - 1; ++n) {
            put(across[n], lane, back.mesh.points[off[n]]);
            put(w.change[n], lane, back.log_metrics[off[n]].l);
        }
    }
    const Pack scale = 1 / dot(edges.chord, edges.chord);
    for (int n = 0; n < D - 1; ++n) {
        for (int k = 0; k < sym_size<D>; ++k) w.change[n].c[k] -= edges.log_metric.c[k];
        for (int i = 0; i < D; ++i) across[n][i] -= edges.origin[i];
        w.along[n] = dot(across[n], edges.chord) * scale;
        for (int i = 0; i < D; ++i) across[n][i] -= w.along[n] * edges.chord[i];
    }
    if constexpr (D == 2) {
        const Pack height = 1 / dot(across[0], across[0]);
        for (int i = 0; i < D; ++i) w.rise[0][i] = across[0][i] * height;
    } else {
        w.rise[0] = cross(across[1], edges.chord);
        w.rise[1] = cross(edges.chord, across[0]);
        const Pack volume = 1 / dot(w.rise[1], across[1]);
        for (int n = 0; n < 2; ++n)
            for (int i = 0; i < D; ++i) w.rise[n][i] *= volume;
    }
    return w;
}

template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> times(const SymPack<D>& a, const VecPack<D>& v) {
    VecPack<D> r;
    for (int i = 0; i < D; ++i) {
        r[i] = a(i, 0) * v[0];
        for (int j = 1; j < D; ++j) r[i] += a(i, j) * v[j];
    }
    return r;
}
template <int D>
[[nodiscard, gnu::always_inline]] inline Pack inner(const SymPack<D>& a, const SymPack<D>& b) {
    Pack diagonal = a(0, 0) * b(0, 0);
    for (int i = 1; i < D; ++i) diagonal += a(i, i) * b(i, i);
    Pack off = a(1, 0) * b(1, 0);
    for (int i = 2; i < D; ++i)
        for (int j = 0; j < i; ++j) off += a(i, j) * b(i, j);
    return diagonal + 2 * off;
}
template <int D>
[[gnu::always_inline]] inline void choose(Mask mask, VecPack<D>& to, const VecPack<D>& from) {
    for (int i = 0; i < D; ++i) to[i] = select(mask, from[i], to[i]);
}
template <int D>
[[gnu::always_inline]] inline void choose(Mask mask, SymPack<D>& to, const SymPack<D>& from) {
    for (int k = 0; k < sym_size<D>; ++k) to.c[k] = select(mask, from.c[k], to.c[k]);
}

/// Step that minimises the model within a cone { y : rise_k·y ≥ 0 }, and the active walls.
template <int D>
struct WallStep {
    VecPack<D> step;
    std::array<Mask, D - 1> active{};
    Pack slope{};
};

/// Minimises gᵀs + ½ sᵀ H s with y + s in the cone.
template <int D>
[[nodiscard, gnu::always_inline]] inline WallStep<D> step_within(const std::array<VecPack<D>, D - 1>& rise,
                                                                 const SymPack<D>& inverse_hessian,
                                                                 const VecPack<D>& gradient, const VecPack<D>& y) {
    WallStep<D> out;
    out.step = times(inverse_hessian, gradient);
    for (int i = 0; i < D; ++i) out.step[i] = -out.step[i];
    std::array<VecPack<D>, D - 1> pushed;
    std::array<Pack, D - 1> height{};
    for (int n = 0; n < D - 1; ++n) {
        pushed[n] = times(inverse_hessian, rise[n]);
        height[n] = dot(rise[n], y) + dot(rise[n], out.step);
    }
    const Pack none = packed(0);
    std::array<Pack, D - 1> pressure{};
    if constexpr (D == 2) {
        out.active[0] = height[0] < 0;
        pressure[0] = select(out.active[0], -height[0] / dot(rise[0], pushed[0]), none);
    } else {
        const Pack h00 = dot(rise[0], pushed[0]);
        const Pack h11 = dot(rise[1], pushed[1]);
        const Pack h01 = dot(rise[0], pushed[1]);
        const Pack onto0 = -height[0] / h00;
        const Pack onto1 = -height[1] / h11;
        const Mask free = (height[0] >= 0) & (height[1] >= 0);
        const Mask on0 = ~free & (height[0] < 0) & (height[1] + onto0 * h01 >= 0);
        const Mask on1 = ~free & ~on0 & (height[1] < 0) & (height[0] + onto1 * h01 >= 0);
        const Mask line = ~free & ~on0 & ~on1;
        const Pack determinant = h00 * h11 - h01 * h01;
        const Pack both0 = (h01 * height[1] - h11 * height[0]) / determinant;
        const Pack both1 = (h01 * height[0] - h00 * height[1]) / determinant;
        pressure[0] = select(on0, onto0, select(line, both0, none));
        pressure[1] = select(on1, onto1, select(line, both1, none));
        out.active[0] = on0 | line;
        out.active[1] = on1 | line;
    }
    for (int n = 0; n < D - 1; ++n)
        for (int i = 0; i < D; ++i) out.step[i] += pressure[n] * pushed[n][i];
    out.slope = dot(gradient, out.step);
    return out;
}

/// Rotates a so that a(p, q) nearly vanishes in `lanes`. The half angle is a rational approximation with the same order
/// of convergence and without a root.
template <int D>
[[gnu::always_inline]] inline void rotate_log(SymPack<D>& a, MatPack<D>& r, int p, int q, Mask lanes) {
    const Pack difference = a(q, q) - a(p, p);
    const Pack twice = 2 * a(p, q);
    const Pack d = abs(difference);
    const Pack o = abs(twice);
    // tan(atan(x)/4), x = o/d, is approximated up to x⁴ by x (1 + αx)/(4 + 4αx + 5x²/4), α = (5/4) tan(π/8).
    constexpr double alpha = 1.25 * 0.41421356237309503;
    const Pack up = o * (d + alpha * o);
    const Pack down = d * (4 * d + 4 * alpha * o) + (1.25 * o * o + 1e-60);
    const Pack unit = 1 / (up * up + down * down);
    const Pack c = select(lanes, (down * down - up * up) * unit, packed(1));
    const Pack s = select(lanes, copysign(2 * up * down * unit, twice * difference), packed(0));
    const Pack moved = s * (s * difference - c * twice);
    a(p, q) = (c * c - s * s) * a(p, q) - c * s * difference;
    a(p, p) += moved;
    a(q, q) -= moved;
    for (int k = 0; k < D; ++k) {
        if (k == p || k == q) continue;
        const Pack akp = a(k, p);
        const Pack akq = a(k, q);
        a(k, p) = c * akp - s * akq;
        a(k, q) = s * akp + c * akq;
    }
    rotate_columns(r, p, q, c, s);
}

/// Computes eigensystems. Off-diagonal entries end below 1e-13 absolutely, because sizes are exponentials of the
/// eigenvalues.
///
/// N matrices are processed together to hide latency; results are bitwise the same as individually.
template <int D, std::size_t N>
[[nodiscard, gnu::always_inline]] inline std::array<EigenPack<D>, N> log_eigen_systems(std::array<SymPack<D>, N> a) {
    std::array<MatPack<D>, N> r;
    r.fill(identity_pack<D>());
    for (int sweep = 0; sweep < 8; ++sweep) {
        std::array<Mask, N> lanes{};
        Mask open{};
        for (std::size_t n = 0; n < N; ++n) {
            Pack off = a[n](1, 0) * a[n](1, 0);
            for (int i = 2; i < D; ++i)
                for (int j = 0; j < i; ++j) off += a[n](i, j) * a[n](i, j);
            lanes[n] = off > 1e-26;
            open |= lanes[n];
        }
        if (!any(open)) break;
#pragma unroll
        for (int p = 0; p < D - 1; ++p)
#pragma unroll
            for (int q = p + 1; q < D; ++q)
#pragma unroll
                for (std::size_t n = 0; n < N; ++n) rotate_log(a[n], r[n], p, q, lanes[n]);
    }
    std::array<EigenPack<D>, N> out;
    for (std::size_t n = 0; n < N; ++n) {
        out[n].vectors = r[n];
        for (int i = 0; i < D; ++i) out[n].values[i] = a[n](i, i);
    }
    return out;
}
template <int D>
[[nodiscard, gnu::always_inline]] inline EigenPack<D> log_eigen_system(const SymPack<D>& a) {
    return log_eigen_systems<D, 1>({a})[0];
}

/// Axes of M at the chord midpoint; offsets are o = axes (scale ∘ y), so that the frozen-metric Hessian of the energy
/// is the identity.
template <int D>
struct ChordFrame {
    VecPack<D> middle;
    MatPack<D> axes;
    VecPack<D> scale;
    VecPack<D> chord;
    SymPack<D> log_metric, change;  ///< log M at a, and its change to b
    VecPack<D> shift;               ///< shift·y is the node's shift along the chord, in chords
};

/// Curvature of the energy: ∫ 2 · 16(1−2t)² dt.
inline constexpr double energy_curvature = 32.0 / 3;

template <int D>
[[nodiscard, gnu::always_inline]] inline ChordFrame<D> chord_frame(const ChordPack<D>& edges) {
    ChordFrame<D> f;
    SymPack<D> middle;
    for (int k = 0; k < sym_size<D>; ++k) middle.c[k] = edges.log_metric.c[k] + 0.5 * edges.change.c[k];
    const EigenPack<D> e = log_eigen_system<D>(middle);
    f.axes = e.vectors;
    f.chord = times_transposed(e.vectors, edges.chord);
    f.log_metric = congruence_transposed(e.vectors, edges.log_metric);
    f.change = congruence_transposed(e.vectors, edges.change);
    const Pack squared = dot(edges.chord, edges.chord);
    const Pack unit = packed(1 / 3.2659863237109041);  // (32/3)^{-1/2}
    for (int i = 0; i < D; ++i) {
        f.middle[i] = edges.origin[i] + 0.5 * edges.chord[i];
        f.scale[i] = unit * exp(-0.5 * e.values[i]);
        f.shift[i] = f.scale[i] * f.chord[i] / squared;
    }
    return f;
}

template <int D>
struct WedgePack {
    std::array<VecPack<D>, D - 1> rise;  ///< derivative ∂u/∂y of the coordinate u of each vertex off the edge
    VecPack<D> rise_b;                   ///< derivative ∂u/∂y of the coordinate of vertex b
    std::array<SymPack<D>, D - 1> change;
};

template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> in_frame(const ChordFrame<D>& f, const VecPack<D>& gradient) {
    VecPack<D> g = times_transposed(f.axes, gradient);
    for (int i = 0; i < D; ++i) g[i] *= f.scale[i];
    return g;
}

template <int D>
[[nodiscard, gnu::always_inline]] inline WedgePack<D> wedge_of(const ChordFrame<D>& f, const ShellElementPack<D>& e) {
    WedgePack<D> w;
    w.rise_b = f.shift;
    for (int n = 0; n < D - 1; ++n) {
        w.rise[n] = in_frame(f, e.rise[n]);
        w.change[n] = congruence_transposed(f.axes, e.change[n]);
        for (int i = 0; i < D; ++i) w.rise_b[i] -= e.along[n] * w.rise[n][i];
    }
    return w;
}

/// Sums for the gradient ∂_i = scale_i common_i + ⟨adjoint, ∂_i log M⟩: common part, and the slope of log M in each
/// element.
template <int D>
struct ObjectiveSums {
    Pack value{};
    VecPack<D> common;
    SymPack<D> adjoint;
};
template <int D>
struct EdgeSums {
    ObjectiveSums<D> energy, length;
    Pack second{}, third{};  ///< Legendre coefficients of the speed
};

template <int D>
struct EdgeValues {
    Pack energy{}, length{};
    VecPack<D> energy_gradient, length_gradient;
    Pack bulge{};  ///< maximum squared difference of log M from the chord (located points)
};

template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> gradient_in(const ChordFrame<D>& f, const WedgePack<D>& w,
                                                                const VecPack<D>& common, const SymPack<D>& adjoint) {
    VecPack<D> g;
    const Pack by_b = inner(adjoint, f.change);
    for (int i = 0; i < D; ++i) g[i] = f.scale[i] * common[i] + by_b * w.rise_b[i];
    for (int n = 0; n < D - 1; ++n) {
        const Pack by_n = inner(adjoint, w.change[n]);
        for (int i = 0; i < D; ++i) g[i] += by_n * w.rise[n][i];
    }
    return g;
}
template <int D>
[[nodiscard, gnu::always_inline]] inline VecPack<D> gradient_in(const ChordFrame<D>& f, const WedgePack<D>& w,
                                                                const ObjectiveSums<D>& sums) {
    return gradient_in(f, w, sums.common, sums.adjoint);
}

/// Relative uncertainty of the length for four or more points. The Legendre coefficients of a smooth speed decrease
/// geometrically, and the error of the rule is the eighth coefficient.
template <int D>
[[nodiscard, gnu::always_inline]] inline Pack unsure_share(const EdgeSums<D>& sums) {
    const Pack share = (abs(sums.second) + abs(sums.third)) / sums.length.value;
    return share * share * sqrt(share);
}

template <int D>
[[nodiscard, gnu::always_inline]] inline EdgeValues<D> values_in(const ChordFrame<D>& f, const WedgePack<D>& w,
                                                                 const EdgeSums<D>& sums) {
    return {sums.energy.value, sums.length.value, gradient_in(f, w, sums.energy), gradient_in(f, w, sums.length),
            packed(0)};
}

template <int D>
struct ParabolaPack {
    VecPack<D> offset;
    Pack u_b{};         ///< change of the coordinate of b by the offset o: ∇u_b·o
    SymPack<D> change;  ///< Σ (∇u_v·o) (L_v − L_a)
};

template <int D>
[[nodiscard, gnu::always_inline]] inline ParabolaPack<D> parabola(const ChordFrame<D>& f, const WedgePack<D>& w,
                                                                  const VecPack<D>& y) {
    ParabolaPack<D> p;
    for (int i = 0; i < D; ++i) p.offset[i] = f.scale[i] * y[i];
    const Pack b = dot(w.rise_b, y);
    for (int k = 0; k < sym_size<D>; ++k) p.change.c[k] = b * f.change.c[k];
    for (int n = 0; n < D - 1; ++n) {
        const Pack u = max(dot(w.rise[n], y), packed(0));
        for (int k = 0; k < sym_size<D>; ++k) p.change.c[k] += u * w.change[n].c[k];
    }
    return p;
}

/// Eigendecomposition of M at a point, and the velocity l' in its axes.
template <int D>
struct PointPack {
    EigenPack<D> log_metric;
    VecPack<D> values, velocity;
    Pack squared{};
};

template <int D>
[[nodiscard, gnu::always_inline]] inline PointPack<D> measured_point(const ChordFrame<D>& f,
                                                                     const EigenPack<D>& log_metric,
                                                                     const VecPack<D>& offset, double t) {
    PointPack<D> point;
    point.log_metric = log_metric;
    VecPack<D> velocity;
    for (int i = 0; i < D; ++i) velocity[i] = f.chord[i] + (4 * (1 - 2 * t)) * offset[i];
    point.velocity = times_transposed(point.log_metric.vectors, velocity);
    point.squared = packed(0);
    for (int i = 0; i < D; ++i) {
        point.values[i] = exp(point.log_metric.values[i]);
        point.squared += point.values[i] * point.velocity[i] * point.velocity[i];
    }
    return point;
}

template <int D>
[[nodiscard, gnu::always_inline]] inline PointPack<D> decomposed(const ChordFrame<D>& f, const SymPack<D>& log_metric,
                                                                 const VecPack<D>& offset, double t) {
    return measured_point(f, log_eigen_system<D>(log_metric), offset, t);
}

template <int D>
[[nodiscard, gnu::always_inline]] inline SymPack<D> log_metric_along(const ChordFrame<D>& f, const ParabolaPack<D>& p,
                                                                     double t) {
    SymPack<D> l;
    for (int k = 0; k < sym_size<D>; ++k)
        l.c[k] = f.log_metric.c[k] + t * f.change.c[k] + (4 * t * (1 - t)) * p.change.c[k];
    return l;
}

/// Calls use(q, point) in pairs of points at equal distance from the middle, because outer points take more rotations.
template <int D, class Use>
[[gnu::always_inline]] inline void each_point(const ChordFrame<D>& f, const ParabolaPack<D>& p, const Quadrature& rule,
                                              const Use& use) {
    const std::size_t n = rule.size();
    for (std::size_t q = 0; 2 * q < n; ++q) {
        const std::size_t other = n - 1 - q;
        const auto systems =
            log_eigen_systems<D, 2>({log_metric_along(f, p, rule.t[q]), log_metric_along(f, p, rule.t[other])});
        for (std::size_t k = 0; k < (q == other ? 1 : 2); ++k) {
            const std::size_t at = k == 0 ? q : other;
            use(at, measured_point(f, systems[k], p.offset, rule.t[at]));
        }
    }
}

/// Adjoint of vᵀ exp(L) v (length_squared_adjoint), with divided differences e^b (e^x − 1)/x.
template <int D>
[[nodiscard, gnu::always_inline]] inline SymPack<D> adjoint_of(const PointPack<D>& p) {
    SymPack<D> inside;
    for (int i = 0; i < D; ++i) {
        inside(i, i) = p.values[i] * p.velocity[i] * p.velocity[i];
        for (int j = 0; j < i; ++j) {
            const Pack x = p.log_metric.values[i] - p.log_metric.values[j];
            const Mask near = abs(x) < 0.1;
            Pack series = packed(1.0 / 5040);
            series = series * x + 1.0 / 720;
            series = series * x + 1.0 / 120;
            series = series * x + 1.0 / 24;
            series = series * x + 1.0 / 6;
            series = series * x + 0.5;
            series = series * x + 1.0;
            const Pack apart = (p.values[i] - p.values[j]) / select(near, packed(1), x);
            inside(i, j) = select(near, p.values[j] * series, apart) * p.velocity[i] * p.velocity[j];
        }
    }
    // R N Rᵀ.
    const MatPack<D>& r = p.log_metric.vectors;
    SymPack<D> out;
    for (int j = 0; j < D; ++j) {
        VecPack<D> row;  // N Rᵀ
        for (int i = 0; i < D; ++i) {
            row[i] = inside(i, 0) * r(j, 0);
            for (int k = 1; k < D; ++k) row[i] += inside(i, k) * r(j, k);
        }
        for (int i = j; i < D; ++i) {
            Pack sum = r(i, 0) * row[0];
            for (int k = 1; k < D; ++k) sum += r(i, k) * row[k];
            out(i, j) = sum;
        }
    }
    return out;
}

template <int D>
[[gnu::always_inline]] inline void add(ObjectiveSums<D>& sums, Pack value, Pack by_velocity, Pack by_metric,
                                       const VecPack<D>& moved, const SymPack<D>& adjoint) {
    sums.value += value;
    for (int i = 0; i < D; ++i) sums.common[i] += by_velocity * moved[i];
    for (int k = 0; k < sym_size<D>; ++k) sums.adjoint.c[k] += by_metric * adjoint.c[k];
}

/// With q = l'ᵀ M l': ∂_i q = 8(1−2t)(M l')_i + 4t(1−t)⟨adjoint, ∂_i log M⟩, and ∂_i sqrt(q) = ∂_i q / (2 sqrt(q)).
/// Calls use(q, point, M l', adjoint).
template <int D, class Use>
[[nodiscard, gnu::always_inline]] inline EdgeSums<D> sums_along(const ChordFrame<D>& f, const ParabolaPack<D>& p,
                                                                const Quadrature& rule, const Use& use) {
    EdgeSums<D> sums{};
    each_point(f, p, rule, [&](std::size_t q, const PointPack<D>& point) __attribute__((always_inline)) {
        const double t = rule.t[q];
        const double w = rule.w[q];
        VecPack<D> moved;  // M l'
        for (int i = 0; i < D; ++i) moved[i] = point.values[i] * point.velocity[i];
        moved = times(point.log_metric.vectors, moved);
        const SymPack<D> adjoint = adjoint_of(point);
        const Pack root = sqrt(point.squared);
        const Pack half = select(root > 0, 0.5 / root, packed(0));
        const double by_velocity = w * 8 * (1 - 2 * t);
        const double by_metric = w * 4 * t * (1 - t);
        add(sums.energy, w * point.squared, packed(by_velocity), packed(by_metric), moved, adjoint);
        add(sums.length, w * root, by_velocity * half, by_metric * half, moved, adjoint);
        const double x = 2 * t - 1;
        sums.second += (w * 2.5 * (3 * x * x - 1)) * root;
        sums.third += (w * 3.5 * x * (5 * x * x - 3)) * root;
        use(q, point, moved, adjoint);
    });
    return sums;
}
template <int D>
[[nodiscard, gnu::always_inline]] inline EdgeSums<D> sums_along(const ChordFrame<D>& f, const ParabolaPack<D>& p,
                                                                const Quadrature& rule) {
    return sums_along(f, p, rule, [](auto&&...) __attribute__((always_inline)) {});
}

template <int D>
[[nodiscard, gnu::always_inline]] inline Pack length_along(const ChordFrame<D>& f, const ParabolaPack<D>& p,
                                                           const Quadrature& rule) {
    Pack length = packed(0);
    each_point(f, p, rule, [&](std::size_t q, const PointPack<D>& point) __attribute__((always_inline)) {
        length += rule.w[q] * sqrt(point.squared);
    });
    return length;
}

}  // namespace camber
