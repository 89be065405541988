// Fields of curved meshes: sampling, and gradients at edges.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>
module camber.metric;
import camber.core;

namespace camber {

namespace {

/// Newton's method ends if a step, in barycentric coordinates, is below this limit. The remaining error is about the
/// square of the step.
constexpr double small_step = 1e-5;
constexpr int max_steps = 10;

template <int D>
void add_outer(Mat<D>& a, const Vec<D>& b, const Vec<D>& c) {
    for (int i = 0; i < D; ++i) a.column[i] += c[i] * b;
}

template <int D>
void add(Mat<D>& sum, const Mat<D>& a) {
    for (int i = 0; i < D; ++i) sum.column[i] += a.column[i];
}

template <int D>
LogGradient<D> in_space(const LogGradient<D>& gradient, const Mat<D>& jacobian) {
    const Mat<D> back = inverse(jacobian);
    LogGradient<D> out{};
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) out[i] += back(j, i) * gradient[j];
    return out;
}

template <int D>
Vec<D> reference_point(const CurvedBack<D>& back, const Location<D>& location) {
    const auto& v = back.reference.mesh.elements.vertices[location.element];
    // The point is computed relative to a corner. Relative to the origin, which may be far away, rounding errors would
    // be larger.
    const Vec<D>& from = back.reference.mesh.points[v[0]];
    Vec<D> p = from;
    for (int i = 1; i <= D; ++i) p += location.xi[i] * (back.reference.mesh.points[v[i]] - from);
    return p;
}

template <int D>
double share_of_element(const std::array<Vec<D>, D + 1>& gradients, const Vec<D>& step) {
    double most = 0;
    for (const Vec<D>& gradient : gradients) most = std::max(most, std::abs(dot(gradient, step)));
    return most;
}

/// Returns the displacement of the element's centre, from which a search estimates a point of the straight mesh. In
/// stacks of thin elements, neighbours have similar displacements.
template <int D>
Vec<D> displacement_at_centre(const CurvedBack<D>& back, ElementId e) {
    Vec<D> sum;
    for (const EdgeId edge : back.edges.of_elements[e]) sum += back.displacements[edge];
    return (4.0 / ((D + 1) * (D + 1))) * sum;
}

}  // namespace

template <int D>
bool CurvedBack<D>::is_curved(ElementId e) const {
    return std::ranges::any_of(edges.of_elements[e], [&](EdgeId edge) { return displacements[edge] != Vec<D>{}; });
}

template <int D>
MappedPoint<D> CurvedBack<D>::at(const Location<D>& location) const {
    MappedPoint<D> bent{reference_point(*this, location), Mat<D>::identity()};
    const auto gradients = barycentric_gradients(reference.mesh, location.element);
    for (int k = 0; k < edges_per_simplex<D>; ++k) {
        const Vec<D>& u = displacements[edges.of_elements[location.element][k]];
        if (u == Vec<D>{}) continue;
        const auto [i, j] = local_edges<D>[k];
        bent.point += (4 * location.xi[i] * location.xi[j]) * u;
        add_outer(bent.jacobian, 4 * u, location.xi[i] * gradients[j] + location.xi[j] * gradients[i]);
    }
    return bent;
}

template <int D>
Location<D> CurvedBack<D>::locate(const Vec<D>& p, ElementId hint) const {
    if (!is_finite(p)) return reference.locate(p, hint);
    Vec<D> relative = hint.valid() ? p - displacement_at_centre(*this, hint) : p;
    Location<D> found = reference.locate(relative, hint);
    if (found.placement != Placement::inside) relative = reference_point(*this, found);
    for (int step = 0; step < max_steps; ++step) {
        const MappedPoint<D> bent = at(found);
        const Vec<D> move = inverse(bent.jacobian) * (p - bent.point);
        if (!is_finite(move)) break;
        const auto gradients = barycentric_gradients(reference.mesh, found.element);
        if (found.placement == Placement::inside && share_of_element<D>(gradients, move) < small_step) {
            for (int i = 0; i <= D; ++i) found.xi[i] += dot(gradients[i], move);
            break;
        }
        found = reference.locate(relative + move, found.element);
        const Vec<D> before = relative;
        relative = found.placement == Placement::inside ? relative + move : reference_point(*this, found);
        if (found.placement != Placement::inside && share_of_element<D>(gradients, relative - before) < small_step)
            break;
    }
    return found;
}

template <int D>
void CurvedBack<D>::sample_values(std::span<const Vec<D>> points, ElementId hint, std::span<FieldSample<D>> out) const {
    for (std::size_t n = 0; n < points.size(); ++n) {
        out[n].location = locate(points[n], hint);
        hint = out[n].location.element;
        out[n].log_metric = reference.value_at(out[n].location);
    }
}

