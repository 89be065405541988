module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <utility>
module camber.curving;
import camber.core;
import camber.bezier;
import camber.validity;
import :by_element;
import :error_system;
import :solution_nodes;

namespace camber {

namespace {

/// Steps of a solve: nodes are near enough, as the next round's matrix is another.
constexpr int solve_steps = 12;
/// How often a step that does not pay is halved.
constexpr int halvings = 3;
/// A round that gains less of the squared error is the last.
constexpr double least_gain = 0.01;

template <int D>
Vec<D> middle_of(const QuadraticMesh<D>& mesh, std::size_t e) {
    const auto& [a, b] = mesh.edges.vertices[e];
    return midpoint(mesh.linear.points[a], mesh.linear.points[b]);
}

/// An offset from the middle of the chord, its part along that shortened.
template <int D>
Vec<D> with_bounded_slide(const Vec<D>& offset, const Vec<D>& chord, double most) {
    const double square = norm_squared(chord);
    if (!(square > 0)) return offset;
    const double slide = dot(offset, chord) / square;
    return offset + (std::clamp(slide, -most, most) - slide) * chord;
}

template <int D>
class Search {
  public:
    Search(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> base, const Incidence<ElementId>& shells,
           const SolutionNodesOptions& options, ErrorSystem<D> system)
        : mesh_(mesh),
          base_(base),
          shells_(shells),
          options_(options),
          system_(std::move(system)),
          home_(mesh.edges.size()) {
        for (std::size_t e = 0; e < home_.size(); ++e) home_[e] = base[e].point - middle_of(mesh, e);
        made_.moves = Buffer<Vec<D>>(mesh.edges.size(), Vec<D>{});
    }

    Outcome<SolutionNodes<D>> run(const Execution& execution) {
        auto error = error_of(made_.moves, part_of(execution, 0, share(0)));
        if (!error) return fail(error.error());
        made_.before = made_.after = std::sqrt(*error);
        if (!(*error > 0) || !std::isfinite(*error)) return std::move(made_);
        while (made_.rounds < options_.rounds) {
            const auto next = round(*error, part_of(execution, share(made_.rounds), share(made_.rounds + 1)));
            if (!next) return fail(next.error());
            const bool is_last = !(*next < (1 - least_gain) * *error);
            error = next;
            if (is_last) break;
        }
        made_.after = std::sqrt(*error);
        return std::move(made_);
    }

  private:
    [[nodiscard]] double share(int rounds) const { return (0.5 + rounds) / (0.5 + options_.rounds); }

    Outcome<double> error_of(const Buffer<Vec<D>>& moves, const Execution& execution) {
        auto offsets =
            map_each(without_progress(execution), moves.size(), [&](std::size_t e) { return home_[e] + moves[e]; });
        if (!offsets) return fail(offsets.error());
        return system_.begin(*offsets, home_, execution);
    }

    /// The step, as chords and elements bear it.
    Outcome<Buffer<Vec<D>>> moved(const Buffer<Vec<D>>& step, double length, const Execution& execution) {
        auto moves = map_each(execution, step.size(), [&](std::size_t e) {
            if (step[e] == Vec<D>{}) return made_.moves[e];
            const auto& [a, b] = mesh_.edges.vertices[e];
            const Vec<D> offset = home_[e] + made_.moves[e] + length * step[e];
            return with_bounded_slide(offset, mesh_.linear.points[b] - mesh_.linear.points[a], options_.max_slide) -
                   home_[e];
        });
        if (!moves) return moves;
        const auto limited = limit_by_jacobian<D>(mesh_, base_, shells_, options_.min_jacobian, *moves, execution);
        if (!limited) return fail(limited.error());
        limited_ = *limited;
        return moves;
    }

    /// Takes a step if it pays: the error after it.
    Outcome<double> round(double before, const Execution& execution) {
        const auto step = system_.solved(solve_steps, part_of(execution, 0, 0.5));
        if (!step) return fail(step.error());
        double length = 1;
        for (int i = 0; i <= halvings; ++i, length /= 2) {
            auto moves = moved(*step, length, without_progress(execution));
            if (!moves) return fail(moves.error());
            const auto after = error_of(*moves, i == 0 ? part_of(execution, 0.5, 1) : without_progress(execution));
            if (!after) return after;
            if (!(*after < before)) continue;
            made_.moves = std::move(*moves);
            made_.drawn_back = limited_;
            ++made_.rounds;
            return after;
        }
        return before;
    }

    const QuadraticMesh<D>& mesh_;
    std::span<const LagrangeNode<D>> base_;
    const Incidence<ElementId>& shells_;
    const SolutionNodesOptions& options_;
    ErrorSystem<D> system_;
    Buffer<Vec<D>> home_;
    std::size_t limited_ = 0;
    SolutionNodes<D> made_;
};

template <int D>
Outcome<Done> check_sizes(const QuadraticMesh<D>& mesh, std::size_t kinds, std::size_t nodes, std::size_t shells,
                          const KnownSolution<D>& solution) {
    const std::size_t n = mesh.edges.size();
    const bool has_values = std::ranges::all_of(
        solution, [&](const KnownField<D>& f) { return f.values.size() == mesh.linear.elements.size(); });
    if (kinds != n || nodes != n || shells != n || !has_values)
        return fail(ErrorKind::internal,
                    "nodes for a solution need a kind, a node and a shell for each edge, and values for each element");
    return Done{};
}

}  // namespace

template <int D>
Outcome<SolutionNodes<D>> solution_nodes(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                         std::span<const LagrangeNode<D>> base, const Incidence<ElementId>& shells,
                                         const KnownSolution<D>& solution, const SolutionNodesOptions& options,
                                         const Execution& execution) {
    if (auto fits = check_sizes(mesh, kinds.size(), base.size(), shells.size(), solution); !fits)
        return fail(fits.error());
    return guarded([&]() -> Outcome<SolutionNodes<D>> {
        if (solution.empty() || mesh.linear.elements.size() == 0)
            return SolutionNodes<D>{.moves = Buffer<Vec<D>>(mesh.edges.size(), Vec<D>{})};
        Search<D> search(mesh, base, shells, options, ErrorSystem<D>(mesh, kinds, shells, solution, options.stiffness));
        return search.run(execution);
    });
}

#define CAMBER_INSTANTIATE(D)                                                               \
    template Outcome<SolutionNodes<D>> solution_nodes<D>(                                   \
        const QuadraticMesh<D>&, const Column<EdgeKind>&, std::span<const LagrangeNode<D>>, \
        const Incidence<ElementId>&, const KnownSolution<D>&, const SolutionNodesOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
