module;
#include <optional>
#include <utility>
export module camber.run:state;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.metric;
import camber.surface;
import camber.validity;

namespace camber::run {

/// What the stages have made so far. Each stage takes the state by value and returns the next one.
template <int D>
struct State {
    LinearMesh<D> linear;
    std::optional<QuadraticMesh<D>> mesh;  ///< from `elevate`, or read; `commit` gives it new nodes
    std::optional<Incidence<ElementId>> shells;
    std::optional<Features<D>> features;
    RequiredBoundary required = RequiredBoundary::keep;
    std::optional<Geometry<D>> geometry;
    std::optional<BackMesh<D>> back;
    std::optional<Curved<D>> curved;
    std::optional<Proposal<D>> proposal;  ///< not committed yet
    bool adopted = false;  ///< the proposal began with the nodes that the mesh was read with: its boundary is given
    std::optional<EdgeLengths> lengths;             ///< in the end, against the chords as they are then
    std::optional<Validation<D>> first_validation;  ///< before any correction
    std::optional<Validation<D>> validation;        ///< of the proposal, or of the mesh when there is none
};

}  // namespace camber::run
