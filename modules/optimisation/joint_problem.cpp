module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>
#include <Eigen/Cholesky>
#include <Eigen/Core>
module camber.optimisation;
import camber.core;
import camber.bezier;
import camber.validity;

namespace camber {

namespace {

/// Coefficients of det J and their derivatives, in the orders of multi_indices<D, D> and QuadraticSimplex.
template <int D>
struct JacobianGradient {
    std::array<double, jacobian_coefficients<D>> value{};
    std::array<std::array<Vec<D>, quadratic_nodes<D>>, jacobian_coefficients<D>> gradient{};
};

template <int D>
constexpr auto control_between = [] {
    std::array<std::array<int, D + 1>, D + 1> table{};
    for (int i = 0; i <= D; ++i) table[i][i] = i;
    for (int e = 0; e < edges_per_simplex<D>; ++e) {
        const auto [i, j] = local_edges<D>[e];
        table[i][j] = table[j][i] = D + 1 + e;
    }
    return table;
}();

constexpr std::array<Vec<2>, 2> determinant_gradient(const std::array<Vec<2>, 2>& c) {
    return {Vec<2>{{c[1][1], -c[1][0]}}, Vec<2>{{-c[0][1], c[0][0]}}};
}
constexpr std::array<Vec<3>, 3> determinant_gradient(const std::array<Vec<3>, 3>& c) {
    return {cross(c[1], c[2]), cross(c[2], c[0]), cross(c[0], c[1])};
}

/// One of the ways to write the multi-index α as an ordered sum Σ_a e_{i_a} of unit indices.
template <int D>
struct CoefficientWay {
    int position = 0;
    std::array<int, D> at{};  ///< i_a
    double weight = 0;        ///< 2^D / number of such sums
};

template <int D>
constexpr auto coefficient_ways = [] {
    std::array<CoefficientWay<D>, D == 2 ? 9 : 64> ways{};
    for (int w = 0; w < static_cast<int>(ways.size()); ++w) {
        MultiIndex<D> alpha{};
        for (int a = 0, rest = w; a < D; ++a, rest /= D + 1) ++alpha[ways[w].at[a] = rest % (D + 1)];
        ways[w].position = position<D, D>(alpha);
        ways[w].weight = (1 << D) / static_cast<double>(multinomial<D>(alpha));
    }
    return ways;
}();

/// Coefficient c_α is the mean over the ordered sums α = Σ_a e_{i_a} of 2^D det(d_1[i_1] … d_D[i_D]), d_a[i] =
/// P_{e_i+e_a} − P_{e_i+e_0} (Johnen, Remacle, Geuzaine 2013). Each summand is linear in each column.
template <int D>
JacobianGradient<D> jacobian_gradient(const QuadraticSimplex<D, D>& element) {
    JacobianGradient<D> out;
    for (const auto& [p, at, weight] : coefficient_ways<D>) {
        std::array<Vec<D>, D> columns;
        for (int a = 0; a < D; ++a)
            columns[a] =
                element.control[control_between<D>[at[a]][a + 1]] - element.control[control_between<D>[at[a]][0]];
        const auto cofactor = determinant_gradient(columns);
        out.value[p] += weight * dot(columns[0], cofactor[0]);
        for (int a = 0; a < D; ++a) {
            const Vec<D> g = weight * cofactor[a];
            out.gradient[p][control_between<D>[at[a]][a + 1]] += g;
            out.gradient[p][control_between<D>[at[a]][0]] -= g;
        }
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

template <int D>
double slack_scale(const QuadraticSimplex<D, D>& element) {
    const double straight = std::abs(straight_determinant<D>(element));
    double largest = 0;
    for (const double c : jacobian(element)) largest = std::max(largest, std::abs(c));
    return std::max({straight, 1e-6 * largest, 1e-300});
}

/// Moves vertices by δ and nodes by m: P_i = p_i + δ_i and P_ij = p_ij + 2 m_ij + (δ_i + δ_j)/2. This is the Bézier
/// form of the node n_ij + m_ij + (δ_i + δ_j)/2.
template <int D>
QuadraticSimplex<D, D> displaced(const typename JointProblem<D>::Element& element, const std::vector<Vec<D>>& offsets) {
    const auto moved = [&](int node) {
        const int unknown = element.unknowns[node];
        return unknown == JointProblem<D>::fixed ? Vec<D>{} : offsets[static_cast<std::size_t>(unknown)];
    };
    QuadraticSimplex<D, D> out = element.bezier;
    for (int i = 0; i <= D; ++i) out.control[i] += moved(i);
    for (int e = 0; e < edges_per_simplex<D>; ++e) {
        const auto [i, j] = local_edges<D>[e];
        out.control[D + 1 + e] += 2 * moved(D + 1 + e) + 0.5 * (moved(i) + moved(j));
    }
    return out;
}

template <int D>
using Slacks = std::array<double, jacobian_coefficients<D>>;

struct SlackLevel {
    double floor = 0;
    double least = -std::numeric_limits<double>::infinity();
};

/// Returns (c − max(floor · |det straight|, least)) / scale for each coefficient c of det J.
template <int D>
Slacks<D> slacks_of(const QuadraticSimplex<D, D>& element, SlackLevel of, double scale) {
    Slacks<D> g = jacobian(element);
    const double level = std::max(of.floor * std::abs(straight_determinant<D>(element)), of.least);
    for (double& x : g) x = (x - level) / scale;
    return g;
}

template <int D>
using SlackGradients = std::array<std::array<Vec<D>, quadratic_nodes<D>>, jacobian_coefficients<D>>;

template <int D>
SlackGradients<D> slack_gradients(const QuadraticSimplex<D, D>& element, SlackLevel of, double scale) {
    const auto columns = straight_columns<D>(element);
    const auto cofactor = determinant_gradient(columns);
    const double straight = dot(columns[0], cofactor[0]);
    const double floor = of.floor * std::abs(straight) < of.least ? 0 : of.floor;
    const double side = straight < 0 ? -floor : floor;
    SlackGradients<D> gradients = jacobian_gradient(element).gradient;
    for (auto& g : gradients) {
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
        for (auto& x : g) x *= 1 / scale;
    }
    return gradients;
}

constexpr int max_updates = 20;  // updates of the multipliers
constexpr int max_steps = 8;     // between two updates
constexpr int patience = 4;      // updates without progress
constexpr double largest_penalty = 1e8;

template <int D>
class Descent {
  public:
    using Problem = JointProblem<D>;
    using Offsets = std::vector<Vec<D>>;

    Descent(const Problem& p, Offsets start)
        : problem_(p), offsets_(std::move(start)), multipliers_(p.elements.size()), penalty_(p.first_penalty) {
        scales_.reserve(p.elements.size());
        for (const auto& e : p.elements) scales_.push_back(slack_scale<D>(e.bezier));
        slacks_ = slacks(offsets_);
        work_ += work_of_all_elements();
    }

    [[nodiscard]] const Offsets& offsets() const { return offsets_; }
    [[nodiscard]] double work() const { return work_; }
    [[nodiscard]] double shortfall() const {
        double largest = -1e300;
        for (const auto& of_element : slacks_)
            for (const double g : of_element) largest = std::max(largest, -g);
        return largest;
    }
    void update_multipliers() {
        for (std::size_t e = 0; e < slacks_.size(); ++e)
            for (int k = 0; k < coefficients; ++k) multipliers_[e][k] = force(e, k, slacks_[e][k]);
    }
    void raise_penalty() { penalty_ = std::min(5 * penalty_, largest_penalty); }
    bool step();

  private:
    static constexpr int coefficients = jacobian_coefficients<D>;
    static constexpr int nodes = quadratic_nodes<D>;

    struct Model {
        Eigen::VectorXd gradient;
        Eigen::MatrixXd hessian;
    };

    [[nodiscard]] std::vector<Slacks<D>> slacks(const Offsets& offsets) const {
        std::vector<Slacks<D>> all(problem_.elements.size());
        for (std::size_t e = 0; e < all.size(); ++e) {
            const auto& element = problem_.elements[e];
            all[e] = slacks_of<D>(displaced<D>(element, offsets), {element.floor, element.least}, scales_[e]);
        }
        return all;
    }
    [[nodiscard]] double force(std::size_t e, int k, double g) const {
        return std::max(0.0, multipliers_[e][k] - penalty_ * g);
    }
    [[nodiscard]] double merit(const Offsets& offsets, const std::vector<Slacks<D>>& slacks) const;
    [[nodiscard]] Model model() const;
    void add_element(std::size_t e, Model& model) const;

    [[nodiscard]] double work_of_all_elements() const {
        return element_work * static_cast<double>(problem_.elements.size());
    }

    const Problem& problem_;
    double work_ = 0;
    std::vector<double> scales_;
    Offsets offsets_;
    std::vector<Slacks<D>> slacks_;
    std::vector<Slacks<D>> multipliers_;
    double penalty_;
};

/// Returns Σ models + Σ max(0, λ − μ g)² / 2μ over the slacks g.
template <int D>
double Descent<D>::merit(const Offsets& offsets, const std::vector<Slacks<D>>& slacks) const {
    double sum = 0;
    for (std::size_t u = 0; u < offsets.size(); ++u) sum += problem_.unknowns[u](offsets[u]);
    for (std::size_t e = 0; e < slacks.size(); ++e)
        for (int k = 0; k < coefficients; ++k) {
            const double f = force(e, k, slacks[e][k]);
            sum += f * f / (2 * penalty_);
        }
    return sum;
}

template <int D>
void Descent<D>::add_element(std::size_t e, Model& model) const {
    const auto& element = problem_.elements[e];
    Slacks<D> forces;
    for (int k = 0; k < coefficients; ++k) forces[k] = force(e, k, slacks_[e][k]);
    if (std::ranges::none_of(forces, [](double f) { return f > 0; })) return;
    const auto gradients =
        slack_gradients<D>(displaced<D>(element, offsets_), {element.floor, element.least}, scales_[e]);
    for (int k = 0; k < coefficients; ++k) {
        if (!(forces[k] > 0)) continue;
        for (int m = 0; m < nodes; ++m) {
            const int u = element.unknowns[m];
            if (u == Problem::fixed) continue;
            const Vec<D>& g = gradients[k][m];
            for (int i = 0; i < D; ++i) model.gradient[u * D + i] -= forces[k] * g[i];
            for (int l = 0; l < nodes; ++l) {
                const int v = element.unknowns[l];
                if (v == Problem::fixed || v > u) continue;
                const Vec<D>& h = gradients[k][l];
                for (int i = 0; i < D; ++i)
                    for (int j = 0; j < D; ++j) model.hessian(u * D + i, v * D + j) += penalty_ * g[i] * h[j];
            }
        }
    }
}

template <int D>
typename Descent<D>::Model Descent<D>::model() const {
    const auto n = static_cast<Eigen::Index>(offsets_.size()) * D;
    Model out{Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Zero(n, n)};
    for (int u = 0; u < static_cast<int>(offsets_.size()); ++u) {
        const auto& [centre, hessian] = problem_.unknowns[u];
        const Vec<D> pull = hessian * (offsets_[u] - centre);
        for (int i = 0; i < D; ++i) {
            out.gradient[u * D + i] += pull[i];
            for (int j = 0; j < D; ++j) out.hessian(u * D + i, u * D + j) += hessian(i, j);
        }
    }
    for (std::size_t e = 0; e < problem_.elements.size(); ++e) add_element(e, out);
    return out;
}

template <int D>
bool Descent<D>::step() {
    Model m = model();
    work_ += equations_work(offsets_.size()) + work_of_all_elements();
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> factors(m.hessian);
    if (factors.info() != Eigen::Success) return false;
    const Eigen::VectorXd direction = factors.solve(-m.gradient);
    const double slope = m.gradient.dot(direction);
    const double before = merit(offsets_, slacks_);
    if (!(slope < -1e-9 * std::max(before, 1e-6))) return false;
    Offsets trial(offsets_.size());
    for (double share = 1; share > 1e-3; share *= 0.5) {
        for (std::size_t u = 0; u < trial.size(); ++u)
            for (int i = 0; i < D; ++i)
                trial[u][i] = offsets_[u][i] + share * direction[static_cast<Eigen::Index>(u) * D + i];
        auto there = slacks(trial);
        work_ += work_of_all_elements();
        if (!(merit(trial, there) < before + 1e-4 * share * slope)) continue;
        offsets_ = std::move(trial);
        slacks_ = std::move(there);
        return true;
    }
    return false;
}

}  // namespace

template <int D>
JointSolution<D> solve(const JointProblem<D>& problem, std::vector<Vec<D>> start) {
    Descent<D> descent(problem, std::move(start));
    double largest = descent.shortfall();
    double before = largest;
    double shortfall = largest;
    const auto is_spent = [&] { return descent.work() >= problem.max_work; };
    for (int update = 0; update < max_updates; ++update) {
        for (int i = 0; i < max_steps && !is_spent(); ++i)
            if (!descent.step()) break;
        shortfall = descent.shortfall();
        largest = std::max(largest, shortfall);
        descent.update_multipliers();
        if (shortfall < largest_shortfall || is_spent()) break;
        // In a fold, penalty and multipliers have no effect, so there is no progress.
        if (update >= patience && shortfall > 0.5 * largest) break;
        if (shortfall > 0.3 * before) descent.raise_penalty();
        before = shortfall;
    }
    return {descent.offsets(), shortfall, descent.work()};
}

#define CAMBER_INSTANTIATE(D) template JointSolution<D> solve<D>(const JointProblem<D>&, std::vector<Vec<D>>);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
