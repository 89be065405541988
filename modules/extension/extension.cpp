// Extends displacements by conjugate gradients over the parts of a mesh.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>
module camber.extension;
import camber.core;
import :energy;
import :system;

namespace camber {

namespace {

/// Iterations stop when the residual is this share of the first residual. Smaller residuals are rounding noise.
constexpr double rounding = 1e-14;

/// Reports the progress of a solve as a share, by logarithms of the residual. It never decreases.
class SolveProgress {
  public:
    SolveProgress(double first, double tolerance, const Execution& execution)
        : first_(first), tolerance_(tolerance), execution_(execution) {}
    void after_step(const ExtensionSums& sums) {
        const double gained = 0.5 * log(first_ / sums.by_residual);  // log of the reduction of the residual's norm
                                                                     // since the start
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

/// All parts as one system. Sums of runs are added in the order of runs.
template <int S, int D>
class Parts {
  public:
    Parts(std::span<ExtensionPart<S, D>> parts, PartCommunication<D>& between, const Execution& execution)
        : parts_(parts), between_(between), execution_(execution), moving_(parts.size()), received_(parts.size()) {}

    Outcome<Done> begin(double stiffening) {
        const auto all = gather_from_parts([&](ExtensionPart<S, D>& part) -> Outcome<std::vector<double>> {
            return part.volume_and_count(execution_);
        });
        if (!all) return fail(all.error());
        double volume = 0, count = 0;
        for (std::size_t i = 0; i < all->size(); i += 2) volume += (*all)[i], count += (*all)[i + 1];
        return each_part([&](ExtensionPart<S, D>& part) {
            return part.begin(volume / std::max(1.0, count), stiffening, execution_);
        });
    }

    Outcome<ExtensionSums> step(double length, double tolerance) {
        const auto all = gather_from_parts([&](ExtensionPart<S, D>& part) {
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

    Outcome<Done> update_direction(double turn) {
        if (auto turned = each_part([&](ExtensionPart<S, D>& part) { return part.update_direction(turn, execution_); });
            !turned)
            return turned;
        std::vector<std::span<Vec<D>>> directions;
        for (std::size_t p = 0; p < parts_.size(); ++p) {
            const auto joined = between_.shared(p, parts_[p].joined_last());
            moving_[p].insert(moving_[p].end(), joined.begin(), joined.end());
            directions.push_back(parts_[p].directions());
        }
        const auto exchanged = between_.exchange_rows(directions, moving_);
        if (!exchanged) return fail(exchanged.error());
        for (std::size_t p = 0; p < parts_.size(); ++p) {
            std::vector<EdgeId> met;
            std::ranges::set_difference((*exchanged)[p], received_[p], std::back_inserter(met));
            received_[p] = std::move((*exchanged)[p]);
            if (auto joined = parts_[p].join(met, execution_); !joined) return joined;
        }
        return Done{};
    }

    Outcome<AlongDirection> multiply() {
        const auto all = gather_from_parts([&](ExtensionPart<S, D>& part) {
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
    Outcome<std::vector<double>> gather_from_parts(const auto& numbers_of) {
        const auto here = [&]() -> Outcome<std::vector<double>> {
            std::vector<double> all;
            for (ExtensionPart<S, D>& part : parts_) {
                const auto numbers = numbers_of(part);
                if (!numbers) return fail(numbers.error());
                all.insert(all.end(), numbers->begin(), numbers->end());
            }
            return all;
        };
        return between_.gather(here());
    }
    Outcome<Done> each_part(const auto& f) {
        for (ExtensionPart<S, D>& part : parts_)
            if (auto done = f(part); !done) return done;
        return Done{};
    }

    std::span<ExtensionPart<S, D>> parts_;
    PartCommunication<D>& between_;
    const Execution& execution_;
    EdgesOfParts moving_;    ///< for each part: its owned moving edges that other parts contain too
    EdgesOfParts received_;  ///< for each part: edges received from other parts, ascending
};

}  // namespace

template <int S, int D>
Outcome<ExtensionSolve> solve_extension(std::span<ExtensionPart<S, D>> input, PartCommunication<D>& between,
                                        const ExtensionOptions& options, const Execution& execution) {
    return guarded([&]() -> Outcome<ExtensionSolve> {
        ExtensionSolve solved;
        const Execution quiet = without_progress(execution);
        Parts<S, D> parts(input, between, quiet);
        if (auto started = parts.begin(options.stiffening); !started) return fail(started.error());
        auto sums = parts.step(0, options.tolerance);
        if (!sums) return fail(sums.error());
        const double first = sums->by_residual;
        SolveProgress headway(first, options.tolerance, execution);
        double turn = 0;
        for (; solved.iterations < options.max_iterations && sums->largest > options.tolerance &&
               sums->by_residual > rounding * rounding * first;
             ++solved.iterations) {
            if (auto turned = parts.update_direction(turn); !turned) return fail(turned.error());
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

template <int S, int D>
Outcome<Extension<D>> extend_displacement(const ExtensionDomain<S, D>& domain, const Column<EdgeKind>& kinds,
                                          const Column<LagrangeNode<D>>& prescribed_nodes,
                                          const Incidence<ElementId>& shells, const ExtensionOptions& options,
                                          const Execution& execution) {
    // The progress limits 0.12, 0.15 and 0.97 are shares of time, measured on shell-like parts with layers, with 1 and
    // 5 million elements.
    auto part = ExtensionPart<S, D>::make(domain, kinds, prescribed_nodes.view(), shells,
                                          {VertexId(0), VertexId(domain.points.size())}, part_of(execution, 0, 0.12));
    if (!part) return fail(part.error());
    ExtensionSolve solved;
    std::size_t moving = 0;
    if (part->is_displaced()) {
        OnePart<D> alone;
        const auto found = solve_extension(std::span(&*part, 1), alone, options, part_of(execution, 0.15, 0.97));
        if (!found) return fail(found.error());
        solved = *found;
        moving = part->moving();
    }
    auto nodes = std::move(*part).nodes(part_of(execution, 0.97, 1));
    if (!nodes) return fail(nodes.error());
    return Extension<D>{std::move(*nodes), solved.iterations, solved.correction, moving};
}

template <int S, int D>
struct ExtensionPart<S, D>::Impl : ExtensionSystem<S, D> {};

template <int S, int D>
ExtensionPart<S, D>::ExtensionPart(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
template <int S, int D>
ExtensionPart<S, D>::ExtensionPart(ExtensionPart&&) noexcept = default;
template <int S, int D>
ExtensionPart<S, D>& ExtensionPart<S, D>::operator=(ExtensionPart&&) noexcept = default;
template <int S, int D>
ExtensionPart<S, D>::~ExtensionPart() = default;

template <int S, int D>
Outcome<ExtensionPart<S, D>> ExtensionPart<S, D>::make(const ExtensionDomain<S, D>& domain,
                                                       const Column<EdgeKind>& kinds,
                                                       std::span<const LagrangeNode<D>> boundary_nodes,
                                                       const Incidence<ElementId>& shells, const OwnVertices& own,
                                                       const Execution& execution) {
    const std::size_t n = domain.edges.size();
    if (kinds.size() != n || boundary_nodes.size() != n || shells.size() != n)
        return fail(ErrorKind::internal, "an extension needs a kind, a node and a shell for each edge");
    auto input = map_each(execution, n, [&](std::size_t e) {
        return kinds[e] == EdgeKind::volume ? Vec<D>{} : boundary_nodes[e].point - chord_middle(domain, e);
    });
    if (!input) return fail(input.error());
    return guarded([&]() -> Outcome<ExtensionPart<S, D>> {
        return ExtensionPart(std::make_unique<Impl>(Impl{ExtensionSystem<S, D>{
            domain, kinds, shells, own, boundary_nodes, std::move(*input), Weighting{}, Buffer<std::uint32_t>(n, 0U),
            Buffer<ElementEnergy<simplex<S>, 2>>(domain.simplices.size()), Rows<S, D>(n, domain.simplices.size())}}));
    });
}

template <int S, int D>
bool ExtensionPart<S, D>::is_displaced() const {
    return std::ranges::any_of(impl_->direction, [](const Vec<D>& v) { return v != Vec<D>{}; });
}

template <int S, int D>
Outcome<std::vector<double>> ExtensionPart<S, D>::volume_and_count(const Execution& execution) const {
    struct Sum {
        double volume = 0;
        std::size_t count = 0;
    };
    const ExtensionDomain<S, D>& domain = impl_->domain;
    const auto sums = reduce_own(
        execution, OwnSimplices<S + 1>{domain.simplices.view(), domain.points.size(), impl_->owned}, Sum{},
        [&](Sum& total, ElementId e) {
            total.volume += scaled_inverse<S, D>(corner_points(domain, e)).volume;
            ++total.count;
        },
        [](const Sum& a, const Sum& b) { return Sum{a.volume + b.volume, a.count + b.count}; });
    if (!sums) return fail(sums.error());
    std::vector<double> numbers;
    for (const Sum& s : *sums) numbers.insert(numbers.end(), {s.volume, static_cast<double>(s.count)});
    return numbers;
}

template <int S, int D>
Outcome<Done> ExtensionPart<S, D>::begin(double mean, double stiffening, const Execution& execution) {
    ExtensionSystem<S, D>& x = *impl_;
    x.weighting = {mean, stiffening};
    std::vector<EdgeId> moved;
    for (std::size_t e = 0; e < x.direction.size(); ++e)
        if (x.kinds[e] != EdgeKind::volume && x.direction[e] != Vec<D>{}) moved.emplace_back(e);
    if (auto started = x.begin_rows_around(moved, execution); !started) return started;
    auto done = each(
        execution, x.blocks.size(),
        [&](std::size_t b) {
            x.each_product(x.blocks[b], x.direction,
                           [&](std::size_t i, const Vec<D>& sum) { x.rows.residual[i] -= sum; });
        },
        blocks_at_once);
    if (!done) return done;
    for (const EdgeId edge : moved) x.direction[edge.index()] = {};
    return Done{};
}

template <int S, int D>
Outcome<std::vector<ExtensionSums>> ExtensionPart<S, D>::step(double length, double tolerance,
                                                              const Execution& execution) {
    ExtensionSystem<S, D>& x = *impl_;
    return x.template reduce_runs<ExtensionSums>(execution, [&](ExtensionSums& sums, RowBlock& block) {
        Rows<S, D>& rows = x.rows;
        block.joined.clear();
        for (std::size_t i = block.begin; i < block.end; ++i) {
            if (rows.state[i] == Row::moving) rows.u[i] += length * x.direction[rows.edges[i].index()];
            if (length != 0) rows.residual[i] -= length * rows.product[i];
            const double size = rows.size(i);
            sums.largest = std::max(sums.largest, size);
            if (rows.state[i] == Row::beside) {
                if (!(size > joining * tolerance)) continue;
                rows.state[i] = Row::joined;
                block.joined.push_back(rows.edges[i]);
                sums.joined += 1;
            }
            if (length != 0) sums.by_product += dot(rows.correction(i), rows.product[i]);
            sums.by_residual += dot(rows.correction(i), rows.residual[i]);
        }
    });
}

template <int S, int D>
Outcome<Done> ExtensionPart<S, D>::update_direction(double turn, const Execution& execution) {
    ExtensionSystem<S, D>& x = *impl_;
    x.joined.clear();
    for (const RowBlock& block : x.blocks) x.joined.insert(x.joined.end(), block.joined.begin(), block.joined.end());
    return each(
        execution, x.blocks.size(),
        [&](std::size_t b) {
            const RowBlock& block = x.blocks[b];
            Rows<S, D>& rows = x.rows;
            for (std::size_t i = block.begin; i < block.end; ++i) {
                if (rows.state[i] == Row::joined) rows.state[i] = Row::moving;
                if (rows.state[i] != Row::moving) continue;
                Vec<D>& direction = x.direction[rows.edges[i].index()];
                direction = rows.correction(i) + turn * direction;
            }
        },
        blocks_at_once);
}

template <int S, int D>
Outcome<Done> ExtensionPart<S, D>::join(std::span<const EdgeId> of_others, const Execution& execution) {
    std::vector<EdgeId>& joined = impl_->joined;
    joined.insert(joined.end(), of_others.begin(), of_others.end());
    return joined.empty() ? Done{} : impl_->begin_rows_around(joined, execution);
}

template <int S, int D>
Outcome<std::vector<AlongDirection>> ExtensionPart<S, D>::multiply(const Execution& execution) {
    ExtensionSystem<S, D>& x = *impl_;
    return x.template reduce_runs<AlongDirection>(execution, [&](AlongDirection& along, const RowBlock& block) {
        Rows<S, D>& rows = x.rows;
        x.each_product(block, x.direction, [&](std::size_t i, const Vec<D>& sum) {
            const Vec<D>& direction = x.direction[rows.edges[i].index()];
            rows.product[i] = sum;
            along.curvature += dot(direction, sum);
            along.slope += dot(direction, rows.residual[i]);
        });
    });
}

template <int S, int D>
std::span<Vec<D>> ExtensionPart<S, D>::directions() {
    return impl_->direction;
}

template <int S, int D>
const std::vector<EdgeId>& ExtensionPart<S, D>::joined_last() const {
    return impl_->joined;
}

template <int S, int D>
std::size_t ExtensionPart<S, D>::moving() const {
    const Rows<S, D>& rows = impl_->rows;
    return static_cast<std::size_t>(
        std::count(rows.state.begin(), rows.state.begin() + static_cast<std::ptrdiff_t>(rows.count), Row::moving));
}

template <int S, int D>
Outcome<Buffer<LagrangeNode<D>>> ExtensionPart<S, D>::nodes(const Execution& execution) && {
    const ExtensionSystem<S, D>& x = *impl_;
    auto nodes = map_each(execution, x.kinds.size(), [&](std::size_t e) {
        return x.kinds[e] == EdgeKind::volume ? LagrangeNode<D>{chord_middle(x.domain, e)} : x.boundary_nodes[e];
    });
    if (!nodes) return nodes;
    for (std::size_t i = 0; i < x.rows.count; ++i) (*nodes)[x.rows.edges[i].index()].point += x.rows.u[i];
    impl_.reset();
    return nodes;
}

#define CAMBER_INSTANTIATE(S, D)                                                                                  \
    template class ExtensionPart<S, D>;                                                                           \
    template Outcome<ExtensionSolve> solve_extension<S, D>(std::span<ExtensionPart<S, D>>, PartCommunication<D>&, \
                                                           const ExtensionOptions&, const Execution&);            \
    template Outcome<Extension<D>> extend_displacement<S, D>(                                                     \
        const ExtensionDomain<S, D>&, const Column<EdgeKind>&, const Column<LagrangeNode<D>>&,                    \
        const Incidence<ElementId>&, const ExtensionOptions&, const Execution&);

CAMBER_INSTANTIATE(2, 2)
CAMBER_INSTANTIATE(3, 3)
CAMBER_INSTANTIATE(2, 3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
