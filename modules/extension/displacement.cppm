module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>
export module camber.extension:displacement;
import camber.core;
import :parts;

export namespace camber {

/// Sums over the rows of a run after a step.
struct ExtensionSums {
    double by_product = 0;  ///< correction · product
    double by_residual = 0;
    double largest = 0;  ///< largest correction, as a share of the height
    double joined = 0;   ///< number of rows that have joined

    friend ExtensionSums operator+(const ExtensionSums& a, const ExtensionSums& b) {
        return {a.by_product + b.by_product, a.by_residual + b.by_residual, std::max(a.largest, b.largest),
                a.joined + b.joined};
    }
};

/// Products of the search direction d: dᵀA d and dᵀr.
struct AlongDirection {
    double curvature = 0, slope = 0;

    friend AlongDirection operator+(const AlongDirection& a, const AlongDirection& b) {
        return {a.curvature + b.curvature, a.slope + b.slope};
    }
};

/// The straight simplices of dimension S in space D over which a displacement is extended, and their edges.
template <int S, int D>
struct ExtensionDomain {
    const Column<Vec<D>>& points;
    const Column<SimplexVertices<S>>& simplices;
    const EdgeSet<S>& edges;
};
/// Returns the elements of a mesh as a domain.
template <int D>
[[nodiscard]] ExtensionDomain<D, D> elements_of(const QuadraticMesh<D>& mesh) {
    return {mesh.linear.points, mesh.linear.elements.vertices, mesh.edges};
}

/// The equations of an extension for the edges of one part of its domain, as far as the displacement reaches.
template <int S, int D>
class ExtensionPart {
  public:
    /// Nodes of edges of kind `volume` are unknowns, all others are given by `boundary_nodes`, one an edge. Errors:
    /// columns that do not fit the domain (internal), stopped, memory. All arguments must outlive it.
    [[nodiscard]] static Outcome<ExtensionPart> make(const ExtensionDomain<S, D>& domain, const Column<EdgeKind>& kinds,
                                                     std::span<const LagrangeNode<D>> boundary_nodes,
                                                     const Incidence<ElementId>& shells, const OwnVertices& own,
                                                     const Execution& execution);
    ExtensionPart(const ExtensionPart&) = delete;
    ExtensionPart& operator=(const ExtensionPart&) = delete;
    ExtensionPart(ExtensionPart&&) noexcept;
    ExtensionPart& operator=(ExtensionPart&&) noexcept;
    ~ExtensionPart();

    /// True if a given node is not at the middle of its chord.
    [[nodiscard]] bool is_displaced() const;
    /// Returns Σ |det| and the number of simplices for each run.
    [[nodiscard]] Outcome<std::vector<double>> volume_and_count(const Execution& execution) const;

    /// Moves the given nodes and starts a row for each unknown beside them. `mean`: mean |det| over the whole domain.
    [[nodiscard]] Outcome<Done> begin(double mean, double stiffening, const Execution& execution);
    /// Moves the nodes along the direction. Returns the sums of each run.
    [[nodiscard]] Outcome<std::vector<ExtensionSums>> step(double length, double tolerance, const Execution& execution);
    /// Sets the next direction: the correction plus `turn` times the last direction. Rows that have joined move from
    /// now on.
    [[nodiscard]] Outcome<Done> turn_by(double turn, const Execution& execution);
    /// Starts rows around the edges that have joined, in this part or in others (`of_others`).
    [[nodiscard]] Outcome<Done> join(std::span<const EdgeId> of_others, const Execution& execution);
    /// Multiplies the direction by the matrix. Returns the products of each run.
    [[nodiscard]] Outcome<std::vector<AlongDirection>> multiply(const Execution& execution);

