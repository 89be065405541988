// Runs many random quadratic operations on a random bowed domain and checks properties in between.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "bowed.hpp"
#include "curved_invariants.hpp"
#include "curved_operations.hpp"
#include "dice.hpp"
#include "mesh_invariants.hpp"
#include "operation_runs.hpp"

import camber.core;
import camber.metric;
import camber.cavity;
import camber.validity;
import camber.operation;
import camber.adapt;

namespace camber::testing {

/// Number of attempts by kind and result.
template <int D>
struct CurvedTally {
    struct Row {
        std::size_t accepted = 0, bowed = 0;  ///< bowed: accepted with an edge of the cavity bowed by at least
                                              ///< `min_bow`
        std::size_t straight_inverted = 0, relaxed = 0, bent_around = 0;
        std::size_t nowhere = 0;  ///< no place of the kind was found
        std::array<std::size_t, rejection_reasons> rejected{};
    };
    std::array<Row, curved_kinds<D>().size()> rows{};

    [[nodiscard]] std::size_t least() const { return std::ranges::min(rows, {}, &Row::bowed).bowed; }
    CurvedTally& operator+=(const CurvedTally& other) {
        for (std::size_t k = 0; k < rows.size(); ++k) {
            Row& row = rows[k];
            const Row& more = other.rows[k];
            row.accepted += more.accepted;
            row.bowed += more.bowed;
            row.straight_inverted += more.straight_inverted;
            row.relaxed += more.relaxed;
            row.bent_around += more.bent_around;
            row.nowhere += more.nowhere;
            for (std::size_t i = 0; i < row.rejected.size(); ++i) row.rejected[i] += more.rejected[i];
        }
        return *this;
    }
};

struct CurvedRunOptions {
    std::size_t steps = 200;
    std::size_t max_elements = 400;
    std::size_t steps_a_check = 16;
    std::size_t steps_a_bow = 20;  ///< steps until nodes are bowed again
    std::size_t exactly = 2;       ///< number of new elements per operation that exact arithmetic checks
};

template <int D>
class CurvedRun {
  public:
    CurvedRun(std::uint64_t seed, const CurvedRunOptions& options)
        : seed_(seed),
          options_(options),
          dice_(seed + 7),
          domain_(bowed_domain<D>(domain_with_required<D>(seed), dice_)),
          invariants_(invariants_of(domain_.state.mesh)),
          sizes_(curved_measures(domain_.state.mesh)) {}

    /// Returns the violated property and its step, or an empty string.
    [[nodiscard]] std::string run(CurvedTally<D>& tally) {
        for (std::size_t step = 0; step < options_.steps; ++step) {
            if (step > 0 && step % options_.steps_a_bow == 0) bow(domain_.state, domain_.stretch, dice_);
            const std::size_t kind = next_kind();
            std::string violation = one(kind, tally.rows[kind]);
            if (violation.empty() && step % options_.steps_a_check == 0) violation = mesh_violation();
            if (!violation.empty()) return message_at(step, violation + " (kind " + std::to_string(kind) + ")");
        }
        const std::string violation = final_violation();
        return violation.empty() ? "" : message_at(options_.steps, violation);
    }

  private:
    using Row = typename CurvedTally<D>::Row;

    [[nodiscard]] std::string message_at(std::size_t step, const std::string& violation) const {
        return "seed " + std::to_string(seed_) + ", step " + std::to_string(step) + ": " + violation;
    }
    /// Returns a random kind, for large meshes mostly a collapse.
    [[nodiscard]] std::size_t next_kind() {
        constexpr auto all = curved_kinds<D>();
        const bool is_large = mesh().element_count() > options_.max_elements;
        for (;;) {
            const std::size_t kind = any_kind<D>(dice_);
            if (!is_large || all[kind].kind.operation == Operation::collapse || dice_.below(50) == 0) return kind;
        }
    }
    [[nodiscard]] const DynamicMesh<D>& mesh() const { return domain_.state.mesh; }

    [[nodiscard]] std::string one(std::size_t kind, Row& row) {
        const auto tried = CurvedTrying<D>(domain_, dice_).any(curved_kinds<D>()[kind]);
        if (!tried) {
            ++row.nowhere;
            return "";
        }
        JudgedPatch<D> patch;
        const PatchLimits limits{
            .min_shape = 1e-3,
            .below_minimum = dice_.below(2) == 0 ? BelowMinimum::refused : BelowMinimum::accepted_if_no_worse,
            .bend_around = bend_around};
        const OperationResult result = operate(domain_.state, domain_.goal, tried->request, limits, workspace_, patch);
        if (result.rejected != RejectionReason::none) {
            ++row.rejected[static_cast<std::size_t>(result.rejected)];
            return "";
        }
        ++row.accepted;
        row.bowed += is_bowed(patch.patch().removed.elements) ? 1 : 0;
        row.straight_inverted += result.straight_inverted ? 1 : 0;
        row.relaxed += result.relaxed ? 1 : 0;
        row.bent_around += result.bends_around ? 1 : 0;
        const double replaced = worst_shape_of(domain_.state, patch.patch().removed.elements);
        const DynamicMesh<D> before = mesh();
        auto [after, changes] = must(commit<D>(std::move(domain_.state), {std::move(patch)}));
        domain_.state = std::move(after);
        for (const std::string& violation :
             {quality_violation(changes.elements.created, replaced), changes_violation(before, mesh(), changes),
              validity_violation(mesh(), changes.elements.created, options_.exactly),
              filling_violation(before, mesh(), changes), node_violation(before, mesh(), changes),
              tried->split ? split_violation(mesh(), changes, *tried->split, domain_.stretch) : std::string(),
              curved_kinds<D>()[kind].kind.operation == Operation::reinsert
                  ? boundary_curve_violation(before, mesh(), changes, domain_.stretch)
                  : std::string()})
            if (!violation.empty()) return violation;
        return "";
    }
    /// New elements are no worse than the replaced ones or the threshold of bad elements.
    [[nodiscard]] std::string quality_violation(const std::vector<ElementId>& created, double replaced) const {
        const double least = std::min(shape_of_quality(PatchLimits{}.bad_quality, D), replaced);
        return worst_shape_of(domain_.state, created) >= (1 - 1e-8) * least ? "" : "an element is worse";
    }
    [[nodiscard]] bool is_bowed(const std::vector<ElementId>& elements) const {
        return std::ranges::any_of(elements, [&](ElementId e) {
            return std::ranges::any_of(mesh().edges_of[e],
                                       [&](EdgeId edge) { return bow_of(mesh(), edge, domain_.stretch) >= min_bow; });
        });
    }

    [[nodiscard]] std::string mesh_violation() const {
        for (const std::string& violation :
             {topology_violation(mesh(), invariants_), curved_size_violation(curved_measures(mesh()), sizes_)})
            if (!violation.empty()) return violation;
        return "";
    }
    [[nodiscard]] std::string final_violation() const {
        std::vector<ElementId> all;
        for (std::size_t e = 0; e < mesh().elements.size(); ++e) all.emplace_back(e);
        for (const std::string& violation :
             {mesh_violation(), characteristics_violation(mesh(), invariants_), rebuild_violation(mesh()),
              validity_violation(mesh(), all, 8 * options_.exactly)})
            if (!violation.empty()) return violation;
        return "";
    }

    std::uint64_t seed_;
    const CurvedRunOptions& options_;
    Dice dice_;
    BowedDomain<D> domain_;
    Invariants<D> invariants_;
    Sizes sizes_;
    OperationWorkspace<D> workspace_;
};

}  // namespace camber::testing
