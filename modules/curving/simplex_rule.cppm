module;
#include <array>
export module camber.curving:simplex_rule;
import camber.core;

namespace camber {

/// A point of a rule by all of its barycentric coordinates, and its share of the simplex.
template <int D>
struct SimplexPoint {
    std::array<double, D + 1> at;
    double weight;
};

/// Rules of degree 6: the square of the error of a quadratic interpolant of a cubic is one.
template <int D>
inline constexpr auto simplex_rule = [] {
    if constexpr (D == 2) {
        // Dunavant, Int. J. Numer. Methods Eng. 21, 1985: 12 points.
        std::array<SimplexPoint<2>, 12> rule{};
        int n = 0;
        for (const auto& [a, weight] :
             {std::array{0.063089014491502, 0.050844906370207}, std::array{0.249286745170910, 0.116786275726379}})
            for (int i = 0; i < 3; ++i) {
                rule[n] = {{a, a, a}, weight};
                rule[n++].at[i] = 1 - 2 * a;
            }
        constexpr double a = 0.053145049844817, b = 0.310352451033784, c = 1 - a - b;
        for (const auto& at : {std::array{a, b, c}, std::array{b, c, a}, std::array{c, a, b}, std::array{a, c, b},
                               std::array{c, b, a}, std::array{b, a, c}})
            rule[n++] = {at, 0.082851075618374};
        return rule;
    } else {
        // Keast, Comput. Methods Appl. Mech. Eng. 55, 1986: 24 points.
        std::array<SimplexPoint<3>, 24> rule{};
        int n = 0;
        for (const auto& [a, weight] : {std::array{0.214602871259152029, 0.039922750257869636},
                                        std::array{0.040673958534611353, 0.010077211055345823},
                                        std::array{0.322337890142275510, 0.055357181543927398}})
            for (int i = 0; i < 4; ++i) {
                rule[n] = {{a, a, a, a}, weight};
                rule[n++].at[i] = 1 - 3 * a;
            }
        constexpr double a = 0.063661001875017525, b = 0.269672331458315808, c = 1 - 2 * a - b;
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j) {
                if (i == j) continue;
                rule[n] = {{a, a, a, a}, 27.0 / 560};
                rule[n].at[i] = b;
                rule[n++].at[j] = c;
            }
        return rule;
    }
}();

}  // namespace camber
