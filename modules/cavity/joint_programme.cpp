module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>
#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
module camber.cavity;
import :jacobian_gradient;
import :joint_programme;
import camber.core;
import camber.bezier;
import camber.validity;

namespace camber {

namespace {

constexpr int most_updates = 12;  // of the multipliers
constexpr int most_steps = 8;     // between two of them
constexpr int patience = 4;       // updates without progress
constexpr double first_penalty = 10;
constexpr double largest_penalty = 1e8;

template <int D>
Vec<D> moved(const std::vector<Vec<D>>& offsets, int unknown) {
    return unknown == JointProgramme<D>::fixed ? Vec<D>{} : offsets[unknown];
}

/// P_i = p_i + δ_i and P_ij = p_ij + 2 m_ij + (δ_i + δ_j)/2: the node n_ij + m_ij + (δ_i + δ_j)/2 in Bézier form.
template <int D>
QuadraticSimplex<D, D> displaced(const typename JointProgramme<D>::Element& element,
                                 const std::vector<Vec<D>>& offsets) {
    QuadraticSimplex<D, D> out = element.bezier;
    for (int i = 0; i <= D; ++i) out.control[i] += moved(offsets, element.unknowns[i]);
    for (int e = 0; e < edges_per_simplex<D>; ++e) {
        const auto [i, j] = local_edges<D>[e];
        const int n = D + 1 + e;
        out.control[n] += 2 * moved(offsets, element.unknowns[n]) +
                          0.5 * (moved(offsets, element.unknowns[i]) + moved(offsets, element.unknowns[j]));
    }
    return out;
}

template <int D>
std::array<Vec<D>, D> straight_columns(const QuadraticSimplex<D, D>& element) {
    std::array<Vec<D>, D> columns;
    for (int a = 0; a < D; ++a) columns[a] = element.control[a + 1] - element.control[0];
    return columns;
}

template <int D>
double straight_determinant(const QuadraticSimplex<D, D>& element) {
    const auto columns = straight_columns<D>(element);
    return dot(columns[0], determinant_gradient(columns)[0]);
}

/// What an element's constraints are divided by: |det straight| at the start; a flat element's largest coefficient.
template <int D>
double scale_of(const QuadraticSimplex<D, D>& element) {
    const double straight = std::abs(straight_determinant<D>(element));
    double largest = 0;
    for (const double c : jacobian(element)) largest = std::max(largest, std::abs(c));
    return std::max({straight, 1e-6 * largest, 1e-300});
}

/// The programme while it is solved.
template <int D>
struct Solver {
    using Programme = JointProgramme<D>;
    static constexpr int coefficients = jacobian_coefficients<D>;

    const Programme& programme;
    std::vector<double> scales;
    std::vector<std::array<double, coefficients>> multipliers;
    double penalty = first_penalty;
    Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factors;
    bool analysed = false;

    explicit Solver(const Programme& p) : programme(p) {
        scales.reserve(p.elements.size());
        for (const auto& e : p.elements) scales.push_back(scale_of<D>(e.bezier));
        multipliers.resize(p.elements.size());
    }

    /// g = (c − floor · |det straight|) / scale ≥ 0, for all coefficients of an element.
    [[nodiscard]] std::array<double, coefficients> slacks(std::size_t e, const std::vector<Vec<D>>& offsets) const {
        const auto element = displaced<D>(programme.elements[e], offsets);
        std::array<double, coefficients> g = jacobian(element);
        const double level = programme.elements[e].floor * std::abs(straight_determinant<D>(element));
        for (double& x : g) x = (x - level) / scales[e];
        return g;
    }
    /// What a constraint still asks for: max(0, λ − μ g).
    [[nodiscard]] double force(double multiplier, double g) const { return std::max(0.0, multiplier - penalty * g); }

    /// Σ models + Σ max(0, λ − μ g)² / 2μ.
    [[nodiscard]] double merit(const std::vector<Vec<D>>& offsets) const {
        double sum = 0;
        for (std::size_t u = 0; u < offsets.size(); ++u) {
            const Vec<D> r = offsets[u] - programme.unknowns[u].centre;
            sum += 0.5 * dot(r, programme.unknowns[u].hessian * r);
        }
        for (std::size_t e = 0; e < programme.elements.size(); ++e) {
            const auto g = slacks(e, offsets);
            for (int k = 0; k < coefficients; ++k) {
                const double f = force(multipliers[e][k], g[k]);
                sum += f * f / (2 * penalty);
            }
        }
        return sum;
    }

    void update_multipliers(const std::vector<Vec<D>>& offsets) {
        for (std::size_t e = 0; e < programme.elements.size(); ++e) {
            const auto g = slacks(e, offsets);
            for (int k = 0; k < coefficients; ++k) multipliers[e][k] = force(multipliers[e][k], g[k]);
        }
    }

    [[nodiscard]] double shortfall(const std::vector<Vec<D>>& offsets) const {
        double largest = -1e300;
        for (std::size_t e = 0; e < programme.elements.size(); ++e)
            for (const double g : slacks(e, offsets)) largest = std::max(largest, -g);
        return largest;
    }

