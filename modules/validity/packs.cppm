module;
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
export module camber.validity:packs;
import camber.core;
import camber.bezier;
import :jacobian;

export namespace camber {

/// Nodes of eight elements, one a lane; lanes that are not set are of points.
template <int D>
struct NodalPack {
    alignas(64) std::array<std::array<std::array<double, pack_size>, D>, quadratic_nodes<D>> nodes{};

    void set(std::size_t lane, const NodalSimplex<D>& s) {
        for (int n = 0; n < quadratic_nodes<D>; ++n)
            for (int c = 0; c < D; ++c) nodes[n][c][lane] = s.nodes[n][c];
    }
};

/// What is left of a BoundedJacobian where its lowest coefficient tells all.
struct LowJacobian {
    double lowest = 0;           ///< of the coefficients
    double straight = 0;         ///< as in BoundedJacobian
    double error = 0;            ///< as there: what rounding may do to both
    double sum_of_absolute = 0;  ///< of the coefficients: neither infinite nor NaN where none of them is

    [[nodiscard]] bool is_finite() const { return std::isfinite(error + straight + sum_of_absolute); }
};

[[nodiscard]] inline LowJacobian low_jacobian(const BoundedJacobian<2>& jacobian) {
    LowJacobian low{jacobian.coefficients[0], jacobian.straight, jacobian.error, 0};
    for (const double c : jacobian.coefficients) {
        low.lowest = c < low.lowest ? c : low.lowest;
        low.sum_of_absolute += std::abs(c);
    }
    return low;
}

/// Of each lane, from the numbers that bounded_jacobian gives, to the last bit, with any instructions.
template <int D>
[[nodiscard]] std::array<LowJacobian, pack_size> low_jacobians(const NodalPack<D>& elements,
                                                               Instructions set = widest_instructions());

/// Whether the element is valid for certain (`decide_by_coefficients`) and rounding does not blur its scaled Jacobian
/// (`blurred`).
[[nodiscard]] bool is_clear(const LowJacobian& jacobian, double bound);

/// As of a BoundedJacobian.
[[nodiscard]] double smallest_scaled_coefficient(const LowJacobian& jacobian);

/// visit(i, jacobian) for i in [begin, end), of the elements element(i).
template <int D, class Element, class Visit>
void each_low_jacobian(std::size_t begin, std::size_t end, const Element& element, const Visit& visit) {
    NodalPack<D> pack;
    for (std::size_t first = begin; first < end; first += pack_size) {
        const std::size_t lanes = end - first < pack_size ? end - first : pack_size;
        for (std::size_t lane = 0; lane < lanes; ++lane) pack.set(lane, element(first + lane));
        const auto jacobians = low_jacobians(pack);
        for (std::size_t lane = 0; lane < lanes; ++lane) visit(first + lane, jacobians[lane]);
    }
}

}  // namespace camber
