module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.recovery;
import camber.bezier;
import camber.core;

namespace camber {

namespace {

constexpr std::size_t elements_at_once = 64;
/// Of a curved element so fine a lattice determines its polynomial, all places of the same weight.
constexpr int fine_degree = lattice_degree + 1;
constexpr double even_core = 1e3;

template <int D, int N>
using Lattice = std::array<Vec<D>, node_count<N, D>>;

/// Places of the lattice α/N: Σ λ_i x_i, and on curved elements 4 λ_i λ_j times the offset of each edge's node more.
template <int D, int N>
Lattice<D, N> lattice_of(const LinearMesh<D>& mesh, ElementId e,
                         const std::array<Vec<D>, edges_per_simplex<D>>& offsets) {
    constexpr auto& all = multi_indices<N, D>;
    Lattice<D, N> places{};
    for (std::size_t q = 0; q < places.size(); ++q) {
        const auto share = [&](std::size_t i) { return all[q][i] * (1.0 / N); };
        for (std::size_t v = 0; v <= D; ++v) places[q] += share(v) * mesh.points[mesh.elements.vertices[e][v]];
        for (std::size_t k = 0; k < offsets.size(); ++k) {
            const auto [i, j] = local_edges<D>[k];
            places[q] += (4 * share(static_cast<std::size_t>(i)) * share(static_cast<std::size_t>(j))) * offsets[k];
        }
    }
    return places;
}

/// The exponent of the power of two in which the function's range at the vertices is about 1. Nothing where it is not
/// finite.
template <int D>
std::optional<int> exponent_of(const LinearMesh<D>& mesh, const FunctionOfPlace<D>& function) {
    Buffer<double> values(mesh.points.size());
    function()(std::span<const Vec<D>>(mesh.points), std::span<double>(values));
    if (!std::ranges::all_of(values, [](double x) { return std::isfinite(x); })) return std::nullopt;
    const auto [least, largest] = std::ranges::minmax(values);
    const double half_range = largest / 2 - least / 2;
    return half_range > 0 ? std::ilogb(half_range) : 0;
}

/// One thread's work.
template <int D>
class FunctionWithin {
  public:
    FunctionWithin(const QuadraticMesh<D>& mesh, const FunctionOfPlace<D>& function, int exponent)
        : mesh_(mesh), evaluate_(function()), exponent_(exponent) {}

    [[nodiscard]] LatticeValues<D> values(ElementId e) {
        std::array<Vec<D>, edges_per_simplex<D>> offsets{};
        bool is_straight = true;
        if (!mesh_.mid_nodes.empty())
            for (std::size_t k = 0; k < offsets.size(); ++k) {
                const EdgeId edge = mesh_.edges.of_elements[e][k];
                const auto& [a, b] = mesh_.edges.vertices[edge];
                offsets[k] = mesh_.mid_nodes[edge].point - midpoint(mesh_.linear.points[a], mesh_.linear.points[b]);
                is_straight = is_straight && offsets[k] == Vec<D>{};
            }
        return is_straight ? at_lattice(e) : fitted(e, offsets);
    }

  private:
    [[nodiscard]] float in_unit(double difference) const {
        return static_cast<float>(std::scalbn(difference, -exponent_));
    }

    [[nodiscard]] LatticeValues<D> at_lattice(ElementId e) {
        const auto places = lattice_of<D, lattice_degree>(mesh_.linear, e, {});
        std::array<double, places.size()> u{};
        evaluate_(std::span<const Vec<D>>(places), std::span<double>(u));
        LatticeValues<D> out{};
        for (std::size_t q = 0; q < out.size(); ++q) out[q] = in_unit(u[q] - u[0]);
        return out;
    }

    [[nodiscard]] LatticeValues<D> fitted(ElementId e, const std::array<Vec<D>, edges_per_simplex<D>>& offsets) {
        auto places = lattice_of<D, fine_degree>(mesh_.linear, e, offsets);
        std::array<double, places.size()> u{};
        evaluate_(std::span<const Vec<D>>(places), std::span<double>(u));
        LatticeValues<D> out{};
        if (!std::ranges::all_of(u, [](double x) { return std::isfinite(x); })) {
            out.fill(std::numeric_limits<float>::quiet_NaN());
            return out;
        }
        const Vec<D> first = places[0];
        double largest = 0;
        for (const Vec<D>& x : places)
            for (const double c : x.c) largest = std::max(largest, std::abs(c));
        for (Vec<D>& x : places) x = x - first;
        fit_.place(places, std::numeric_limits<double>::epsilon() * largest, even_core);
        const Unit unit = scale(u);
        if (!(unit.half > 0)) return out;
        const auto c = fit_.solve(u, lattice_degree);
        std::array<Vec<D>, D> axes;
        for (std::size_t a = 0; a < D; ++a)
            axes[a] = fit_.whitened_by() * (mesh_.linear.points[mesh_.linear.elements.vertices[e][a + 1]] - first);
        const auto values = values_at_lattice<D, lattice_degree>(c, Vec<D>{}, axes);
        for (std::size_t q = 0; q < out.size(); ++q) out[q] = in_unit(unit.times(values[q] - values[0]));
        return out;
    }

    const QuadraticMesh<D>& mesh_;
    std::function<void(std::span<const Vec<D>>, std::span<double>)> evaluate_;
    int exponent_;
    Fit<D, lattice_degree> fit_;
};

}  // namespace

template <int D>
Outcome<Column<LatticeValues<D>>> element_values(const QuadraticMesh<D>& mesh, const FunctionOfPlace<D>& function,
                                                 const Execution& execution) {
    const auto not_finite = [](Entity where) {
        return fail(ErrorKind::usage, "the function that nodes are placed by is no number there", {}, where,
                    "give one that is finite on the whole domain");
    };
    return guarded([&]() -> Outcome<Column<LatticeValues<D>>> {
        const std::size_t n = mesh.linear.elements.size();
        if (n == 0) return Column<LatticeValues<D>>{};
        const auto exponent = exponent_of(mesh.linear, function);
        if (!exponent) return not_finite({});
        Buffer<LatticeValues<D>> values(n);
        const auto done = each_chunk(
            execution, n,
            [&](std::size_t begin, std::size_t end) {
                FunctionWithin<D> within(mesh, function, *exponent);
                for (std::size_t e = begin; e < end; ++e) values[e] = within.values(ElementId(e));
            },
            elements_at_once);
        if (!done) return fail(done.error());
        const auto bad = std::ranges::find_if_not(values, [](const LatticeValues<D>& at) {
            return std::ranges::all_of(at, [](float x) { return std::isfinite(x); });
        });
        if (bad != values.end()) return not_finite({"element", static_cast<std::size_t>(bad - values.begin()) + 1});
        return Column<LatticeValues<D>>(std::move(values));
    });
}

template Outcome<Column<LatticeValues<2>>> element_values<2>(const QuadraticMesh<2>&, const FunctionOfPlace<2>&,
                                                             const Execution&);
template Outcome<Column<LatticeValues<3>>> element_values<3>(const QuadraticMesh<3>&, const FunctionOfPlace<3>&,
                                                             const Execution&);

}  // namespace camber
