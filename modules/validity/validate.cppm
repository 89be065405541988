module;
#include <cstddef>
#include <span>
#include <utility>
#include <vector>
export module camber.validity:validate;
import camber.core;
import camber.bezier;
import :jacobian;
import :verdict;

export namespace camber {

/// Minimum det J / |det straight| of valid elements, including rounding errors (paper §4.3).
inline constexpr double min_bound = 1e-9;
/// Recommended value: suitable for solvers, reachable at low cost (bench/results/bounds.md).
inline constexpr double default_bound = 0.1;
/// Target of the repair without a metric or solution (docs/algorithms/repair.md).
inline constexpr double target_without_metric = 0.6;

struct JacobianBound {
    double value = default_bound;
    bool is_explicit = false;

    constexpr JacobianBound() = default;
    [[nodiscard]] static constexpr JacobianBound recommended(double value) {
        JacobianBound bound;
        bound.value = value;
        return bound;
    }
    constexpr JacobianBound(double requested) : value(requested), is_explicit(true) {}  // NOLINT(*-explicit-*)
    [[nodiscard]] constexpr operator double() const { return value; }                   // NOLINT(*-explicit-*)
    friend constexpr bool operator==(const JacobianBound&, const JacobianBound&) = default;
};

/// S must have a member `min_scaled_jacobian`.
template <class S>
[[nodiscard]] constexpr Option<S, JacobianBound> bound_option() {
    return option("min_scaled_jacobian", &S::min_scaled_jacobian,
                  "an element is good enough if its Jacobian determinant is everywhere at least this share of the "
                  "straight element's. Elements below it are a failure. null: the value of an earlier stage, else "
                  "0.1, with only a note about elements below it")
        .at_least(0)
        .below(1);
}

/// Verdicts of a mesh. For standalone surface meshes, elements are triangles.
template <int D>
struct Validation {
    double bound = 0;  ///< bound for the verdicts
    Column<Verdict> verdicts;
    /// Certified lower bounds of det J / |det straight|. A value is within 1e-3 of the minimum (see ElementValidity) if
    /// the coefficients alone did not decide, or if the minimum of the mesh may occur in the element. Other values are
    /// the smallest coefficient. Flat straight elements have ±∞.
    Column<float> min_scaled_jacobian;
    std::size_t invalid = 0, undecided = 0;
    /// Elements for which det J > 0 is not certified, ascending: `invalid` if it is refuted, else `undecided`.
    std::vector<std::pair<ElementId, Verdict>> not_positive;
    std::size_t straight_inverted = 0;  ///< elements with a flat or inverted straight element
    double smallest = 1;  ///< minimum of min_scaled_jacobian without flat elements; within 1e-3 of the true minimum
    ElementId worst;      ///< element with the value `smallest`, if any

    [[nodiscard]] std::size_t not_valid() const { return invalid + undecided; }
    [[nodiscard]] bool all_valid() const { return not_valid() == 0; }  ///< true if all elements are valid for the bound
    [[nodiscard]] bool certified() const { return not_positive.empty(); }  ///< det J > 0 everywhere
    friend bool operator==(const Validation&, const Validation&) = default;
};

/// A proposal with its mesh and all verdicts. Only `validate` and functions that use its results (`relax`, `repair`)
/// create judged proposals, so the verdicts match the nodes. `commit` accepts nothing else.
template <int D>
class JudgedProposal {
  public:
    [[nodiscard]] const QuadraticMesh<D>& mesh() const { return mesh_; }  ///< the mesh before the proposal
    [[nodiscard]] const Proposal<D>& proposal() const { return proposal_; }
    [[nodiscard]] const Validation<D>& validation() const { return validation_; }

    /// Returns a copy with other edge kinds, which do not influence the verdicts.
    [[nodiscard]] JudgedProposal with_kinds(Column<EdgeKind> kinds) const {
        JudgedProposal other = *this;
        other.proposal_.kinds = std::move(kinds);
        return other;
    }
    friend bool operator==(const JudgedProposal&, const JudgedProposal&) = default;

    /// Judges the proposed nodes relative to the straight elements with the proposed points. Errors: a proposal of
    /// another mesh (internal), stopped.
    [[nodiscard]] static Outcome<JudgedProposal> judge(QuadraticMesh<D> mesh, Proposal<D> proposal, double bound,
                                                       const Execution& execution);

    /// Judges other nodes with the same vertices; `touched` must include all elements with a changed node.
    [[nodiscard]] Outcome<JudgedProposal> judge_again(Proposal<D> proposal, std::span<const ElementId> touched,
                                                      const Execution& execution) const;

  private:
    JudgedProposal(QuadraticMesh<D> mesh, Proposal<D> proposal, Validation<D> validation)
        : mesh_(std::move(mesh)), proposal_(std::move(proposal)), validation_(std::move(validation)) {}

    QuadraticMesh<D> mesh_;
    Proposal<D> proposal_;
    Validation<D> validation_;
};

/// See JudgedProposal::judge.
template <int D>
[[nodiscard]] inline Outcome<JudgedProposal<D>> validate(QuadraticMesh<D> mesh, Proposal<D> proposal, double bound,
                                                         const Execution& execution) {
    return JudgedProposal<D>::judge(std::move(mesh), std::move(proposal), bound, execution);
}

template <int D>
[[nodiscard]] Outcome<Validation<D>> validate(const QuadraticMesh<D>& mesh, double bound, const Execution& execution);

template <int D>
[[nodiscard]] inline NodalSimplex<D> nodal_element(const QuadraticMesh<D>& mesh,
                                                   std::span<const LagrangeNode<D>> mid_nodes, ElementId e) {
    return nodal_form<D>(mesh.linear.points, mid_nodes, mesh.linear.elements.vertices[e], mesh.edges.of_elements[e]);
}

/// A committed mesh. Its entity maps are identities, because the topology is unchanged.
template <int D>
struct Committed {
    QuadraticMesh<D> mesh;
    MeshMaps maps;
};

/// Commits the positions if det J > 0 is certified everywhere; callers check higher bounds
/// (`validation().all_valid()`). Otherwise the mesh is unchanged and the error names an element (ErrorKind::input).
template <int D>
[[nodiscard]] Outcome<Committed<D>> commit(const JudgedProposal<D>& judged);

/// Commits without a validity check.
template <int D>
[[nodiscard]] Committed<D> commit_uncertified(const JudgedProposal<D>& judged);

}  // namespace camber
