module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>
#include <Eigen/Cholesky>
#include <Eigen/Core>
module camber.optimisation;
import :joint_programme;
import :joint_slack;
import camber.core;
import camber.bezier;
import camber.validity;

namespace camber {

namespace {

constexpr int max_updates = 20;  // of the multipliers
constexpr int max_steps = 8;     // between two of them
constexpr int patience = 4;      // updates without progress
constexpr double largest_penalty = 1e8;

/// An augmented Lagrangian while it is minimised, with the slacks where it is.
template <int D>
class Descent {
  public:
    using Programme = JointProgramme<D>;
    using Offsets = std::vector<Vec<D>>;

    Descent(const Programme& p, Offsets start)
        : programme_(p), offsets_(std::move(start)), multipliers_(p.elements.size()), penalty_(p.first_penalty) {
        scales_.reserve(p.elements.size());
        for (const auto& e : p.elements) scales_.push_back(slack_scale<D>(e.bezier));
        slacks_ = slacks(offsets_);
        work_ += work_of_all_elements();
    }

    [[nodiscard]] const Offsets& offsets() const { return offsets_; }
    /// Work so far, in the units of element_work.
    [[nodiscard]] double work() const { return work_; }
    /// How far the lowest coefficient is below its floor.
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
    /// A Gauss–Newton step that lowers the merit; false when there is none.
    bool step();

  private:
    static constexpr int coefficients = jacobian_coefficients<D>;
    static constexpr int nodes = quadratic_nodes<D>;

    /// ∇ and the lower triangle of a Gauss–Newton ∇² of the merit.
    struct Model {
        Eigen::VectorXd gradient;
        Eigen::MatrixXd hessian;
    };

    [[nodiscard]] std::vector<Slacks<D>> slacks(const Offsets& offsets) const {
        std::vector<Slacks<D>> all(programme_.elements.size());
        for (std::size_t e = 0; e < all.size(); ++e) {
            const auto& element = programme_.elements[e];
            all[e] = slacks_of<D>(displaced<D>(element, offsets), {element.floor, element.least}, scales_[e]);
        }
        return all;
    }
    /// What a constraint g ≥ 0 still asks for: max(0, λ − μ g).
    [[nodiscard]] double force(std::size_t e, int k, double g) const {
        return std::max(0.0, multipliers_[e][k] - penalty_ * g);
    }
    [[nodiscard]] double merit(const Offsets& offsets, const std::vector<Slacks<D>>& slacks) const;
    [[nodiscard]] Model model() const;
    void add_element(std::size_t e, Model& model) const;

    [[nodiscard]] double work_of_all_elements() const {
        return element_work * static_cast<double>(programme_.elements.size());
    }

    const Programme& programme_;
    double work_ = 0;
    std::vector<double> scales_;
    Offsets offsets_;
    std::vector<Slacks<D>> slacks_;
    std::vector<Slacks<D>> multipliers_;
    double penalty_;
};

/// Σ models + Σ max(0, λ − μ g)² / 2μ.
template <int D>
double Descent<D>::merit(const Offsets& offsets, const std::vector<Slacks<D>>& slacks) const {
    double sum = 0;
    for (std::size_t u = 0; u < offsets.size(); ++u) sum += programme_.unknowns[u](offsets[u]);
    for (std::size_t e = 0; e < slacks.size(); ++e)
        for (int k = 0; k < coefficients; ++k) {
            const double f = force(e, k, slacks[e][k]);
            sum += f * f / (2 * penalty_);
        }
    return sum;
}

template <int D>
void Descent<D>::add_element(std::size_t e, Model& model) const {
    const auto& element = programme_.elements[e];
    Slacks<D> forces;
    for (int k = 0; k < coefficients; ++k) forces[k] = force(e, k, slacks_[e][k]);
    if (std::ranges::none_of(forces, [](double f) { return f > 0; })) return;
    const auto gradients =
        slack_gradients<D>(displaced<D>(element, offsets_), {element.floor, element.least}, scales_[e]);
    for (int k = 0; k < coefficients; ++k) {
        if (!(forces[k] > 0)) continue;
        for (int m = 0; m < nodes; ++m) {
            const int u = element.unknowns[m];
            if (u == Programme::fixed) continue;
            const Vec<D>& g = gradients[k][m];
            for (int i = 0; i < D; ++i) model.gradient[u * D + i] -= forces[k] * g[i];
            for (int l = 0; l < nodes; ++l) {
                const int v = element.unknowns[l];
                if (v == Programme::fixed || v > u) continue;
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
        const auto& [centre, hessian] = programme_.unknowns[u];
        const Vec<D> pull = hessian * (offsets_[u] - centre);
        for (int i = 0; i < D; ++i) {
            out.gradient[u * D + i] += pull[i];
            for (int j = 0; j < D; ++j) out.hessian(u * D + i, u * D + j) += hessian(i, j);
        }
    }
    for (std::size_t e = 0; e < programme_.elements.size(); ++e) add_element(e, out);
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
JointSolution<D> solve(const JointProgramme<D>& programme, std::vector<Vec<D>> start) {
    Descent<D> descent(programme, std::move(start));
    double largest = descent.shortfall();
    double before = largest;
    double shortfall = largest;
    const auto is_spent = [&] { return descent.work() >= programme.max_work; };
    for (int update = 0; update < max_updates; ++update) {
        for (int i = 0; i < max_steps && !is_spent(); ++i)
            if (!descent.step()) break;
        shortfall = descent.shortfall();
        largest = std::max(largest, shortfall);
        descent.update_multipliers();
        if (shortfall < largest_shortfall || is_spent()) break;
        // Stuck in a fold: neither penalty nor multipliers have moved it.
        if (update >= patience && shortfall > 0.5 * largest) break;
        if (shortfall > 0.3 * before) descent.raise_penalty();
        before = shortfall;
    }
    return {descent.offsets(), shortfall, descent.work()};
}

#define CAMBER_INSTANTIATE(D) template JointSolution<D> solve<D>(const JointProgramme<D>&, std::vector<Vec<D>>);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
