module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>
#include <fmt/format.h>
module camber.recipes;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;
import camber.soundness;

namespace camber::run {

namespace {

std::vector<std::uint32_t> find_lowest(const Column<Verdict>& verdicts, const Buffer<double>& scores, std::size_t n) {
    std::vector<std::uint32_t> order(scores.size());
    std::iota(order.begin(), order.end(), 0U);
    const auto worse = [&](std::uint32_t a, std::uint32_t b) {
        const auto rank = [&](std::uint32_t e) { return std::tuple(verdicts[e] == Verdict::valid, scores[e], e); };
        return rank(a) < rank(b);
    };
    n = std::min(n, order.size());
    std::ranges::partial_sort(order, order.begin() + static_cast<std::ptrdiff_t>(n), worse);
    order.resize(n);
    return order;
}

template <int D>
auto with_element(const Judged<D>& judged, std::size_t e, const auto& visit) {
    if constexpr (D == 3)
        if (is_standalone_surface(judged.mesh.linear))
            return visit(surface_triangle(judged.mesh, judged.mesh.mid_nodes.view(), e),
                         facet_of(judged.mesh, FacetId(e)));
    return visit(nodal_element<D>(judged.mesh, judged.mesh.mid_nodes.view(), ElementId(e)),
                 element_of(judged.mesh, ElementId(e)));
}

template <int D>
std::span<const VertexId> vertices_of(const LinearMesh<D>& mesh, std::size_t e) {
    if (is_standalone_surface(mesh)) return mesh.facets.vertices[e];
    return mesh.elements.vertices[e];
}

template <int D>
ElementValidity check_closely(const Judged<D>& judged, std::size_t e) {
    return with_element(
        judged, e, [&](const auto& element, const auto&) { return check_element(element, judged.validation.bound); });
}

/// Stored bounds may be far below the values. So values are computed for the n lowest bounds, then for all bounds below
/// the highest of these values.
template <int D>
Outcome<std::vector<std::uint32_t>> find_lowest_jacobians(const Judged<D>& judged, std::size_t n,
                                                          const Execution& execution) {
    const Column<float>& bounds = judged.report.elements.min_scaled_jacobian;
    const Column<Verdict>& verdicts = judged.report.elements.verdicts;
    Buffer<double> scores(bounds.begin(), bounds.end());
    const auto refine = [&](std::size_t e) { scores[e] = check_closely(judged, e).min_scaled_jacobian; };
    const auto first = find_lowest(verdicts, scores, n);
    auto refined = each(execution, first.size(), [&](std::size_t i) { refine(first[i]); }, 16);
    if (!refined) return fail(refined.error());
    double ceiling = 0;
    for (const std::uint32_t e : first)
        if (std::isfinite(scores[e])) ceiling = std::max(ceiling, scores[e]);
    ceiling -= 0.1 * scaled_jacobian_tolerance * std::max(1.0, ceiling);
    refined = each(execution, scores.size(), [&](std::size_t e) {
        if (std::isfinite(bounds[e]) && scores[e] == bounds[e] && scores[e] < ceiling) refine(e);
    });
    if (!refined) return fail(refined.error());
    return find_lowest(verdicts, scores, n);
}

template <int D>
std::string name_place(const Barycentric<D>& at, const std::vector<std::size_t>& vertices) {
    std::string names;
    int n = 0;
    for (int i = 0; i <= D; ++i)
        if (at[i] > 0) names += (n++ > 0 ? "-" : "") + std::to_string(vertices[static_cast<std::size_t>(i)]);
    if (n == 1) return "at vertex " + names;
    if (n == 2) return "on the edge " + names;
    if (n == D) return "in the face " + names;
    return "inside";
}

template <int K>
bool is_flat(const BoundedJacobian<K>& jacobian) {
    return !(std::abs(jacobian.straight) > 2 * jacobian.error);
}

/// A place, and det J there relative to |det of the straight element|, or det J itself if that element is flat.
template <int D>
struct LowPlace {
    Barycentric<D> at{};
    double scaled_jacobian = 0;
};

/// Point where det J is lowest or, for an invalid element, where the condition is proved to fail; none: no such point.
template <int K>
std::optional<LowPlace<K>> find_low_place(const BoundedJacobian<K>& jacobian, const auto& nodes, Verdict verdict,
                                          double bound) {
    const MinJacobianPoint<K> low = min_jacobian_point(jacobian);
    const bool flat = is_flat(jacobian);
    if (verdict != Verdict::invalid)
        return LowPlace<K>{low.at, flat ? low.jacobian : low.jacobian / std::abs(jacobian.straight)};
    const auto failure = find_failure(nodes, bound, low.at);
    if (!failure) return {};
    return LowPlace<K>{failure->at, flat ? failure->jacobian : failure->scaled};
}

template <int D>
std::string describe_wall(const Judged<D>& judged, ElementId e) {
    const auto& walls = judged.soundness.wall_elements;
    const auto at = std::lower_bound(walls.begin(), walls.end(), e,
                                     [](const WallElement& wall, ElementId id) { return wall.element < id; });
    if (at == walls.end() || at->element != e) return {};
    const std::size_t a = judged.report.numbers(at->hinge[0].index());
    if (D == 2)
        return fmt::format(
            "two edges on one smooth wall (at vertex {}): when it is curved, the element needs "
            "a swap",
            a);
    return fmt::format(
        "two faces on one smooth wall (edge {}-{}): no position of its nodes makes the element good; it "
        "needs a swap",
        a, judged.report.numbers(at->hinge[1].index()));
}

struct Facts {
    bool flat = false, inverted_all_over = false;
    double bound = 0;
    std::string where;
};

std::string reason_text(const ElementReport& element, const Facts& facts) {
    const double value = element.witness->scaled_jacobian;
    const std::string bound_text =
        element.verdict == Verdict::invalid ? upper_bound_text(value) : fmt::format("{:.4g}", value);
    if (facts.flat) return fmt::format("flat when straight, and det J = {} {}", bound_text, facts.where);
    if (element.verdict == Verdict::valid && std::abs(value - 1) < 1e-6) return "as good as straight";
    if (facts.inverted_all_over) return "inverted: det J is negative everywhere";
    const std::string share = fmt::format("det J = {} of the straight element's {}", bound_text, facts.where);
    switch (element.verdict) {
        case Verdict::valid: return *element.straight_inverted ? share + "; inverted when straight, yet valid" : share;
        case Verdict::undecided:
            return fmt::format("undecided: within rounding of the bound {:g} {}", facts.bound, facts.where);
        case Verdict::invalid: break;
    }
    if (*element.straight_inverted) return share + "; inverted when straight";
    return value > 0 ? share + fmt::format(", below the bound {:g}", facts.bound) : share;
}

template <int K, int D>
void describe_curved(const BoundedJacobian<K>& jacobian, const auto& nodes, const QuadraticSimplex<K, D>& curved,
                     double bound, ElementReport& element) {
    const auto low = find_low_place(jacobian, nodes, element.verdict, bound);
    if (!low) {
        element.reason = "invalid at a point that double-precision numbers cannot represent";
        return;
    }
    Barycentric<K> place = low->at;
    const double sum = std::accumulate(place.begin(), place.end(), 0.0);
    for (double& x : place) x /= sum;
    const Vec<D> point = curved.point(place);
    element.witness = Witness{{low->at.begin(), low->at.end()}, {point.c.begin(), point.c.end()}, low->scaled_jacobian};
    const double highest = *std::max_element(jacobian.coefficients.begin(), jacobian.coefficients.end());
    element.reason = reason_text(
        element, {is_flat(jacobian), highest < -jacobian.error, bound, name_place<K>(low->at, element.vertices)});
}

template <int D>
void describe_curved(const Judged<D>& judged, ElementReport& element, std::size_t e) {
    element.min_scaled_jacobian = check_closely(judged, e).min_scaled_jacobian;
    element.straight_inverted = judged.report.elements.straight_inverted[e] == 1;
    with_element(judged, e, [&](const auto& nodes, const auto& curved) {
        const auto plain = bounded_jacobian(nodes);
        describe_curved(blurred(plain) ? double_double_jacobian(nodes) : plain, nodes, curved, judged.validation.bound,
                        element);
    });
}

template <int D>
void describe_straight(const Judged<D>& judged, ElementReport& element, std::size_t e) {
    element.quality = judged.report.elements.quality[e];
    element.volume = judged.report.elements.volume[e];
    const bool is_alone = is_standalone_surface(judged.mesh.linear);
    const char* measure = D == 2 || is_alone ? "area" : "volume";
    if (element.verdict == Verdict::valid) {
        const std::span<const VertexId> vertices = vertices_of(judged.mesh.linear, e);
        double shortest = std::numeric_limits<double>::infinity(), longest = 0;
        for (const VertexId a : vertices)
            for (const VertexId b : vertices) {
                if (!(a < b)) continue;
                const double length = distance(judged.mesh.linear.points[a], judged.mesh.linear.points[b]);
                shortest = std::min(shortest, length);
                longest = std::max(longest, length);
            }
        element.reason = fmt::format("edges from {:.4g} to {:.4g}", shortest, longest);
    } else if (*element.volume < 0 && element.verdict == Verdict::invalid) {
        element.reason = fmt::format("inverted: its {} is negative", measure);
    } else {
        element.reason = fmt::format("flat: its {} is 0 to rounding", measure);
    }
}

template <int D>
ElementReport describe_element(const Judged<D>& judged, std::size_t e) {
    ElementReport element;
    const CheckReport& report = judged.report;
    element.number = e + 1;
    element.tag = report.tag_of(e + 1);
    element.reference = report.elements.references[e];
    element.name = name_in(report.groups, report.mesh.judged_dimension(), element.reference);
    element.verdict = report.elements.verdicts[e];
    element.vertices.reserve(D + 1);
    for (const VertexId v : vertices_of(judged.mesh.linear, e)) element.vertices.push_back(report.numbers(v.index()));
    report.elements.is_curved() ? describe_curved(judged, element, e) : describe_straight(judged, element, e);
    if (is_standalone_surface(judged.mesh.linear)) return element;
    if (const std::string wall = describe_wall(judged, ElementId(e)); !wall.empty()) element.reason += "; " + wall;
    return element;
}

}  // namespace

template <int D>
Outcome<std::vector<ElementReport>> find_worst_elements(const Judged<D>& judged, std::size_t n,
                                                        const Execution& execution) {
    std::vector<std::uint32_t> chosen;
    if (judged.report.elements.is_curved()) {
        auto found = find_lowest_jacobians(judged, n, execution);
        if (!found) return fail(found.error());
        chosen = std::move(*found);
    } else {
        const Column<float>& quality = judged.report.elements.quality;
        chosen = find_lowest(judged.report.elements.verdicts, Buffer<double>(quality.begin(), quality.end()), n);
    }
    std::vector<ElementReport> worst(chosen.size());
    auto done =
        each(execution, chosen.size(), [&](std::size_t i) { worst[i] = describe_element(judged, chosen[i]); }, 16);
    if (!done) return fail(done.error());
    const auto rank = [&](const ElementReport& e) {
        return std::tuple(e.verdict == Verdict::valid,
                          judged.report.elements.is_curved() ? *e.min_scaled_jacobian : *e.quality, e.number);
    };
    std::sort(worst.begin(), worst.end(),
              [&](const ElementReport& a, const ElementReport& b) { return rank(a) < rank(b); });
    return worst;
}

#define CAMBER_INSTANTIATE(D)                                                                          \
    template Outcome<std::vector<ElementReport>> find_worst_elements<D>(const Judged<D>&, std::size_t, \
                                                                        const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
