module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <utility>
module camber.curving;
import camber.core;
import camber.bezier;
import camber.validity;

namespace camber {

namespace {

constexpr int solve_steps = 12;
constexpr int halvings = 3;
/// A frame is the solution in the elements of one mesh. Steps in a frame end below the first relative decrease of the
/// squared error, frames below the second one.
constexpr double least_gain = 0.01, least_gain_of_frame = 0.04;
constexpr int shortenings = 3;

template <int D>
Vec<D> middle_of(const QuadraticMesh<D>& mesh, std::size_t e) {
    const auto& [a, b] = mesh.edges.vertices[e];
    return midpoint(mesh.linear.points[a], mesh.linear.points[b]);
}

/// Returns the fraction of `step` to be taken. The component of the offset along the chord then stays within `most`
/// chord lengths, or does not grow. Shortening only this component would move nodes off an oblique front.
template <int D>
double share_within_slide(const Vec<D>& offset, const Vec<D>& step, const Vec<D>& chord, double most) {
    const double square = norm_squared(chord);
    if (!(square > 0)) return 1;
    const double slide = dot(offset, chord) / square, change = dot(step, chord) / square;
    const double room = std::max(most - std::copysign(1.0, change) * slide, 0.0);
    return std::abs(change) <= room ? 1 : room / std::abs(change);
}

template <int D>
struct Frame {
    QuadraticMesh<D> mesh;
    KnownSolution<D> known;
    Buffer<Vec<D>> reference_offsets;
    ErrorSystem<D> system;
    double error = 0;

    Frame(QuadraticMesh<D> curved, KnownSolution<D> solution, const Column<EdgeKind>& kinds,
          const Incidence<ElementId>& shells, double stiffness)
        : mesh(std::move(curved)),
          known(std::move(solution)),
          reference_offsets(mesh.edges.size()),
          system(mesh, kinds, shells, known, stiffness) {
        for (std::size_t e = 0; e < reference_offsets.size(); ++e)
            reference_offsets[e] = mesh.mid_nodes[e].point - middle_of(mesh, e);
    }
    Frame(const Frame&) = delete;
    Frame(Frame&&) = delete;
    Frame& operator=(const Frame&) = delete;
    Frame& operator=(Frame&&) = delete;
    ~Frame() = default;

    [[nodiscard]] Outcome<double> expected(const Execution& execution) const {
        const auto squared = squared_error(mesh, known, without_progress(execution));
        if (!squared) return squared;
        return (known.size() == 1 ? std::ldexp(1.0, known.front().exponent) : 1) * std::sqrt(*squared);
    }
};

/// Moves nodes to the minimum of the error in one frame. In each step scaled Jacobians stay above `least`; if it is −∞,
/// elements may become invalid.
template <int D>
class Search {
  public:
    Search(Frame<D>& frame, const Incidence<ElementId>& shells, const SolutionNodesOptions& options, double least)
        : frame_(frame),
          shells_(shells),
          options_(options),
          least_(least),
          moves_(frame.reference_offsets.size(), Vec<D>{}) {}

    Outcome<Buffer<Vec<D>>> run(const Execution& execution) {
        double error = frame_.error;
        for (int i = 0; i < options_.rounds; ++i) {
            const auto next = round(error, part_of(execution, share(i), share(i + 1)));
            if (!next) return fail(next.error());
            const bool is_last = !(*next < (1 - least_gain) * error);
            error = *next;
            if (is_last) break;
        }
        return std::move(moves_);
    }

  private:
    [[nodiscard]] double share(int rounds) const { return static_cast<double>(rounds) / options_.rounds; }

    Outcome<double> error_of(const Buffer<Vec<D>>& moves, const Execution& execution) {
        auto offsets = map_each(without_progress(execution), moves.size(),
                                [&](std::size_t e) { return frame_.reference_offsets[e] + moves[e]; });
        if (!offsets) return fail(offsets.error());
        return frame_.system.begin(*offsets, frame_.reference_offsets, execution);
    }

    Outcome<Buffer<Vec<D>>> moved(const Buffer<Vec<D>>& step, double length, const Execution& execution) {
        const LinearMesh<D>& linear = frame_.mesh.linear;
        auto moves = map_each(execution, step.size(), [&](std::size_t e) {
            if (step[e] == Vec<D>{}) return moves_[e];
            const auto& [a, b] = frame_.mesh.edges.vertices[e];
            const Vec<D> whole = length * step[e], chord = linear.points[b] - linear.points[a];
            return moves_[e] +
                   share_within_slide(frame_.reference_offsets[e] + moves_[e], whole, chord, options_.max_slide) *
                       whole;
        });
        if (!moves || std::isinf(least_)) return moves;
        const auto limited =
            limit_by_jacobian<D>(frame_.mesh, frame_.mesh.mid_nodes.view(), shells_, least_, *moves, execution);
        if (!limited) return fail(limited.error());
        return moves;
    }