template <int D>
void CurvedBack<D>::sample_with_gradients(std::span<const Vec<D>> points, ElementId hint,
                                          std::span<FieldSample<D>> out) const {
    sample_values(points, hint, out);
    for (FieldSample<D>& s : out) s.gradient = in_space<D>(reference.gradient_at(s.location), at(s.location).jacobian);
}

template <int D>
void CurvedBack<D>::sample_with_recovered_gradients(std::span<const Vec<D>> points, ElementId hint,
                                                    std::span<FieldSample<D>> out) const {
    sample_values(points, hint, out);
    for (FieldSample<D>& s : out)
        s.gradient = in_space<D>(reference.recovered_gradient_at(s.location), at(s.location).jacobian);
}

template <int D>
void CurvedBack<D>::sample_edges(std::span<const BackEdge> pack, std::span<EdgeEnds<D>> out) const {
    for (std::size_t i = 0; i < pack.size(); ++i) {
        const auto& [a, b, shell] = pack[i];
        out[i] = {{reference.log_metrics[a]}, {reference.log_metrics[b]}, std::ranges::any_of(shell, [&](ElementId e) {
                      return is_curved(e);
                  })};
        if (!relative_gradients.empty()) {
            out[i].a.gradient = relative_gradients[a];
            out[i].b.gradient = relative_gradients[b];
        }
        if (!out[i].is_curved) continue;
        out[i].a.jacobian = out[i].b.jacobian = {};
        for (const ElementId e : shell) {
            const auto gradients = barycentric_gradients(reference.mesh, e);
            add(out[i].a.jacobian, jacobian_at_corner<D>(*this, e, a, gradients));
            add(out[i].b.jacobian, jacobian_at_corner<D>(*this, e, b, gradients));
        }
        for (EdgeEnd<D>* end : {&out[i].a, &out[i].b})
            for (Vec<D>& column : end->jacobian.column) column *= 1.0 / static_cast<double>(shell.size());
    }
}

template <int D>
BackSector<D> CurvedBack<D>::sector(ElementId e, VertexId a, VertexId b) const {
    BackSector<D> sector = reference.sector(e, a, b);
    if (!is_curved(e)) return sector;
    Location<D> middle{.element = e, .xi = {}};
    for (int i = 0; i <= D; ++i)
        if (const VertexId v = reference.mesh.elements.vertices[e][i]; v == a || v == b) middle.xi[i] = 0.5;
    const Mat<D> jacobian = at(middle).jacobian;
    sector.gradient = in_space<D>(sector.gradient, jacobian);
    const Mat<D> back = transposed(inverse(jacobian));
    for (Vec<D>& wall : sector.walls) wall = back * wall;
    return sector;
}

template <int D>
Outcome<BackMesh<D>> make_curved_back_mesh(QuadraticMesh<D> mesh, const Incidence<ElementId>& balls,
                                           Column<LogMetric<D>> log_metrics, const Execution& execution,
                                           StoredGradients stored) {
    // The curved triangles of a standalone surface are close to the straight ones, and the field is constant along
    // their normals. So the field of the straight mesh is sufficient.
    if (is_standalone_surface(mesh.linear))
        return make_back_mesh(mesh.linear, balls, std::move(log_metrics), execution);
    auto displacements = map_each(part_of(execution, 0, 0.03), mesh.edges.size(), [&](std::size_t e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        return mesh.mid_nodes[e].point - midpoint(mesh.linear.points[a], mesh.linear.points[b]);
    });
    if (!displacements) return fail(displacements.error());
    mesh.mid_nodes = {};
    if (std::ranges::all_of(*displacements, [](const Vec<D>& u) { return u == Vec<D>{}; }))
        return make_back_mesh(mesh.linear, balls, std::move(log_metrics), part_of(execution, 0.03, 1));
    auto straight = make_straight_back(mesh.linear, balls, std::move(log_metrics), part_of(execution, 0.03, 0.35));
    if (!straight) return fail(straight.error());
    if (stored != StoredGradients::sampled) {
        auto recovered = mean_gradients(*straight, balls, part_of(execution, 0.35, 0.6));
        if (!recovered) return fail(recovered.error());
        straight->nodal_gradients = std::move(*recovered);
    }
    CurvedBack<D> back;
    back.reference = std::move(*straight);
    back.edges = mesh.edges;
    back.displacements = std::move(*displacements);
    if (stored == StoredGradients::recovered) return BackMesh<D>(std::move(back));
    auto relative =
        relative_gradients(back, balls, part_of(execution, stored == StoredGradients::sampled ? 0.35 : 0.6, 1));
    if (!relative) return fail(relative.error());
    back.relative_gradients = std::move(*relative);
    return BackMesh<D>(std::move(back));
}

