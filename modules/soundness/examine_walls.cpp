module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>
module camber.soundness;
import camber.core;
import camber.validity;
import :examination;

namespace camber {

namespace {

/// What two faces of an element share: an edge; in 2D a vertex and no other.
using Hinge = std::array<VertexId, 2>;

template <int D>
Hinge hinge_between(const SimplexVertices<D>& element, int i, int j) {
    Hinge hinge;
    std::size_t n = 0;
    for (int k = 0; k <= D; ++k)
        if (k != i && k != j) hinge[n++] = element[k];
    return hinge;
}

/// The ridges that the file lists, lower vertex first, sorted; in 2D its corners, and the ends of its ridges. An edge
/// that is merely listed is smooth, and its wall goes on.
template <int D>
std::vector<Hinge> listed_features(const LinearMesh<D>& mesh) {
    std::vector<Hinge> features;
    features.reserve(mesh.corners.size() + 2 * mesh.ridges.size());
    if constexpr (D == 3) {
        for (const std::uint32_t ridge : mesh.ridges) {
            const auto& [a, b] = mesh.edges.vertices[ridge];
            features.push_back({std::min(a, b), std::max(a, b)});
        }
    } else {
        for (const VertexId v : mesh.corners) features.push_back({v, {}});
        for (const std::uint32_t f : mesh.ridges)
            for (const VertexId v : mesh.facets.vertices[f]) features.push_back({v, {}});
    }
    std::sort(features.begin(), features.end());
    return features;
}

/// Normal of a face (its size: length, or twice the area), outwards if the element is positive.
Vec<2> normal_of(const Column<Vec<2>>& points, const SimplexVertices<1>& face) {
    const Vec<2> along = points[face[1]] - points[face[0]];
    return {{along[1], -along[0]}};
}
Vec<3> normal_of(const Column<Vec<3>>& points, const SimplexVertices<2>& face) {
    return cross(points[face[1]] - points[face[0]], points[face[2]] - points[face[0]]);
}

/// Whether two vectors turn by less than the angle; none of them 0.
template <int D>
bool turns_less(const Vec<D>& a, const Vec<D>& b, double cosine) {
    const double size = norm(a) * norm(b);
    return size > 0 && dot(a, b) > cosine * size;
}

template <int D>
class Walls {
  public:
    Walls(const LinearMesh<D>& mesh, const ExamineOptions& options, const Examination<D>& x)
        : mesh_(mesh),
          x_(x),
          cosine_(cos(options.ridge_angle_degrees * std::numbers::pi / 180)),
          features_(listed_features(mesh)) {}

    /// Whether two faces are on one wall; what they share.
    [[nodiscard]] std::optional<Hinge> hinge(std::size_t e) const {
        if (!x_.element_counts(e)) return {};
        for (int i = 0; i < D; ++i)
            for (int j = i + 1; j <= D; ++j)
                if (is_one_wall(e, i, j)) return hinge_between<D>(mesh_.elements.vertices[e], i, j);
        return {};
    }

  private:
    [[nodiscard]] bool is_one_wall(std::size_t e, int i, int j) const {
        const std::uint32_t a = x_.neighbours[e][i], b = x_.neighbours[e][j];
        const bool both_outer = a == nobody && b == nobody;
        const auto is_interface = [&](std::uint32_t other) {
            return other < several && mesh_.elements.references[other] != mesh_.elements.references[e];
        };
        if (!both_outer && !(is_interface(a) && is_interface(b))) return false;
        const auto& element = mesh_.elements.vertices[e];
        const auto first = face_of<D>(element, i), second = face_of<D>(element, j);
        if (!turns_less(normal_of(mesh_.points, first), normal_of(mesh_.points, second), cosine_)) return false;
        const Hinge at = hinge_between<D>(element, i, j);
        return reference(first) == reference(second) && !is_feature(at) && facets_at(at) <= 2;
    }

    /// The reference that a face is listed with.
    [[nodiscard]] std::optional<Reference> reference(const SimplexVertices<D - 1>& face) const {
        for (const FacetId f : x_.facets_of[loneliest(face, x_.facets_of)])
            if (has_all(mesh_.facets.vertices[f], face)) return mesh_.facets.references[f];
        return {};
    }

    [[nodiscard]] bool is_feature(Hinge at) const {
        if (D == 3 && at[1] < at[0]) std::swap(at[0], at[1]);
        return std::binary_search(features_.begin(), features_.end(), at);
    }

    /// Where other walls join in, this one breaks.
    [[nodiscard]] std::size_t facets_at(const Hinge& at) const {
        const auto around = x_.facets_of[at[0]];
        return static_cast<std::size_t>(std::count_if(around.begin(), around.end(), [&](FacetId f) {
            return x_.facet_counts(f.index()) && (D == 2 || has(mesh_.facets.vertices[f], at[1]));
        }));
    }

    const LinearMesh<D>& mesh_;
    const Examination<D>& x_;
    double cosine_;
    std::vector<Hinge> features_;
};

}  // namespace

template <int D>
Outcome<Done> examine_walls(const LinearMesh<D>& mesh, const ExamineOptions& options, Examination<D>& x,
                            const Execution& execution) {
    const Walls<D> walls(mesh, options, x);
    auto on_wall = map_each(execution, mesh.elements.size(),
                            [&](std::size_t e) { return static_cast<std::uint8_t>(walls.hinge(e).has_value()); });
    if (!on_wall) return fail(on_wall.error());
    std::vector<WallElement>& found = x.soundness.wall_elements;
    found.clear();
    for (std::size_t e = 0; e < on_wall->size(); ++e)
        if ((*on_wall)[e] == 1) found.push_back({ElementId(e), *walls.hinge(e)});
    if (!found.empty()) x[Defect::wall_element] = {found.size(), found.front().element.index() + 1, 0};
    return Done{};
}

#define CAMBER_INSTANTIATE(D)                                                                             \
    template Outcome<Done> examine_walls<D>(const LinearMesh<D>&, const ExamineOptions&, Examination<D>&, \
                                            const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
