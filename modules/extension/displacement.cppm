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

struct ExtensionSums {
    double by_product = 0;  ///< Σ c · A d over the unknowns: correction c, matrix A, search direction d
    double by_residual = 0;
    double largest = 0;  ///< largest |c|, relative to the smallest height of simplices at the edge
    double joined = 0;   ///< number of nodes that start to move

    friend ExtensionSums operator+(const ExtensionSums& a, const ExtensionSums& b) {
        return {a.by_product + b.by_product, a.by_residual + b.by_residual, std::max(a.largest, b.largest),
                a.joined + b.joined};
    }
};

struct AlongDirection {
    double curvature = 0, slope = 0;

    friend AlongDirection operator+(const AlongDirection& a, const AlongDirection& b) {
        return {a.curvature + b.curvature, a.slope + b.slope};
    }
};

template <int S, int D>
struct ExtensionDomain {
    const Column<Vec<D>>& points;
    const Column<SimplexVertices<S>>& simplices;
    const EdgeSet<S>& edges;
};
template <int D>
[[nodiscard]] ExtensionDomain<D, D> elements_of(const QuadraticMesh<D>& mesh) {
    return {mesh.linear.points, mesh.linear.elements.vertices, mesh.edges};
}

/// Linear system of one part of a domain. Its unknowns are the edge nodes that the displacement reaches.
template <int S, int D>
class ExtensionPart {
  public:
    /// Nodes of edges of kind `volume` are unknowns; `boundary_nodes` (one per edge) prescribes the nodes of all other
    /// edges. All arguments must outlive the part. Errors: wrong row counts (internal), stopped, memory.
    [[nodiscard]] static Outcome<ExtensionPart> make(const ExtensionDomain<S, D>& domain, const Column<EdgeKind>& kinds,
                                                     std::span<const LagrangeNode<D>> boundary_nodes,
                                                     const Incidence<ElementId>& shells, const OwnVertices& own,
                                                     const Execution& execution);
    ExtensionPart(const ExtensionPart&) = delete;
    ExtensionPart& operator=(const ExtensionPart&) = delete;
    ExtensionPart(ExtensionPart&&) noexcept;
    ExtensionPart& operator=(ExtensionPart&&) noexcept;
    ~ExtensionPart();

    /// True if a prescribed node is not at the middle of its chord.
    [[nodiscard]] bool is_displaced() const;
    /// Returns two numbers for each run (see `OwnVertices`): the sum of |det J| over its simplices, with Jacobian
    /// matrices J, and the number of simplices.
    [[nodiscard]] Outcome<std::vector<double>> volume_and_count(const Execution& execution) const;

    /// Applies the prescribed displacements. Creates a matrix row for each unknown of the simplices around the
    /// displaced edges. `mean`: mean |det J| over the whole domain.
    [[nodiscard]] Outcome<Done> begin(double mean, double stiffening, const Execution& execution);
    /// Moves each node by `length` times its search direction. Returns the sums of each run.
    [[nodiscard]] Outcome<std::vector<ExtensionSums>> step(double length, double tolerance, const Execution& execution);
    /// Replaces the search direction d by the correction plus `turn` · d. The nodes of `joined_last` move from now on.
    [[nodiscard]] Outcome<Done> update_direction(double turn, const Execution& execution);
    /// Creates rows for the unknowns around the nodes of `joined_last`. `of_others`: edges whose nodes start to move in
    /// other parts.
    [[nodiscard]] Outcome<Done> join(std::span<const EdgeId> of_others, const Execution& execution);
    /// Returns dᵀA d and dᵀr of each run, for the matrix A, search direction d and residual r.
    [[nodiscard]] Outcome<std::vector<AlongDirection>> multiply(const Execution& execution);

