module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>
module camber.optimisation;
import camber.core;
import camber.bezier;
import camber.validity;

namespace camber {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Maximum relative change of coefficients in the linear program; closed shells need far less.
constexpr double volume_reach = 1e3;

/// Constraints are tightened by 4, 64, … rounding errors until `decide` agrees.
constexpr int tightenings = 6;

template <int D>
struct AffinePart {
    std::array<AffineFunction<D>, jacobian_coefficients<D>> coefficients{};
    int element = 0;
};

template <int D>
AffinePart<D> half_of(AffinePart<D> part, int edge, int side) {
    for (const auto [target, source] : bisections<D>[edge][side]) {
        auto& t = part.coefficients[target];
        const auto& s = part.coefficients[source];
        t = {0.5 * (t.gradient + s.gradient), 0.5 * (t.offset + s.offset)};
    }
    return part;
}

template <int D>
constexpr auto is_corner = [] {
    std::array<bool, jacobian_coefficients<D>> table{};
    for (const int c : corner_coefficients<D>) table[c] = true;
    return table;
}();

struct Place {
    std::uint16_t part = 0, coefficient = 0;
};

/// Parts of the elements of a shell as functions of x = P − P_0, where P_0 is the shell's node.
template <int D>
struct Parts {
    std::vector<AffinePart<D>> parts;
    std::vector<double> straight, error;
    std::vector<double> sharpest;  ///< maximum |gradient| of the coefficients of each element
    int cuts = 0;

    explicit Parts(const EdgeShell<D>& shell) {
        const std::size_t n = shell.elements.size();
        parts.reserve(n + 8);
        straight.reserve(n), error.reserve(n), sharpest.reserve(n);
        for (std::size_t e = 0; e < n; ++e) {
            const auto j = affine_jacobian(shell.elements[e].element, shell.elements[e].edge);
            parts.push_back({j.coefficients, static_cast<int>(e)});
            straight.push_back(j.straight), error.push_back(j.error);
            double most = 0;
            for (const auto& f : j.coefficients) most = std::max(most, norm_squared(f.gradient));
            sharpest.push_back(std::sqrt(most));
        }
    }

    [[nodiscard]] std::size_t size() const { return parts.size(); }

