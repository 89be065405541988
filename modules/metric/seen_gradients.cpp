module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>
module camber.metric;
import :ball_sums;
import :packs;
import :seen_gradients;
import :straight_back;
import camber.core;

namespace camber {

namespace {

template <int D>
using GradientPack = std::array<SymPack<D>, D>;

/// What an element has to add at a corner to the mean there.
template <int D>
using Part = WeightedGradient<D>;
template <int D>
using Parts = std::array<Part<D>, D + 1>;

/// D! times the volume; what is lost in slim elements does not count in a mean.
template <int D>
double volume_of(const LinearMesh<D>& mesh, ElementId e) {
    const auto& v = mesh.elements.vertices[e];
    Mat<D> sides;
    for (int a = 0; a < D; ++a) sides.column[a] = mesh.points[v[a + 1]] - mesh.points[v[0]];
    return std::abs(det(sides));
}

/// In an element without curves the gradient is the field's own, and the map the identity.
template <int D>
void add_straight(const CurvedBack<D>& back, ElementId e, Parts<D>& parts) {
    parts.fill(weighted_gradient(back.reference, e));
}

/// The eigen systems of log-metrics.
template <int D>
Outcome<Buffer<EigenSystem<D>>> eigen_systems(const Column<LogMetric<D>>& field, const Execution& execution) {
    return guarded([&]() -> Outcome<Buffer<EigenSystem<D>>> {
        Buffer<EigenSystem<D>> systems(field.size());
        const auto found = each_chunk(execution, field.size(), [&](std::size_t begin, std::size_t end) {
            with_instructions(widest_instructions(), [&]() __attribute__((always_inline)) {
                const std::span<const LogMetric<D>> chunk = field.view().subspan(begin, end - begin);
                for (std::size_t first = 0; first < chunk.size(); first += pack_size) {
                    const EigenPack<D> pack = eigen_system<D>(gathered_sym<D>(
                        chunk, first,
                        [](const LogMetric<D>& m) __attribute__((always_inline)) -> const Sym<D>& { return m.l; }));
                    const std::size_t n = std::min<std::size_t>(pack_size, chunk.size() - first);
                    for (std::size_t lane = 0; lane < n; ++lane) {
                        EigenSystem<D>& system = systems[begin + first + lane];
                        for (int i = 0; i < D; ++i) system.values[i] = pack.values[i][lane];
                        for (int i = 0; i < D; ++i)
                            for (int j = 0; j < D; ++j) system.vectors(i, j) = pack.vectors(i, j)[lane];
                    }
                }
            });
        });
        if (!found) return fail(found.error());
        return systems;
    });
}

/// A field, and its eigen systems: an element asks for those of its corners, a vertex has many.
template <int D>
struct DecomposedField {
    const CurvedBack<D>& back;
    std::span<const EigenSystem<D>> systems;
};

/// An element with curves, as the kernel takes it.
template <int D>
struct BentElement {
    std::array<Vec<D>, D + 1> gradients;
    std::array<LogMetric<D>, D + 1> log_metrics;
    std::array<EigenSystem<D>, D + 1> systems;
    std::array<Vec<D>, edges_per_simplex<D>> displacements;
    double volume = 0;
};

template <int D>
BentElement<D> bent_element(const DecomposedField<D>& field, ElementId e) {
    const CurvedBack<D>& back = field.back;
    const LinearMesh<D>& mesh = back.reference.mesh;
    BentElement<D> element{barycentric_gradients(mesh, e), {}, {}, {}, volume_of(mesh, e)};
    for (int i = 0; i <= D; ++i) {
        const VertexId v = mesh.elements.vertices[e][i];
        element.log_metrics[i] = back.reference.log_metrics[v];
        element.systems[i] = field.systems[v.index()];
    }
    for (int k = 0; k < edges_per_simplex<D>; ++k)
        element.displacements[k] = back.displacements[back.edges.of_elements[e][k]];
    return element;
}

template <int D>
[[nodiscard, gnu::always_inline]] inline MatPack<D> jacobian_at(
    int corner, const std::array<VecPack<D>, D + 1>& gradients,
    const std::array<VecPack<D>, edges_per_simplex<D>>& displacements) {
    MatPack<D> jacobian = identity_pack<D>();
    for (int k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        if (i != corner && j != corner) continue;
        const VecPack<D>& along = gradients[i == corner ? j : i];
        for (int c = 0; c < D; ++c)
            for (int r = 0; r < D; ++r) jacobian(r, c) += along[c] * (4 * displacements[k][r]);
    }
    return jacobian;
}

/// F⁻¹ by cofactors.
[[nodiscard, gnu::always_inline]] inline MatPack<2> inverse(const MatPack<2>& a) {
    const Pack scale = 1 / (a(1, 1) * a(0, 0) - a(0, 1) * a(1, 0));
    MatPack<2> r;
    r(0, 0) = a(1, 1) * scale;
    r(0, 1) = -a(0, 1) * scale;
    r(1, 0) = -a(1, 0) * scale;
    r(1, 1) = a(0, 0) * scale;
    return r;
}
[[nodiscard, gnu::always_inline]] inline MatPack<3> inverse(const MatPack<3>& a) {
    MatPack<3> rows;  // transposed
    for (int i = 0; i < 3; ++i) {
        const VecPack<3>& b = a.column[(i + 1) % 3];
        const VecPack<3>& c = a.column[(i + 2) % 3];
        for (int k = 0; k < 3; ++k) {
            const int l = (k + 1) % 3, m = (k + 2) % 3;
            rows(k, i) = b[l] * c[m] - b[m] * c[l];
        }
    }
    const Pack scale = 1 / dot(rows.column[0], a.column[0]);
    MatPack<3> r;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) r(i, j) = rows(j, i) * scale;
    return r;
}

/// A gradient in the reference as one in space: the derivatives by F⁻ᵀ, the tensors turned from M̂'s frame into M's.
template <int D>
[[nodiscard, gnu::always_inline]] inline GradientPack<D> brought(const GradientPack<D>& gradient,
                                                                 const MatPack<D>& jacobian, const MatPack<D>& axes) {
    const MatPack<D> back = inverse(jacobian);
    MatPack<D> rows;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) rows(i, j) = axes(j, i);
    GradientPack<D> out{};
    for (int j = 0; j < D; ++j) {
        const SymPack<D> tensor = congruence_transposed(rows, gradient[j]);
        for (int i = 0; i < D; ++i)
            for (int k = 0; k < sym_size<D>; ++k) out[i].c[k] += back(j, i) * tensor.c[k];
    }
    return out;
}

