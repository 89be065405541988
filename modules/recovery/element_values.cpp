// Evaluates fitted polynomials and functions at the lattice points of elements.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>
module camber.recovery;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// A node has the weight 1/(near_core + |y|). |y| ≤ 1 is its distance from the element's middle in whitened
/// coordinates.
constexpr double near_core = 0.05;
constexpr double own_surplus = 1.2;
constexpr double enough_independence_within = 1e-7;
constexpr int most_rings = 5;
constexpr std::size_t elements_at_once = 64;

template <int D, int K, int P>
class ElementFits {
  public:
    ElementFits(const NodalMesh<D>& nodal, std::span<const Column<double>> fields, const QuadraticMesh<D>& curved,
                std::vector<Buffer<LatticeValues<D>>>& out)
        : nodal_(nodal), fields_(fields), curved_(curved), out_(out), rings_(nodal) {}

    void fit(ElementId e) {
        const EdgeOffsets<D> offsets = edge_offsets(nodal_.mesh, e);
        std::array<double, D + 1> centroid{};
        centroid.fill(1.0 / (D + 1));
        middle_ = position_within(nodal_.mesh.linear, e, offsets, centroid);
        const int degree = place(e);
        Lattice<D> places = lattice_of(nodal_.mesh.linear, e, edge_offsets(curved_, e));
        for (Vec<D>& x : places) x = fit_.whitened_by() * (x - middle_);
        for (std::size_t f = 0; f < fields_.size(); ++f) {
            values_.clear();
            for (const std::uint32_t node : rings_.nodes()) values_.push_back(fields_[f][node]);
            const Unit unit = scale(values_);
            Coefficients<D, P> c{};
            if (unit.half > 0 && degree > K) c = fit_.solve(values_, degree);
            const auto values = values_at<D, P>(c, places);
            for (std::size_t q = 0; q < values.size(); ++q)
                out_[f][e.index()][q] = static_cast<float>(unit.times(values[q] - values[0]));
        }
    }

  private:
    /// Gathers nodes for a polynomial of degree P, and factorises the fit. Returns the degree that the nodes determine.
    int place(ElementId e) {
        rings_.begin(e);
        const auto grow = [&] { return rings_.count() < most_rings && rings_.grow(); };
        while (grow() && !are_enough(rings_.nodes().size(), P)) {
        }
        for (;;) {
            place_nodes();
            const int degree = determined();
            if (degree == P || !grow()) return degree;
        }
    }

    [[nodiscard]] static bool are_enough(std::size_t nodes, int degree) {
        return static_cast<double>(nodes) >= own_surplus * monomials_up_to<D>(degree);
    }

    void place_nodes() {
        offsets_.clear();
        double largest = 0;
        for (const std::uint32_t node : rings_.nodes()) {
            const Vec<D> x = nodal_.place(node);
            for (const double c : x.c) largest = std::max(largest, std::abs(c));
            offsets_.push_back(x - middle_);
        }
        fit_.place(offsets_, std::numeric_limits<double>::epsilon() * largest, near_core);
    }

    [[nodiscard]] int determined() const {
        int degree = P;
        while (degree > 0 &&
               (!are_enough(fit_.nodes(), degree) || fit_.independence(degree) < enough_independence_within))
            --degree;
        return degree;
    }

    const NodalMesh<D>& nodal_;
    std::span<const Column<double>> fields_;
    const QuadraticMesh<D>& curved_;
    std::vector<Buffer<LatticeValues<D>>>& out_;
    Rings<D> rings_;
    Fit<D, P> fit_;
    Vec<D> middle_;
    std::vector<Vec<D>> offsets_;
    std::vector<double> values_;
};

template <int D, int K, int P>
Outcome<std::vector<Column<LatticeValues<D>>>> fitted(const NodalMesh<D>& nodal, std::span<const Column<double>> fields,
                                                      const QuadraticMesh<D>& curved, const Execution& execution) {
    const std::size_t n = nodal.mesh.linear.elements.size();
    std::vector<Buffer<LatticeValues<D>>> out;
    out.reserve(fields.size());
    for (std::size_t f = 0; f < fields.size(); ++f) out.emplace_back(n);
    const auto done = each_chunk(
        execution, n,
        [&](std::size_t begin, std::size_t end) {
            ElementFits<D, K, P> fits(nodal, fields, curved, out);
            for (std::size_t e = begin; e < end; ++e) fits.fit(ElementId(e));
        },
        elements_at_once);
    if (!done) return fail(done.error());
    std::vector<Column<LatticeValues<D>>> columns;
    columns.reserve(out.size());
    for (auto& values : out) columns.emplace_back(std::move(values));
    return columns;
}

}  // namespace

