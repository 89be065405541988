module;
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
export module camber.surface:fit;
import camber.core;

export namespace camber {

/// Largest distance of a boundary vertex from its surface or curve, as a share of the shortest boundary edge at the
/// vertex. A vertex farther away is off.
inline constexpr double off_limit = 0.05;

/// Largest share of the vertices of one surface or curve that may be off. More of them mean that the mesh was made on
/// another surface.
inline constexpr double off_vertices = 0.02;

/// To three significant digits.
[[nodiscard]] inline std::string three_digits(double number) {
    std::array<char, 32> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number, std::chars_format::general, 3);
    return {digits.data(), end.ptr};
}

/// Lengths of the boundary edges at a vertex.
struct EdgeLengthsAt {
    double shortest = 0, longest = 0;
};
/// Those of the edges of these facets (at least one).
template <int D>
[[nodiscard]] EdgeLengthsAt edge_lengths_at(const LinearMesh<D>& mesh, std::span<const FacetId> facets, VertexId v) {
    EdgeLengthsAt out{std::numeric_limits<double>::infinity(), 0};
    for (const FacetId f : facets)
        for (const VertexId other : mesh.facets.vertices[f]) {
            if (other == v) continue;
            const double length = distance(mesh.points[v], mesh.points[other]);
            out = {std::fmin(out.shortest, length), std::fmax(out.longest, length)};
        }
    return out;
}

/// The vertices of a mesh on one surface or curve, and those of them that are off.
struct VertexFit {
    std::size_t vertices = 0, off = 0;
    std::size_t lost = 0;            ///< off by more than half of their longest edge
    double largest = 0, length = 0;  ///< the largest distance, and the shortest edge at that vertex
    VertexId farthest = {};

    void add(VertexId v, double distance, const EdgeLengthsAt& edges) {
        constexpr double half = 0.5;
        ++vertices;
        if (distance <= off_limit * edges.shortest) return;
        const double far = std::isnan(distance) ? std::numeric_limits<double>::infinity() : distance;
        const std::size_t is_lost = far <= half * edges.longest ? 0 : 1;
        add({0, 1, is_lost, far, edges.shortest, v});
    }
    /// Adds other vertices of the same surface. Of equally far ones the first is reported, in any order of addition.
    void add(const VertexFit& others) {
        vertices += others.vertices;
        off += others.off;
        lost += others.lost;
        if (others.off == 0 || others.largest < largest) return;
        if (off > others.off && others.largest == largest && farthest < others.farthest) return;
        largest = others.largest;
        length = others.length;
        farthest = others.farthest;
    }
    /// Whether too many vertices are off. Less than the vertices of one facet of `facet_vertices` vertices say nothing
    /// about a surface: a mesher may have merged a small edge.
    [[nodiscard]] bool is_refused(std::size_t facet_vertices) const {
        return off >= facet_vertices && static_cast<double>(off) > off_vertices * static_cast<double>(vertices);
    }
    /// The sentence about the farthest vertex, and how many are off; `name`: that of the surface or curve.
    [[nodiscard]] std::string text(std::string_view name) const {
        return "is " + three_digits(largest) + " away from " + std::string(name) + ", " +
               three_digits(100 * largest / length) + " % of the shortest boundary edge there; " + std::to_string(off) +
               " of the " + std::to_string(vertices) + " vertices of the mesh on " + std::string(name) +
               " are off by more than " + three_digits(100 * off_limit) + " % of that length";
    }
};

/// How far a vertex may be from the boundary of another mesh, as a share of the facet's longest edge.
inline constexpr double fit_tolerance = 0.1;

/// A vertex that is farther than that.
struct Misfit {
    double distance = 0, allowed = 0;
    VertexId vertex = {};
    Reference reference = 0;
};
/// The farther one; of equally far ones the first, whatever the order in which they are met.
[[nodiscard]] inline Misfit worse(const Misfit& a, const Misfit& b) {
    if (a.distance != b.distance) return a.distance > b.distance ? a : b;
    return b.distance > 0 && b.vertex < a.vertex ? b : a;
}

/// Distances of facets from the boundary of another mesh. A mesh that was adapted to thin layers may have left single
/// vertices short of the surface: those of one facet in a hundred may be beyond the tolerance, but by less than half of
/// their edges.
struct BoundaryFit {
    std::size_t facets = 0, off = 0;
    Misfit worst;

    /// One more facet; a misfit of no distance: on the surface.
    void add(const Misfit& misfit) {
        ++facets;
        off += misfit.distance > 0 ? 1 : 0;
        worst = worse(worst, misfit);
    }
    void add(const BoundaryFit& others) {
        facets += others.facets;
        off += others.off;
        worst = worse(worst, others.worst);
    }
    /// The worst one, where there are too many of them or it is too far.
    [[nodiscard]] std::optional<Misfit> refused() const {
        constexpr std::size_t most = 100;
        constexpr double farthest = 0.5 / fit_tolerance;
        if (off * most <= facets && !(worst.distance > farthest * worst.allowed)) return {};
        return worst;
    }
};

}  // namespace camber