/// Of eight elements at a time, what each has to add at its corners.
template <int D>
[[gnu::always_inline]] inline void parts_of_pack(std::span<const BentElement<D>> elements, std::size_t begin,
                                                 const auto& parts_of) {
    using Element = BentElement<D>;
    std::array<VecPack<D>, D + 1> gradients;
    std::array<VecPack<D>, edges_per_simplex<D>> displacements;
    for (int i = 0; i <= D; ++i)
        gradients[i] = gathered_vec<D>(elements, begin,
                                       [&](const Element& e)
                                           __attribute__((always_inline)) -> const Vec<D>& { return e.gradients[i]; });
    for (int k = 0; k < edges_per_simplex<D>; ++k)
        displacements[k] = gathered_vec<D>(
            elements, begin,
            [&](const Element& e) __attribute__((always_inline)) -> const Vec<D>& { return e.displacements[k]; });
    const Pack volume =
        gathered(elements, begin, [](const Element& e) __attribute__((always_inline)) { return e.volume; });
    std::array<MatPack<D>, D + 1> jacobians;
    std::array<SeenPack<D>, D + 1> seen;
    for (int i = 0; i <= D; ++i) {
        jacobians[i] = jacobian_at<D>(i, gradients, displacements);
        const EigenPack<D> metric{
            gathered_vec<D>(elements, begin,
                            [&](const Element& e)
                                __attribute__((always_inline)) -> const Vec<D>& { return e.systems[i].values; }),
            gathered_mat<D>(elements, begin, [&](const Element& e) __attribute__((always_inline)) -> const Mat<D>& {
                return e.systems[i].vectors;
            })};
        seen[i] = seen_through<D>(
            gathered_sym<D>(elements, begin,
                            [&](const Element& e)
                                __attribute__((always_inline)) -> const Sym<D>& { return e.log_metrics[i].l; }),
            metric, jacobians[i]);
    }
    GradientPack<D> gradient{};
    for (int a = 1; a <= D; ++a)
        for (int k = 0; k < sym_size<D>; ++k) {
            const Pack difference = seen[a].log_metric.c[k] - seen[0].log_metric.c[k];
            for (int i = 0; i < D; ++i) gradient[i].c[k] += gradients[a][i] * difference;
        }
    const std::size_t n = std::min<std::size_t>(pack_size, elements.size() - begin);
    for (int v = 0; v <= D; ++v) {
        const GradientPack<D> here = brought<D>(gradient, jacobians[v], seen[v].axes);
        for (std::size_t lane = 0; lane < n; ++lane) parts_of(begin + lane)[v].volume = volume[lane];
        for (int i = 0; i < D; ++i)
            for (int k = 0; k < sym_size<D>; ++k) {
                const Pack weighted = volume * here[i].c[k];
                for (std::size_t lane = 0; lane < n; ++lane)
                    parts_of(begin + lane)[v].gradient[i].c[k] = weighted[lane];
            }
    }
}

