// Judges all elements of a mesh, and commits judged meshes.
module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.validity;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

float rounded_down(double x) {
    const auto f = static_cast<float>(x);
    return static_cast<double>(f) > x ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}

struct Counts {
    std::size_t invalid = 0, undecided = 0;
    std::vector<std::pair<ElementId, Verdict>> not_positive = {};

    friend Counts operator+(Counts a, const Counts& b) {
        a.invalid += b.invalid;
        a.undecided += b.undecided;
        a.not_positive.insert(a.not_positive.end(), b.not_positive.begin(), b.not_positive.end());
        return a;
    }
};

struct Smallest {
    double value = infinity;
    ElementId element;

    void add(double x, std::size_t e) {
        if (std::isfinite(x) && x < value) *this = {x, ElementId(e)};
    }
    friend Smallest operator+(const Smallest& a, const Smallest& b) { return b.value < a.value ? b : a; }
};

template <int D>
struct Elements {
    static constexpr int dimension = D;
    const QuadraticMesh<D>& mesh;

    [[nodiscard]] auto operator()(ElementId e) const { return nodal_element(mesh, mesh.mid_nodes.view(), e); }
};
template <int D>
void each_low(const Elements<D>& elements, std::size_t begin, std::size_t end, const auto& id, const auto& visit) {
    each_jacobian_summary<D>(begin, end, [&](std::size_t i) { return elements(id(i)); }, visit);
}

struct Triangles {
    static constexpr int dimension = 3;
    const QuadraticMesh<3>& mesh;

    [[nodiscard]] SurfaceTriangle operator()(ElementId e) const {
        return surface_triangle(mesh, mesh.mid_nodes.view(), e.index());
    }
};
void each_low(const Triangles& triangles, std::size_t begin, std::size_t end, const auto& id, const auto& visit) {
    for (std::size_t i = begin; i < end; ++i) visit(i, jacobian_summary(bounded_jacobian(triangles(id(i)))));
}

template <int D>
auto visit_judged(const QuadraticMesh<D>& mesh, const auto& visit) {
    if constexpr (D == 3)
        if (is_standalone_surface(mesh.linear)) return visit(Triangles{mesh});
    return visit(Elements<D>{mesh});
}

struct Marks {
    Buffer<Verdict> verdicts;
    Buffer<float> lower_bounds;
};

/// Returns true if the straight element is flat or inverted.
template <class Items>
bool mark(const Items& items, const JacobianSummary& jacobian, double bound, ElementId e, Marks& marks) {
    if (is_clear(jacobian, bound)) {
        marks.verdicts[e.index()] = Verdict::valid;
        marks.lower_bounds[e.index()] = rounded_down(smallest_scaled_coefficient(jacobian));
        return jacobian.straight < 0;
    }
    const ElementValidity validity = check_element(items(e), bound);
    marks.verdicts[e.index()] = validity.verdict;
    marks.lower_bounds[e.index()] = rounded_down(validity.min_scaled_jacobian);
    return validity.straight_inverted;
}

template <class Items, class Ids>
Outcome<std::size_t> mark_all(const Items& items, std::size_t n, const Ids& id, double bound, Marks& marks,
                              const Execution& execution) {
    constexpr std::size_t grain = 4096;
    return guarded([&]() -> Outcome<std::size_t> {
        std::vector<std::size_t> inverted((n + grain - 1) / grain, 0);
        auto done = each_chunk(
            execution, n,
            [&](std::size_t begin, std::size_t end) {
                each_low(items, begin, end, id, [&](std::size_t i, const JacobianSummary& jacobian) {
                    inverted[begin / grain] += mark(items, jacobian, bound, id(i), marks) ? 1 : 0;
                });
            },
            grain);
        if (!done) return fail(std::move(done.error()));
        return std::accumulate(inverted.begin(), inverted.end(), std::size_t{0});
    });
}

template <class Items>
Verdict positivity(const Items& items, double bound, const Marks& marks, std::size_t e) {
    if (bound == 0 || (marks.verdicts[e] == Verdict::valid && bound > 0)) return marks.verdicts[e];
    if (std::isfinite(marks.lower_bounds[e]) && marks.lower_bounds[e] > 0) return Verdict::valid;
    return decide(items(ElementId(e)), 0);
}

template <class Items>
Outcome<Counts> count_verdicts(const Items& items, double bound, const Marks& marks, const Execution& execution) {
    return reduce_each(
        execution, marks.verdicts.size(), Counts{},
        [&](Counts& sum, std::size_t e) {
            sum.invalid += marks.verdicts[e] == Verdict::invalid;
            sum.undecided += marks.verdicts[e] == Verdict::undecided;
            if (const Verdict v = positivity(items, bound, marks, e); v != Verdict::valid)
                sum.not_positive.emplace_back(ElementId(e), v);
        },
        [](const Counts& a, const Counts& b) { return a + b; });
}

