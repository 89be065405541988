module;
#include <optional>
#include <utility>
#include <variant>
export module camber.run:state;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.metric;
import camber.surface;
import camber.validity;
import camber.curving;

namespace camber::run {

/// What the stages have made so far. Each stage takes the state by value and returns the next one.
template <int D>
struct State {
    std::variant<LinearMesh<D>, QuadraticMesh<D>> mesh;  ///< of degree 2 from `elevate` on, or read so; then `commit`'s
    Column<Vec<D>> given_points;  ///< of the vertices as they were read: where the rows of metric files speak
    std::optional<Incidence<ElementId>> shells;
    std::optional<Features<D>> features;
    RequiredBoundary required = RequiredBoundary::keep;
    std::optional<Geometry<D>> geometry;
    std::optional<BackMesh<D>> back;
    std::optional<Curved<D>> curved;
    std::optional<Proposal<D>> proposal;            ///< the last one, committed or not
    std::optional<JudgedProposal<D>> judged;        ///< of `proposal` for `mesh`, until either changes
    bool read_curved = false;                       ///< the mesh was read with its curves
    bool adopted = false;                           ///< the proposal began with the nodes that the mesh was read with
    std::optional<EdgeLengths> lengths;             ///< in the end, against the chords as they are then
    std::optional<Validation<D>> first_validation;  ///< before any correction
    std::optional<Validation<D>> validation;        ///< of the proposal, or of the mesh when there is none

    [[nodiscard]] const LinearMesh<D>& linear() const {
        const auto* curves = quadratic();
        return curves ? curves->linear : std::get<LinearMesh<D>>(mesh);
    }
    /// Whether the boundary's nodes are the file's: they stay, unless surfaces are prescribed.
    [[nodiscard]] bool boundary_is_given() const { return read_curved && !(geometry && (*geometry)->prescribes_any()); }
    /// None while the mesh is of degree 1.
    [[nodiscard]] const QuadraticMesh<D>* quadratic() const { return std::get_if<QuadraticMesh<D>>(&mesh); }

    void propose(Proposal<D> next) {
        proposal = std::move(next);
        judged.reset();
        validation.reset();
    }
};

}  // namespace camber::run
