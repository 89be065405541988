// Local error models from second and third derivatives.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <string>
#include <utility>
module camber.solution_metric;
import camber.core;
import camber.bezier;
import camber.metric;

namespace camber {

namespace {

constexpr double tiny = 1e-290;  // lower bound of |T(y)|, so that logs are finite

/// Lower bounds of vᵀQv in coordinates y with v = G y (G: `to_space`): |T[v, v, v]|^{2/3} and floor |v|².
template <int D>
struct Bounded {
    CubicForm<D> specified;
    double floor = 0;  // lower bound of the eigenvalues of Q
    Mat<D> to_space = Mat<D>::identity();
    CubicForm<D> local;    // T in coordinates y: T[G·, G·, G·]
    Sym<D> local_floor{};  // floor GᵀG, the floor in coordinates y

    Bounded(const CubicForm<D>& t) : specified(t), local(t) {}
    void set_frame(const Mat<D>& g) {
        to_space = g;
        local = pulled_back(specified, g);
        local_floor = floor * congruence(transposed(g), Sym<D>::identity());
    }
    [[nodiscard]] double floor_at(const Vec<D>& y) const { return dot(y, local_floor * y); }
    [[nodiscard]] double value(const Vec<D>& y) const { return trilinear(local, y, y, y); }
    [[nodiscard]] double log_bound(const Vec<D>& y) const {
        const double of_t = std::max(std::abs(value(y)), tiny);
        return std::max(2.0 / 3 * log(of_t), log(std::max(floor_at(y), tiny)));
    }
};

template <int D>
void log_bounds(const Directions<D>& directions, const Bounded<D>& bounded, auto& out) {
    with_instructions(widest_instructions(), [&]() __attribute__((always_inline)) {
        for (int p = 0; p < Directions<D>::packs; ++p) {
            Pack t = packed(0), low = packed(0);
            for (int k = 0; k < cubic_size<D>; ++k) t += directions.cubic[p][k] * bounded.local.c[k];
            for (int k = 0; k < sym_size<D>; ++k) low += directions.quadratic[p][k] * bounded.local_floor.c[k];
            low = max(low, packed(0));
            out[p] = 2.0 / 3 * log(max(max(abs(t), low * sqrt(low)), packed(tiny)));
        }
    });
}

template <int D>
std::array<Vec<D>, D - 1> across(const Vec<D>& y) {
    if constexpr (D == 2) {
        return {Vec<2>{{-y[1], y[0]}}};
    } else {
        int least = 0;
        for (int i = 1; i < 3; ++i)
            if (std::abs(y[i]) < std::abs(y[least])) least = i;
        Vec<3> axis;
        axis[least] = 1;
        const Vec<3> a = normalised(cross(y, axis));
        return {a, cross(y, a)};
    }
}

/// Takes a Newton step on the unit sphere from y towards a maximum of |T(y)|. In the tangent plane at y, the gradient
/// of T is 3 T[y,y,·] and its Hessian 6 T[y,·,·] − 3 T(y). If the Hessian has the wrong sign, the step follows the
/// gradient.
template <int D>
Vec<D> step_to_largest(const CubicForm<D>& t, const Vec<D>& y) {
    const Sym<D> along = contracted(t, y);
    const Vec<D> slope = along * y;
    const double value = dot(slope, y), sign = value < 0 ? -1 : 1;
    const auto tangents = across(y);
    Vec<D> step;
    if constexpr (D == 2) {
        const double g = 3 * sign * dot(slope, tangents[0]);
        const double h = sign * (6 * dot(tangents[0], along * tangents[0]) - 3 * value);
        step = (h < 0 ? -g / h : g / std::max(3 * std::abs(value), tiny)) * tangents[0];
    } else {
        const double g0 = 3 * sign * dot(slope, tangents[0]), g1 = 3 * sign * dot(slope, tangents[1]);
        const double h00 = sign * (6 * dot(tangents[0], along * tangents[0]) - 3 * value);
        const double h01 = sign * 6 * dot(tangents[0], along * tangents[1]);
        const double h11 = sign * (6 * dot(tangents[1], along * tangents[1]) - 3 * value);
        const double d = h00 * h11 - h01 * h01;
        if (h00 < 0 && d > 0)
            step = ((h01 * g1 - h11 * g0) / d) * tangents[0] + ((h01 * g0 - h00 * g1) / d) * tangents[1];
        else
            step = (1 / std::max(3 * std::abs(value), tiny)) * (g0 * tangents[0] + g1 * tangents[1]);
    }
    constexpr double longest = 0.2;
    if (const double length = norm(step); length > longest) step *= longest / length;
    return normalised(y + step);
}

template <int D>
class Search {
    static constexpr int unknowns = sym_size<D>;
    static constexpr int cut_packs = 4;
    static constexpr int most_cuts = cut_packs * pack_size;
    static constexpr int table = Directions<D>::count;
    using Program = SmallLinearProgram<unknowns, Directions<D>::packs + cut_packs>;