namespace {

template <int D>
using GradientPack = std::array<SymPack<D>, D>;

template <int D>
using Part = WeightedGradient<D>;
template <int D>
using Parts = std::array<Part<D>, D + 1>;

template <int D>
double volume_of(const LinearMesh<D>& mesh, ElementId e) {
    const auto& v = mesh.elements.vertices[e];
    Mat<D> sides;
    for (int a = 0; a < D; ++a) sides.column[a] = mesh.points[v[a + 1]] - mesh.points[v[0]];
    return std::abs(det(sides));
}

template <int D>
void add_straight(const CurvedBack<D>& back, ElementId e, Parts<D>& parts) {
    parts.fill(weighted_gradient(back.reference, e));
}

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

template <int D>
struct DecomposedField {
    const CurvedBack<D>& back;
    std::span<const EigenSystem<D>> systems;
};

template <int D>
struct CurvedElementInput {
    std::array<Vec<D>, D + 1> gradients;
    std::array<LogMetric<D>, D + 1> log_metrics;
    std::array<EigenSystem<D>, D + 1> systems;
    std::array<Vec<D>, edges_per_simplex<D>> displacements;
    double volume = 0;
};

template <int D>
CurvedElementInput<D> curved_element_input(const DecomposedField<D>& field, ElementId e) {
    const CurvedBack<D>& back = field.back;
    const LinearMesh<D>& mesh = back.reference.mesh;
    CurvedElementInput<D> element{barycentric_gradients(mesh, e), {}, {}, {}, volume_of(mesh, e)};
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
    MatPack<3> rows;  // column i is row i of the adjugate det(a) a⁻¹
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

/// Transforms the gradient of log M̂, with M̂ = Fᵀ M F, to physical space. Directions of derivatives are transformed by
/// F⁻ᵀ (F: `jacobian`), and tensors by the rotation `axes` from the frame of M̂ to that of M.
template <int D>
[[nodiscard, gnu::always_inline]] inline GradientPack<D> pushed_forward(const GradientPack<D>& gradient,
                                                                        const MatPack<D>& jacobian,
                                                                        const MatPack<D>& axes) {
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

template <int D>
[[gnu::always_inline]] inline void parts_of_pack(std::span<const CurvedElementInput<D>> elements, std::size_t begin,
                                                 const auto& parts_of) {
    using Element = CurvedElementInput<D>;
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
    std::array<PulledBackPack<D>, D + 1> relative;
    for (int i = 0; i <= D; ++i) {
        jacobians[i] = jacobian_at<D>(i, gradients, displacements);
        const EigenPack<D> metric{
            gathered_vec<D>(elements, begin,
                            [&](const Element& e)
                                __attribute__((always_inline)) -> const Vec<D>& { return e.systems[i].values; }),
            gathered_mat<D>(elements, begin, [&](const Element& e) __attribute__((always_inline)) -> const Mat<D>& {
                return e.systems[i].vectors;
            })};
        relative[i] = pull_back_pack<D>(
            gathered_sym<D>(elements, begin,
                            [&](const Element& e)
                                __attribute__((always_inline)) -> const Sym<D>& { return e.log_metrics[i].l; }),
            metric, jacobians[i]);
    }
    GradientPack<D> gradient{};
    for (int a = 1; a <= D; ++a)
        for (int k = 0; k < sym_size<D>; ++k) {
            const Pack difference = relative[a].log_metric.c[k] - relative[0].log_metric.c[k];
            for (int i = 0; i < D; ++i) gradient[i].c[k] += gradients[a][i] * difference;
        }
    const std::size_t n = std::min<std::size_t>(pack_size, elements.size() - begin);
    for (int v = 0; v <= D; ++v) {
        const GradientPack<D> here = pushed_forward<D>(gradient, jacobians[v], relative[v].axes);
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
    std::vector<CurvedElementInput<D>> elements;
    std::vector<std::size_t> places;
    elements.reserve(end - begin);
    places.reserve(end - begin);
    for (std::size_t e = begin; e < end; ++e) {
        if (!back.is_curved(ElementId(e))) {
            add_straight(back, ElementId(e), parts[e - begin]);
            continue;
        }
        elements.push_back(curved_element_input(field, ElementId(e)));
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
    template class CurvedBack<D>;                                                                                     \
    template Outcome<BackMesh<D>> make_curved_back_mesh<D>(QuadraticMesh<D>, const Incidence<ElementId>&,             \
                                                           Column<LogMetric<D>>, const Execution&, StoredGradients);  \
    template Mat<D> jacobian_at_corner<D>(const CurvedBack<D>&, ElementId, VertexId,                                  \
                                          const std::array<Vec<D>, D + 1>&);                                          \
    template Outcome<Buffer<LogGradient<D>>> relative_gradients<D>(const CurvedBack<D>&, const Incidence<ElementId>&, \
                                                                   const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
