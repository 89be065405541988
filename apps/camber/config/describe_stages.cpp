module;
#include <functional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <nlohmann/json.hpp>
module camber.config;
import camber.core;
import camber.metric;
import camber.validity;
import camber.cavity;
import camber.curving;
import camber.repair;
import :codec;
import :description;
import :json;
import :values;

namespace camber::config {

const Description<Elevate>& Described<Elevate>::get() {
    static const Description<Elevate> description{
        "elevate", "Linear to quadratic: each edge gets a node at its middle; no point of the mesh moves.", {}, {}};
    return description;
}

const Description<Curve>& Described<Curve>::get() {
    static const Description<Curve> description{
        "curve",
        "Moves each edge's node: boundary nodes onto the geometry, volume nodes where the objective asks for "
        "them: by default where what the metric is made for is interpolated best.",
        listed<Curve>(),
        {}};
    return description;
}

const Description<Validate>& Described<Validate>::get() {
    static const Description<Validate> description{
        "validate", "Judges every element by certified bounds of its Jacobian's determinant.", listed<Validate>(), {}};
    return description;
}

const Description<Relax>& Described<Relax>::get() {
    static const Description<Relax> description{"relax",
                                                "Repairs what is not valid, at the least loss of what the stage before "
                                                "wanted: volume edges first, surface edges "
                                                "last.",
                                                listed<Relax>(),
                                                {}};
    return description;
}

const Description<Commit>& Described<Commit>::get() {
    static const Description<Commit> description{"commit", "Makes the planned nodes the mesh's own.", {}, {}};
    return description;
}

const Description<Reinsert>& Described<Reinsert>::get() {
    static const Description<Reinsert> description{
        "reinsert",
        "The global algorithm of the P2 cavity operator: every vertex is reinserted, its ball as the cavity, which "
        "curves, "
        "validates, relaxes and commits its edges. No element that is valid stops being so at any time. In place of "
        "curve, "
        "validate, relax and commit.",
        listed<Reinsert>(),
        {}};
    return description;
}

const Choice<Stage>& Described<Stage>::get() {
    static const auto choice = choice_of<Stage>(
        "stages", "One step of the pipeline.", key<Elevate>("elevate", "linear to quadratic"),
        key<Curve>("curve", "plan where nodes go"), key<Validate>("validate", "judge every element"),
        key<Relax>("relax", "repair what is not valid"), key<Commit>("commit", "make the plan the mesh"),
        key<Reinsert>("reinsert", "curve cavity by cavity"));
    return choice;
}

}  // namespace camber::config
