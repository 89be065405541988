module;
#include <algorithm>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>
export module camber.operation:state;
import camber.core;
import camber.metric;
import camber.crossing;
import camber.cavity;
import camber.surface;
import :refusals;
import :vertex_data;

export namespace camber {

/// A mesh that is brought to a metric: an immutable value between two commits.
template <int D>
struct Adaptation {
    DynamicMesh<D> mesh;
    VertexData<D> vertices;
    FacetGrid<D> walls = {};  ///< boxes of its facets, see walls_of
    /// Vertices of the boundary that are off the geometry, new ones among them that could go a part of their way only.
    /// Ids may have come to name others since.
    Column<VertexId> off_geometry = {};
    Refusals refusals = {};
    Column<double> shapes = {};  ///< of elements, shape_of, as far as they are known: others are below 0
    /// Of edges of degree 2, length_of; of degree 1, where measuring costs no more than looking up, no rows.
    Column<double> lengths = {};
};

/// A search for the nodes of inner edges, by the energy or the length.
struct NodeSearch {
    EdgeMinimiserOptions options;
    EdgeRules rules;

    explicit NodeSearch(const EdgeMinimiserOptions& given) : options(given), rules(edge_rules(given)) {}
};

/// Largest distance that facets may have from the geometry (model units).
struct DistanceBound {
    double largest = std::numeric_limits<double>::infinity();
    std::vector<Reference> references = {};  ///< of these facets; empty: of all
};
/// The smallest of the bounds that hold for facets of a reference; infinite where none does.
[[nodiscard]] inline double distance_bound(std::span<const DistanceBound> bounds, Reference reference) {
    double least = std::numeric_limits<double>::infinity();
    for (const DistanceBound& bound : bounds)
        if (bound.references.empty() || std::ranges::find(bound.references, reference) != bound.references.end())
            least = std::min(least, bound.largest);
    return least;
}

/// What the mesh is brought to: the field, which new vertices ask for theirs, and the geometry on which those of the
/// boundary lie (none: the mesh's own straight facets).
template <int D>
struct AdaptationGoal {
    BackMesh<D> field;
    std::optional<Geometry<D>> geometry;
    // Of degree 2, where inner nodes are wanted: by a search, or without one by the closed form of accuracy.
    EdgeAccuracyOptions accuracy = {};
    std::optional<NodeSearch> search = {};
    /// Of degree 2, where the topology stays: where the node of each edge is wanted, the boundary's too. Then neither
    /// the field nor the geometry is asked.
    Column<LagrangeNode<D>> wanted = {};
    /// Every patch keeps these bounds, or its facets exceed them by no more than the facets that it removes.
    std::vector<DistanceBound> distance_bounds = {};
    EmbeddedCurves<D> curves = {};  ///< on which the mesh's embedded lines lie
    /// A pass that comes beyond it ends with an error (memory): no field that asks for more than anybody expected takes
    /// the machine along.
    std::size_t max_elements = max_entities;
};

/// The mesh with its metric at each vertex, which is asked of the field; of a surface alone see make_dynamic_surface.
/// Errors: a mesh without elements or triangles (input), those of make_dynamic.
template <int D>
[[nodiscard]] Outcome<Adaptation<D>> begin_adaptation(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                      const BreaksOfMesh& breaks, const AdaptationGoal<D>& goal,
                                                      const Execution& execution);

/// The same of a mesh of degree 2. Errors: also a surface alone (unsupported).
template <int D>
[[nodiscard]] Outcome<Adaptation<D>> begin_adaptation(const QuadraticMesh<D>& mesh, const BreaksOfMesh& breaks,
                                                      const AdaptationGoal<D>& goal, const Execution& execution);

/// The boxes of all facets; of a surface alone of its triangles.
template <int D>
[[nodiscard]] FacetGrid<D> walls_of(const DynamicMesh<D>& mesh);

/// `lengths` anew, of a mesh whose nodes were not changed by commits. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<Done> measure_lengths(Adaptation<D>& r, const Execution& execution);

}  // namespace camber
