module;
#include <array>
#include <cstddef>
module camber.metric:edge_wedge;
import camber.core;
import :packs;
import :spd;
import :straight_back;

namespace camber {

/// An element of an edge's shell is a wedge around the chord: the coordinates of its vertices off the edge rise from
/// its walls. While the offset o of the edge's node stays in it, and moves neither end's coordinate by more than −1/4,
/// the whole parabola chord + 4t(1−t) o lies in the element, where log M is linear: along the edge it is
/// (1−t) L_a + t L_b + 4t(1−t) Σ (∇u_v·o) L_v, nothing is located and nothing has kinks.

/// One element of the shell for each lane, in space.
template <int D>
struct ShellElementPack {
    std::array<VecPack<D>, D - 1> rise;    ///< ∇u of the vertices off the edge
    std::array<Pack, D - 1> along{};       ///< where along the chord they are, in chords
    std::array<SymPack<D>, D - 1> change;  ///< log M there, less that at a
};

/// Eight edges of the back mesh.
template <int D>
struct ChordPack {
    std::array<VertexId, pack_size> a, b;
    VecPack<D> origin, chord;
    SymPack<D> log_metric, change;  ///< at a, and from a to b
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

/// By the parts across the chord, so that needles keep the digits that the coordinates have.
template <int D>
[[nodiscard, gnu::always_inline]] inline ShellElementPack<D> shell_elements(
    const StraightBack<D>& back, const ChordPack<D>& edges, const std::array<ElementId, pack_size>& elements) {
    ShellElementPack<D> w;
    std::array<VecPack<D>, D - 1> across;
    for (int lane = 0; lane < pack_size; ++lane) {
        // Those off the edge, without branches, of which half would be guessed wrong.
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
/// Σ A_ij B_ij.
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

/// A step of the quadratic model within a cone { y : rise_k·y ≥ 0 }, and which walls hold it.
template <int D>
struct WallStep {
    VecPack<D> step;
    std::array<Mask, D - 1> held{};
    Pack slope{};  ///< of the objective along it
};

/// min gᵀs + ½ sᵀ H⁻¹ s while y + s is in the cone: the free step, that onto one wall, or that onto their line.
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
        out.held[0] = height[0] < 0;
        pressure[0] = select(out.held[0], -height[0] / dot(rise[0], pushed[0]), none);
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
        out.held[0] = on0 | line;
        out.held[1] = on1 | line;
    }
    for (int n = 0; n < D - 1; ++n)
        for (int i = 0; i < D; ++i) out.step[i] += pressure[n] * pushed[n][i];
    out.slope = dot(gradient, out.step);
    return out;
}

}  // namespace camber
