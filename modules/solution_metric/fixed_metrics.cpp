// Metrics of fixed sizes: sizes by reference and sizes by chord error.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>
#define EIGEN_ALLOCA __builtin_alloca
#include <Eigen/Dense>
module camber.solution_metric;
import camber.core;
import camber.bezier;
import camber.metric;

namespace camber {

namespace {

bool is_length(double size) { return size >= min_length && size <= max_length; }

std::size_t each_vertex_of(const auto& simplices, Reference reference, const auto& visit) {
    std::size_t found = 0;
    for (std::size_t s = 0; s < simplices.size(); ++s) {
        if (simplices.references[s] != reference) continue;
        ++found;
        for (const VertexId v : simplices.vertices[s]) visit(v);
    }
    return found;
}

template <int D>
std::size_t each_vertex_of(const LinearMesh<D>& mesh, ReferencedEntity of, Reference reference, const auto& visit) {
    if (of == ReferencedEntity::elements) return each_vertex_of(mesh.elements, reference, visit);
    // In 2D the edges of the boundary are stored as facets.
    if (of == ReferencedEntity::facets || (D == 2 && of == ReferencedEntity::edges))
        return each_vertex_of(mesh.facets, reference, visit);
    if (of == ReferencedEntity::edges) return each_vertex_of(mesh.edges, reference, visit);
    std::size_t found = 0;
    for (std::size_t v = 0; v < mesh.point_references.size(); ++v)
        if (mesh.point_references[v] == reference) {
            ++found;
            visit(VertexId(v));
        }
    return found;
}

template <int D>
Outcome<Done> check(const LinearMesh<D>& mesh, std::span<const MetricsAtVertices<D>> at_some,
                    std::span<const Column<LogMetric<D>>> at_all, double largest, const Execution& execution) {
    if (!is_length(largest)) return fail(ErrorKind::usage, "the largest size must be positive and finite");
    for (const auto& metrics : at_some) {
        const bool fits = metrics.vertices.size() == metrics.log_metrics.size() &&
                          std::all_of(metrics.vertices.begin(), metrics.vertices.end(),
                                      [&](VertexId v) { return v.index() < mesh.points.size(); });
        if (!fits) return fail(ErrorKind::usage, "the metrics at vertices belong to another mesh");
        if (auto sound = check_sizes(metrics.log_metrics, execution); !sound) return sound;
    }
    for (const auto& metric : at_all) {
        if (metric.size() != mesh.points.size()) return fail(ErrorKind::usage, "the metric belongs to another mesh");
        if (auto sound = check_sizes(metric, execution); !sound) return sound;
    }
    return Done{};
}

}  // namespace

template <int D>
Outcome<MetricsAtVertices<D>> sizes_by_reference(const LinearMesh<D>& mesh, std::span<const ReferenceSize> sizes) {
    return guarded([&]() -> Outcome<MetricsAtVertices<D>> {
        constexpr double none = std::numeric_limits<double>::infinity();
        Buffer<double> least(mesh.points.size(), none);
        for (const ReferenceSize& requested : sizes) {
            if (!is_length(requested.size))
                return fail(ErrorKind::usage, "a size of " + std::to_string(requested.size) +
                                                  " by reference is not between 1e-60 and 1e60");
            const auto lower = [&](VertexId v) { least[v.index()] = std::min(least[v.index()], requested.size); };
            for (const Reference reference : requested.references)
                if (each_vertex_of(mesh, requested.of, reference, lower) == 0)
                    return fail(ErrorKind::usage,
                                "none of the mesh's " + std::string(word_of(requested.of)) + " has the reference " +
                                    std::to_string(reference),
                                {}, {}, "camber info lists the references of the mesh");
        }
        Buffer<VertexId> vertices;
        Buffer<LogMetric<D>> logs;
        for (std::size_t v = 0; v < least.size(); ++v) {
            if (least[v] == none) continue;
            vertices.push_back(VertexId(v));
            logs.push_back({-2 * log(least[v]) * Sym<D>::identity()});
        }
        return MetricsAtVertices<D>{std::move(vertices), std::move(logs)};
    });
}

template <int D>
Outcome<Column<LogMetric<D>>> fixed_metric(const LinearMesh<D>& mesh, std::span<const MetricsAtVertices<D>> at_some,
                                           std::span<const Column<LogMetric<D>>> at_all, double largest,
                                           const Execution& execution) {
    if (auto sound = check(mesh, at_some, at_all, largest, without_progress(execution)); !sound)
        return fail(sound.error());
    return guarded([&]() -> Outcome<Column<LogMetric<D>>> {
        Buffer<LogMetric<D>> whole(mesh.points.size(), LogMetric<D>{-2 * log(largest) * Sym<D>::identity()});
        for (const auto& metrics : at_some)
            for (std::size_t i = 0; i < metrics.vertices.size(); ++i) {
                LogMetric<D>& here = whole[metrics.vertices[i].index()];
                here = intersection(here, metrics.log_metrics[i]);
            }
        Column<LogMetric<D>> out(std::move(whole));
        for (const auto& metric : at_all) {
            auto both = intersection(out, metric, execution);
            if (!both) return fail(both.error());
            out = std::move(*both);
        }
        return out;
    });
}

namespace {

template <int D>
struct Curved {
    Vec<D> normal;
    std::array<Vec<D>, D - 1> tangents;
    std::array<double, D - 1> curvatures{};
};

Curved<2> principal(const Vec<2>& n, const std::array<Vec<2>, 1>& tangents, const std::array<double, 1>& shape) {
    return {n, tangents, {std::abs(shape[0])}};
}
Curved<3> principal(const Vec<3>& n, const std::array<Vec<3>, 2>& tangents, const std::array<double, 3>& shape) {
    const EigenSystem<2> e = eigen_system(Sym<2>{shape});
    Curved<3> out{n, {}, {std::abs(e.values[0]), std::abs(e.values[1])}};
    for (int i = 0; i < 2; ++i) out.tangents[i] = e.vectors(0, i) * tangents[0] + e.vectors(1, i) * tangents[1];
    return out;
}

template <int D>
Vec<D> side_normal(const LinearMesh<D>& mesh, Side side) {
    Vec<D> sum;
    for (const FacetId f : side) sum += to_side_of(area_normal(mesh, f), sum);
    return normalised(sum);
}

/// Matrices of fits have a dynamic size, so that Eigen's decomposition is compiled only once.
constexpr int most_unknowns = 5;
using Equations = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, Eigen::Dynamic, most_unknowns>;
using Unknowns = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, most_unknowns, 1>;

bool solve(const Equations& a, const Eigen::VectorXd& b, Unknowns& x) {
    Eigen::ColPivHouseholderQR<Equations> qr(a);
    qr.setThreshold(1e-6);
    if (qr.rank() < a.cols()) return false;
    x = qr.solve(b);
    return true;
}

/// Least-squares fit of a quadratic function through a vertex to two rings of vertices around it, within one patch.
template <int D>
class Fit {
    static constexpr int slopes = D - 1, unknowns = slopes + sym_size<D - 1>;

