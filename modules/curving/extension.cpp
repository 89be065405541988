module;
#include <algorithm>
#include <cstddef>
#include <iterator>
#include <limits>
#include <span>
#include <utility>
#include <vector>
module camber.curving;
import camber.core;
import :extension;
import :extension_part;
import :parts;

namespace camber {

namespace {

/// Corrections of this share of the first are rounding.
constexpr double rounding = 1e-14;

/// How far a solve is: the steps that are left, if each of them takes as much of the largest correction as those so far
/// took of the residual's norm on the mean. Where it comes no nearer for a while, nobody can know, and the share stays.
class Headway {
  public:
    Headway(double first, double tolerance, const Execution& execution)
        : first_(first), tolerance_(tolerance), execution_(execution) {}
    void after_step(const ExtensionSums& sums) {
        const double gained = 0.5 * log(first_ / sums.by_residual);  // in all steps, of the norm
        const double missing = log(sums.largest / tolerance_);
        if (gained > 0 && missing < std::numeric_limits<double>::infinity())
            share_ = std::max(share_, gained / (gained + std::max(missing, 0.0)));
        constexpr std::size_t fine = 1000;
        report_progress(execution_, static_cast<std::size_t>(share_ * fine), fine);
    }

  private:
    double first_, tolerance_, share_ = 0;
    const Execution& execution_;
};

/// All parts, as one system: what they find of each run is added up in their order.
template <int D>
class Parts {
  public:
    Parts(std::span<ExtensionPart<D>> parts, BetweenParts<D>& between, const Execution& execution)
        : parts_(parts), between_(between), execution_(execution), moving_(parts.size()), given_(parts.size()) {}

    Outcome<Done> begin(double stiffening) {
        const auto all = gathered(
            [&](ExtensionPart<D>& part) -> Outcome<std::vector<double>> { return part.volume_and_count(execution_); });
        if (!all) return fail(all.error());
        double volume = 0, count = 0;
        for (std::size_t i = 0; i < all->size(); i += 2) volume += (*all)[i], count += (*all)[i + 1];
        return each_part(
            [&](ExtensionPart<D>& part) { return part.begin(volume / std::max(1.0, count), stiffening, execution_); });
    }

    Outcome<ExtensionSums> step(double length, double tolerance) {
        const auto all = gathered([&](ExtensionPart<D>& part) {
            return part.step(length, tolerance, execution_).map([](const std::vector<ExtensionSums>& runs) {
                std::vector<double> numbers;
                for (const ExtensionSums& s : runs)
                    numbers.insert(numbers.end(), {s.by_product, s.by_residual, s.largest, s.joined});
                return numbers;
            });
        });
        if (!all) return fail(all.error());
        ExtensionSums sums;
        for (std::size_t i = 0; i < all->size(); i += 4)
            sums = sums + ExtensionSums{(*all)[i], (*all)[i + 1], (*all)[i + 2], (*all)[i + 3]};
        return sums;
    }

    /// The next direction of all parts, known to all, and rows around what joined.
    Outcome<Done> turn_by(double turn) {
        if (auto turned = each_part([&](ExtensionPart<D>& part) { return part.turn_by(turn, execution_); }); !turned)
            return turned;
        std::vector<std::span<Vec<D>>> directions;
        for (std::size_t p = 0; p < parts_.size(); ++p) {
            const auto joined = between_.shared(p, parts_[p].joined_last());
            moving_[p].insert(moving_[p].end(), joined.begin(), joined.end());
            directions.push_back(parts_[p].directions());
        }
        const auto brought = between_.bring(directions, moving_);
        if (!brought) return fail(brought.error());
        for (std::size_t p = 0; p < parts_.size(); ++p) {
            std::vector<EdgeId> met;
            std::ranges::set_difference((*brought)[p], given_[p], std::back_inserter(met));
            given_[p] = std::move((*brought)[p]);
            if (auto joined = parts_[p].join(met, execution_); !joined) return joined;
        }
        return Done{};
    }

