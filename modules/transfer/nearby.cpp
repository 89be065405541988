module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
module camber.transfer;
import :nearby;
import :simplex;
import :sources;
import camber.core;
import camber.bezier;
import camber.metric;

namespace camber {

/// Newton's method from the centre, with the Jacobian of the place once the element bends.
template <int D>
bool Nearby<D>::is_inside(const Tried& here, const Vec<D>& p, Barycentric<D>& xi) {
    constexpr int most_steps = 6;
    constexpr double far = 0.2, small = 1e-6;  // the error after a step of 10⁻⁶ is its square
    const Vec<D> r = p - here.map.origin;
    xi.fill(1.0 / (D + 1));
    Vec<D> step = here.inverse * (r - here.centre);
    for (int k = 0; k < most_steps; ++k) {
        double rest = 1, largest = 0;
        for (int i = 0; i < D; ++i) {
            xi[i + 1] += step[i];
            rest -= xi[i + 1];
            largest = std::max(largest, std::abs(step[i]));
        }
        xi[0] = rest;
        if (k > 0 && largest < small) return std::ranges::all_of(xi, [](double u) { return u >= 0; });
        for (const double u : xi)
            if (!(u > -far)) return false;
        if (here.map.is_straight) {
            Vec<D> x;
            for (int i = 0; i < D; ++i) x[i] = xi[i + 1];
            step = here.inverse * (r - here.jacobian * x);
        } else {
            step = inverse(Mat<D>{here.map.relative.derivatives(xi)}) * (r - here.map.relative.point(xi));
        }
    }
    return false;
}

/// The old element across the face that p lies farthest behind, by the linear map at the centre.
template <int D>
std::uint32_t Nearby<D>::next_towards(const Tried& here, const Vec<D>& p) const {
    const Vec<D> step = here.inverse * (p - here.map.origin - here.centre);
    std::size_t face = 0;
    double least = 0, rest = 0;
    for (int i = 0; i < D; ++i) {
        rest -= step[i];
        if (!(step[i] < least)) continue;
        least = step[i];
        face = static_cast<std::size_t>(i) + 1;
    }
    if (rest < least) face = 0;
    return sources_.across(material_, here.element, face);
}

template <int D>
OldPlace<D> Nearby<D>::find(const Vec<D>& p) {
    constexpr int short_walk = 6;
    OldPlace<D> place;
    for (std::size_t i = 0; i < tried_.size(); ++i)
        if (is_inside(tried_[i], p, place.xi)) return found(i, place);
    std::size_t at = 0;
    for (int step = 0; step < short_walk && at < tried_.size(); ++step) {
        const std::uint32_t next = next_towards(tried_[at], p);
        if (next == none || std::ranges::find(tried_, next, &Tried::element) != tried_.end()) break;
        at = remember(next);
        if (is_inside(tried_[at], p, place.xi)) return found(at, place);
    }
    place = sources_.find(p, material_, hint_);
    const auto known = std::ranges::find(tried_, place.element, &Tried::element);
    const auto i = static_cast<std::size_t>(known - tried_.begin());
    return found(known == tried_.end() ? remember(place.element) : i, place);
}

/// Puts the element first, where the next point is likely to be.
template <int D>
OldPlace<D> Nearby<D>::found(std::size_t i, OldPlace<D> place) {
    Tried& here = tried_[i];
    place.element = here.element;
    hint_ = here.element;
    if (!here.is_seen) seen_.push_back(here.element);
    here.is_seen = true;
    if (i > 0) std::swap(here, tried_[0]);
    return place;
}

template <int D>
std::size_t Nearby<D>::remember(std::uint32_t element) {
    Tried here{.element = element, .map = element_map(mesh_, element), .centre = {}, .jacobian = {}, .inverse = {}};
    Barycentric<D> centre{};
    centre.fill(1.0 / (D + 1));
    here.centre = here.map.relative.point(centre);
    here.jacobian = {here.map.relative.derivatives(centre)};
    here.inverse = inverse(here.jacobian);
    tried_.push_back(here);
    return tried_.size() - 1;
}

#define CAMBER_INSTANTIATE(D) template class Nearby<D>;

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