  public:
    Search(const Directions<D>& directions, const CubicForm<D>& t, double max_anisotropy)
        : directions_(directions), bounded_(t), max_anisotropy_(max_anisotropy) {
        log_bounds(directions_, bounded_, program_.least);
        bounded_.floor = exp(largest_of_table()) / (max_anisotropy * max_anisotropy);
        bounded_.set_frame(bounded_.to_space);
    }

    /// Computes `CubicBound::diagonal`: in the eigenvectors of T:T, Q is diagonal with entries e^{l_i}. A linear
    /// program minimises Σ l_i subject to (l_i + l_j + l_k)/2 ≥ log|T_ijk|. A cost of 0.1 on the largest l_i selects
    /// one of several solutions: for T = n³ + 3 n t², a smaller size along n allows a larger one along t.
    void bound_by_entries() {
        constexpr int rounds = 5;
        EntryProgram program = entry_program();
        Mat<D> best;
        double least = std::numeric_limits<double>::max();
        for (int round = 0; round < rounds; ++round) {
            bounded_.set_frame(bounded_.to_space * eigen_system(contracted_twice(bounded_.local)).vectors);
            for (int c = 0; c < cubic_size<D>; ++c)
                program.set_least(c, log(std::max(std::abs(bounded_.local.c[c]), tiny)));
            for (int i = 0; i < D; ++i) {
                const int c = CubicForm<D>::index(i, i, i);
                const double low = 1.5 * log(std::max(bounded_.local_floor(i, i), tiny));
                program.set_least(c, std::max(program.least_of(c), low));
            }
            const auto l = program.solve();
            Mat<D> g = bounded_.to_space;
            for (int i = 0; i < D; ++i) g.column[i] *= exp(-l[i] / 2);
            bounded_.set_frame(g);
            log_bounds(directions_, bounded_, program_.least);
            const double most = largest_of_table(), now = log_det_of(most);
            set_floor(most);
            if (!(now < least)) continue;
            least = now;
            best = g;
        }
        bounded_.set_frame(best);
        log_bounds(directions_, bounded_, program_.least);
        const double most = largest_of_table();
        set_floor(most);
        grow_by(most);
    }

    void bound_by_directions() {
        constexpr int most_rounds = 16, most_cutting = 24;
        for (int p = 0; p < Directions<D>::packs; ++p) program_.rows[p] = directions_.quadratic[p];
        for (int i = 0; i < D; ++i) program_.cost[Sym<D>::index(i, i)] = 1;
        for (int i = 0; i < unknowns; ++i) program_.basis[i] = i;
        log_bounds(directions_, bounded_, program_.least);
        Mat<D> best = bounded_.to_space;
        double least = log_det_of(cut());  // log det of the diagonal bound, which remains the result unless the search
                                           // finds a smaller determinant
        cuts_ = 0;
        for (int p = 0; p < cut_packs; ++p) program_.least[Directions<D>::packs + p] = packed(Program::no_row);
        for (int round = 0; round < most_rounds; ++round) {
            const double most = largest_of_table();
            if (step() < 0.1 || D * most - trace_ < 0.02) break;
            log_bounds(directions_, bounded_, program_.least);
        }
        const auto basis = program_.basis;
        double last_value = std::numeric_limits<double>::max();
        for (int round = 0;; ++round) {
            log_bounds(directions_, bounded_, program_.least);
            const double most = cut();
            const double now = log_det_of(most);
            if (now < least) {
                least = now;
                best = bounded_.to_space;
            }
            // If the minimum is nearly flat, the search would not end. So it stops when a few steps gain too little.
            constexpr int often = 4;
            constexpr double min_improvement = 0.04;
            if (round % often == often - 1) {
                if (!(last_value - least > min_improvement)) break;
                last_value = least;
            }
            if (round == most_cutting) break;
            program_.basis = basis;
            step();
            if (D * most - trace_ < 4e-3) break;
        }
        bounded_.set_frame(best);
    }

