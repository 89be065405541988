module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <span>
#include <utility>
module camber.curving;
import camber.core;
import camber.bezier;
import camber.validity;

namespace camber {

namespace {

using Lanes = std::array<double, pack_size>;
using FloatPack = float __attribute__((ext_vector_type(8)));

constexpr std::size_t packs_at_once = 16;
/// This fraction of the mean element error is added to each element's error before `stiffen` uses the errors as
/// weights. Tiny errors are too uncertain for that.
constexpr double least_share = 0.01;

Pack loaded(const Lanes& lanes) {
    Pack p;
    std::memcpy(&p, lanes.data(), sizeof p);
    return p;
}

template <int D>
Sym<D> inverse_of(const Sym<D>& a) {
    Sym<D> adjugate;
    double det = 0, trace = 0;
    for (int i = 0; i < D; ++i) trace += a(i, i);
    if constexpr (D == 2) {
        adjugate(0, 0) = a(1, 1);
        adjugate(1, 1) = a(0, 0);
        adjugate(1, 0) = -a(1, 0);
    } else {
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j <= i; ++j) {
                const int p = (i + 1) % 3, q = (i + 2) % 3, r = (j + 1) % 3, s = (j + 2) % 3;
                adjugate(i, j) = a(p, r) * a(q, s) - a(p, s) * a(q, r);
            }
    }
    for (int j = 0; j < D; ++j) det += a(0, j) * adjugate(0, j);
    if (det > 0) return (1 / det) * adjugate;
    return trace > 0 ? (1 / trace) * Sym<D>::identity() : Sym<D>{};
}

template <int D>
std::array<Vec<D>, D> jacobian_within(const QuadraticMesh<D>& mesh, ElementId e) {
    std::array<Vec<D>, D> columns;
    const auto& vertices = mesh.linear.elements.vertices[e];
    for (int a = 0; a < D; ++a) columns[a] = mesh.linear.points[vertices[a + 1]] - mesh.linear.points[vertices[0]];
    for (int k = 0; k < edges_per_simplex<D>; ++k) {
        const Vec<D> slope = (4.0 / (D + 1)) * edge_of(mesh, mesh.edges.of_elements[e][k]).offset();
        for (const int v : local_edges<D>[k])  // ∇λ_0 = −Σ ∇ξ_a
            for (int a = 0; a < D; ++a) {
                if (v == 0) columns[a] -= slope;
                if (v == a + 1) columns[a] += slope;
            }
    }
    return columns;
}

template <int D>
Outcome<double> product_of(std::span<const Vec<D>> a, std::span<const Vec<D>> b, const Execution& execution) {
    return reduce_each(
        execution, a.size(), 0.0, [&](double& sum, std::size_t i) { sum += dot(a[i], b[i]); },
        [](double x, double y) { return x + y; });
}

}  // namespace

template <int D>
ErrorSystem<D>::ErrorSystem(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                            const Incidence<ElementId>& shells, const KnownSolution<D>& solution, double stiffness)
    : mesh_(mesh),
      kinds_(kinds),
      shells_(shells),
      solution_(solution),
      stiffness_(stiffness),
      elements_(mesh.linear.elements.size()),
      curvature_(packs() * Errors::entries * pack_size),
      slope_(packs() * Errors::unknowns * pack_size),
      product_(packs() * Errors::unknowns * pack_size),
      errors_(elements_) {}

template <int D>
std::size_t ErrorSystem<D>::element_of(std::size_t pack, int lane) const {
    return std::min(pack * pack_size + static_cast<std::size_t>(lane), elements_ - 1);
}

template <int D>
bool ErrorSystem<D>::is_free(std::size_t edge) const {
    return kinds_[edge] == EdgeKind::volume && !shells_[edge].empty();
}

template <int D>
ElementPacks<D> ErrorSystem<D>::elements_of(std::size_t pack, std::span<const Vec<D>> offsets) const {
    std::array<std::array<Lanes, D>, D> axes{};
    std::array<std::array<Lanes, D>, edges_per_simplex<D>> of_frame{}, of_edges{};
    for (int lane = 0; lane < pack_size; ++lane) {
        const std::size_t e = element_of(pack, lane);
        const auto& vertices = mesh_.linear.elements.vertices[e];
        for (int a = 0; a < D; ++a) {
            const Vec<D> axis = mesh_.linear.points[vertices[a + 1]] - mesh_.linear.points[vertices[0]];
            for (int i = 0; i < D; ++i) axes[a][i][lane] = axis[i];
        }
        for (int k = 0; k < edges_per_simplex<D>; ++k) {
            const EdgeId edge = mesh_.edges.of_elements[e][k];
            const Vec<D> in_frame = edge_of(mesh_, edge).offset();
            for (int i = 0; i < D; ++i) {
                of_frame[k][i][lane] = in_frame[i];
                of_edges[k][i][lane] = offsets[edge.index()][i];
            }
        }
    }
    ElementPacks<D> out{};
    for (int i = 0; i < D; ++i) {
        for (int a = 0; a < D; ++a) out.axes[a][i] = loaded(axes[a][i]);
        for (int k = 0; k < edges_per_simplex<D>; ++k) {
            out.frame_offsets[k][i] = loaded(of_frame[k][i]);
            out.offsets[k][i] = loaded(of_edges[k][i]);
        }
    }
    return out;
}

