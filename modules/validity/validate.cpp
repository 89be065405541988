module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>
#include <vector>
module camber.validity;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// The nearest float that is not above x.
float rounded_down(double x) {
    const auto f = static_cast<float>(x);
    return static_cast<double>(f) > x ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}

struct Counts {
    std::size_t invalid = 0, undecided = 0, straight_inverted = 0;

    void add(Verdict verdict) {
        invalid += verdict == Verdict::invalid;
        undecided += verdict == Verdict::undecided;
    }
    friend Counts operator+(const Counts& a, const Counts& b) {
        return {a.invalid + b.invalid, a.undecided + b.undecided, a.straight_inverted + b.straight_inverted};
    }
};

/// Smallest finite value and where; the first of equals.
struct Smallest {
    double value = infinity;
    ElementId element;

    void add(double x, std::size_t e) {
        if (std::isfinite(x) && x < value) *this = {x, ElementId(e)};
    }
    friend Smallest operator+(const Smallest& a, const Smallest& b) { return b.value < a.value ? b : a; }
};

/// What a pass over elements writes.
struct Marks {
    Buffer<Verdict> verdicts;
    Buffer<float> lows;
};

/// The coefficients decide most elements; the others are looked at closely. True if the straight element is flat or
/// inverted.
template <int D>
bool judge(const NodalSimplex<D>& element, double bound, std::size_t e, Marks& marks) {
    const BoundedJacobian<D> jacobian = bounded_jacobian(element);
    if (decide_by_coefficients(jacobian, bound) == Verdict::valid && !blurred(jacobian)) {
        marks.verdicts[e] = Verdict::valid;
        marks.lows[e] = rounded_down(smallest_scaled_coefficient(jacobian));
        return jacobian.straight < 0;
    }
    const ElementValidity validity = check_element(element, bound);
    marks.verdicts[e] = validity.verdict;
    marks.lows[e] = rounded_down(validity.min_scaled_jacobian);
    return validity.straight_inverted;
}

/// Makes the smallest value of the mesh a close one: once the element with the lowest bound is refined, only elements
/// whose bound is below its value can be lower still.
template <int D>
Outcome<Validation<D>> finished(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> mid_nodes, double bound,
                                Marks marks, Counts counts, const Execution& execution) {
    const auto scan = [&] {
        return reduce_each(
            execution, marks.lows.size(), Smallest{},
            [&](Smallest& smallest, std::size_t e) { smallest.add(marks.lows[e], e); },
            [](const Smallest& a, const Smallest& b) { return a + b; });
    };
    const auto refined = [&](std::size_t e) {
        return check_element(nodal_element(mesh, mid_nodes, ElementId(e)), bound).min_scaled_jacobian;
    };
    auto lowest = scan();
    if (!lowest) return fail(lowest.error());
    if (lowest->element.valid()) {
        const double first = refined(lowest->element.index());
        marks.lows[lowest->element.index()] = rounded_down(first);
        const double ceiling = first - 0.1 * scaled_jacobian_tolerance * std::max(1.0, std::abs(first));
        auto closed = each(execution, marks.lows.size(), [&](std::size_t e) {
            if (std::isfinite(marks.lows[e]) && marks.lows[e] < ceiling) marks.lows[e] = rounded_down(refined(e));
        });
        if (!closed) return fail(closed.error());
        lowest = scan();
        if (!lowest) return fail(lowest.error());
    }
    Validation<D> validation;
    validation.bound = bound;
    validation.verdicts = std::move(marks.verdicts);
    validation.min_scaled_jacobian = std::move(marks.lows);
    validation.invalid = counts.invalid;
    validation.undecided = counts.undecided;
    validation.straight_inverted = counts.straight_inverted;
    if (lowest->element.valid()) validation.smallest = lowest->value;
    validation.worst = lowest->element;
    return validation;
}

template <int D>
Outcome<Validation<D>> validate_nodes(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> mid_nodes,
                                      double bound, const Execution& execution) {
    if (mid_nodes.size() != mesh.edges.size())
        return fail(ErrorKind::internal, "the proposal has another number of edges than the mesh");
    const std::size_t n = mesh.linear.elements.size();
    Marks marks{Buffer<Verdict>(n), Buffer<float>(n)};
    auto counts = reduce_each(
        execution, n, Counts{},
        [&](Counts& sum, std::size_t e) {
            sum.straight_inverted += judge(nodal_element(mesh, mid_nodes, ElementId(e)), bound, e, marks);
            sum.add(marks.verdicts[e]);
        },
        [](const Counts& a, const Counts& b) { return a + b; });
    if (!counts) return fail(counts.error());
    return finished(mesh, mid_nodes, bound, std::move(marks), *counts, execution);
}

}  // namespace

template <int D>
Outcome<Validation<D>> validate(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal, double bound,
                                const Execution& execution) {
    return guarded([&] { return validate_nodes<D>(mesh, proposal.mid_nodes.view(), bound, execution); });
}

template <int D>
Outcome<Validation<D>> validate(const QuadraticMesh<D>& mesh, double bound, const Execution& execution) {
    return guarded([&] { return validate_nodes<D>(mesh, mesh.mid_nodes.view(), bound, execution); });
}

template <int D>
Outcome<Validation<D>> revalidate(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> mid_nodes,
                                  Validation<D> before, std::span<const ElementId> touched,
                                  const Execution& execution) {
    const double bound = before.bound;
    const std::size_t straight_inverted = before.straight_inverted;  // nodes do not change it
    Marks marks{take(std::move(before.verdicts)), take(std::move(before.min_scaled_jacobian))};
    auto judged = each(execution, touched.size(), [&](std::size_t i) {
        judge(nodal_element(mesh, mid_nodes, touched[i]), bound, touched[i].index(), marks);
    });
    if (!judged) return fail(judged.error());
    auto counts = reduce_each(
        execution, marks.verdicts.size(), Counts{}, [&](Counts& sum, std::size_t e) { sum.add(marks.verdicts[e]); },
        [](const Counts& a, const Counts& b) { return a + b; });
    if (!counts) return fail(counts.error());
    counts->straight_inverted = straight_inverted;
    return finished(mesh, mid_nodes, bound, std::move(marks), *counts, execution);
}

#define CAMBER_INSTANTIATE(D)                                                                                \
    template Outcome<Validation<D>> validate<D>(const QuadraticMesh<D>&, const Proposal<D>&, double,         \
                                                const Execution&);                                           \
    template Outcome<Validation<D>> validate<D>(const QuadraticMesh<D>&, double, const Execution&);          \
    template Outcome<Validation<D>> revalidate<D>(const QuadraticMesh<D>&, std::span<const LagrangeNode<D>>, \
                                                  Validation<D>, std::span<const ElementId>, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