    struct Model {
        Eigen::VectorXd gradient;
        Eigen::SparseMatrix<double> hessian;
    };
    [[nodiscard]] Model model(const std::vector<Vec<D>>& offsets) const;
    /// A Gauss–Newton step that lowers the merit; false when there is none.
    bool step(std::vector<Vec<D>>& offsets);
};

/// Gradients of an element's slacks with respect to its unknowns.
template <int D>
struct SlackGradient {
    std::array<double, jacobian_coefficients<D>> value{};
    std::array<std::array<Vec<D>, quadratic_nodes<D>>, jacobian_coefficients<D>> gradient{};
};

template <int D>
SlackGradient<D> slack_gradient(const typename JointProgramme<D>::Element& element, const std::vector<Vec<D>>& offsets,
                                double scale) {
    const auto now = displaced<D>(element, offsets);
    const auto bezier = jacobian_gradient(now);
    const auto columns = straight_columns<D>(now);
    const auto cofactor = determinant_gradient(columns);
    const double straight = dot(columns[0], cofactor[0]);
    const double side = straight < 0 ? -element.floor : element.floor;
    SlackGradient<D> out;
    for (int k = 0; k < jacobian_coefficients<D>; ++k) {
        out.value[k] = (bezier.value[k] - side * straight) / scale;
        auto g = bezier.gradient[k];
        for (int a = 0; a < D; ++a) {
            g[a + 1] -= side * cofactor[a];
            g[0] += side * cofactor[a];
        }
        for (int e = 0; e < edges_per_simplex<D>; ++e) {
            const auto [i, j] = local_edges<D>[e];
            g[i] += 0.5 * g[D + 1 + e];
            g[j] += 0.5 * g[D + 1 + e];
            g[D + 1 + e] *= 2;
        }
        for (int n = 0; n < quadratic_nodes<D>; ++n) out.gradient[k][n] = g[n] * (1 / scale);
    }
    return out;
}

template <int D>
typename Solver<D>::Model Solver<D>::model(const std::vector<Vec<D>>& offsets) const {
    constexpr int nodes = quadratic_nodes<D>;
    const int n = static_cast<int>(offsets.size()) * D;
    Model out{Eigen::VectorXd::Zero(n), Eigen::SparseMatrix<double>(n, n)};
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(offsets.size() * D * D + programme.elements.size() * nodes * nodes * D * D);
    for (int u = 0; u < static_cast<int>(offsets.size()); ++u) {
        const auto& [centre, hessian] = programme.unknowns[u];
        const Vec<D> pull = hessian * (offsets[u] - centre);
        for (int i = 0; i < D; ++i) {
            out.gradient[u * D + i] += pull[i];
            for (int j = 0; j < D; ++j) entries.emplace_back(u * D + i, u * D + j, hessian(i, j));
        }
    }
    for (std::size_t e = 0; e < programme.elements.size(); ++e) {
        const auto& element = programme.elements[e];
        const auto slack = slack_gradient<D>(element, offsets, scales[e]);
        Eigen::Matrix<double, nodes * D, nodes * D> local = Eigen::Matrix<double, nodes * D, nodes * D>::Zero();
        for (int k = 0; k < coefficients; ++k) {
            const double f = force(multipliers[e][k], slack.value[k]);
            if (!(f > 0)) continue;
            Eigen::Matrix<double, nodes * D, 1> g;
            for (int m = 0; m < nodes; ++m)
                for (int i = 0; i < D; ++i) g[m * D + i] = slack.gradient[k][m][i];
            local += penalty * g * g.transpose();
            for (int m = 0; m < nodes; ++m)
                if (const int u = element.unknowns[m]; u != Programme::fixed)
                    for (int i = 0; i < D; ++i) out.gradient[u * D + i] -= f * g[m * D + i];
        }
        for (int m = 0; m < nodes; ++m)
            for (int l = 0; l < nodes; ++l) {
                const int u = element.unknowns[m];
                const int v = element.unknowns[l];
                if (u == Programme::fixed || v == Programme::fixed || u < v) continue;
                for (int i = 0; i < D; ++i)
                    for (int j = 0; j < D; ++j) entries.emplace_back(u * D + i, v * D + j, local(m * D + i, l * D + j));
            }
    }
    out.hessian.setFromTriplets(entries.begin(), entries.end());
    return out;
}

template <int D>
bool Solver<D>::step(std::vector<Vec<D>>& offsets) {
    const Model m = model(offsets);
    if (!analysed) factors.analyzePattern(m.hessian);
    analysed = true;
    factors.factorize(m.hessian);
    if (factors.info() != Eigen::Success) return false;
    const Eigen::VectorXd direction = factors.solve(-m.gradient);
    const double slope = m.gradient.dot(direction);
    const double before = merit(offsets);
    if (!(slope < -1e-9 * std::max(before, 1e-6))) return false;
    std::vector<Vec<D>> trial(offsets.size());
    for (double share = 1; share > 1e-3; share *= 0.5) {
        for (std::size_t u = 0; u < offsets.size(); ++u)
            for (int i = 0; i < D; ++i)
                trial[u][i] = offsets[u][i] + share * direction[static_cast<Eigen::Index>(u) * D + i];
        if (merit(trial) < before + 1e-4 * share * slope) {
            offsets = trial;
            return true;
        }
    }
    return false;
}

}  // namespace

template <int D>
JointSolution<D> solve(const JointProgramme<D>& programme) {
    JointSolution<D> solution{std::vector<Vec<D>>(programme.unknowns.size()), 0};
    Solver<D> solver(programme);
    const double first = solver.shortfall(solution.offsets);
    double before = first;
    for (int update = 0; update < most_updates; ++update) {
        for (int i = 0; i < most_steps; ++i)
            if (!solver.step(solution.offsets)) break;
        solution.shortfall = solver.shortfall(solution.offsets);
        solver.update_multipliers(solution.offsets);
        if (solution.shortfall < 1e-6) break;
        // Stuck in a fold: neither penalty nor multipliers have moved it.
        if (update >= patience && solution.shortfall > 0.5 * first) break;
        if (solution.shortfall > 0.3 * before) solver.penalty = std::min(5 * solver.penalty, largest_penalty);
        before = solution.shortfall;
    }
    return solution;
}

template JointSolution<2> solve<2>(const JointProgramme<2>&);
template JointSolution<3> solve<3>(const JointProgramme<3>&);

}  // namespace camber