template <int D>
void ErrorSystem<D>::add_fields(std::size_t pack, const ElementPacks<D>& elements, Errors& sum) const {
    for (const KnownField<D>& field : solution_) {
        std::array<Lanes, lattice_size<D>> lanes{};
        for (int lane = 0; lane < pack_size; ++lane) {
            const auto& values = field.values[element_of(pack, lane)];
            for (std::size_t k = 0; k < lanes.size(); ++k) lanes[k][lane] = static_cast<double>(values[k]);
        }
        LatticePacks<D> packs{};
        for (std::size_t k = 0; k < lanes.size(); ++k) packs[k] = loaded(lanes[k]);
        add_error<D>(elements, packs, field.weight * field.weight, widest_instructions(), sum);
    }
}

template <int D>
void ErrorSystem<D>::begin_pack(std::size_t pack, std::span<const Vec<D>> offsets) {
    const ElementPacks<D> elements = elements_of(pack, offsets);
    Errors sum;
    add_fields(pack, elements, sum);
    for (int lane = 0; lane < pack_size; ++lane) {
        const std::size_t e = pack * pack_size + static_cast<std::size_t>(lane);
        if (e < elements_) errors_[e] = sum.error[lane];
        for (std::size_t i = 0; i < Errors::unknowns; ++i)
            slope_[(pack * Errors::unknowns + i) * pack_size + lane] = sum.slope[i][lane];
        for (std::size_t i = 0; i < Errors::entries; ++i)
            curvature_[(pack * Errors::entries + i) * pack_size + lane] = static_cast<float>(sum.curvature[i][lane]);
    }
}

/// Adds the gradient and Hessian of |J⁻¹(d − d_0)|² for each edge to the error model, times `stiffness_` and the
/// element's error. d and d_0 are the edge's rows of `offsets` and `reference_offsets`; J is the Jacobian at the
/// element's centre.
template <int D>
void ErrorSystem<D>::stiffen(std::size_t pack, std::span<const Vec<D>> offsets,
                             std::span<const Vec<D>> reference_offsets, double least) {
    for (int lane = 0; lane < pack_size; ++lane) {
        const std::size_t e = element_of(pack, lane);
        Sym<D> square;  // J Jᵀ
        for (const Vec<D>& axis : jacobian_within(mesh_, ElementId(e))) {
            for (int i = 0; i < D; ++i)
                for (int j = 0; j <= i; ++j) square(i, j) += axis[i] * axis[j];
        }
        const Sym<D> fixed = (stiffness_ * (errors_[e] + least)) * inverse_of(square);
        for (int k = 0; k < edges_per_simplex<D>; ++k) {
            const std::size_t edge = mesh_.edges.of_elements[e][k].index();
            const Vec<D> pull = fixed * (offsets[edge] - reference_offsets[edge]);
            for (int i = 0; i < D; ++i) {
                const int at = k * D + i;
                slope_[(pack * Errors::unknowns + at) * pack_size + lane] += pull[i];
                for (int j = 0; j <= i; ++j)
                    curvature_[(pack * Errors::entries + Errors::entry(at, k * D + j)) * pack_size + lane] +=
                        static_cast<float>(fixed(i, j));
            }
        }
    }
}

template <int D>
Outcome<double> ErrorSystem<D>::begin(std::span<const Vec<D>> offsets, std::span<const Vec<D>> reference_offsets,
                                      const Execution& execution) {
    auto started =
        each(part_of(execution, 0, 0.8), packs(), [&](std::size_t pack) { begin_pack(pack, offsets); }, packs_at_once);
    if (!started) return fail(started.error());
    const auto total = reduce_each(
        without_progress(execution), elements_, 0.0, [&](double& sum, std::size_t e) { sum += errors_[e]; },
        [](double a, double b) { return a + b; });
    if (!total) return total;
    const double least = least_share * *total / static_cast<double>(std::max<std::size_t>(elements_, 1));
    auto stiff = each(
        part_of(execution, 0.8, 1), packs(),
        [&](std::size_t pack) { stiffen(pack, offsets, reference_offsets, least); }, packs_at_once);
    if (!stiff) return fail(stiff.error());
    return total;
}

