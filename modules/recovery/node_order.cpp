module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.recovery;
import camber.core;

namespace camber {

namespace {

struct Centred {
    std::vector<double> values;
    double square = 0;
};
Centred centred(std::span<const double> values) {
    Centred out{{values.begin(), values.end()}};
    double mean = 0;
    for (const double x : values) mean += x / static_cast<double>(values.size());
    for (double& x : out.values) {
        x -= mean;
        out.square += x * x;
    }
    return out;
}

/// Participation number (Σ x²)²/Σ x⁴ of centred values x: approximately the number of values that differ from the mean.
double participation(const Centred& c) {
    double fourth = 0;
    for (const double x : c.values) fourth += x * x * x * x;
    return fourth > 0 ? c.square * c.square / fourth : 0;
}

/// Values compressed as in `check_node_order`. Empty if their range is below 10⁻⁴ of the largest absolute value,
/// because it may be noise.
std::optional<std::vector<double>> compressed(std::span<const double> values) {
    constexpr double least_range = 1e-4, linear = 1e-3;
    if (values.empty()) return std::nullopt;
    const auto [low, high] = std::ranges::minmax(values);
    const double range = high - low;
    if (!(range > least_range * std::max(std::abs(low), std::abs(high))) || !std::isfinite(range)) return std::nullopt;
    std::vector<double> out(values.begin(), values.end());
    const auto middle = out.begin() + static_cast<std::ptrdiff_t>(out.size() / 2);
    std::ranges::nth_element(out, middle);
    const double median = *middle, unit = linear * range;
    for (std::size_t i = 0; i < out.size(); ++i) {
        const double x = std::abs(values[i] - median) / unit;
        out[i] = std::copysign(log(x + std::sqrt(x * x + 1)), values[i] - median);
    }
    return out;
}

using EdgeEnds = Column<std::array<VertexId, 2>>;

class NeighbourMeans {
  public:
    NeighbourMeans(const EdgeEnds& edges, std::size_t vertices) : edges_(edges), degrees_(vertices) {
        for (const auto& ends : edges)
            for (const VertexId v : ends) ++degrees_[v.index()];
    }

    [[nodiscard]] std::vector<double> operator()(const std::vector<double>& values) const {
        std::vector<double> means(values.size());
        for (const auto& [a, b] : edges_) {
            means[a.index()] += values[b.index()];
            means[b.index()] += values[a.index()];
        }
        for (std::size_t v = 0; v < means.size(); ++v)
            if (degrees_[v] > 0) means[v] /= degrees_[v];
        return means;
    }