    /// Computes a step and takes it if it reduces the error; returns the squared error.
    Outcome<double> round(double before, const Execution& execution) {
        const auto step = frame_.system.solved(solve_steps, part_of(execution, 0, 0.5));
        if (!step) return fail(step.error());
        double length = 1;
        for (int i = 0; i <= halvings; ++i, length /= 2) {
            auto moves = moved(*step, length, without_progress(execution));
            if (!moves) return fail(moves.error());
            const auto after = error_of(*moves, i == 0 ? part_of(execution, 0.5, 1) : without_progress(execution));
            if (!after) return after;
            if (!(*after < before)) continue;
            moves_ = std::move(*moves);
            return after;
        }
        return before;
    }

    Frame<D>& frame_;
    const Incidence<ElementId>& shells_;
    const SolutionNodesOptions& options_;
    double least_;
    Buffer<Vec<D>> moves_;
};

template <int D>
class Frames {
  public:
    Frames(const MeshEdges<D>& edges, const SolutionInElements<D>& solution, const SolutionNodesOptions& options)
        : mesh_(edges.mesh), kinds_(edges.kinds), shells_(edges.shells), solution_(solution), options_(options) {}

    Outcome<SolutionNodes<D>> run(std::span<const Column<LagrangeNode<D>>> starts, const Execution& execution) {
        constexpr double of_starts = 0.2;
        auto frame = best_of(starts, part_of(execution, 0, of_starts));
        if (!frame) return fail(frame.error());
        for (int i = 0; i < options_.frames; ++i) {
            const double error = (*frame)->error;
            if (!(error > 0) || !std::isfinite(error)) break;
            const auto share = [&](int frames) {
                return of_starts + (1 - of_starts) * frames / static_cast<double>(options_.frames);
            };
            frame = next(std::move(*frame), bound_of_search(i), part_of(execution, share(i), share(i + 1)));
            if (!frame) return fail(frame.error());
            if ((*frame)->error < error) ++result_.frames;
            if (!((*frame)->error < (1 - least_gain_of_frame) * error)) break;
        }
        result_.nodes = (*frame)->mesh.mid_nodes;
        const auto after = (*frame)->expected(execution);
        if (!after) return fail(after.error());
        result_.after = *after;
        return std::move(result_);
    }

  private:
    using OwnFrame = std::unique_ptr<Frame<D>>;

    /// Returns the minimum scaled Jacobian of a search. Thin stacked elements block each other, although all are valid
    /// at the minimum. So every second search is unbounded, and its moves are limited afterwards.
    [[nodiscard]] double bound_of_search(int frame) const {
        return frame % 2 == 1 ? -std::numeric_limits<double>::infinity() : options_.min_jacobian;
    }

    Outcome<OwnFrame> frame_of(Column<LagrangeNode<D>> nodes, const Execution& execution) {
        QuadraticMesh<D> curved = mesh_;
        curved.mid_nodes = std::move(nodes);
        auto known = solution_(curved, without_progress(execution));
        if (!known) return fail(known.error());
        const bool fits = std::ranges::all_of(
            *known, [&](const KnownField<D>& f) { return f.values.size() == mesh_.linear.elements.size(); });
        if (!fits) return fail(ErrorKind::internal, "a known solution needs values for each element");
        auto frame =
            std::make_unique<Frame<D>>(std::move(curved), std::move(*known), kinds_, shells_, options_.stiffness);
        const auto error = frame->system.begin(frame->reference_offsets, frame->reference_offsets, execution);
        if (!error) return fail(error.error());
        frame->error = *error;
        return frame;
    }

    Outcome<OwnFrame> best_of(std::span<const Column<LagrangeNode<D>>> starts, const Execution& execution) {
        const Column<LagrangeNode<D>>* best = nullptr;
        double least = 0;
        OwnFrame frame;
        for (const Column<LagrangeNode<D>>& start : starts) {
            frame.reset();  // frames are large: only one at a time
            auto at = frame_of(start, execution);
            if (!at) return at;
            frame = std::move(*at);
            if (best == nullptr) {
                const auto before = frame->expected(execution);
                if (!before) return fail(before.error());
                result_.before = *before;
            }
            if (best == nullptr || frame->error < least) best = &start, least = frame->error;
        }
        if (best == &starts.back()) return frame;
        frame.reset();
        return frame_of(*best, execution);
    }

