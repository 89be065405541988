#include "back_field.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "matrix.hpp"

namespace paper {

namespace {

/// Computes the coordinates of p from the cofactors of the sides (subvolumes in the paper). ∇u_j is an inward normal
/// divided by the volume.
void measure(const BackField& field, const Vector& p, Place& place) {
    const auto& v = field.elements[place.element].vertices;
    const Vector& origin = field.vertices[v[0]].point;
    const Vector a = field.vertices[v[1]].point - origin;
    const Vector b = field.vertices[v[2]].point - origin;
    const Vector c = field.vertices[v[3]].point - origin;
    const Vector bc = cross(b, c);
    const double scale = 1 / dot(a, bc);
    place.gradient[1] = scale * bc;
    place.gradient[2] = scale * cross(c, a);
    place.gradient[3] = scale * cross(a, b);
    place.gradient[0] = -1.0 * (place.gradient[1] + place.gradient[2] + place.gradient[3]);
    const Vector r = p - origin;
    for (std::size_t j = 1; j < 4; ++j) place.u[j] = dot(place.gradient[j], r);
    place.u[0] = 1 - place.u[1] - place.u[2] - place.u[3];
}

constexpr int longest_walk = 256;
constexpr double on_face = 1e-10;  ///< a point this close to a face is in both of its elements

}  // namespace

std::optional<Place> locate(const BackField& field, const Vector& p, std::uint32_t hint) {
    Place place;
    place.element = hint;
    for (place.steps = 1; place.steps <= longest_walk; ++place.steps) {
        measure(field, p, place);
        const auto lowest = static_cast<std::size_t>(std::ranges::min_element(place.u) - place.u.begin());
        if (place.u[lowest] >= -on_face) return place;
        // Chooses the inner face that p is farthest beyond.
        std::uint32_t next = no_element;
        double lowest_coordinate = -on_face;
        for (std::size_t j = 0; j < 4; ++j) {
            const std::uint32_t across = field.elements[place.element].neighbours[j];
            if (!(place.u[j] < lowest_coordinate) || across == no_element) continue;
            next = across;
            lowest_coordinate = place.u[j];
        }
        if (next == no_element) return std::nullopt;
        place.element = next;
    }
    return std::nullopt;
}

}  // namespace paper
