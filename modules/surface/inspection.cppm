module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <vector>
export module camber.surface:inspection;
import camber.core;
import :features;

/// What the boundary of a mesh is, and where it is doubtful what it ought to be.
export namespace camber {

/// A smooth piece.
struct PatchFacts {
    std::vector<Reference> references;             ///< rising
    std::size_t facets = 0, interface_facets = 0;  ///< those with elements on both sides
    double area = 0, size = 0;  ///< of the straight facets, 2D their length; the diagonal of their box
    bool is_flat = false;       ///< in one plane, 2D on one line, to 1e-12 of the size
};

/// A chain of ridge edges between corners (3D).
struct CurveFacts {
    std::size_t edges = 0;
    double length = 0;
    double min_turn = 0, largest_turn = 0;  ///< degrees between its two facets, of edges that have two
    std::vector<Reference> references;      ///< of the facets beside it, rising
};

/// Facets turn by 0 degrees where they are in one plane, and by 180 where they lie on each other.
enum class Suspicion : std::uint8_t {
    near_ridge,      ///< an edge (2D: a vertex) that turns by nearly as much as a ridge
    mild_ridge,      ///< a ridge by its angle alone that turns by little more than is asked for
    knife_edge,      ///< facets that nearly lie on each other
    tip,             ///< all facets of a vertex are steep to its normal: the tip of a cone
    spread_normals,  ///< some are
    turned_facet,    ///< a facet's own normal is far from those of its vertices
};
inline constexpr std::size_t suspicion_count = 6;
[[nodiscard]] constexpr auto words(Suspicion) {
    return words_of(Word{Suspicion::near_ridge, "near_ridge"}, Word{Suspicion::mild_ridge, "mild_ridge"},
                    Word{Suspicion::knife_edge, "knife_edge"}, Word{Suspicion::tip, "tip"},
                    Word{Suspicion::spread_normals, "spread_normals"}, Word{Suspicion::turned_facet, "turned_facet"});
}

/// One such place.
template <int D>
struct Suspect {
    Suspicion what = Suspicion::near_ridge;
    double degrees = 0;  ///< of the turn, or of the farthest normal
    Vec<D> point;
    std::vector<VertexId> vertices;  ///< of the edge, the vertex or the facet
    std::vector<FacetId> facets;     ///< beside or around it
};

/// When a place is suspicious; angles in degrees.
struct InspectionLimits {
    double ridge_angle = 40;
    double near = 0.75;       ///< a turn from this share of the ridge angle up is near it, and up to 1/near beyond
    double knife_edge = 150;  ///< a turn from here up
    double normals = 40;      ///< a normal farther than this from that of its vertex
};

template <int D>
struct BoundaryInspection {
    std::vector<PatchFacts> patches;  ///< by their numbers in Features
    std::vector<CurveFacts> curves;   ///< 3D
    std::vector<VertexId> corners;
    std::size_t smooth_listed_edges = 0;  ///< edges that the file lists and that are no ridges (3D)
    std::size_t interface_facets = 0;     ///< with elements on both sides
    std::size_t lone_facets = 0;          ///< with none, where there are elements
    /// Edges (2D: vertices, twice the same) of one facet, of more than two, and where two facets are turned to
    /// different sides, with these.
    std::vector<std::array<VertexId, 2>> open, crowded;
    struct Turned {
        std::array<VertexId, 2> edge;
        std::array<FacetId, 2> facets;
    };
    std::vector<Turned> turned;
    std::vector<Suspect<D>> suspects;  ///< the worst of a kind first
};

/// Errors: `edges` or `features` are not of this mesh (internal), stopped.
template <int D>
[[nodiscard]] Outcome<BoundaryInspection<D>> inspect_boundary(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                              const Features<D>& features,
                                                              const InspectionLimits& limits,
                                                              const Execution& execution);

}  // namespace camber

namespace camber {

/// Facets that meet: at an edge, in 2D at a vertex (twice the same).
template <int D>
struct Hinge {
    std::array<VertexId, 2> ends;
    std::vector<FacetId> facets;
    bool is_ridge = false, is_listed = false;  ///< is_listed: the file says that it is one
    std::uint32_t curve = no_feature;
};
template <int D>
[[nodiscard]] Outcome<std::vector<Hinge<D>>> find_hinges(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                         const Features<D>& features, const Execution& execution);

/// By how many degrees two facets turn at a hinge, whichever way their vertices go round.
template <int D>
[[nodiscard]] double turn_at(const LinearMesh<D>& mesh, const Hinge<D>& hinge);

/// Errors: stopped.
template <int D>
[[nodiscard]] Outcome<std::vector<Suspect<D>>> find_suspects(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                             const Features<D>& features,
                                                             const std::vector<Hinge<D>>& hinges,
                                                             const InspectionLimits& limits,
                                                             const Execution& execution);

}  // namespace camber
