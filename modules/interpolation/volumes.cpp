module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>
module camber.interpolation;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

double determinant(const std::array<Vec<2>, 2>& columns) { return det(columns[0], columns[1]); }
double determinant(const std::array<Vec<3>, 3>& columns) { return det(columns[0], columns[1], columns[2]); }

/// det J of the straight element, D! times its volume.
template <int D>
double straight_determinant(const LinearMesh<D>& mesh, std::size_t e) {
    const auto& vertices = mesh.elements.vertices[e];
    std::array<Vec<D>, D> columns;
    for (std::size_t a = 0; a < D; ++a) columns[a] = mesh.points[vertices[a + 1]] - mesh.points[vertices[0]];
    return determinant(columns);
}

}  // namespace

template <int D>
Volumes volumes_of(const QuadraticMesh<D>& mesh, const std::vector<std::uint32_t>& bent) {
    const CollapsedRule<D> rule(2);  // exact: det J is of degree D
    double straight = 0, beyond = 0;
    for (std::size_t e = 0; e < mesh.linear.elements.size(); ++e)
        straight += straight_determinant(mesh.linear, e) / (D == 2 ? 2 : 6);
    for (const std::uint32_t e : bent) {
        const auto element = element_of(mesh, ElementId(std::size_t{e}));
        const double of_straight = straight_determinant(mesh.linear, e);
        for (std::size_t p = 0; p < rule.count; ++p) {
            Barycentric<D> xi{};
            for (std::size_t i = 0; i <= D; ++i) xi[i] = rule.barycentric[i][p];
            beyond += rule.weights[p] * (determinant(element.derivatives(xi)) - of_straight);
        }
    }
    return {straight, straight + beyond};
}

template Volumes volumes_of<2>(const QuadraticMesh<2>&, const std::vector<std::uint32_t>&);
template Volumes volumes_of<3>(const QuadraticMesh<3>&, const std::vector<std::uint32_t>&);

}  // namespace camber
