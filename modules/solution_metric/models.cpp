module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
module camber.solution_metric;
import camber.core;
import camber.bezier;
import camber.metric;

namespace camber {

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
                "look for values of the solution that are not numbers");
}

/// The models of n rows, and how many are of which kind.
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

/// F of an element about its centroid.
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

/// Ĥ.
template <int D>
Sym<D> in_reference(const ElementMap<D>& map, const Vec<D>& gradient, const Sym<D>& hessian) {
    Sym<D> out = congruence(transposed(map.jacobian), hessian);
    for (int a = 0; a < D; ++a)
        for (int b = 0; b <= a; ++b) out(a, b) += dot(gradient, map.second[a][b]);
    return out;
}

/// T̂.
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

/// Q = J⁻ᵀ Q̂ J⁻¹ from the singular values of J Q̂^{−1/2}.
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
        return fail(ErrorKind::usage, "the derivatives are of another mesh: there must be one row an element", {}, {},
                    "take element_means of those at vertices");
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