    Outcome<OwnFrame> next(OwnFrame frame, double least_jacobian, const Execution& execution) {
        const QuadraticMesh<D> from = frame->mesh;
        const double before = frame->error;
        const Buffer<double> errors(frame->system.errors().begin(), frame->system.errors().end());
        auto moves = Search<D>(*frame, shells_, options_, least_jacobian).run(part_of(execution, 0, 0.8));
        if (!moves) return fail(moves.error());
        frame.reset();
        Column<LagrangeNode<D>> best = from.mid_nodes;
        double least = before;
        std::size_t relaxed = 0;
        for (int i = 0; i <= shortenings; ++i) {
            const auto limited = limit_by_jacobian<D>(from, from.mid_nodes.view(), shells_, options_.min_jacobian,
                                                      *moves, without_progress(execution));
            if (!limited) return fail(limited.error());
            relaxed += *limited;
            auto to = frame_of(moved(from, *moves), part_of(execution, 0.8 + 0.2 * i / (shortenings + 1), 1));
            if (!to) return to;
            const bool is_better = (*to)->error < least;
            if (!is_better && least < before) break;  // moves were shortened too much
            if (is_better) {
                best = (*to)->mesh.mid_nodes;
                least = (*to)->error;
                result_.relaxed = relaxed;
            }
            const double part = i + 1 < shortenings ? 0.25 : 0;
            const std::size_t shortened = shorten_worse(errors, (*to)->system.errors(), before, part, *moves);
            if (shortened == 0 && is_better) return to;
            to->reset();
            if (shortened == 0)
                for (Vec<D>& move : *moves) move *= 0.5;
            relaxed += shortened;
        }
        return frame_of(std::move(best), without_progress(execution));
    }

    static Column<LagrangeNode<D>> moved(const QuadraticMesh<D>& mesh, const Buffer<Vec<D>>& moves) {
        Buffer<LagrangeNode<D>> nodes(mesh.mid_nodes.begin(), mesh.mid_nodes.end());
        for (std::size_t e = 0; e < nodes.size(); ++e) nodes[e].point += moves[e];
        return Column<LagrangeNode<D>>(std::move(nodes));
    }

    /// Multiplies the moves of nodes near which the error increased noticeably by the factor `part`. Returns their
    /// number.
    std::size_t shorten_worse(std::span<const double> before, std::span<const double> after, double all, double part,
                              Buffer<Vec<D>>& moves) const {
        constexpr double of_all = 1e-3, of_own = 0.2;
        std::size_t shortened = 0;
        for (std::size_t e = 0; e < moves.size(); ++e) {
            if (moves[e] == Vec<D>{}) continue;
            double was = 0, is = 0;
            for (const ElementId element : shells_[e]) {
                was += before[element.index()];
                is += after[element.index()];
            }
            if (is - was < std::max(of_all * all, of_own * was)) continue;
            moves[e] *= part;
            ++shortened;
        }
        return shortened;
    }

    const QuadraticMesh<D>& mesh_;
    const Column<EdgeKind>& kinds_;
    const Incidence<ElementId>& shells_;
    const SolutionInElements<D>& solution_;
    const SolutionNodesOptions& options_;
    SolutionNodes<D> result_;
};

template <int D>
Outcome<Done> check_sizes(const MeshEdges<D>& edges, std::span<const Column<LagrangeNode<D>>> starts) {
    const std::size_t n = edges.mesh.edges.size();
    const bool are_rows =
        std::ranges::all_of(starts, [&](const Column<LagrangeNode<D>>& nodes) { return nodes.size() == n; });
    if (edges.kinds.size() == n && edges.shells.size() == n && !starts.empty() && are_rows) return Done{};
    return fail(ErrorKind::internal, "nodes for a solution need a kind, a node and a shell for each edge");
}

}  // namespace

template <int D>
Outcome<SolutionNodes<D>> solution_nodes(const MeshEdges<D>& edges, std::span<const Column<LagrangeNode<D>>> starts,
                                         const SolutionInElements<D>& solution, const SolutionNodesOptions& options,
                                         const Execution& execution) {
    if (auto fits = check_sizes(edges, starts); !fits) return fail(fits.error());
    if (edges.mesh.linear.elements.size() == 0) return SolutionNodes<D>{.nodes = starts.front()};
    return guarded([&] { return Frames<D>(edges, solution, options).run(starts, execution); });
}

#define CAMBER_INSTANTIATE(D)                                                                        \
    template Outcome<SolutionNodes<D>> solution_nodes<D>(                                            \
        const MeshEdges<D>&, std::span<const Column<LagrangeNode<D>>>, const SolutionInElements<D>&, \
        const SolutionNodesOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