    bool bisect(std::vector<Place>& places, const Vec<D>& x, int max_cuts) {
        std::sort(places.begin(), places.end(), [](Place a, Place b) { return a.part < b.part; });
        bool any = false;
        for (std::size_t i = 0; i < places.size() && cuts < max_cuts; ++i) {
            if (i > 0 && places[i].part == places[i - 1].part) continue;
            const AffinePart<D> whole_part = parts[places[i].part];
            JacobianPart<D> values;
            for (int k = 0; k < jacobian_coefficients<D>; ++k) values.coefficients[k] = whole_part.coefficients[k](x);
            const int edge = largest_bend(values).edge;
            parts[places[i].part] = half_of(whole_part, edge, 0);
            parts.push_back(half_of(whole_part, edge, 1));
            ++cuts;
            any = true;
        }
        return any;
    }
};

template <int D>
bool is_constant(const AffineFunction<D>& f) {
    return norm_squared(f.gradient) == 0;
}

/// safe: all coefficients are constraints, so every feasible node is valid. all: only coefficients that are values of
/// det J are constraints, so every valid node is feasible.
enum class Admits { safe, all };

template <int D>
bool takes_part(Admits admits, int coefficient) {
    return admits == Admits::safe || is_corner<D>[coefficient];
}

/// Returns the position x that reaches `value` with the smallest changes of the functions, or `otherwise` if there is
/// none. Other positions may be far away if the shell is open.
template <int D>
Vec<D> min_change(std::span<const RaisedFunction<D>> raised, double value, const Vec<D>& otherwise) {
    QuadraticModel<D> change{{}, {}, 0};
    std::vector<AffineFunction<D>> functions;
    functions.reserve(raised.size());
    for (const auto& [f, weight] : raised) {
        for (int i = 0; i < D; ++i)
            for (int j = 0; j <= i; ++j) change.hessian(i, j) += f.gradient[i] * f.gradient[j];
        functions.push_back({f.gradient, f.offset - weight * value});
    }
    const auto nearest = nearest_point<D>(change, functions);
    return nearest.feasible ? nearest.x : otherwise;
}

/// Solution of the linear program. Coefficients that do not depend on the node limit the achieved value.
template <int D>
struct LinearAnswer {
    Vec<D> x;
    double lower = 0, upper = 0;
    std::vector<Place> active_places;  ///< parts with active coefficients that are not values of det J
};

template <int D>
std::optional<LinearAnswer<D>> raise(const Parts<D>& parts, const EdgeShell<D>& shell, Admits admits,
                                     double least = -infinity) {
    std::vector<RaisedFunction<D>> functions;
    std::vector<Place> places;
    functions.reserve(parts.size() * jacobian_coefficients<D>);
    places.reserve(functions.capacity());
    double cap = infinity;
    Place capped;
    double largest = 1;
    for (std::size_t p = 0; p < parts.size(); ++p) {
        const auto& required_jacobian = shell.elements[parts.parts[p].element].required_jacobian;
        for (int k = 0; k < jacobian_coefficients<D>; ++k) {
            if (!takes_part<D>(admits, k)) continue;
            const Place place{static_cast<std::uint16_t>(p), static_cast<std::uint16_t>(k)};
            AffineFunction<D> f = parts.parts[p].coefficients[k];
            if (is_constant(f)) {
                if (!required_jacobian && f.offset < cap) cap = f.offset, capped = place;
                continue;
            }
            if (required_jacobian) f.offset -= *required_jacobian;
            largest = std::max(largest, std::abs(f.offset));
            functions.push_back({f, required_jacobian ? 0.0 : 1.0});
            places.push_back(place);
        }
    }
    if (cap <= least) return {};
    const auto highest = max_min_point<D>(functions, volume_reach * largest, least);
    if (!highest) return {};
    LinearAnswer<D> answer{highest->x, std::min(highest->lower, cap), std::min(highest->upper, cap), {}};
    const auto hold = [&](Place place) {
        if (!is_corner<D>[place.coefficient]) answer.active_places.push_back(place);
    };
    if (cap <= highest->lower) {
        answer.x = min_change<D>(functions, cap, highest->x);
        hold(capped);
    } else {
        for (int i = 0; i < highest->active_count; ++i) hold(places[highest->active[i]]);
    }
    return answer;
}

template <int D>
void bisect_weak_parts(Parts<D>& parts, const EdgeShell<D>& shell, const Vec<D>& x, int max_cuts) {
    std::vector<Place> weak;
    do {
        weak.clear();
        for (std::size_t p = 0; p < parts.size(); ++p) {
            const auto& required_jacobian = shell.elements[parts.parts[p].element].required_jacobian;
            if (!required_jacobian) continue;
            double corner = infinity;
            double other = infinity;
            for (int k = 0; k < jacobian_coefficients<D>; ++k) {
                double& least = is_corner<D>[k] ? corner : other;
                least = std::min(least, parts.parts[p].coefficients[k](x));
            }
            if (other < *required_jacobian && corner >= *required_jacobian)
                weak.push_back({static_cast<std::uint16_t>(p), 0});
        }
    } while (parts.bisect(weak, x, max_cuts));
}

template <int D>
double floor_of(const Parts<D>& parts, const EdgeShell<D>& shell, std::size_t e, double bound, double slack) {
    const double required = std::max(0.0, shell.elements[e].required_jacobian.value_or(bound));
    // Stored coordinates are rounded by half a unit in the last place.
    double stored = 0;
    for (int c = 0; c < D; ++c) stored = std::max(stored, std::abs(shell.node.point[c]));
    const double rounding = parts.error[e] * (1 + required) + parts.sharpest[e] * stored * 0x1p-52 + 0x1p-50 * required;
    return required * parts.straight[e] + slack * rounding;
}

template <int D>
struct QuadraticAnswer {
    NearestPoint<D> nearest;
    std::vector<Place> active_places;
};

template <int D>
QuadraticAnswer<D> approach(const Parts<D>& parts, std::span<const double> floors, const QuadraticModel<D>& model,
                            Admits admits) {
    std::vector<AffineFunction<D>> functions;
    std::vector<Place> places;
    functions.reserve(parts.size() * jacobian_coefficients<D>);
    places.reserve(functions.capacity());
    for (std::size_t p = 0; p < parts.size(); ++p)
        for (int k = 0; k < jacobian_coefficients<D>; ++k) {
            if (!takes_part<D>(admits, k)) continue;
            AffineFunction<D> f = parts.parts[p].coefficients[k];
            f.offset -= floors[parts.parts[p].element];
            if (is_constant(f) && f.offset >= 0) continue;
            functions.push_back(f);
            places.push_back({static_cast<std::uint16_t>(p), static_cast<std::uint16_t>(k)});
        }
    QuadraticAnswer<D> answer{nearest_point<D>(model, functions), {}};
    for (int i = 0; i < answer.nearest.active_count; ++i) {
        const Place place = places[answer.nearest.active[i]];
        if (!is_corner<D>[place.coefficient]) answer.active_places.push_back(place);
    }
    return answer;
}

template <int D>
std::optional<NearestPoint<D>> approach_with_cuts(Parts<D>& parts, std::span<const double> floors,
                                                  const QuadraticModel<D>& model, const EdgeProgramOptions& options) {
    for (;;) {
        auto answer = approach(parts, floors, model, Admits::safe);
        const NearestPoint<D>& safe = answer.nearest;
        const auto found = safe.feasible ? std::optional(safe) : std::nullopt;
        if (answer.active_places.empty()) return found;
        const NearestPoint<D> all = approach(parts, floors, model, Admits::all).nearest;
        if (!all.feasible) return {};
        const double scale = std::max({std::abs(model.value), safe.cost, std::numeric_limits<double>::min()});
        if (safe.feasible && safe.cost - all.cost <= options.tolerance * scale) return found;
        if (!parts.bisect(answer.active_places, safe.x, options.max_cuts)) return found;
    }
}

template <int D>
std::vector<double> floors_of(const Parts<D>& parts, const EdgeShell<D>& shell, double bound, double slack) {
    std::vector<double> floors(shell.elements.size());
    for (std::size_t e = 0; e < floors.size(); ++e) floors[e] = floor_of(parts, shell, e, bound, slack);
    return floors;
}

}  // namespace