    [[nodiscard]] std::span<Vec<D>> directions();                  ///< one an edge
    [[nodiscard]] const std::vector<EdgeId>& joined_last() const;  ///< rising in each batch
    [[nodiscard]] std::size_t moving() const;                      ///< number of rows that move
    /// Returns the nodes, one an edge; only those of edges that it owns are final. Empties the part. Errors: stopped,
    /// memory.
    [[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> nodes(const Execution& execution) &&;

  private:
    struct Impl;
    explicit ExtensionPart(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

/// Options of an extension.
struct ExtensionOptions {
    /// Largest correction of a Jacobi step at the end, as a share of the smallest height of the simplices around the
    /// edge. det (I + ∇u) then has an error of about that size, in layers of any anisotropy.
    double tolerance = 1e-3;
    int max_iterations = 1000;
    /// Exponent s of the weight (mean |det| / |det|)^s of a straight simplex. 0 is the Dirichlet energy; larger values
    /// make small simplices stiffer, so that large ones take up the deformation.
    double stiffening = 2;
};

/// Result of an extension.
template <int D>
struct Extension {
    Buffer<LagrangeNode<D>> nodes;  ///< one an edge
    int iterations = 0;
    double correction = 0;   ///< largest correction at the end, measured as the tolerance is
    std::size_t solved = 0;  ///< number of unknowns that were solved for; all others are straight
};

/// Extends a displacement over simplices: `given_nodes` (one an edge) holds the nodes of all edges that are not of kind
/// `volume`, displaced from the middles of their chords. The nodes of the other edges get the displacement u that
/// minimises Σ w_K ∫_K |∇u|² dx over the straight simplices, u in the space of the quadratic edge functions 4 ξ_i ξ_j
/// (vertices stay). Where S = D, det (I + ∇u) is the scaled Jacobian; where S < D, ∇u is taken in the simplex's plane.
/// Since the gradient is taken in space, u varies least across thin simplices: a stack of layers moves with its wall.
/// The system is solved by conjugate gradients, with rows where the displacement exceeds the tolerance; the result has
/// the same bytes for any number of threads. Errors: columns that do not fit the domain (internal), stopped.
template <int S, int D>
[[nodiscard]] Outcome<Extension<D>> extend_displacement(const ExtensionDomain<S, D>& domain,
                                                        const Column<EdgeKind>& kinds,
                                                        const Column<LagrangeNode<D>>& given_nodes,
                                                        const Incidence<ElementId>& shells,
                                                        const ExtensionOptions& options, const Execution& execution);

/// Extends the displacement of the boundary's nodes over the elements of a mesh.
template <int D>
[[nodiscard]] Outcome<Extension<D>> extend_boundary(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                                    const Column<LagrangeNode<D>>& boundary_nodes,
                                                    const Incidence<ElementId>& shells, const ExtensionOptions& options,
                                                    const Execution& execution) {
    return extend_displacement(elements_of(mesh), kinds, boundary_nodes, shells, options, execution);
}

/// The smooth faces of a boundary.
struct Faces {
    Buffer<std::uint8_t> facets;  ///< 1: the facet is part of a face
    Buffer<std::uint8_t> inside;  ///< by edge; 1: inside a face, not on its curves
};

/// Displacements of edge nodes inside faces.
struct FaceShifts {
    std::vector<EdgeId> edges;   ///< those that are displaced, rising within each face
    std::vector<Vec<3>> shifts;  ///< one each
};

/// Extends displacements over the triangles of each face separately, with the weight 1/area: the result for a face does
/// not depend on the others. `given(facet, edge)`: the displacement of an edge that is not inside a face, as the face
/// of the facet sees it. Errors: stopped, memory.
[[nodiscard]] Outcome<FaceShifts> extend_over_triangles(const LinearMesh<3>& mesh, const EdgeSet<3>& edges,
                                                        const Faces& faces,
                                                        const std::function<Vec<3>(FacetId, EdgeId)>& given,
                                                        const Execution& execution);

/// Result of a solve.
struct ExtensionSolve {
    int iterations = 0;
    double correction = 0;  ///< largest correction at the end, measured as the tolerance is
};
/// Solves for the parts of a domain that this process has. The parts are new, and at least one part of the domain is
/// displaced. Conjugate gradients with the diagonal as preconditioner; the D components share their steps. Rows join
/// when the residual reaches them, so each direction is made conjugate to the last by the product itself (Polak and
/// Ribière). Sums are added in the order of the parts, on any number of processes.
template <int S, int D>
[[nodiscard]] Outcome<ExtensionSolve> solve_extension(std::span<ExtensionPart<S, D>> parts, BetweenParts<D>& between,
                                                      const ExtensionOptions& options, const Execution& execution);

}  // namespace camber
