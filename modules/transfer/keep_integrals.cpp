module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

// The macro alloca, which Eigen takes otherwise, does not come along where the standard headers are one module.
#define EIGEN_ALLOCA __builtin_alloca
#include <Eigen/Dense>
module camber.transfer;
import :integrals;
import :key_table;
import :patches;
import :projection;
import :simplex;
import :sums;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// A pseudo-inverse: groups none of whose nodes are free have no say. Rows are scaled first, since materials may be of
/// very different volumes.
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& a) {
    constexpr double singular = 1e-10;
    Eigen::VectorXd scale = a.diagonal();
    for (double& s : scale) s = s > 0 ? 1 / std::sqrt(s) : 0;
    const Eigen::MatrixXd scaled = scale.asDiagonal() * (0.5 * (a + a.transpose())) * scale.asDiagonal();
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition;
    decomposition.setThreshold(singular);
    decomposition.compute(scaled);
    return scale.asDiagonal() * decomposition.pseudoInverse() * scale.asDiagonal();
}

/// The changes in L2 that integrals by group can be put right by.
template <int D, int K>
class Changes {
  public:
    using Patches = typename PatchSearch<D>::Patches;

    Changes(const Patches& patches, MassMatrix<D, K>& matrix)
        : patches_(patches), matrix_(matrix), patch_of_(matrix.size(), none) {
        for (std::size_t slot = 0; slot < patches.group_of_new.size(); ++slot)
            for (const std::uint32_t u : matrix.unknowns(slot))
                if (u != none) patch_of_[u] = patches.groups[patches.group_of_new[slot]].patch;
    }

    /// M⁻¹ Cᵀ, a column for the first group of each patch, one for the second, and so on: patches do not touch. And of
    /// each patch the inverse of C M⁻¹ Cᵀ on what it can reach.
    [[nodiscard]] Outcome<Done> make(const Execution& execution) {
        std::size_t most = 0;
        for (std::size_t p = 0; p < patches_.patches; ++p) {
            const auto n = static_cast<Eigen::Index>(groups_of(p));
            inverse_.emplace_back(Eigen::MatrixXd::Zero(n, n));
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
                    inverse_[p](static_cast<Eigen::Index>(local(g)), static_cast<Eigen::Index>(k)) = (*sums)[g].value();
        }
        for (Eigen::MatrixXd& square : inverse_) square = pseudo_inverse(square);
        return Done{};
    }

    /// The least change by which the integrals over the groups change so much.
    [[nodiscard]] Buffer<double> least(const std::vector<double>& gap) const {
        std::vector<double> lambda(gap.size());
        for (std::size_t p = 0; p < patches_.patches; ++p) {
            const std::size_t first = patches_.first_group[p];
            const auto n = static_cast<Eigen::Index>(groups_of(p));
            Eigen::Map<Eigen::VectorXd>(lambda.data() + first, n) =
                inverse_[p] * Eigen::Map<const Eigen::VectorXd>(gap.data() + first, n);
        }
        Buffer<double> change(matrix_.size(), 0);
        for (std::size_t u = 0; u < change.size(); ++u)
            for (std::size_t k = 0; k < groups_of(patch_of_[u]); ++k)
                change[u] += lambda[patches_.first_group[patch_of_[u]] + k] * columns_[k][u];
        return change;
    }

  private:
    [[nodiscard]] std::size_t groups_of(std::size_t patch) const {
        return patches_.first_group[patch + 1] - patches_.first_group[patch];
    }
    [[nodiscard]] std::size_t local(std::size_t group) const {
        return group - patches_.first_group[patches_.groups[group].patch];
    }
    /// C x.
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
    std::vector<std::uint32_t> patch_of_;  ///< of each unknown
    std::vector<Buffer<double>> columns_;
    std::vector<Eigen::MatrixXd> inverse_;
};

}  // namespace

template <int D, int K>
Outcome<std::vector<Sum>> integrals_before(const TransferScene<D>& scene,
                                           const typename PatchSearch<D>::Patches& patches,
                                           const Projection<D, K>& projection, const Execution& execution) {
    return integrals_by_group<D, K>(
        scene.old_mesh, [&](std::size_t slot) { return std::size_t{scene.changed.old_elements[slot]}; },
        patches.group_of_old, patches.groups.size(), projection.block.old_values, projection.block.components,
        execution);
}

template <int D, int K>
Outcome<std::vector<double>> missing_integrals(const TransferScene<D>& scene,
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
    // A material that comes where it was not has no integral to keep.
    std::vector<std::uint8_t> was_there(patches.groups.size(), 0);
    for (const std::uint32_t group : patches.group_of_old)
        if (group != no_group) was_there[group] = 1;
    std::vector<double> missing(before.size(), 0);
    for (std::size_t i = 0; i < missing.size(); ++i) {
        if (was_there[i / components] == 0) continue;
        const double gap = (before[i].total - (*after)[i].total) + (before[i].rest - (*after)[i].rest);
        constexpr double rounding = 1e-14;
        missing[i] = std::abs(gap) > rounding * std::max(before[i].size, (*after)[i].size) ? gap : 0;
    }
    return missing;
}

template <int D, int K>
Outcome<Done> keep_integrals(const TransferScene<D>& scene, const typename PatchSearch<D>::Patches& patches,
                             Projection<D, K>& projection, const Execution& execution) {
    Changes<D, K> changes(patches, projection.matrix);
    const std::size_t components = projection.block.components;
    // Once, and again for what the columns' own errors left.
    constexpr int rounds = 3;
    for (int round = 0; round < rounds; ++round) {
        const auto missing = missing_integrals(scene, patches, projection, execution);
        if (!missing) return fail(missing.error());
        if (std::ranges::all_of(*missing, [](double gap) { return gap == 0; })) return Done{};
        if (round == 0)
            if (auto made = changes.make(execution); !made) return made;
        for (std::size_t c = 0; c < components; ++c) {
            std::vector<double> gap(patches.groups.size());
            for (std::size_t g = 0; g < gap.size(); ++g) gap[g] = (*missing)[g * components + c];
            projection.add(c, changes.least(gap));
        }
    }
    return Done{};
}

#define CAMBER_INSTANTIATE(D, K)                                                                                       \
    template Outcome<std::vector<Sum>> integrals_before<D, K>(const TransferScene<D>&, const PatchSearch<D>::Patches&, \
                                                              const Projection<D, K>&, const Execution&);              \
    template Outcome<std::vector<double>> missing_integrals<D, K>(                                                     \
        const TransferScene<D>&, const PatchSearch<D>::Patches&, const Projection<D, K>&, const Execution&);           \
    template Outcome<Done> keep_integrals<D, K>(const TransferScene<D>&, const PatchSearch<D>::Patches&,               \
                                                Projection<D, K>&, const Execution&);

CAMBER_INSTANTIATE(2, 1)
CAMBER_INSTANTIATE(2, 2)
CAMBER_INSTANTIATE(3, 1)
CAMBER_INSTANTIATE(3, 2)
#undef CAMBER_INSTANTIATE

}  // namespace camber