template <int D>
bool holds(const EdgeShell<D>& shell, const LagrangeNode<D>& node, double bound) {
    return std::all_of(shell.elements.begin(), shell.elements.end(), [&](const ShellElement<D>& s) {
        return decide(with_node(s, node), s.required_jacobian.value_or(bound)) == Verdict::valid;
    });
}

template <int D>
double smallest_scaled_jacobian(const EdgeShell<D>& shell, const LagrangeNode<D>& node, double enough) {
    double smallest = infinity;
    for (const ShellElement<D>& s : shell.elements) {
        if (s.required_jacobian) continue;
        const NodalSimplex<D> element = with_node(s, node);
        double value = smallest_scaled_coefficient(bounded_jacobian(element));
        // For the requested value, `decide` may prove more than the coefficients do.
        if (value < enough) {
            value = std::max(value, enough > 0 && decide(element, enough) == Verdict::valid
                                        ? enough
                                        : check_element(element, 0).min_scaled_jacobian);
        }
        smallest = std::min(smallest, value);
    }
    return smallest;
}

namespace {

template <int D>
std::optional<MaxMinNode<D>> max_min_by_linear_programs(const EdgeShell<D>& shell, const EdgeProgramOptions& options) {
    Parts<D> parts(shell);
    bisect_weak_parts(parts, shell, Vec<D>{}, options.max_cuts);
    MaxMinNode<D> best;
    const double least = options.max_cuts == 0 ? options.least : -infinity;
    double upper = infinity;
    double before = -infinity;
    for (;;) {
        auto answer = raise(parts, shell, Admits::safe, least);
        if (!answer) return {};
        best = {{shell.node.point + answer->x}, answer->lower, 0, parts.cuts};
        if (answer->active_places.empty() || options.max_cuts == 0) {
            upper = answer->upper;
            break;
        }
        if (answer->lower >= options.enough) break;
        // The upper bound costs as much as the lower one, so it is computed only if it may end the search.
        const double close = options.tolerance * std::max(1.0, std::abs(best.lower));
        if (parts.cuts == 0 || best.lower < before + close) {
            if (const auto all = raise(parts, shell, Admits::all)) upper = std::min(upper, all->upper);
            if (upper < options.enough && options.enough < infinity) break;
            if (upper - best.lower <= close) break;
        }
        before = best.lower;
        if (!parts.bisect(answer->active_places, answer->x, options.max_cuts)) break;
    }
    // The certificate refers to the stored node. The claimed bound is slightly below the program's value because of
    // rounding.
    const double claimed_bound = best.lower - 1e-9 * std::max(1.0, std::abs(best.lower));
    best.lower = smallest_scaled_jacobian(shell, best.node, parts.cuts == 0 ? -infinity : claimed_bound);
    best.upper = std::max(upper, best.lower);
    return best;
}

}  // namespace

template <int D>
std::optional<MaxMinNode<D>> max_min_node(const EdgeShell<D>& shell, const EdgeProgramOptions& options) {
    const auto highest = max_min_by_linear_programs(shell, options);
    if (!highest) return {};
    for (const ShellElement<D>& s : shell.elements) {
        if (!s.required_jacobian) continue;
        const auto element = with_node(s, highest->node);
        const double slack = 0x1p-40 * (1 + std::abs(*s.required_jacobian));
        if (check_element(element, 0).min_scaled_jacobian < *s.required_jacobian - scaled_jacobian_tolerance - slack)
            return {};
    }
    return highest;
}

template <int D>
std::optional<NearestNode<D>> nearest_node(const EdgeShell<D>& shell, const QuadraticModel<D>& model, double bound,
                                           const EdgeProgramOptions& options) {
    Parts<D> parts(shell);
    QuadraticModel<D> relative_model = model;
    relative_model.centre -= shell.node.point;
    double slack = 4;
    for (int turn = 0; turn < tightenings; ++turn, slack *= 16) {
        const auto nearest = approach_with_cuts(parts, floors_of(parts, shell, bound, slack), relative_model, options);
        if (!nearest) return {};
        const LagrangeNode<D> node{shell.node.point + nearest->x};
        if (holds(shell, node, bound)) return NearestNode<D>{node, model(node.point), parts.cuts};
    }
    return {};
}

#define CAMBER_INSTANTIATE(D)                                                                                     \
    template bool holds<D>(const EdgeShell<D>&, const LagrangeNode<D>&, double);                                  \
    template double smallest_scaled_jacobian<D>(const EdgeShell<D>&, const LagrangeNode<D>&, double);             \
    template std::optional<MaxMinNode<D>> max_min_node<D>(const EdgeShell<D>&, const EdgeProgramOptions&);        \
    template std::optional<NearestNode<D>> nearest_node<D>(const EdgeShell<D>&, const QuadraticModel<D>&, double, \
                                                           const EdgeProgramOptions&);
CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
