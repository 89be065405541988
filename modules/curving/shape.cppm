module;
#include <cstddef>
export module camber.curving:shape;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;
import :extension;

export namespace camber {

/// How far the shape of elements is evened out.
struct ShapeOptions {
    ExtensionOptions extension;
    /// Of the programmes. Without cuts elements count by their coefficients, which are close where shapes are good.
    EdgeProgrammeOptions programme{.tolerance = 1e-3, .max_cuts = 0};
    double enough = 0.95;    ///< elements with such a scaled Jacobian are let be
    double min_gain = 1e-3;  ///< a step must raise the smallest scaled Jacobian around its edge by so much
    /// Elements are raised together that are less than this above the worst, of max(1, |worst|).
    double band = 0.02;
    int rings = 2;               ///< of elements that are raised with the worst, where these alone do not rise
    std::size_t max_steps = 20;  ///< in one band, for each of its elements
    int max_bands = 100;
};

/// What `shape` came to.
template <int D>
struct Shaped {
    Proposal<D> proposal;
    int iterations = 0;          ///< of the linear extension
    std::size_t solved = 0;      ///< edges that it was solved for
    std::size_t steps = 0;       ///< nodes moved by programmes
    double after_extension = 0;  ///< smallest scaled Jacobian of the mesh, at most `enough`
    double smallest = 0;         ///< the same in the end
};

/// The second verb with the elements' shape as its aim, for a mesh without a field: boundary edges take
/// `boundary_nodes`, and nodes of volume edges are put so that the scaled Jacobian is as even as it may: by the linear
/// extension of the boundary's displacement, then by programmes of single edges, worst elements first, each of which
/// raises the smallest scaled Jacobian around its edge as far as that edge can, until all have `enough` or the worst
/// cannot be raised. The same bytes for any number of threads. Errors: as extend_boundary.
template <int D>
[[nodiscard]] Outcome<Shaped<D>> shape(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                       const Column<LagrangeNode<D>>& boundary_nodes,
                                       const Incidence<ElementId>& shells, const ShapeOptions& options,
                                       const Execution& execution);

}  // namespace camber