  private:
    const EdgeEnds& edges_;
    std::vector<std::uint32_t> degrees_;
};

double product(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
}

/// Four moments of a field u on the graph of edges: (u, Pu), (Pu, Pu), (Pu, P²u) and (P²u, P²u), each divided by (u,
/// u). P replaces each value by the mean of its neighbours' values.
constexpr std::size_t moment_count = 4;
using Moments = std::array<double, moment_count>;
Moments moments_of(const NeighbourMeans& means, const Centred& field) {
    const auto once = means(field.values), twice = means(once);
    Moments moments{product(field.values, once), product(once, once), product(once, twice), product(twice, twice)};
    for (double& m : moments) m /= field.square;
    return moments;
}

void shuffle(std::vector<double>& values, std::uint64_t& state) {
    for (std::size_t i = values.size(); i > 1; --i) {
        state += 0x9e3779b97f4a7c15ULL;
        std::swap(values[i - 1], values[mixed_bits(state) % i]);
    }
}

/// True if each moment is within `most_deviations` standard deviations of its mean over random orders of the values.
bool is_like_random(const NeighbourMeans& means, Centred field, const Moments& moments) {
    constexpr int orders = 32;
    constexpr double most_deviations = 2.5;
    Moments sum{}, squares{};
    std::uint64_t state = 1;
    for (int i = 0; i < orders; ++i) {
        shuffle(field.values, state);
        const Moments of_order = moments_of(means, field);
        for (std::size_t k = 0; k < moment_count; ++k) {
            sum[k] += of_order[k] / orders;
            squares[k] += of_order[k] * of_order[k] / orders;
        }
    }
    for (std::size_t k = 0; k < moment_count; ++k) {
        const double deviation = std::sqrt(std::max(squares[k] - sum[k] * sum[k], 0.0));
        if (std::abs(moments[k] - sum[k]) > most_deviations * deviation) return false;
    }
    return true;
}

/// Returns the edges in the order of the first element that contains each edge. Edges without elements are last.
template <int D>
std::vector<std::size_t> edges_by_first_element(const EdgeSet<D>& edges) {
    std::vector<std::size_t> order;
    std::vector<bool> is_named(edges.size());
    const auto name = [&](std::size_t e) {
        if (is_named[e]) return;
        is_named[e] = true;
        order.push_back(e);
    };
    for (const auto& of_element : edges.of_elements)
        for (const EdgeId e : of_element) name(e.index());
    for (std::size_t e = 0; e < edges.size(); ++e) name(e);
    return order;
}

struct MiddleFit {
    double correlation = 1;
    /// Σ (edge value − mean of the ends' values)². `square`: in the input order; `square_by_element`: in the order of
    /// `edges_by_first_element`.
    double square = 0, square_by_element = 0;
};
template <int D>
MiddleFit middle_fit(const EdgeSet<D>& edges, std::span<const double> vertices, std::span<const double> middles) {
    std::vector<double> means(edges.size());
    for (std::size_t e = 0; e < means.size(); ++e)
        means[e] = (vertices[edges.vertices[e][0].index()] + vertices[edges.vertices[e][1].index()]) / 2;
    MiddleFit fit;
    const auto order = edges_by_first_element(edges);
    for (std::size_t e = 0; e < means.size(); ++e) {
        fit.square += (middles[e] - means[e]) * (middles[e] - means[e]);
        fit.square_by_element += (middles[e] - means[order[e]]) * (middles[e] - means[order[e]]);
    }
    const Centred a = centred(means), b = centred(middles);
    if (a.square > 0 && b.square > 0) fit.correlation = product(a.values, b.values) / std::sqrt(a.square * b.square);
    return fit;
}

/// Minimum participation numbers for verdicts, found by measurements. `of_random`: for the verdict `unrelated`.
constexpr double least_participation = 30, of_random = 200;
constexpr double related = 0.3, unrelated = 0.2, better_by = 3;

template <int D>
NodeOrderCheck checked(const QuadraticMesh<D>& mesh, std::span<const double> values) {
    const std::size_t vertices = mesh.linear.points.size();
    const auto all = compressed(values);
    if (!all) return {};
    const auto at_vertices = std::span(*all).first(vertices), at_edges = std::span(*all).subspan(vertices);
    Centred field = centred(at_vertices);
    const double different = participation(field);
    if (different < least_participation) return {};
    const NeighbourMeans means(mesh.edges.vertices, vertices);
    const Moments moments = moments_of(means, field);
    NodeOrderCheck check{.between_vertices = moments[0]};
    if (!at_edges.empty()) {
        if (participation(centred(at_edges)) < least_participation) return check;
        const MiddleFit fit = middle_fit(mesh.edges, at_vertices, at_edges);
        check.between_ends_and_middle = fit.correlation;
        if (better_by * fit.square_by_element < fit.square) {
            check.order = NodeOrder::by_first_element;
            return check;
        }
        if (std::abs(fit.correlation) >= unrelated) return check;
        if (moments[0] > related) {
            check.order = NodeOrder::unrelated_mid_nodes;
            return check;
        }
    }
    if (different >= of_random && std::abs(moments[0]) < unrelated && is_like_random(means, std::move(field), moments))
        check.order = NodeOrder::unrelated;
    return check;
}

}  // namespace

template <int D>
Outcome<NodeOrderCheck> check_node_order(const QuadraticMesh<D>& mesh, const Column<double>& values,
                                         const Execution& execution) {
    const std::size_t vertices = mesh.linear.points.size(), nodes = vertices + mesh.edges.size();
    if (values.size() != vertices && values.size() != nodes)
        return fail(ErrorKind::usage, "a field has " + std::to_string(values.size()) + " values", {}, {},
                    "give one per vertex (" + std::to_string(vertices) + "), or one per vertex and one per edge (" +
                        std::to_string(nodes) + ")");
    if (execution.stop.stop_requested()) return stopped();
    return guarded([&]() -> Outcome<NodeOrderCheck> { return checked(mesh, values.view()); });
}

template Outcome<NodeOrderCheck> check_node_order<2>(const QuadraticMesh<2>&, const Column<double>&, const Execution&);
template Outcome<NodeOrderCheck> check_node_order<3>(const QuadraticMesh<3>&, const Column<double>&, const Execution&);

}  // namespace camber