/// Refines the smallest value. Once the lowest element is refined, only elements with a lower bound below its value
/// remain to be refined.
template <class Items>
Outcome<Validation<Items::dimension>> finish_validation(const Items& items, double bound, Marks marks,
                                                        std::size_t straight_inverted, const Execution& execution) {
    constexpr int D = Items::dimension;
    const Execution quiet = without_progress(execution);
    const auto counts = count_verdicts(items, bound, marks, quiet);
    if (!counts) return fail(counts.error());
    const auto scan = [&] {
        return reduce_each(
            quiet, marks.lower_bounds.size(), Smallest{},
            [&](Smallest& smallest, std::size_t e) { smallest.add(marks.lower_bounds[e], e); },
            [](const Smallest& a, const Smallest& b) { return a + b; });
    };
    const auto refined = [&](std::size_t e) { return check_element(items(ElementId(e)), bound).min_scaled_jacobian; };
    auto lowest = scan();
    if (!lowest) return fail(lowest.error());
    if (lowest->element.valid()) {
        const double first = refined(lowest->element.index());
        marks.lower_bounds[lowest->element.index()] = rounded_down(first);
        const double ceiling = first - 0.1 * scaled_jacobian_tolerance * std::max(1.0, std::abs(first));
        auto closed = each(quiet, marks.lower_bounds.size(), [&](std::size_t e) {
            if (std::isfinite(marks.lower_bounds[e]) && marks.lower_bounds[e] < ceiling)
                marks.lower_bounds[e] = rounded_down(refined(e));
        });
        if (!closed) return fail(closed.error());
        lowest = scan();
        if (!lowest) return fail(lowest.error());
    }
    Validation<D> validation;
    validation.bound = bound;
    validation.verdicts = std::move(marks.verdicts);
    validation.min_scaled_jacobian = std::move(marks.lower_bounds);
    validation.invalid = counts->invalid;
    validation.undecided = counts->undecided;
    validation.not_positive = counts->not_positive;
    validation.straight_inverted = straight_inverted;
    if (lowest->element.valid()) validation.smallest = lowest->value;
    validation.worst = lowest->element;
    return validation;
}

}  // namespace

template <int D>
Outcome<Validation<D>> validate(const QuadraticMesh<D>& mesh, double bound, const Execution& execution) {
    return guarded([&]() -> Outcome<Validation<D>> {
        return visit_judged(mesh, [&](const auto& items) -> Outcome<Validation<D>> {
            const std::size_t n = judged_count(mesh.linear);
            Marks marks{Buffer<Verdict>(n), Buffer<float>(n)};
            const auto straight_inverted = mark_all(
                items, n, [](std::size_t e) { return ElementId(e); }, bound, marks, part_of(execution, 0, 0.88));
            if (!straight_inverted) return fail(straight_inverted.error());
            return finish_validation(items, bound, std::move(marks), *straight_inverted, execution);
        });
    });
}

template <int D>
Outcome<JudgedProposal<D>> JudgedProposal<D>::judge(QuadraticMesh<D> mesh, Proposal<D> proposal, double bound,
                                                    const Execution& execution) {
    if (proposal.mid_nodes.size() != mesh.edges.size() || proposal.points.size() != mesh.linear.points.size())
        return fail(ErrorKind::internal,
                    "the number of vertices or edges of the proposal differs from that of the "
                    "mesh");
    auto validation = validate(apply_proposal(mesh, proposal), bound, execution);
    if (!validation) return fail(validation.error());
    return JudgedProposal(std::move(mesh), std::move(proposal), std::move(*validation));
}

template <int D>
Outcome<JudgedProposal<D>> JudgedProposal<D>::judge_again(Proposal<D> proposal, std::span<const ElementId> touched,
                                                          const Execution& execution) const {
    if (proposal.mid_nodes.size() != mesh_.edges.size() || proposal.points != proposal_.points)
        return fail(ErrorKind::internal,
                    "the proposal moves vertices, or its number of edges differs from that of "
                    "the mesh");
    return guarded([&]() -> Outcome<JudgedProposal<D>> {
        const QuadraticMesh<D> mesh = apply_proposal(mesh_, proposal);
        const double bound = validation_.bound;
        Marks marks{take(validation_.verdicts), take(validation_.min_scaled_jacobian)};
        auto validation = visit_judged(mesh, [&](const auto& items) -> Outcome<Validation<D>> {
            auto judged =
                mark_all(items, touched.size(), [&](std::size_t i) { return touched[i]; }, bound, marks, execution);
            if (!judged) return fail(judged.error());
            return finish_validation(items, bound, std::move(marks), validation_.straight_inverted, execution);
        });
        if (!validation) return fail(validation.error());
        return JudgedProposal(mesh_, std::move(proposal), std::move(*validation));
    });
}

namespace {

template <int D>
MeshMaps identities(const QuadraticMesh<D>& mesh) {
    return {IdMap<VertexId>::identity(mesh.linear.points.size()), IdMap<EdgeId>::identity(mesh.edges.size()),
            IdMap<ElementId>::identity(mesh.linear.elements.size()),
            IdMap<FacetId>::identity(mesh.linear.facets.size())};
}

}  // namespace

template <int D>
Outcome<Committed<D>> commit(const JudgedProposal<D>& judged) {
    const Validation<D>& validation = judged.validation();
    if (!validation.certified())
        return fail(ErrorKind::input,
                    "is not certified valid, one of " + std::to_string(validation.not_positive.size()) +
                        " of which det J > 0 is not certain",
                    {},
                    Entity{is_standalone_surface(judged.mesh().linear) ? simplex_name<2> : simplex_name<D>,
                           validation.not_positive.front().first.index() + 1},
                    "add a relax stage before commit");
    return commit_uncertified(judged);
}

template <int D>
Committed<D> commit_uncertified(const JudgedProposal<D>& judged) {
    return {apply_proposal(judged.mesh(), judged.proposal()), identities(judged.mesh())};
}

#define CAMBER_INSTANTIATE(D)                                                                       \
    template class JudgedProposal<D>;                                                               \
    template Outcome<Validation<D>> validate<D>(const QuadraticMesh<D>&, double, const Execution&); \
    template Outcome<Committed<D>> commit<D>(const JudgedProposal<D>&);                             \
    template Committed<D> commit_uncertified<D>(const JudgedProposal<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