template <int D>
void ErrorSystem<D>::multiply(std::size_t pack, std::span<const Vec<D>> x) {
    std::array<Lanes, Errors::unknowns> lanes{};
    for (int lane = 0; lane < pack_size; ++lane) {
        const auto& edges = mesh_.edges.of_elements[element_of(pack, lane)];
        for (int k = 0; k < edges_per_simplex<D>; ++k)
            for (int i = 0; i < D; ++i) lanes[k * D + i][lane] = x[edges[k].index()][i];
    }
    const float* matrix = curvature_.data() + pack * Errors::entries * pack_size;
    double* const out = product_.data() + pack * Errors::unknowns * pack_size;
    with_instructions(widest_instructions(), [&]() __attribute__((always_inline)) {
        std::array<Pack, Errors::unknowns> in{}, sum{};
        std::memcpy(in.data(), lanes.data(), sizeof in);
        for (int i = 0; i < Errors::unknowns; ++i)
            for (int j = 0; j <= i; ++j, matrix += pack_size) {
                FloatPack single;
                std::memcpy(&single, matrix, sizeof single);
                const Pack a = __builtin_convertvector(single, Pack);
                sum[i] += a * in[j];
                if (j < i) sum[j] += a * in[i];
            }
        std::memcpy(out, sum.data(), sizeof sum);
    });
}

template <int D>
Vec<D> ErrorSystem<D>::gathered(std::size_t edge, std::span<const double> parts) const {
    Vec<D> sum;
    for (const ElementId e : shells_[edge]) {
        const auto& edges = mesh_.edges.of_elements[e];
        const auto k = static_cast<std::size_t>(std::ranges::find(edges, EdgeId(edge)) - edges.begin());
        const std::size_t pack = e.index() / pack_size, lane = e.index() % pack_size;
        for (std::size_t i = 0; i < D; ++i) sum[i] += parts[(pack * Errors::unknowns + k * D + i) * pack_size + lane];
    }
    return sum;
}

template <int D>
Sym<D> ErrorSystem<D>::preconditioner(std::size_t edge) const {
    Sym<D> sum;
    for (const ElementId e : shells_[edge]) {
        const auto& edges = mesh_.edges.of_elements[e];
        const auto k = static_cast<int>(std::ranges::find(edges, EdgeId(edge)) - edges.begin());
        const std::size_t pack = e.index() / pack_size, lane = e.index() % pack_size;
        for (int i = 0; i < D; ++i)
            for (int j = 0; j <= i; ++j)
                sum(i, j) +=
                    static_cast<double>(curvature_[(pack * Errors::entries +
                                                    static_cast<std::size_t>(Errors::entry(k * D + i, k * D + j))) *
                                                       pack_size +
                                                   lane]);
    }
    return inverse_of(sum);
}

template <int D>
Outcome<Buffer<Vec<D>>> ErrorSystem<D>::solved(int iterations, const Execution& execution) {
    return guarded([&]() -> Outcome<Buffer<Vec<D>>> {
        const Execution quiet = without_progress(execution);
        const std::size_t n = mesh_.edges.size();
        Buffer<Vec<D>> x(n, Vec<D>{}), residual(n, Vec<D>{}), corrected(n, Vec<D>{}), direction(n, Vec<D>{}),
            product(n, Vec<D>{});
        Buffer<Sym<D>> inverse(n, Sym<D>{});
        auto done = each(quiet, n, [&](std::size_t e) {
            if (!is_free(e)) return;
            residual[e] = -gathered(e, slope_);
            inverse[e] = preconditioner(e);
            direction[e] = corrected[e] = inverse[e] * residual[e];
        });
        if (!done) return fail(done.error());
        auto size = product_of<D>(residual, corrected, quiet);
        if (!size) return fail(size.error());
        const double first = *size;
        for (int step = 0; step < iterations && *size > 1e-6 * first; ++step) {
            done = each(quiet, packs(), [&](std::size_t pack) { multiply(pack, direction); }, packs_at_once);
            if (!done) return fail(done.error());
            done = each(quiet, n, [&](std::size_t e) {
                if (is_free(e)) product[e] = gathered(e, product_);
            });
            if (!done) return fail(done.error());
            const auto along = product_of<D>(direction, product, quiet);
            if (!along) return fail(along.error());
            if (!(*along > 0)) break;
            const double length = *size / *along;
            done = each(quiet, n, [&](std::size_t e) {
                x[e] += length * direction[e];
                residual[e] -= length * product[e];
                corrected[e] = inverse[e] * residual[e];
            });
            if (!done) return fail(done.error());
            const auto next = product_of<D>(residual, corrected, quiet);
            if (!next) return fail(next.error());
            const double turn = *next / *size;
            done = each(quiet, n, [&](std::size_t e) { direction[e] = corrected[e] + turn * direction[e]; });
            if (!done) return fail(done.error());
            size = next;
            report_progress(execution, static_cast<std::size_t>(step) + 1, static_cast<std::size_t>(iterations));
        }
        return x;
    });
}

template class ErrorSystem<2>;
template class ErrorSystem<3>;

}  // namespace camber