  public:
    Fit(const LinearMesh<D>& mesh, const Incidence<FacetId>& balls, const Column<std::uint32_t>& patches)
        : mesh_(mesh), balls_(balls), patches_(patches) {}

    [[nodiscard]] Curved<D> operator()(VertexId v, Side side) {
        const Vec<D> n = side_normal(mesh_, side);
        const auto tangents = tangents_of(n);
        collect(v, side);
        std::array<double, sym_size<D - 1>> shape{};
        // If there are fewer points than unknowns, the surface counts as flat.
        if (ring_.size() >= static_cast<std::size_t>(unknowns)) shape = fitted(mesh_.points[v], n, tangents);
        return principal(n, tangents, shape);
    }

  private:
    void add_ring(Side facets, VertexId v, std::uint32_t patch) {
        for (const FacetId f : facets)
            if (patches_[f] == patch)
                for (const VertexId w : mesh_.facets.vertices[f])
                    if (w != v && std::find(ring_.begin(), ring_.end(), w) == ring_.end()) ring_.push_back(w);
    }
    void collect(VertexId v, Side side) {
        constexpr std::size_t enough = 40;  // number of ring vertices after which no more are added
        ring_.clear();
        const std::uint32_t patch = patches_[side[0]];
        add_ring(side, v, patch);
        const std::size_t first = ring_.size();
        for (std::size_t i = 0; i < first && ring_.size() < enough; ++i) add_ring(balls_[ring_[i]], v, patch);
    }
    [[nodiscard]] std::array<double, sym_size<D - 1>> fitted(const Vec<D>& origin, const Vec<D>& n,
                                                             const std::array<Vec<D>, D - 1>& tangents) const {
        // Lengths are divided by the radius of the rings.
        double radius = 0;
        for (const VertexId w : ring_) radius = std::max(radius, distance(mesh_.points[w], origin));
        std::array<double, sym_size<D - 1>> shape{};
        if (!(radius > 0)) return shape;
        static_assert(unknowns <= most_unknowns);
        Equations a(ring_.size(), unknowns);
        Eigen::VectorXd b(ring_.size());
        for (std::size_t r = 0; r < ring_.size(); ++r) {
            const auto row = static_cast<Eigen::Index>(r);
            const Vec<D> e = (mesh_.points[ring_[r]] - origin) / radius;
            const double weight = 1 / std::max(norm_squared(e), 1e-6);
            Vec<D - 1> x;
            for (int i = 0; i < D - 1; ++i) x[i] = dot(tangents[i], e);
            int k = 0;
            for (int i = 0; i < D - 1; ++i) a(row, k++) = weight * x[i];
            for (int i = 0; i < D - 1; ++i)
                for (int j = 0; j <= i; ++j) a(row, k++) = weight * (i == j ? 0.5 : 1) * x[i] * x[j];
            b(row) = weight * dot(n, e);
        }
        Unknowns x;
        if (!solve(a, b, x)) return shape;
        // In tangential coordinates x, the fitted function is h = a·x + ½ xᵀSx. Its curvature S/(1 + |a|²)^{3/2} is S
        // to first order in the small slope a.
        for (std::size_t k = 0; k < shape.size(); ++k) shape[k] = x(slopes + static_cast<Eigen::Index>(k)) / radius;
        return shape;
    }