template <int D>
Outcome<std::vector<Column<LatticeValues<D>>>> element_values(const QuadraticMesh<D>& mesh,
                                                              std::span<const Column<double>> fields,
                                                              const QuadraticMesh<D>& curved,
                                                              const Execution& execution) {
    return guarded([&]() -> Outcome<std::vector<Column<LatticeValues<D>>>> {
        const auto nodes = checked_nodes(mesh, fields, execution);
        if (!nodes) return fail(nodes.error());
        const NodalMesh<D> nodal = nodes->of(mesh);
        return nodal.degree == 1 ? fitted<D, 1, 4>(nodal, fields, curved, execution)
                                 : fitted<D, 2, 5>(nodal, fields, curved, execution);
    });
}

template Outcome<std::vector<Column<LatticeValues<2>>>> element_values<2>(const QuadraticMesh<2>&,
                                                                          std::span<const Column<double>>,
                                                                          const QuadraticMesh<2>&, const Execution&);
template Outcome<std::vector<Column<LatticeValues<3>>>> element_values<3>(const QuadraticMesh<3>&,
                                                                          std::span<const Column<double>>,
                                                                          const QuadraticMesh<3>&, const Execution&);

namespace {

template <int D>
Outcome<Buffer<LatticeValues<D>>> sampled(const QuadraticMesh<D>& mesh, const FunctionOfPosition<D>& function,
                                          int exponent, const Execution& execution) {
    Buffer<LatticeValues<D>> values(mesh.linear.elements.size());
    const auto done = each_chunk(
        execution, values.size(),
        [&](std::size_t begin, std::size_t end) {
            const auto evaluate = function();
            std::array<double, node_count<lattice_degree, D>> u{};
            for (std::size_t e = begin; e < end; ++e) {
                const Lattice<D> places = lattice_of(mesh.linear, ElementId(e), edge_offsets(mesh, ElementId(e)));
                evaluate(std::span<const Vec<D>>(places), std::span<double>(u));
                for (std::size_t q = 0; q < u.size(); ++q)
                    values[e][q] = static_cast<float>(std::scalbn(u[q] - u[0], -exponent));
            }
        },
        elements_at_once);
    if (!done) return fail(done.error());
    return values;
}

}  // namespace

template <int D>
Outcome<FunctionValues<D>> element_values(const QuadraticMesh<D>& mesh, const FunctionOfPosition<D>& function,
                                          const Execution& execution) {
    return guarded([&]() -> Outcome<FunctionValues<D>> {
        if (mesh.linear.elements.size() == 0) return FunctionValues<D>{};
        Buffer<double> at_vertices(mesh.linear.points.size());
        function()(std::span<const Vec<D>>(mesh.linear.points), std::span<double>(at_vertices));
        const int exponent = range_exponent(at_vertices);
        auto values = sampled(mesh, function, exponent, execution);
        if (!values) return fail(values.error());
        const auto bad = std::ranges::find_if(*values, [](const LatticeValues<D>& at) {
            return !std::ranges::all_of(at, [](float x) { return std::isfinite(x); });
        });
        if (bad != values->end())
            return fail(ErrorKind::usage, "the function that determines node positions is not a number there", {},
                        Entity{"element", static_cast<std::size_t>(bad - values->begin()) + 1},
                        "give a function that is finite on the whole domain");
        return FunctionValues<D>{Column<LatticeValues<D>>(std::move(*values)), exponent};
    });
}

template Outcome<FunctionValues<2>> element_values<2>(const QuadraticMesh<2>&, const FunctionOfPosition<2>&,
                                                      const Execution&);
template Outcome<FunctionValues<3>> element_values<3>(const QuadraticMesh<3>&, const FunctionOfPosition<3>&,
                                                      const Execution&);

}  // namespace camber
