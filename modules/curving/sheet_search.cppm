module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
module camber.curving:sheet_search;
import camber.core;
import camber.metric;
import camber.surface;

/// Minimising on a sheet: BFGS in the one or two tangential coordinates, each step followed by projection. The frame
/// goes along with the place, so that at each the projection's derivative is that of the tangent plane.
namespace camber {

/// How far a node may go, from where it began.
template <int D>
struct NodeReach {
    static constexpr double most = 0.3;          ///< of the chord
    static constexpr double to_the_ridge = 0.4;  ///< of the way to the corner that is on one, across the edge

    Vec<D> origin, middle, chord;
    double max_shift = 0;          ///< along the chord, of the chord
    std::span<const Vec<D>> thin;  ///< corners on ridges

    [[nodiscard]] bool has(const Vec<D>& p) const {
        const double squared = norm_squared(chord);
        const Vec<D> offset = p - origin;
        if (!(norm_squared(offset) <= most * most * squared)) return false;
        if (!(std::abs(dot(p - middle, chord)) <= max_shift * squared)) return false;
        return std::ranges::all_of(thin, [&](const Vec<D>& corner) {
            const Vec<D> to = corner - origin;
            const Vec<D> height = to - dot(to, chord) / squared * chord;
            return dot(offset, height) <= to_the_ridge * norm_squared(height);
        });
    }
};

/// A place, its objective, and what that looks like from there.
template <int D>
struct SheetIterate {
    SheetPlace<D> place;
    double value = 0;
    Vec<2> gradient;
    Sym<2> hessian;
};

template <int D>
class SheetSearch {
  public:
    SheetSearch(const EdgeSheet<D>& sheet, const NodeReach<D>& reach) : sheet_(sheet), reach_(reach) {}

    /// The place a step away in coordinates; nothing where there is none within reach.
    [[nodiscard]] std::optional<SheetPlace<D>> at(const SheetPlace<D>& from, const Vec<2>& y) const {
        Vec<D> step;
        for (int i = 0; i < sheet_.unknowns(); ++i) step += y[i] * from.tangents[static_cast<std::size_t>(i)];
        auto place = sheet_.moved(from, step);
        if (place && !reach_.has(place->point)) return std::nullopt;
        return place;
    }
    [[nodiscard]] Vec<2> coordinates(const SheetPlace<D>& place, const Vec<D>& v) const {
        Vec<2> y;
        for (int i = 0; i < sheet_.unknowns(); ++i) y[i] = dot(place.tangents[static_cast<std::size_t>(i)], v);
        return y;
    }

    template <class Objective>
    [[nodiscard]] SheetIterate<D> evaluated(const Objective& objective, const SheetPlace<D>& place) const {
        const ObjectiveSample<D> sample = objective.evaluate(place.point);
        SheetIterate<D> out{place, sample.value, coordinates(place, sample.gradient), Sym<2>::identity()};
        for (int i = 0; i < sheet_.unknowns(); ++i)
            for (int j = 0; j <= i; ++j)
                out.hessian(i, j) = dot(place.tangents[static_cast<std::size_t>(i)],
                                        sample.hessian * place.tangents[static_cast<std::size_t>(j)]);
        return out;
    }

    /// How a descent ended: where the model promises no more, or where no step lowered the objective (a kink), or the
    /// steps were spent.
    enum class End : std::uint8_t { converged, stopped };

    /// The least that BFGS finds from there.
    template <class Objective>
    End descend(const Objective& objective, int max_steps, double tolerance, SheetIterate<D>& at) const {
        Sym<2> h = inverse_of(at.hessian, Objective::damping);
        for (int step = 0; step < max_steps; ++step) {
            Vec<2> s = -(h * at.gradient);
            const double promised = -0.5 * dot(s, at.gradient);
            if (!(promised > tolerance * std::abs(at.value))) return End::converged;
            const auto next = along(objective, at, s);
            if (!next) return End::stopped;
            const Vec<2> change = next->gradient - at.gradient;
            at = *next;
            update(h, s, change);
        }
        return End::stopped;
    }

    /// Where kinks of the field stop a descent: along the axes of the Hessian with falling radius.
    template <class Objective>
    void polish(const Objective& objective, SheetIterate<D>& at) const {
        const std::array<Vec<2>, 2> axes = unit_axes(inverse_of(at.hessian, Objective::damping));
        const double scale = std::sqrt(std::max(at.value, 0.0));
        double radius = 0.05 * scale;
        for (int round = 0; round < 10 && radius > 1e-3 * scale; ++round) {
            bool is_better = false;
            for (int k = 0; k < sheet_.unknowns(); ++k)
                for (const double side : {-radius, radius}) {
                    const auto place = this->at(at.place, side * axes[static_cast<std::size_t>(k)]);
                    if (!place) continue;
                    const double value = objective.value(place->point);
                    if (!(value < at.value)) continue;
                    at.place = *place;
                    at.value = value;
                    is_better = true;
                }
            if (!is_better) radius *= 0.3;
        }
    }

  private:
    /// A step that lowers the objective enough, halved until it does; `s` becomes what it was.
    template <class Objective>
    std::optional<SheetIterate<D>> along(const Objective& objective, const SheetIterate<D>& from, Vec<2>& s) const {
        constexpr double longest = 0.15;  // of the chord
        constexpr double armijo = 1e-4;
        const double limit = longest * norm(reach_.chord), length = norm(s);
        if (length > limit) s *= limit / length;
        for (int halving = 0; halving < 10; ++halving, s *= 0.5) {
            const auto place = at(from.place, s);
            if (!place) continue;
            if (!(objective.value(place->point) <= from.value + armijo * dot(s, from.gradient))) continue;
            return evaluated(objective, *place);
        }
        return std::nullopt;
    }

    /// The inverse with a share of the trace on the diagonal, where the objective may leave a direction undecided.
    [[nodiscard]] Sym<2> inverse_of(const Sym<2>& h, double damping) const {
        const bool is_one = sheet_.unknowns() == 1;
        const double added = damping * (h(0, 0) + (is_one ? 0 : h(1, 1)));
        const double a = h(0, 0) + added, b = is_one ? 0 : h(1, 0), c = is_one ? 1 : h(1, 1) + added;
        const double determinant = a * c - b * b;
        Sym<2> out;
        if (determinant > 0 && a > 0) {
            out(0, 0) = c / determinant;
            out(1, 0) = -b / determinant;
            out(1, 1) = a / determinant;
        }
        return out;
    }

    /// Columns of a square root of a symmetric matrix.
    [[nodiscard]] static std::array<Vec<2>, 2> unit_axes(const Sym<2>& h) {
        const double a = std::sqrt(std::max(h(0, 0), 0.0));
        if (!(a > 0)) return {};
        const double b = h(1, 0) / a;
        return {Vec<2>{{a, b}}, Vec<2>{{0, std::sqrt(std::max(h(1, 1) - b * b, 0.0))}}};
    }

    static void update(Sym<2>& h, const Vec<2>& s, const Vec<2>& d) {
        const double sd = dot(s, d);
        if (!(sd > 1e-10 * norm(s) * norm(d))) return;
        const Vec<2> hd = h * d;
        const double factor = (1 + dot(d, hd) / sd) / sd;
        for (int i = 0; i < 2; ++i)
            for (int j = 0; j <= i; ++j) h(i, j) += factor * s[i] * s[j] - (hd[i] * s[j] + s[i] * hd[j]) / sd;
    }

    const EdgeSheet<D>& sheet_;
    const NodeReach<D>& reach_;
};

}  // namespace camber