    void bound_everywhere() {
        log_bounds(directions_, bounded_, program_.least);
        double most = largest_of_table();
        // A lower maximum of the table may lead to the larger maximum of T, so the search starts from each of them.
        constexpr double all = 1;
        each_near_largest(most - 0.08, 8, all, [&](const Vec<D>& y) { most = std::max(most, bounded_.log_bound(y)); });
        grow_by(most);
    }

    [[nodiscard]] EigenSystem<D> logs() const {
        EigenSystem<D> out = left_singular(bounded_.to_space);
        for (double& x : out.values.c) x = -2 * log(x);
        return out;
    }

  private:
    using EntryProgram = SmallLinearProgram<D + 1, (cubic_size<D> + D + 1 + pack_size - 1) / pack_size>;
    [[nodiscard]] static EntryProgram entry_program() {
        constexpr double share = 0.1, lowest = -1e4;
        EntryProgram program;
        program.least.fill(packed(program.no_row));
        program.cost.fill(1);
        program.cost[D] = share;
        for (int i = 0; i < D; ++i)
            for (int j = 0; j <= i; ++j)
                for (int k = 0; k <= j; ++k) {
                    std::array<double, D + 1> row{};
                    for (const int a : {i, j, k}) row[a] += 0.5;
                    program.set_row(CubicForm<D>::index(i, j, k), row);
                }
        for (int i = 0; i <= D; ++i) {
            std::array<double, D + 1> row{};
            row[D] = 1;
            if (i < D) row[i] = -1;
            program.set_row(cubic_size<D> + i, row);
            program.set_least(cubic_size<D> + i, i < D ? 0 : lowest);
            program.basis[i] = i < D ? CubicForm<D>::index(i, i, i) : cubic_size<D> + D;
        }
        return program;
    }
    /// Returns the matrix T:T with the entries Σ_ab T_iab T_jab.
    [[nodiscard]] static Sym<D> contracted_twice(const CubicForm<D>& t) {
        Sym<D> twice;
        for (int a = 0; a < D; ++a) {
            const Sym<D> along = contracted(t, Mat<D>::identity().column[a]);
            for (int i = 0; i < D; ++i)
                for (int j = 0; j <= i; ++j)
                    for (int b = 0; b < D; ++b) twice(i, j) += along(i, b) * along(j, b);
        }
        return twice;
    }
    void set_floor(double most) {
        const Vec<D> roots = left_singular(bounded_.to_space).values;
        const double shortest = *std::min_element(roots.c.begin(), roots.c.end());
        bounded_.floor = exp(most) / (shortest * shortest * max_anisotropy_ * max_anisotropy_);
        bounded_.set_frame(bounded_.to_space);
    }
    [[nodiscard]] double log_det_of(double most) const {
        LocalModel<D> model{logs()};
        double sum = D * most;
        for (const double x : floored(model, max_anisotropy_).logs.values.c) sum += x;
        return sum;
    }
    [[nodiscard]] double largest_of_table() const {
        double most = -std::numeric_limits<double>::max();
        for (int i = 0; i < table; ++i) most = std::max(most, program_.least_of(i));
        return most;
    }
    /// Calls `visit(y)` at maxima of |T(y)| and at the axes of the floor. Newton's method searches the maxima from
    /// tabulated directions whose bounds are at least `least` and no smaller than those at angles with a cosine above
    /// `around`.
    void each_near_largest(double least, int steps, double around, const auto& visit) {
        std::array<int, table> tried{};
        int count = 0;
        for (int i = 0; i < table; ++i)
            if (program_.least_of(i) >= least) tried[count++] = i;
        for (int a = 0; a < count; ++a) {
            const double own = program_.least_of(tried[a]);
            Vec<D> y = directions_.unit[tried[a]];
            bool is_largest = true;
            for (int b = 0; b < count && is_largest; ++b)
                is_largest =
                    !(program_.least_of(tried[b]) > own && std::abs(dot(directions_.unit[tried[b]], y)) > around);
            if (!is_largest) continue;
            for (int s = 0; s < steps; ++s) {
                const Vec<D> before = std::exchange(y, step_to_largest(bounded_.local, y));
                if (norm_squared(y - before) < 1e-14) break;  // the next step would be about 1e-14
            }
            visit(y);
        }
        // The floor is a quadratic form, with maxima on its axes.
        const EigenSystem<D> floor = eigen_system(bounded_.local_floor);
        for (int i = 0; i < D; ++i)
            if (log(std::max(floor.values[i], tiny)) >= least) visit(floor.vectors.column[i]);
    }
    /// Adds constraints at the maxima of |T(y)|, which replace the oldest ones. Returns the largest bound.
    double cut() {
        double most = largest_of_table();
        for (int c = 0; c < std::min(cuts_, most_cuts); ++c) set_cut(c);
        constexpr double around = 0.955;  // cosine of 1.5 times the spacing of directions
        each_near_largest(most - 0.1, 3, around, [&](const Vec<D>& y) {
            const double bound = bounded_.log_bound(y);
            most = std::max(most, bound);
            for (int c = 0; c < std::min(cuts_, most_cuts); ++c)
                if (std::abs(dot(cut_at_[c], y)) > 1 - 1e-5) return;
            const int c = cuts_ % most_cuts;
            cut_at_[c] = y;
            set_cut(c);
            ++cuts_;
        });
        return most;
    }
    void set_cut(int c) {
        program_.set_row(table + c, quadratic_row(cut_at_[c]));
        program_.set_least(table + c, bounded_.log_bound(cut_at_[c]));
    }
    /// Solves the program for L, and updates Q ← Q^{1/2} e^L Q^{1/2}, G ← G e^{−L/2}; returns |L|.
    double step() {
        Sym<D> l;
        l.c = program_.solve();
        trace_ = trace(l);
        EigenSystem<D> e = eigen_system(l);
        EigenSystem<D> grow = e;
        for (double& x : e.values.c) x = exp(-x / 2);
        for (double& x : grow.values.c) x = exp(x / 2);
        const Sym<D> shrink = composed(e), to_new = composed(grow);
        Mat<D> g;
        for (int j = 0; j < D; ++j)
            for (int k = 0; k < D; ++k) g.column[j] += shrink(k, j) * bounded_.to_space.column[k];
        for (int c = 0; c < std::min(cuts_, most_cuts); ++c) cut_at_[c] = normalised(to_new * cut_at_[c]);
        bounded_.set_frame(g);
        return norm(l);
    }
    void grow_by(double log_factor) {
        Mat<D> g = bounded_.to_space;
        for (Vec<D>& column : g.column) column *= exp(-log_factor / 2);
        bounded_.set_frame(g);
    }

