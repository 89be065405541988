module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <span>
#include <vector>
module camber.recovery;
import camber.core;
import camber.bezier;
import :derivatives;
import :material_rows;
import :normal_gradients;

namespace camber {

namespace {

using ByReference = std::map<Reference, NormalGradients>;

Vec<2> normal_to(const std::array<Vec<2>, 1>& columns) { return {{columns[0][1], -columns[0][0]}}; }
Vec<3> normal_to(const std::array<Vec<3>, 2>& columns) { return cross(columns[0], columns[1]); }

/// The unit normals of a facet at its corners; zero where it is degenerate.
template <int D>
std::array<Vec<D>, D> normals_at_corners(const QuadraticMesh<D>& mesh, FacetId f) {
    const QuadraticSimplex<D - 1, D> facet = facet_of(mesh, f);
    std::array<Vec<D>, D> normals;
    for (int i = 0; i < D; ++i) {
        Barycentric<D - 1> corner{};
        corner[i] = 1;
        normals[i] = normalised(normal_to(facet.derivatives(corner)));
    }
    return normals;
}

/// The measure of a straight facet.
template <int D>
double area_of(const LinearMesh<D>& mesh, FacetId f) {
    const auto& corners = mesh.facets.vertices[f];
    std::array<Vec<D>, D - 1> sides;
    for (int i = 0; i < D - 1; ++i) sides[i] = mesh.points[corners[i + 1]] - mesh.points[corners[0]];
    return norm(normal_to(sides)) / (D - 1);
}

/// The derivatives of one mesh, sampled at facets.
template <int D>
class AtFacets {
  public:
    AtFacets(const QuadraticMesh<D>& mesh, const Incidence<ElementId>& balls,
             const RecoveredDerivatives<D>& derivatives, std::span<const double> weights)
        : mesh_(mesh), balls_(balls), derivatives_(derivatives), weights_(weights) {}

    void add(FacetId f, NormalGradients& sums) const {
        const double area = area_of(mesh_.linear, f);
        sums.area += area;
        for (const double gradient : at_corners(f)) {
            sums.integral += area / D * gradient;
            sums.squares += area / D * gradient * gradient;
        }
    }

  private:
    /// The normal derivatives at the corners of a facet; 0 where it has no element.
    [[nodiscard]] std::array<double, D> at_corners(FacetId f) const {
        const auto& corners = mesh_.linear.facets.vertices[f];
        const auto normals = normals_at_corners(mesh_, f);
        std::array<double, D> gradients{};
        for (const ElementId e : balls_[corners[0]]) {
            const auto& vertices = mesh_.linear.elements.vertices[e];
            const auto has = [&](VertexId v) { return std::ranges::find(vertices, v) != vertices.end(); };
            if (!std::ranges::all_of(corners, has)) continue;
            for (int i = 0; i < D; ++i)
                if (const auto row = derivatives_.rows.row(corners[i], mesh_.linear.elements.references[e]))
                    gradients[i] = std::max(gradients[i], along(normals[i], *row));
        }
        return gradients;
    }
    [[nodiscard]] double along(const Vec<D>& normal, std::size_t row) const {
        double sum = 0;
        for (std::size_t f = 0; f < weights_.size(); ++f) {
            const double part = weights_[f] * dot(normal, derivatives_.fields[f].gradients[row]);
            sum += part * part;
        }
        return std::sqrt(sum);
    }

    const QuadraticMesh<D>& mesh_;
    const Incidence<ElementId>& balls_;
    const RecoveredDerivatives<D>& derivatives_;
    const std::span<const double> weights_;
};

}  // namespace

template <int D>
Outcome<std::vector<NormalGradients>> normal_gradients(const QuadraticMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                       const RecoveredDerivatives<D>& derivatives,
                                                       std::span<const double> weights, const Execution& execution) {
    if (weights.size() != derivatives.fields.size())
        return fail(ErrorKind::usage, "there must be one weight for each field");
    const AtFacets<D> at(mesh, balls, derivatives, weights);
    const auto found = reduce_each(
        execution, mesh.linear.facets.size(), ByReference{},
        [&](ByReference& all, std::size_t f) { at.add(FacetId(f), all[mesh.linear.facets.references[FacetId(f)]]); },
        [](ByReference a, const ByReference& b) {
            for (const auto& [reference, part] : b) {
                NormalGradients& sums = a[reference];
                sums.area += part.area;
                sums.integral += part.integral;
                sums.squares += part.squares;
            }
            return a;
        });
    if (!found) return fail(found.error());
    std::vector<NormalGradients> gradients;
    gradients.reserve(found->size());
    for (const auto& [reference, sums] : *found)
        gradients.push_back({reference, sums.area, sums.integral, sums.squares});
    return gradients;
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template Outcome<std::vector<NormalGradients>> normal_gradients<D>(                                                \
        const QuadraticMesh<D>&, const Incidence<ElementId>&, const RecoveredDerivatives<D>&, std::span<const double>, \
        const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