    Outcome<AlongDirection> multiply() {
        const auto all = gathered([&](ExtensionPart<D>& part) {
            return part.multiply(execution_).map([](const std::vector<AlongDirection>& runs) {
                std::vector<double> numbers;
                for (const AlongDirection& a : runs) numbers.insert(numbers.end(), {a.curvature, a.slope});
                return numbers;
            });
        });
        if (!all) return fail(all.error());
        AlongDirection along;
        for (std::size_t i = 0; i < all->size(); i += 2) along = along + AlongDirection{(*all)[i], (*all)[i + 1]};
        return along;
    }

  private:
    /// The numbers of each run of all, one after the other.
    Outcome<std::vector<double>> gathered(const auto& numbers_of) {
        const auto here = [&]() -> Outcome<std::vector<double>> {
            std::vector<double> all;
            for (ExtensionPart<D>& part : parts_) {
                const auto numbers = numbers_of(part);
                if (!numbers) return fail(numbers.error());
                all.insert(all.end(), numbers->begin(), numbers->end());
            }
            return all;
        };
        return between_.gather(here());
    }
    Outcome<Done> each_part(const auto& f) {
        for (ExtensionPart<D>& part : parts_)
            if (auto done = f(part); !done) return done;
        return Done{};
    }

    std::span<ExtensionPart<D>> parts_;
    BetweenParts<D>& between_;
    const Execution& execution_;
    EdgesOfParts moving_;  ///< its own that others have
    EdgesOfParts given_;   ///< those of others, rising
};

}  // namespace

template <int D>
Outcome<ExtensionSolve> solve_extension(std::span<ExtensionPart<D>> given, BetweenParts<D>& between,
                                        const ExtensionOptions& options, const Execution& execution) {
    return guarded([&]() -> Outcome<ExtensionSolve> {
        ExtensionSolve solved;
        const Execution quiet = without_progress(execution);
        Parts<D> parts(given, between, quiet);
        if (auto begun = parts.begin(options.stiffening); !begun) return fail(begun.error());
        auto sums = parts.step(0, options.tolerance);
        if (!sums) return fail(sums.error());
        const double first = sums->by_residual;
        Headway headway(first, options.tolerance, execution);
        double turn = 0;
        for (; solved.iterations < options.max_iterations && sums->largest > options.tolerance &&
               sums->by_residual > rounding * rounding * first;
             ++solved.iterations) {
            if (auto turned = parts.turn_by(turn); !turned) return fail(turned.error());
            const auto along = parts.multiply();
            if (!along) return fail(along.error());
            if (!(along->curvature > 0)) break;
            sums = parts.step(along->slope / along->curvature, options.tolerance);
            if (!sums) return fail(sums.error());
            turn = -sums->by_product / along->curvature;
            headway.after_step(*sums);
        }
        solved.correction = sums->largest;
        return solved;
    });
}

template <int D>
Outcome<Extension<D>> extend_boundary(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                      const Column<LagrangeNode<D>>& boundary_nodes, const Incidence<ElementId>& shells,
                                      const ExtensionOptions& options, const Execution& execution) {
    // Shares of the time of shells with layers, 1 and 5 million elements.
    auto part = ExtensionPart<D>::make(mesh, kinds, boundary_nodes.view(), shells, whole(mesh.linear),
                                       part_of(execution, 0, 0.12));
    if (!part) return fail(part.error());
    ExtensionSolve solved;
    std::size_t moving = 0;
    if (part->is_displaced()) {
        OnePart<D> alone;
        const auto found = solve_extension<D>(std::span(&*part, 1), alone, options, part_of(execution, 0.15, 0.97));
        if (!found) return fail(found.error());
        solved = *found;
        moving = part->moving();
    }
    auto nodes = std::move(*part).nodes(part_of(execution, 0.97, 1));
    if (!nodes) return fail(nodes.error());
    return Extension<D>{std::move(*nodes), solved.iterations, solved.correction, moving};
}

#define CAMBER_INSTANTIATE(D)                                                                                      \
    template Outcome<ExtensionSolve> solve_extension<D>(std::span<ExtensionPart<D>>, BetweenParts<D>&,             \
                                                        const ExtensionOptions&, const Execution&);                \
    template Outcome<Extension<D>> extend_boundary<D>(const QuadraticMesh<D>&, const Column<EdgeKind>&,            \
                                                      const Column<LagrangeNode<D>>&, const Incidence<ElementId>&, \
                                                      const ExtensionOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