    [[nodiscard]] std::span<Vec<D>> directions();                  ///< one per edge
    [[nodiscard]] const std::vector<EdgeId>& joined_last() const;  ///< edges whose nodes start to move after the last
                                                                   ///< step
    [[nodiscard]] std::size_t moving() const;
    /// Returns the nodes, one per edge; only nodes of owned edges are final. Empties the part. Errors: stopped, memory.
    [[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> nodes(const Execution& execution) &&;

  private:
    struct Impl;
    explicit ExtensionPart(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

struct ExtensionOptions {
    /// Iterations stop when no Jacobi correction of a node exceeds this share of the smallest height of simplices
    /// around its edge. The share is about the error of det (I + ∇u) for the displacement u, at any anisotropy.
    double tolerance = 1e-3;
    int max_iterations = 1000;
    /// Exponent s of a simplex's weight (mean |det J| / |det J|)^s, with its Jacobian matrix J. s = 0 gives the
    /// Dirichlet energy. Larger s makes small simplices stiffer, so that large simplices deform.
    double stiffening = 2;
};

template <int D>
struct Extension {
    Buffer<LagrangeNode<D>> nodes;  ///< one per edge
    int iterations = 0;
    double correction = 0;   ///< largest correction in the last iteration, see `ExtensionOptions::tolerance`
    std::size_t solved = 0;  ///< number of nodes that moved; all other edges of kind `volume` are straight
};

/// Computes the nodes of all edges from the nodes of some edges. The displacement u of nodes from chord middles is
/// interpolated by the edge functions 4 ξ_i ξ_j (vertices are fixed). `prescribed_nodes` (one per edge) contains the
/// nodes of edges that are not of kind `volume`. The other nodes minimise Σ w_K ∫_K |∇u|² dx over the straight
/// simplices K. `ExtensionOptions::stiffening` defines the weights w_K.
///
/// For S = D, det (I + ∇u) is the scaled Jacobian. For S < D, ∇u is the gradient in the plane of the simplex. u varies
/// least across thin simplices, so layers move with their wall. Conjugate gradients solve only for the nodes that the
/// displacement reaches within the tolerance. The result is bitwise equal for any number of threads. Errors: wrong row
/// counts (internal), stopped.
template <int S, int D>
[[nodiscard]] Outcome<Extension<D>> extend_displacement(const ExtensionDomain<S, D>& domain,
                                                        const Column<EdgeKind>& kinds,
                                                        const Column<LagrangeNode<D>>& prescribed_nodes,
                                                        const Incidence<ElementId>& shells,
                                                        const ExtensionOptions& options, const Execution& execution);

template <int D>
[[nodiscard]] Outcome<Extension<D>> extend_boundary(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                                    const Column<LagrangeNode<D>>& boundary_nodes,
                                                    const Incidence<ElementId>& shells, const ExtensionOptions& options,
                                                    const Execution& execution) {
    return extend_displacement(elements_of(mesh), kinds, boundary_nodes, shells, options, execution);
}

struct Faces {
    Buffer<std::uint8_t> facets;  ///< one per facet; 1: part of a face
    Buffer<std::uint8_t> inside;  ///< one per edge; 1: inside a face, not on a curve that bounds it
};

struct FaceShifts {
    std::vector<EdgeId> edges;
    std::vector<Vec<3>> shifts;
};

/// Extends displacements of edges on curves over each face separately, as `extend_displacement` does; a triangle has
/// the weight 1/area. `input(facet, edge)` returns the displacement of an edge on a curve. It may differ between the
/// faces beside the curve; `facet` selects the face. Errors: stopped, memory.
[[nodiscard]] Outcome<FaceShifts> extend_over_triangles(const LinearMesh<3>& mesh, const EdgeSet<3>& edges,
                                                        const Faces& faces,
                                                        const std::function<Vec<3>(FacetId, EdgeId)>& input,
                                                        const Execution& execution);

struct ExtensionSolve {
    int iterations = 0;
    double correction = 0;  ///< largest correction in the last iteration, see `ExtensionOptions::tolerance`
};
/// Solves the linear system of all parts; `parts` are those of this process. The parts must be new, and a prescribed
/// node must be displaced. Uses conjugate gradients with a diagonal preconditioner; the D components share their step
/// lengths.
///
/// Nodes start to move when the residual reaches them. Each new direction is therefore made conjugate with the product
/// A d of the matrix A and the last direction d (Polak and Ribière). Sums are added in the order of parts, on any
/// number of processes.
template <int S, int D>
[[nodiscard]] Outcome<ExtensionSolve> solve_extension(std::span<ExtensionPart<S, D>> parts,
                                                      PartCommunication<D>& between, const ExtensionOptions& options,
                                                      const Execution& execution);

}  // namespace camber