    const Directions<D>& directions_;
    Bounded<D> bounded_;
    double max_anisotropy_;
    Program program_;
    std::array<Vec<D>, most_cuts> cut_at_{};
    int cuts_ = 0;
    double trace_ = 0;
};

}  // namespace

template <int D>
CubicModels<D>::CubicModels(const ModelOptions& options)
    : options_(options), directions_(std::make_shared<const Directions<D>>()) {}

template <int D>
LocalModel<D> CubicModels<D>::operator()(const CubicForm<D>& t) const {
    double scale = 0;
    for (const double x : t.c) scale = std::max(scale, std::abs(x));
    if (scale == 0) return zero_model<D>();
    CubicForm<D> unit = t;
    for (double& x : unit.c) x /= scale;
    Search<D> search(*directions_, unit, options_.max_anisotropy);
    search.bound_by_entries();
    if (options_.bound == CubicBound::optimal) search.bound_by_directions();
    search.bound_everywhere();
    LocalModel<D> model{search.logs()};
    for (double& x : model.logs.values.c) x += 2.0 / 3 * log(scale);
    return floored(model, options_.max_anisotropy);
}

namespace {

constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

bool all_finite(const auto& row) {
    return std::all_of(row.c.begin(), row.c.end(), [](double x) { return std::isfinite(x); });
}

template <class Row>
Outcome<Done> check_finite(const Column<Row>& rows, const std::string& kind, const Execution& execution) {
    const auto first = reduce_each(
        without_progress(execution), rows.size(), none,
        [&](std::size_t& at, std::size_t i) {
            if (at == none && !all_finite(rows[i])) at = i;
        },
        [](std::size_t a, std::size_t b) { return std::min(a, b); });
    if (!first) return fail(first.error());
    if (*first == none) return Done{};
    return fail(ErrorKind::input, "is not finite", {}, Entity{kind, *first + 1},
                "check the solution for values that are not numbers");
}

template <int D>
Outcome<LocalModels<D>> counted(std::size_t n, const Execution& execution, const auto& model) {
    constexpr std::size_t grain = 64;
    auto rows = map_each(execution, n, model, grain);
    if (!rows) return fail(rows.error());
    LocalModels<D> out{std::move(*rows)};
    for (const LocalModel<D>& m : out.rows) {
        out.zero += m.kind == ModelKind::zero ? 1 : 0;
        out.floored += m.kind == ModelKind::floored ? 1 : 0;
    }
    return out;
}

template <int D>
struct ElementMap {
    Mat<D> jacobian;
    std::array<std::array<Vec<D>, D>, D> second;
};

template <int D>
ElementMap<D> element_map(const QuadraticMesh<D>& mesh, std::size_t e) {
    QuadraticSimplex<D, D> simplex = element_of(mesh, ElementId(e));
    const Vec<D> origin = simplex.control[0];
    for (Vec<D>& p : simplex.control) p -= origin;
    Barycentric<D> centroid;
    centroid.fill(1.0 / (D + 1));
    ElementMap<D> map;
    map.jacobian.column = simplex.derivatives(centroid);
    for (int a = 0; a < D; ++a)
        for (int b = 0; b < D; ++b)
            map.second[a][b] =
                2.0 * (simplex.at(a + 1, b + 1) - simplex.at(a + 1, 0) - simplex.at(b + 1, 0) + simplex.control[0]);
    return map;
}

template <int D>
Sym<D> in_reference(const ElementMap<D>& map, const Vec<D>& gradient, const Sym<D>& hessian) {
    Sym<D> out = congruence(transposed(map.jacobian), hessian);
    for (int a = 0; a < D; ++a)
        for (int b = 0; b <= a; ++b) out(a, b) += dot(gradient, map.second[a][b]);
    return out;
}

template <int D>
CubicForm<D> in_reference(const ElementMap<D>& map, const Sym<D>& hessian, const CubicForm<D>& third) {
    CubicForm<D> out = pulled_back(third, map.jacobian);
    const auto& j = map.jacobian.column;
    for (int a = 0; a < D; ++a)
        for (int b = 0; b <= a; ++b)
            for (int c = 0; c <= b; ++c)
                out(a, b, c) += dot(map.second[a][b], hessian * j[c]) + dot(map.second[b][c], hessian * j[a]) +
                                dot(map.second[c][a], hessian * j[b]);
    return out;
}

/// Transforms the model Q̂ in reference coordinates to space: Q = J⁻ᵀ Q̂ J⁻¹, from the singular values of J Q̂^{−1/2}.
template <int D>
LocalModel<D> in_space(const LocalModel<D>& model, const Mat<D>& jacobian, const ModelOptions& options) {
    if (model.kind == ModelKind::zero || det(jacobian) == 0) return zero_model<D>();
    const auto& values = model.logs.values.c;
    const double top = *std::max_element(values.begin(), values.end());
    Mat<D> root = jacobian * model.logs.vectors;
    for (int i = 0; i < D; ++i) root.column[i] *= exp((top - values[i]) / 2);
    LocalModel<D> out{left_singular(root), model.kind};
    for (double& x : out.logs.values.c) x = top - 2 * log(x);
    return floored(out, options.max_anisotropy);
}

template <int D>
Outcome<Done> check_rows(const QuadraticMesh<D>& mesh, std::size_t a, std::size_t b, const ModelOptions& options) {
    const std::size_t n = mesh.linear.elements.size();
    if (a != n || b != n)
        return fail(ErrorKind::usage, "the derivatives belong to another mesh; there must be one row per element", {},
                    {}, "use element_means of the derivatives at vertices");
    return check_limits(options);
}

}  // namespace

template <int D>
Outcome<LocalModels<D>> hessian_models(const Column<Sym<D>>& hessians, const ModelOptions& options,
                                       const Execution& execution) {
    if (auto sound = check_limits(options); !sound) return fail(sound.error());
    if (auto sound = check_finite(hessians, "derivatives, row", execution); !sound) return fail(sound.error());
    return counted<D>(hessians.size(), execution, [&](std::size_t i) { return hessian_model(hessians[i], options); });
}

template <int D>
Outcome<LocalModels<D>> cubic_models(const Column<CubicForm<D>>& thirds, const ModelOptions& options,
                                     const Execution& execution) {
    if (auto sound = check_limits(options); !sound) return fail(sound.error());
    if (auto sound = check_finite(thirds, "derivatives, row", execution); !sound) return fail(sound.error());
    const CubicModels<D> models(options);
    return counted<D>(thirds.size(), execution, [&](std::size_t i) { return models(thirds[i]); });
}

template <int D>
Outcome<LocalModels<D>> curved_hessian_models(const QuadraticMesh<D>& mesh, const Column<Vec<D>>& gradients,
                                              const Column<Sym<D>>& hessians, const ModelOptions& options,
                                              const Execution& execution) {
    if (auto sound = check_rows(mesh, gradients.size(), hessians.size(), options); !sound) return fail(sound.error());
    if (auto sound = check_finite(gradients, "gradient of element", execution); !sound) return fail(sound.error());
    if (auto sound = check_finite(hessians, "Hessian of element", execution); !sound) return fail(sound.error());
    return counted<D>(hessians.size(), execution, [&](std::size_t e) {
        const ElementMap<D> map = element_map(mesh, e);
        return in_space(hessian_model(in_reference(map, gradients[e], hessians[e]), options), map.jacobian, options);
    });
}

template <int D>
Outcome<LocalModels<D>> curved_cubic_models(const QuadraticMesh<D>& mesh, const Column<Sym<D>>& hessians,
                                            const Column<CubicForm<D>>& thirds, const ModelOptions& options,
                                            const Execution& execution) {
    if (auto sound = check_rows(mesh, hessians.size(), thirds.size(), options); !sound) return fail(sound.error());
    if (auto sound = check_finite(hessians, "Hessian of element", execution); !sound) return fail(sound.error());
    if (auto sound = check_finite(thirds, "third derivatives of element", execution); !sound)
        return fail(sound.error());
    const CubicModels<D> models(options);
    return counted<D>(thirds.size(), execution, [&](std::size_t e) {
        const ElementMap<D> map = element_map(mesh, e);
        return in_space(models(in_reference(map, hessians[e], thirds[e])), map.jacobian, options);
    });
}

template class CubicModels<2>;
template class CubicModels<3>;

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template Outcome<LocalModels<D>> hessian_models<D>(const Column<Sym<D>>&, const ModelOptions&, const Execution&);  \
    template Outcome<LocalModels<D>> cubic_models<D>(const Column<CubicForm<D>>&, const ModelOptions&,                 \
                                                     const Execution&);                                                \
    template Outcome<LocalModels<D>> curved_hessian_models<D>(                                                         \
        const QuadraticMesh<D>&, const Column<Vec<D>>&, const Column<Sym<D>>&, const ModelOptions&, const Execution&); \
    template Outcome<LocalModels<D>> curved_cubic_models<D>(const QuadraticMesh<D>&, const Column<Sym<D>>&,            \
                                                            const Column<CubicForm<D>>&, const ModelOptions&,          \
                                                            const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
