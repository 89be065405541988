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

/// det J / |det straight| that makes an element valid, rounding included (paper §4.3).
inline constexpr double min_bound = 1e-9;
/// The same that is recommended where none is asked: what a solver is glad of, and what costs next to nothing
/// (bench/results/bounds.md).
inline constexpr double default_bound = 0.1;
/// The scaled Jacobian that elements are raised to where nodes follow the mesh alone, neither a metric nor a solution
/// (docs/algorithms/repair.md).
inline constexpr double target_without_metric = 0.6;

/// The scaled Jacobian that elements are to have: required, or recommended if none is required.
struct JacobianBound {
    double value = default_bound;
    bool is_asked = false;

    constexpr JacobianBound() = default;
    [[nodiscard]] static constexpr JacobianBound recommended(double value) {
        JacobianBound bound;
        bound.value = value;
        return bound;
    }
    constexpr JacobianBound(double asked) : value(asked), is_asked(true) {}  // NOLINT(*-explicit-*)
    [[nodiscard]] constexpr operator double() const { return value; }        // NOLINT(*-explicit-*)
    friend constexpr bool operator==(const JacobianBound&, const JacobianBound&) = default;
};

/// It as an option of S, which has a member `min_scaled_jacobian`.
template <class S>
[[nodiscard]] constexpr Option<S, JacobianBound> bound_option() {
    return option("min_scaled_jacobian", &S::min_scaled_jacobian,
                  "an element is good enough when the determinant of its Jacobian is everywhere at least this share of "
                  "the straight element's; what stays below is a failure. null: what a stage before asks for; else "
                  "0.1 is recommended: what stays below is a note")
        .at_least(0)
        .below(1);
}

/// Verdicts of a whole mesh; of a surface alone (`is_surface_alone`) all that is said of elements is of its triangles.
template <int D>
struct Validation {
    double bound = 0;          ///< what the verdicts were asked for
    Column<Verdict> verdicts;  ///< one an element
    /// Certified lower bounds of det J / |det straight|, one an element: within 1e-3 of the minimum (as
    /// ElementValidity says) where the coefficients alone did not decide and where the smallest of the mesh might be;
    /// the smallest coefficient elsewhere. ±∞ where the straight element is flat.
    Column<float> min_scaled_jacobian;
    std::size_t invalid = 0, undecided = 0;
    /// Elements of which det J > 0 everywhere is not certified, whatever the bound, rising: whether that is known not
    /// to be so (invalid) or not known (undecided).
    std::vector<std::pair<ElementId, Verdict>> not_positive;
    std::size_t straight_inverted = 0;  ///< elements whose straight counterpart is flat or inverted
    double smallest = 1;                ///< of min_scaled_jacobian, flat ones left out; within 1e-3 of the true minimum
    ElementId worst;                    ///< where it is; invalid when there is no element to speak of

    [[nodiscard]] std::size_t not_valid() const { return invalid + undecided; }  ///< to the bound
    [[nodiscard]] bool all_valid() const { return not_valid() == 0; }            ///< to the bound
    [[nodiscard]] bool certified() const { return not_positive.empty(); }        ///< det J > 0 everywhere
    friend bool operator==(const Validation&, const Validation&) = default;
};

/// A proposal, the mesh that it is for, and the verdicts of all its elements. Only `validate` makes one (and what is
/// made of its results: `relax`, `repair`), so that whoever holds one knows that the verdicts are those of the nodes;
/// `commit` takes nothing else.
template <int D>
class JudgedProposal {
  public:
    [[nodiscard]] const QuadraticMesh<D>& mesh() const { return mesh_; }  ///< as it is without the proposal
    [[nodiscard]] const Proposal<D>& proposal() const { return proposal_; }
    [[nodiscard]] const Validation<D>& validation() const { return validation_; }

    /// The same places; what kinds the edges are does not enter the verdicts.
    [[nodiscard]] JudgedProposal with_kinds(Column<EdgeKind> kinds) const {
        JudgedProposal other = *this;
        other.proposal_.kinds = std::move(kinds);
        return other;
    }
    friend bool operator==(const JudgedProposal&, const JudgedProposal&) = default;

    /// The third verb: verdicts of all elements, of the stored Lagrange nodes, over their own straight elements (those
    /// of the proposal's points). Errors: a proposal of another mesh (internal), stopped.
    [[nodiscard]] static Outcome<JudgedProposal> judge(QuadraticMesh<D> mesh, Proposal<D> proposal, double bound,
                                                       const Execution& execution);

    /// Other nodes of the same mesh, with the vertices where they are: only the elements `touched` are looked at, those
    /// with a node that is elsewhere.
    [[nodiscard]] Outcome<JudgedProposal> judge_again(Proposal<D> proposal, std::span<const ElementId> touched,
                                                      const Execution& execution) const;

  private:
    JudgedProposal(QuadraticMesh<D> mesh, Proposal<D> proposal, Validation<D> validation)
        : mesh_(std::move(mesh)), proposal_(std::move(proposal)), validation_(std::move(validation)) {}

    QuadraticMesh<D> mesh_;
    Proposal<D> proposal_;
    Validation<D> validation_;
};

/// The third verb: see JudgedProposal::judge.
template <int D>
[[nodiscard]] inline Outcome<JudgedProposal<D>> validate(QuadraticMesh<D> mesh, Proposal<D> proposal, double bound,
                                                         const Execution& execution) {
    return JudgedProposal<D>::judge(std::move(mesh), std::move(proposal), bound, execution);
}

/// The verdicts of a mesh with its own nodes.
template <int D>
[[nodiscard]] Outcome<Validation<D>> validate(const QuadraticMesh<D>& mesh, double bound, const Execution& execution);

/// An element of the mesh with other mid nodes.
template <int D>
[[nodiscard]] inline NodalSimplex<D> nodal_element(const QuadraticMesh<D>& mesh,
                                                   std::span<const LagrangeNode<D>> mid_nodes, ElementId e) {
    return nodal_form<D>(mesh.linear.points, mid_nodes, mesh.linear.elements.vertices[e], mesh.edges.of_elements[e]);
}

/// What a commit gives: the mesh, and where its entities are now. Identities while the topology stays.
template <int D>
struct Committed {
    QuadraticMesh<D> mesh;
    MeshMaps maps;
};

/// The last verb: the places of the proposal become the mesh's, if det J > 0 is certified everywhere; a bound above
/// that is the caller's to ask for (`validation().all_valid()`). All or nothing: otherwise an element is named
/// (ErrorKind::input), and the mesh stays as it was.
template <int D>
[[nodiscard]] Outcome<Committed<D>> commit(const JudgedProposal<D>& judged);

/// The same without asking for validity, for those who want to see a broken mesh, or repair it elsewhere.
template <int D>
[[nodiscard]] Committed<D> commit_uncertified(const JudgedProposal<D>& judged);

}  // namespace camber
