// Corrects transferred values to preserve integrals and limits.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
// Eigen's default is the macro alloca, which is not defined if the standard headers are imported as a module.
#define EIGEN_ALLOCA __builtin_alloca
#include <Eigen/Dense>
module camber.transfer;
import camber.core;
import camber.bezier;
import :materials;
import :projection;

namespace camber {

namespace {

template <int D>
std::vector<std::uint32_t> materials_of(const QuadraticMesh<D>& mesh, const Materials<D>& materials) {
    std::vector<std::uint32_t> all(mesh.linear.elements.size());
    for (std::size_t e = 0; e < all.size(); ++e) all[e] = static_cast<std::uint32_t>(materials.of(mesh.linear, e));
    return all;
}

template <int D>
Outcome<std::vector<Sum>> integrals_of(const QuadraticMesh<D>& mesh, const TransferField& field,
                                       const std::vector<std::uint32_t>& material_of, std::size_t materials,
                                       const Execution& execution) {
    const NodalValues nodal{field.values.view(), static_cast<std::size_t>(field.components)};
    const auto element = [](std::size_t e) { return e; };
    return field.degree == 1 ? integrals_by_group<D, 1>(mesh, element, material_of, materials, nodal, execution)
                             : integrals_by_group<D, 2>(mesh, element, material_of, materials, nodal, execution);
}

}  // namespace

template <int D>
Outcome<std::vector<std::vector<MaterialIntegrals>>> total_integrals(
    const QuadraticMesh<D>& old_mesh, std::span<const TransferField> old_fields, const QuadraticMesh<D>& new_mesh,
    std::span<const TransferField> new_fields, const Materials<D>& materials, const Execution& execution) {
    const auto old_materials = materials_of(old_mesh, materials), new_materials = materials_of(new_mesh, materials);
    std::vector<std::uint8_t> has_elements(materials.size(), 0);
    for (const std::uint32_t m : old_materials) has_elements[m] = 1;
    for (const std::uint32_t m : new_materials) has_elements[m] = 1;
    std::vector<std::vector<MaterialIntegrals>> all;
    for (std::size_t f = 0; f < old_fields.size(); ++f) {
        const auto before = integrals_of(old_mesh, old_fields[f], old_materials, materials.size(), execution);
        if (!before) return fail(before.error());
        const auto after = integrals_of(new_mesh, new_fields[f], new_materials, materials.size(), execution);
        if (!after) return fail(after.error());
        const auto components = static_cast<std::size_t>(old_fields[f].components);
        std::vector<MaterialIntegrals> rows;
        for (std::size_t m = 0; m < materials.size(); ++m) {
            if (has_elements[m] == 0) continue;
            MaterialIntegrals row{.reference = materials.reference(m), .before = {}, .after = {}};
            for (std::size_t c = 0; c < components; ++c) {
                row.before.push_back((*before)[m * components + c].value());
                row.after.push_back((*after)[m * components + c].value());
            }
            rows.push_back(std::move(row));
        }
        all.push_back(std::move(rows));
    }
    return all;
}

namespace {

/// Matrix C M⁻¹ Cᵀ: the change of each integral for unit multipliers λ. C has the integrals of the basis functions by
/// group; M is the mass matrix. The matrix may be singular: integrals over elements without free nodes cannot change,
/// and interface nodes couple two integrals.
class Reach {
  public:
    Reach() = default;
    /// Rows are scaled for the pseudo-inverse, because volumes of materials differ widely.
    explicit Reach(const Eigen::MatrixXd& a) : square_(0.5 * (a + a.transpose())) {
        constexpr double singular = 1e-10;
        Eigen::VectorXd scale = a.diagonal();
        for (double& s : scale) s = s > 0 ? 1 / std::sqrt(s) : 0;
        Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition;
        decomposition.setThreshold(singular);
        decomposition.compute(scale.asDiagonal() * square_ * scale.asDiagonal());
        inverse_ = scale.asDiagonal() * decomposition.pseudoInverse() * scale.asDiagonal();
        is_whole_ = decomposition.rank() == a.rows();
    }
    [[nodiscard]] const Eigen::MatrixXd& square() const { return square_; }
    [[nodiscard]] bool is_whole() const { return is_whole_; }
    [[nodiscard]] Eigen::VectorXd multipliers(const Eigen::VectorXd& gap) const { return inverse_ * gap; }
    /// Part of `gap` that no change of the field can correct; parts within rounding error count as 0.
    [[nodiscard]] Eigen::VectorXd rest(const Eigen::VectorXd& gap) const {
        constexpr double rounding = 1e-8;
        Eigen::VectorXd rest = Eigen::VectorXd::Zero(gap.size());
        if (is_whole_) return rest;
        const Eigen::VectorXd reached = square_ * multipliers(gap);
        for (Eigen::Index i = 0; i < gap.size(); ++i)
            if (std::abs(gap[i] - reached[i]) > rounding * std::abs(gap[i])) rest[i] = gap[i] - reached[i];
        return rest;
    }