    const LinearMesh<D>& mesh_;
    const Incidence<FacetId>& balls_;
    const Column<std::uint32_t>& patches_;
    std::vector<VertexId> ring_;
};

template <int D>
struct FacetJet {
    std::array<Vec<D>, D - 1> first;
    std::array<std::array<Vec<D>, D - 1>, D - 1> second;
};
template <int D>
FacetJet<D> jet_at(const QuadraticMesh<D>& mesh, FacetId f, VertexId v) {
    const QuadraticSimplex<D - 1, D> simplex = facet_of(mesh, f);
    const auto& corners = mesh.linear.facets.vertices[f];
    Barycentric<D - 1> at{};
    for (int i = 0; i < D; ++i) at[i] = corners[i] == v ? 1 : 0;
    FacetJet<D> jet;
    jet.first = simplex.derivatives(at);
    for (int a = 0; a < D - 1; ++a)
        for (int b = 0; b < D - 1; ++b)
            jet.second[a][b] =
                2.0 * (simplex.at(a + 1, b + 1) - simplex.at(a + 1, 0) - simplex.at(b + 1, 0) + simplex.control[0]);
    return jet;
}

/// Averages the second fundamental forms of the facets at a vertex, weighted by area, in the plane normal to the
/// facets' mean normal.
template <int D>
Curved<D> curved_of_facets(const QuadraticMesh<D>& mesh, VertexId v, Side side) {
    Vec<D> sum;
    for (const FacetId f : side) sum += to_side_of(area_normal(jet_at(mesh, f, v).first), sum);
    const Vec<D> n = normalised(sum);
    const auto tangents = tangents_of(n);
    std::array<double, sym_size<D - 1>> shape{};
    double all = 0;
    for (const FacetId f : side) {
        const FacetJet<D> jet = jet_at(mesh, f, v);
        const double area = norm(area_normal(jet.first));
        if (!(area > 0)) continue;
        // Second fundamental form S = G⁻ᵀ (n·F_ab) G⁻¹. F_ab are the second derivatives of the facet. The columns of G
        // are its first derivatives in the basis `tangents`.
        Eigen::Matrix<double, D - 1, D - 1> g, form;
        for (int a = 0; a < D - 1; ++a)
            for (int b = 0; b < D - 1; ++b) {
                g(a, b) = dot(tangents[a], jet.first[b]);
                form(a, b) = dot(n, jet.second[a][b]);
            }
        const Eigen::Matrix<double, D - 1, D - 1> inverse = g.inverse();
        const Eigen::Matrix<double, D - 1, D - 1> s = inverse.transpose() * form * inverse;
        if (!s.allFinite()) continue;
        for (int i = 0; i < D - 1; ++i)
            for (int j = 0; j <= i; ++j) shape[Sym<D - 1>::index(i, j)] += area * s(i, j);
        all += area;
    }
    if (all > 0)
        for (double& x : shape) x /= all;
    return principal(n, tangents, shape);
}

double chord_of(double curvature, const ChordOptions& options) {
    constexpr double none = std::numeric_limits<double>::infinity();
    const double by_error = options.chord_error > 0 ? std::sqrt(8 * options.chord_error / curvature) : none;
    const double by_angle = options.angle > 0 ? options.angle * std::numbers::pi / 180 / curvature : none;
    return std::min(by_error, by_angle);
}

template <int D>
LogMetric<D> metric_of(const Curved<D>& curved, const ChordOptions& options, double largest) {
    Vec<D> sizes;
    Mat<D> axes;
    double least = largest;
    for (int i = 0; i < D - 1; ++i) {
        sizes[i] = std::clamp(chord_of(curved.curvatures[i], options), min_length, largest);
        axes.column[i] = curved.tangents[i];
        least = std::min(least, sizes[i]);
    }
    sizes[D - 1] = std::min(largest, options.normal_ratio * least);
    axes.column[D - 1] = curved.normal;
    return log_metric_of_sizes(sizes, axes);
}

/// Computes the metrics of all sides (a side consists of the facets of one patch around a vertex). `make_curved()` is
/// called once per chunk of vertices. It returns a function that computes the curvatures of a side.
template <int D>
Outcome<MetricsAtVertices<D>> metrics_of_sides(const Incidence<FacetId>& balls, const Column<std::uint32_t>& patches,
                                               const ChordOptions& options, double largest, const Execution& execution,
                                               const auto& make_curved) {
    return guarded([&]() -> Outcome<MetricsAtVertices<D>> {
        Buffer<VertexId> vertices;
        for (std::size_t v = 0; v < balls.size(); ++v)
            if (std::ranges::any_of(balls[v], [&](FacetId f) { return patches[f] != no_patch; }))
                vertices.push_back(VertexId(v));
        Buffer<LogMetric<D>> logs(vertices.size());
        auto done = each_chunk(execution, vertices.size(), [&](std::size_t begin, std::size_t end) {
            auto curved = make_curved();
            std::vector<FacetId> facets;
            for (std::size_t i = begin; i < end; ++i)
                each_side(balls[vertices[i]], patches, facets, [&](Side side) {
                    const LogMetric<D> own = metric_of<D>(curved(vertices[i], side), options, largest);
                    logs[i] = side.data() == facets.data() ? own : intersection(logs[i], own);
                });
        });
        if (!done) return fail(done.error());
        return MetricsAtVertices<D>{std::move(vertices), std::move(logs)};
    });
}

template <int D>
Outcome<Done> check_chords(const LinearMesh<D>& mesh, const Column<std::uint32_t>& patches, const ChordOptions& options,
                           double largest) {
    if (auto sound = check_limits(options); !sound) return sound;
    if (!(options.chord_error > 0) && !(options.angle > 0))
        return fail(ErrorKind::usage, "neither chord_error nor angle is positive");
    return check_sides(mesh, patches, largest);
}

}  // namespace

template <int D>
Outcome<MetricsAtVertices<D>> chord_metrics(const LinearMesh<D>& mesh, const Column<std::uint32_t>& patches,
                                            const ChordOptions& options, double largest, const Execution& execution) {
    if (auto sound = check_chords(mesh, patches, options, largest); !sound) return fail(sound.error());
    const auto balls = facet_balls(mesh, without_progress(execution));
    if (!balls) return fail(balls.error());
    return metrics_of_sides<D>(*balls, patches, options, largest, execution,
                               [&] { return Fit<D>(mesh, *balls, patches); });
}

template <int D>
Outcome<MetricsAtVertices<D>> chord_metrics(const QuadraticMesh<D>& mesh, const Column<std::uint32_t>& patches,
                                            const ChordOptions& options, double largest, const Execution& execution) {
    if (auto sound = check_chords(mesh.linear, patches, options, largest); !sound) return fail(sound.error());
    const auto balls = facet_balls(mesh.linear, without_progress(execution));
    if (!balls) return fail(balls.error());
    return metrics_of_sides<D>(*balls, patches, options, largest, execution,
                               [&] { return [&](VertexId v, Side side) { return curved_of_facets(mesh, v, side); }; });
}

#define CAMBER_INSTANTIATE(D)                                                                                       \
    template Outcome<MetricsAtVertices<D>> sizes_by_reference<D>(const LinearMesh<D>&,                              \
                                                                 std::span<const ReferenceSize>);                   \
    template Outcome<Column<LogMetric<D>>> fixed_metric<D>(                                                         \
        const LinearMesh<D>&, std::span<const MetricsAtVertices<D>>, std::span<const Column<LogMetric<D>>>, double, \
        const Execution&);                                                                                          \
    template Outcome<MetricsAtVertices<D>> chord_metrics<D>(const LinearMesh<D>&, const Column<std::uint32_t>&,     \
                                                            const ChordOptions&, double, const Execution&);         \
    template Outcome<MetricsAtVertices<D>> chord_metrics<D>(const QuadraticMesh<D>&, const Column<std::uint32_t>&,  \
                                                            const ChordOptions&, double, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
