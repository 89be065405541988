// Many random operations of degree 2 on a random bowed domain, with its laws looked at along the way.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "bowed.hpp"
#include "curved_laws.hpp"
#include "curved_operations.hpp"
#include "dice.hpp"
#include "mesh_laws.hpp"
#include "operation_runs.hpp"

import camber.core;
import camber.metric;
import camber.cavity;
import camber.validity;
import camber.operation;
import camber.adapt;

namespace camber::testing {

/// What became of the tries, by kind.
template <int D>
struct CurvedTally {
    struct Row {
        std::size_t accepted = 0, bowed = 0;  ///< bowed: accepted where an edge of the cavity was, by min_bow
        std::size_t straight_inverted = 0, drawn_back = 0, bent_around = 0;
        std::size_t nowhere = 0;  ///< nothing of the kind was found
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
            row.drawn_back += more.drawn_back;
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
    std::size_t steps_a_bow = 20;  ///< then nodes are bowed anew
    std::size_t exactly = 2;       ///< new elements of each operation that exact arithmetic looks at
};

template <int D>
class CurvedRun {
  public:
    CurvedRun(std::uint64_t seed, const CurvedRunOptions& options)
        : seed_(seed),
          options_(options),
          dice_(seed + 7),
          domain_(bowed_domain<D>(domain_with_required<D>(seed), dice_)),
          kept_(kept_by(domain_.state.mesh)),
          sizes_(curved_measures(domain_.state.mesh)) {}

    /// Which law broke, and at which step; nothing where all hold.
    [[nodiscard]] std::string run(CurvedTally<D>& tally) {
        for (std::size_t step = 0; step < options_.steps; ++step) {
            if (step > 0 && step % options_.steps_a_bow == 0) bow(domain_.state, domain_.stretch, dice_);
            const std::size_t kind = next_kind();
            std::string law = one(kind, tally.rows[kind]);
            if (law.empty() && step % options_.steps_a_check == 0) law = unless_mesh_holds();
            if (!law.empty()) return told(step, law + " (kind " + std::to_string(kind) + ")");
        }
        const std::string law = unless_all_holds_at_end();
        return law.empty() ? "" : told(options_.steps, law);
    }

  private:
    using Row = typename CurvedTally<D>::Row;

    [[nodiscard]] std::string told(std::size_t step, const std::string& law) const {
        return "seed " + std::to_string(seed_) + ", step " + std::to_string(step) + ": " + law;
    }
    /// Small meshes grow, large ones shrink.
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
            .below_least = dice_.below(2) == 0 ? BelowLeast::refused : BelowLeast::accepted_if_no_worse,
            .bend_around = bend_around};
        const OperationResult result = operate(domain_.state, domain_.goal, tried->request, limits, workspace_, patch);
        if (result.rejected != RejectionReason::none) {
            ++row.rejected[static_cast<std::size_t>(result.rejected)];
            return "";
        }
        ++row.accepted;
        row.bowed += is_bowed(patch.patch().removed.elements) ? 1 : 0;
        row.straight_inverted += result.straight_inverted ? 1 : 0;
        row.drawn_back += result.drawn_back ? 1 : 0;
        row.bent_around += result.bends_around ? 1 : 0;
        const double replaced = worst_shape_of(domain_.state, patch.patch().removed.elements);
        const DynamicMesh<D> before = mesh();
        auto [after, changes] = must(commit<D>(std::move(domain_.state), {std::move(patch)}));
        domain_.state = std::move(after);
        for (const std::string& law :
             {unless_no_worse(changes.elements.created, replaced), unless_told(before, mesh(), changes),
              unless_valid(mesh(), changes.elements.created, options_.exactly), unless_filled(before, mesh(), changes),
              unless_nodes_stay(before, mesh(), changes),
              tried->split ? unless_halved(mesh(), changes, *tried->split, domain_.stretch) : std::string(),
              curved_kinds<D>()[kind].kind.operation == Operation::reinsert
                  ? unless_boundary_stays(before, mesh(), changes, domain_.stretch)
                  : std::string()})
            if (!law.empty()) return law;
        return "";
    }
    /// Than what is replaced, or than what is bad.
    [[nodiscard]] std::string unless_no_worse(const std::vector<ElementId>& created, double replaced) const {
        const double least = std::min(shape_of_quality(PatchLimits{}.bad_quality, D), replaced);
        return worst_shape_of(domain_.state, created) >= (1 - 1e-8) * least ? "" : "an element is worse";
    }
    [[nodiscard]] bool is_bowed(const std::vector<ElementId>& elements) const {
        return std::ranges::any_of(elements, [&](ElementId e) {
            return std::ranges::any_of(mesh().edges_of[e],
                                       [&](EdgeId edge) { return bow_of(mesh(), edge, domain_.stretch) >= min_bow; });
        });
    }

    [[nodiscard]] std::string unless_mesh_holds() const {
        for (const std::string& law :
             {unless_topology_holds(mesh(), kept_), unless_same_sizes(curved_measures(mesh()), sizes_)})
            if (!law.empty()) return law;
        return "";
    }
    [[nodiscard]] std::string unless_all_holds_at_end() const {
        std::vector<ElementId> all;
        for (std::size_t e = 0; e < mesh().elements.size(); ++e) all.emplace_back(e);
        for (const std::string& law : {unless_mesh_holds(), unless_parts_stay(mesh(), kept_),
                                       unless_as_made_anew(mesh()), unless_valid(mesh(), all, 8 * options_.exactly)})
            if (!law.empty()) return law;
        return "";
    }

    std::uint64_t seed_;
    const CurvedRunOptions& options_;
    Dice dice_;
    BowedDomain<D> domain_;
    Kept<D> kept_;
    Sizes sizes_;
    OperationWorkspace<D> workspace_;
};

}  // namespace camber::testing