  private:
    Eigen::MatrixXd square_, inverse_;
    bool is_whole_ = true;
};

struct SmallestChange {
    Buffer<double> change;
    std::vector<double> moved;  ///< change of each group's target integral
    std::size_t spread = 0, unconserved_materials = 0;
};

template <int D, int K>
class Changes {
  public:
    using Patches = typename PatchSearch<D>::Patches;

    Changes(const Patches& patches, std::size_t materials, MassMatrix<D, K>& matrix)
        : patches_(patches), matrix_(matrix), materials_(materials), patch_of_(matrix.size(), none) {
        for (std::size_t slot = 0; slot < patches.group_of_new.size(); ++slot)
            for (const std::uint32_t u : matrix.unknowns(slot))
                if (u != none) patch_of_[u] = patches.groups[patches.group_of_new[slot]].patch;
    }

    /// Computes M⁻¹ Cᵀ and the matrices `Reach` of each patch and of the materials. Column k serves the k-th groups of
    /// all patches; these groups are disjoint.
    [[nodiscard]] Outcome<Done> make(const Execution& execution) {
        std::size_t most = 0;
        std::vector<Eigen::MatrixXd> squares;
        for (std::size_t p = 0; p < patches_.patches; ++p) {
            const auto n = static_cast<Eigen::Index>(groups_of(p));
            squares.emplace_back(Eigen::MatrixXd::Zero(n, n));
            most = std::max(most, groups_of(p));
        }
        Buffer<double> right(matrix_.size());
        for (std::size_t k = 0; k < most; ++k) {
            Buffer<double>& column = columns_.emplace_back(matrix_.size());
            const auto part = [&](std::size_t slot) {
                auto weights = matrix_.integrals(slot);
                if (local(patches_.group_of_new[slot]) != k) weights = {};
                return weights;
            };
            auto done = matrix_.assemble(part, right, execution);
            if (done) done = matrix_.solve(right, column, execution);
            if (!done) return done;
            const auto sums = over_groups(column, execution);
            if (!sums) return fail(sums.error());
            for (std::size_t g = 0; g < patches_.groups.size(); ++g)
                if (const std::size_t p = patches_.groups[g].patch; k < groups_of(p))
                    squares[p](static_cast<Eigen::Index>(local(g)), static_cast<Eigen::Index>(k)) = (*sums)[g].value();
        }
        for (const Eigen::MatrixXd& square : squares) of_patches_.emplace_back(square);
        if (!std::ranges::all_of(of_patches_, &Reach::is_whole)) of_materials_ = reach_of_materials();
        return Done{};
    }

    /// Smallest change of the field that changes the integrals by `gap`. Parts of `gap` that a patch cannot reach are
    /// spread over all nodes of the material.
    [[nodiscard]] SmallestChange least(const std::vector<double>& gap) const {
        SmallestChange out{.change = Buffer<double>(matrix_.size(), 0), .moved = std::vector<double>(gap.size(), 0)};
        std::vector<double> lambda(gap.size());
        Eigen::VectorXd missing = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(materials_));
        for (std::size_t p = 0; p < patches_.patches; ++p) {
            const Eigen::VectorXd own = of_patch(gap, p), rest = of_patches_[p].rest(own);
            of_patch(lambda, p) = of_patches_[p].multipliers(own);
            of_patch(out.moved, p) -= rest;
            for (std::size_t k = 0; k < groups_of(p); ++k) {
                const double r = rest[static_cast<Eigen::Index>(k)];
                missing[material_of(p, k)] += r;
                out.spread += r != 0 ? 1 : 0;
            }
        }
        if (out.spread > 0) spread(missing, lambda, out);
        for (std::size_t u = 0; u < out.change.size(); ++u)
            for (std::size_t k = 0; k < groups_of(patch_of_[u]); ++k)
                out.change[u] += lambda[patches_.first_group[patch_of_[u]] + k] * columns_[k][u];
        return out;
    }