template <int D>
void make_parts(const DecomposedField<D>& field, std::size_t begin, std::size_t end, std::span<Parts<D>> parts) {
    const CurvedBack<D>& back = field.back;
    std::vector<BentElement<D>> elements;
    std::vector<std::size_t> places;  // of these in `parts`
    elements.reserve(end - begin);
    places.reserve(end - begin);
    for (std::size_t e = begin; e < end; ++e) {
        if (!back.is_bent(ElementId(e))) {
            add_straight(back, ElementId(e), parts[e - begin]);
            continue;
        }
        elements.push_back(bent_element(field, ElementId(e)));
        places.push_back(e - begin);
    }
    with_instructions(widest_instructions(), [&]() __attribute__((always_inline)) {
        for (std::size_t first = 0; first < elements.size(); first += pack_size)
            parts_of_pack<D>(elements, first, [&](std::size_t i) __attribute__((always_inline)) -> Parts<D>& {
                return parts[places[i]];
            });
    });
}

}  // namespace

template <int D>
Mat<D> jacobian_at_corner(const CurvedBack<D>& back, ElementId e, VertexId v,
                          const std::array<Vec<D>, D + 1>& gradients) {
    const auto& corners = back.reference.mesh.elements.vertices[e];
    Mat<D> jacobian = Mat<D>::identity();
    for (int k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        if (corners[i] != v && corners[j] != v) continue;
        const Vec<D> u = 4 * back.displacements[back.edges.of_elements[e][k]];
        const Vec<D>& along = gradients[corners[i] == v ? j : i];
        for (int c = 0; c < D; ++c) jacobian.column[c] += along[c] * u;
    }
    return jacobian;
}

template <int D>
Outcome<Buffer<LogGradient<D>>> relative_gradients(const CurvedBack<D>& back, const Incidence<ElementId>& balls,
                                                   const Execution& execution) {
    const LinearMesh<D>& mesh = back.reference.mesh;
    const auto systems = eigen_systems<D>(back.reference.log_metrics, without_progress(execution));
    if (!systems) return fail(systems.error());
    const DecomposedField<D> field{back, *systems};
    return guarded([&]() -> Outcome<Buffer<LogGradient<D>>> {
        Buffer<LogGradient<D>> gradients(mesh.points.size(), LogGradient<D>{});
        Buffer<double> volumes(mesh.points.size(), 0.0);
        auto summed = sum_over_balls<Part<D>>(
            mesh, balls, execution,
            [&](std::size_t begin, std::size_t end, std::span<Parts<D>> parts) {
                make_parts(field, begin, end, parts);
            },
            [&](VertexId v, const auto& each_part) {
                Part<D> sum{gradients[v.index()], volumes[v.index()]};
                each_part([&](const Part<D>& part) {
                    if (!(part.volume > 0)) return;
                    for (int i = 0; i < D; ++i) sum.gradient[i] += part.gradient[i];
                    sum.volume += part.volume;
                });
                gradients[v.index()] = sum.gradient;
                volumes[v.index()] = sum.volume;
            });
        if (!summed) return fail(summed.error());
        auto divided = each(without_progress(execution), gradients.size(), [&](std::size_t v) {
            if (!(volumes[v] > 0)) return;
            for (Sym<D>& g : gradients[v]) g *= 1 / volumes[v];
        });
        if (!divided) return fail(divided.error());
        return gradients;
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template Mat<D> jacobian_at_corner<D>(const CurvedBack<D>&, ElementId, VertexId,                                  \
                                          const std::array<Vec<D>, D + 1>&);                                          \
    template Outcome<Buffer<LogGradient<D>>> relative_gradients<D>(const CurvedBack<D>&, const Incidence<ElementId>&, \
                                                                   const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
