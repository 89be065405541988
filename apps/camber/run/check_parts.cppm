module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>
module camber.run:check_parts;
import camber.core;
import camber.validity;
import camber.soundness;
import camber.recipes;
import :check;
import :file_numbers;

namespace camber::run {

/// "valid", "invalid", "undecided".
[[nodiscard]] constexpr std::string_view word(Verdict verdict) {
    return verdict == Verdict::valid ? "valid" : verdict == Verdict::invalid ? "invalid" : "undecided";
}

/// As the file numbers what was found.
[[nodiscard]] SoundnessReport soundness_report(Soundness soundness, const FileNumbers& numbers);

/// Facets that cross, as the file numbers them; those of the `given` mesh, where it lists any.
template <int D>
[[nodiscard]] CrossingsReport crossings_report(const LinearMesh<D>& given, const CheckedWalls<D>& walls,
                                               const FileNumbers& numbers);

/// Elements that overlap, as the file numbers them.
template <int D>
[[nodiscard]] OverlapsReport overlaps_report(const LinearMesh<D>& given, const Overlaps<D>& overlaps,
                                             const FileNumbers& numbers);

/// "triangles 3 and 14 overlap at (0.25, 0.5)".
[[nodiscard]] std::string overlap_text(const OverlapReport& overlap, const MeshReport& mesh);

/// A mesh and what is known of its elements.
template <int D>
struct Judged {
    const QuadraticMesh<D>& mesh;
    const Validation<D>& validation;
    const ElementColumns& columns;
    const Soundness& soundness;
    const FileNumbers& numbers;
    int degree = 2;
};

/// The n worst elements: those not valid first, then by their smallest scaled Jacobian (degree 2) or their quality.
template <int D>
[[nodiscard]] Outcome<std::vector<ElementReport>> find_worst_elements(const Judged<D>& judged, std::size_t n,
                                                                      const Execution& execution);

template <int D>
[[nodiscard]] std::array<Vec<D>, D + 1> corners_of(const LinearMesh<D>& mesh, std::size_t e) {
    std::array<Vec<D>, D + 1> corners;
    for (int i = 0; i <= D; ++i) corners[i] = mesh.points[mesh.elements.vertices[e][i]];
    return corners;
}

/// Of a triangle of a surface alone.
[[nodiscard]] inline std::array<Vec<3>, 3> triangle_corners(const LinearMesh<3>& mesh, std::size_t t) {
    const auto& v = mesh.facets.vertices[t];
    return {mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]]};
}

}  // namespace camber::run