  private:
    [[nodiscard]] Reach reach_of_materials() const {
        const auto m = static_cast<Eigen::Index>(materials_);
        Eigen::MatrixXd all = Eigen::MatrixXd::Zero(m, m);
        for (std::size_t p = 0; p < patches_.patches; ++p)
            for (std::size_t i = 0; i < groups_of(p); ++i)
                for (std::size_t j = 0; j < groups_of(p); ++j)
                    all(material_of(p, i), material_of(p, j)) +=
                        of_patches_[p].square()(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
        return Reach(all);
    }
    void spread(const Eigen::VectorXd& missing, std::vector<double>& lambda, SmallestChange& out) const {
        const Eigen::VectorXd of_material = of_materials_.multipliers(missing);
        for (const double rest : of_materials_.rest(missing)) out.unconserved_materials += rest != 0 ? 1 : 0;
        for (std::size_t p = 0; p < patches_.patches; ++p) {
            Eigen::VectorXd own(static_cast<Eigen::Index>(groups_of(p)));
            for (std::size_t k = 0; k < groups_of(p); ++k)
                own[static_cast<Eigen::Index>(k)] = of_material[material_of(p, k)];
            of_patch(lambda, p) += own;
            of_patch(out.moved, p) += of_patches_[p].square() * own;
        }
    }
    [[nodiscard]] Eigen::Map<Eigen::VectorXd> of_patch(std::vector<double>& groups, std::size_t p) const {
        return {groups.data() + patches_.first_group[p], static_cast<Eigen::Index>(groups_of(p))};
    }
    [[nodiscard]] Eigen::Map<const Eigen::VectorXd> of_patch(const std::vector<double>& groups, std::size_t p) const {
        return {groups.data() + patches_.first_group[p], static_cast<Eigen::Index>(groups_of(p))};
    }
    [[nodiscard]] Eigen::Index material_of(std::size_t patch, std::size_t k) const {
        return patches_.groups[patches_.first_group[patch] + k].material;
    }
    [[nodiscard]] std::size_t groups_of(std::size_t patch) const {
        return patches_.first_group[patch + 1] - patches_.first_group[patch];
    }
    [[nodiscard]] std::size_t local(std::size_t group) const {
        return group - patches_.first_group[patches_.groups[group].patch];
    }
    [[nodiscard]] Outcome<std::vector<Sum>> over_groups(std::span<const double> x, const Execution& execution) const {
        return sums_by_group(
            patches_.group_of_new, patches_.groups.size(), 1,
            [&](std::size_t slot, std::span<double> out) {
                const auto weights = matrix_.integrals(slot);
                const auto& unknowns = matrix_.unknowns(slot);
                out[0] = 0;
                for (std::size_t i = 0; i < unknowns.size(); ++i)
                    if (unknowns[i] != none) out[0] += weights[i] * x[unknowns[i]];
            },
            execution);
    }

    const Patches& patches_;
    MassMatrix<D, K>& matrix_;
    std::size_t materials_;
    Buffer<std::uint32_t> patch_of_;
    std::vector<Buffer<double>> columns_;
    std::vector<Reach> of_patches_;  ///< for the groups of each patch
    Reach of_materials_;             ///< for the materials; only if the integrals of some patch cannot all change
};

}  // namespace

template <int D, int K>
Outcome<std::vector<Sum>> integrals_before(const ProjectionInput<D>& scene,
                                           const typename PatchSearch<D>::Patches& patches,
                                           const Projection<D, K>& projection, const Execution& execution) {
    return integrals_by_group<D, K>(
        scene.old_mesh, [&](std::size_t slot) { return std::size_t{scene.changed.old_elements[slot]}; },
        patches.group_of_old, patches.groups.size(), {projection.block.old_values, projection.block.components},
        execution);
}

template <int D, int K>
Outcome<std::vector<double>> missing_integrals(const ProjectionInput<D>& scene,
                                               const typename PatchSearch<D>::Patches& patches,
                                               const Projection<D, K>& projection, const Execution& execution) {
    const std::size_t components = projection.block.components;
    const auto after = sums_by_group(
        patches.group_of_new, patches.groups.size(), components,
        [&](std::size_t slot, std::span<double> out) {
            const auto weights = projection.matrix.integrals(slot);
            const auto nodes = nodes_of<D, K>(scene.new_mesh, scene.changed.new_elements[slot]);
            std::ranges::fill(out, 0.0);
            for (std::size_t i = 0; i < nodes.size(); ++i)
                for (std::size_t c = 0; c < components; ++c)
                    out[c] += weights[i] * projection.block.values[nodes[i] * components + c];
        },
        execution);
    if (!after) return fail(after.error());
    const std::vector<Sum>& before = projection.before;
    // A material that is new in a patch has no integral to preserve.
    std::vector<std::uint8_t> existed(patches.groups.size(), 0);
    for (const std::uint32_t group : patches.group_of_old)
        if (group != no_group) existed[group] = 1;
    std::vector<double> missing(before.size(), 0);
    for (std::size_t i = 0; i < missing.size(); ++i) {
        if (existed[i / components] == 0) continue;
        const double gap = (before[i].total - (*after)[i].total) + (before[i].rest - (*after)[i].rest);
        constexpr double rounding = 1e-14;
        missing[i] = std::abs(gap) > rounding * std::max(before[i].size, (*after)[i].size) ? gap : 0;
    }
    return missing;
}

template <int D, int K>
Outcome<Done> conserve_integrals(const ProjectionInput<D>& scene, const typename PatchSearch<D>::Patches& patches,
                                 Projection<D, K>& projection, const Execution& execution) {
    Changes<D, K> changes(patches, scene.materials.size(), projection.matrix);
    const std::size_t components = projection.block.components;
    // Repetitions correct the errors of the approximate columns of M⁻¹ Cᵀ.
    constexpr int rounds = 3;
    for (int round = 0; round < rounds; ++round) {
        const auto missing = missing_integrals(scene, patches, projection, execution);
        if (!missing) return fail(missing.error());
        if (std::ranges::all_of(*missing, [](double gap) { return gap == 0; })) return Done{};
        if (round == 0)
            if (auto result = changes.make(execution); !result) return result;
        for (std::size_t c = 0; c < components; ++c) {
            std::vector<double> gap(patches.groups.size());
            for (std::size_t g = 0; g < gap.size(); ++g) gap[g] = (*missing)[g * components + c];
            const SmallestChange least = changes.least(gap);
            projection.add(c, least.change);
            for (std::size_t g = 0; g < gap.size(); ++g) projection.before[g * components + c].add(least.moved[g]);
            projection.spread = std::max(projection.spread, least.spread);
            projection.unconserved_materials = std::max(projection.unconserved_materials, least.unconserved_materials);
        }
    }
    return Done{};
}

#define CAMBER_INSTANTIATE(D, K)                                                                               \
    template Outcome<std::vector<Sum>> integrals_before<D, K>(                                                 \
        const ProjectionInput<D>&, const PatchSearch<D>::Patches&, const Projection<D, K>&, const Execution&); \
    template Outcome<std::vector<double>> missing_integrals<D, K>(                                             \
        const ProjectionInput<D>&, const PatchSearch<D>::Patches&, const Projection<D, K>&, const Execution&); \
    template Outcome<Done> conserve_integrals<D, K>(const ProjectionInput<D>&, const PatchSearch<D>::Patches&, \
                                                    Projection<D, K>&, const Execution&);

CAMBER_INSTANTIATE(2, 1)
CAMBER_INSTANTIATE(2, 2)
CAMBER_INSTANTIATE(3, 1)
CAMBER_INSTANTIATE(3, 2)
#undef CAMBER_INSTANTIATE

namespace {

/// ∫ φ for each unknown, and the group that contains all elements of its node. The group is `no_group` for interface
/// nodes, where a change would affect two groups.
template <int D, int K>
struct Movable {
    Buffer<double> weight;
    Buffer<std::uint32_t> group;
};
template <int D, int K>
Outcome<Movable<D, K>> movable(const typename PatchSearch<D>::Patches& patches, MassMatrix<D, K>& matrix,
                               const Execution& execution) {
    Movable<D, K> out{Buffer<double>(matrix.size()), Buffer<std::uint32_t>(matrix.size(), no_group)};
    const auto part = [&](std::size_t slot) { return matrix.integrals(slot); };
    auto done = matrix.assemble(part, out.weight, execution);
    if (!done) return fail(done.error());
    Buffer<std::uint8_t> is_visited(matrix.size(), 0);
    for (std::size_t slot = 0; slot < patches.group_of_new.size(); ++slot)
        for (const std::uint32_t u : matrix.unknowns(slot)) {
            if (u == none) continue;
            if (is_visited[u] != 0 && out.group[u] != patches.group_of_new[slot])
                out.group[u] = no_group;
            else if (is_visited[u] == 0)
                out.group[u] = patches.group_of_new[slot];
            is_visited[u] = 1;
        }
    return out;
}

}  // namespace

template <int D, int K>
Outcome<Done> clip_to_limits(const ProjectionInput<D>& scene, const typename PatchSearch<D>::Patches& patches,
                             Projection<D, K>& projection, const Execution& execution) {
    const std::size_t unknowns = projection.matrix.size(), components = projection.block.components;
    const auto value = [&](std::size_t u, std::size_t c) -> double& {
        return projection.block.values[projection.matrix.node_of()[u] * components + c];
    };
    for (std::size_t u = 0; u < unknowns; ++u)
        for (std::size_t c = 0; c < components; ++c)
            value(u, c) =
                std::clamp(value(u, c), projection.low[u * components + c], projection.high[u * components + c]);
    const auto free = movable<D, K>(patches, projection.matrix, execution);
    if (!free) return fail(free.error());
    // The second pass corrects rounding errors of the first.
    for (int round = 0; round < 2; ++round) {
        const auto missing = missing_integrals(scene, patches, projection, execution);
        if (!missing) return fail(missing.error());
        // Maximum change of a node's value towards the missing integral, within the limits.
        const auto room = [&](std::size_t u, std::size_t c) {
            const double gap = (*missing)[free->group[u] * components + c] * free->weight[u];
            if (gap == 0) return 0.0;
            return (gap > 0 ? projection.high : projection.low)[u * components + c] - value(u, c);
        };
        const auto possible = sums_by_group(
            free->group, patches.groups.size(), components,
            [&](std::size_t u, std::span<double> out) {
                for (std::size_t c = 0; c < components; ++c)
                    out[c] = free->group[u] == no_group ? 0 : free->weight[u] * room(u, c);
            },
            execution);
        if (!possible) return fail(possible.error());
        for (std::size_t u = 0; u < unknowns; ++u) {
            if (free->group[u] == no_group) continue;
            for (std::size_t c = 0; c < components; ++c) {
                const std::size_t at = free->group[u] * components + c;
                const double all = (*possible)[at].value();
                if (all == 0) continue;
                value(u, c) += std::min(1.0, (*missing)[at] / all) * room(u, c);
                value(u, c) =
                    std::clamp(value(u, c), projection.low[u * components + c], projection.high[u * components + c]);
            }
        }
    }
    return Done{};
}

#define CAMBER_INSTANTIATE(D, K)                                                                           \
    template Outcome<Done> clip_to_limits<D, K>(const ProjectionInput<D>&, const PatchSearch<D>::Patches&, \
                                                Projection<D, K>&, const Execution&);

CAMBER_INSTANTIATE(2, 1)
CAMBER_INSTANTIATE(2, 2)
CAMBER_INSTANTIATE(3, 1)
CAMBER_INSTANTIATE(3, 2)
#undef CAMBER_INSTANTIATE

#define CAMBER_INSTANTIATE(D)                                                             \
    template Outcome<std::vector<std::vector<MaterialIntegrals>>> total_integrals<D>(     \
        const QuadraticMesh<D>&, std::span<const TransferField>, const QuadraticMesh<D>&, \
        std::span<const TransferField>, const Materials<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
