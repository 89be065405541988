module;
#include <functional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <nlohmann/json.hpp>
module camber.config;
import camber.core;
import :codec;
import :description;
import :json;
import :values;

namespace camber::config {

namespace {

constexpr const char* validity_doc =
    "an element is valid when the determinant of its Jacobian is everywhere at least this share of the straight "
    "element's";

}  // namespace

const Words& Described<Objective>::get() {
    static const Words words{{"energy", "length", "shape"}};
    return words;
}
const Words& Described<FieldOfEdge>::get() {
    static const Words words{{"back", "edge"}};
    return words;
}
const Words& Described<Repair>::get() {
    static const Words words{{"cavity", "edge", "segment", "relax"}};
    return words;
}

const Words& Described<Vertices>::get() {
    static const Words words{{"move", "keep"}};
    return words;
}

const Description<Elevate>& Described<Elevate>::get() {
    static const Description<Elevate> description{
        "elevate", "Linear to quadratic: each edge gets a node at its middle; no point of the mesh moves.", {}, {}};
    return description;
}

const Description<Curve>& Described<Curve>::get() {
    using S = Curve;
    static const Description<S> description{
        "curve",
        "Moves each edge's node: boundary nodes onto the geometry, volume nodes where the metric makes the edge "
        "shortest.",
        {field("objective", &S::objective,
               "what volume edges minimise in the metric: their energy (smooth, evenly spaced) or their length; shape: "
               "no "
               "metric, the Jacobians of their elements are made as even as may be"),
         field("field", &S::field,
               "metric along the edge: back, from the mesh's vertices all the way; edge, from the edge's own three "
               "values"),
         field("quadrature_points", &S::quadrature_points, "Gauss points along an edge").at_least(2).at_most(12),
         field("iterations", &S::iterations, "largest number of quasi-Newton steps an edge").at_least(0).at_most(1000),
         field("length_tolerance", &S::length_tolerance,
               "energy only: from its minimum the length is lowered while that promises more than this share; 0: never")
             .at_least(0)
             .at_most(1),
         field("max_tangential_shift", &S::max_tangential_shift, "how far a node may slide along its edge")
             .unit("chord lengths")
             .at_least(0)
             .below(0.25),
         field("max_offset", &S::max_offset, "how far a volume node may leave the middle of its chord")
             .unit("lengths in the metric")
             .above(0)},
        {}};
    return description;
}

const Description<Validate>& Described<Validate>::get() {
    using S = Validate;
    static const Description<S> description{
        "validate",
        "Judges every element by certified bounds of its Jacobian's determinant.",
        {field("min_scaled_jacobian", &S::min_scaled_jacobian, validity_doc).at_least(0).below(1)},
        {}};
    return description;
}

const Description<Relax>& Described<Relax>::get() {
    using S = Relax;
    static const Description<S> description{
        "relax",
        "Mends what is not valid, at the least loss of what the stage before wanted: volume edges first, surface edges "
        "last.",
        {field(
             "repair", &S::repair,
             "cavity: the nodes of an element together, else one edge, then larger cavities, then vertices; edge: one "
             "node "
             "at a time, nearest to where it is wanted; segment: the same "
             "towards the middle of the chord, each as little as its elements need; relax: each edge of an invalid "
             "element by theta, as in the paper"),
         field("target", &S::target,
               "what is aimed at in mended elements where it can be had, as a share of the straight element's "
               "determinant; keeps them off the very edge of validity")
             .at_least(0)
             .below(1),
         field("boundary_tolerance", &S::boundary_tolerance,
               "of a mesh that was read with its curves: how far the node of a boundary edge may move where nothing "
               "else helps; 0: the boundary stays as it is. After curve, such nodes may always go back to their chords")
             .unit("model units")
             .at_least(0),
         field("vertices", &S::vertices,
               "vertices of the volume: move, where nodes alone do not mend an element; keep, all stay. Required ones "
               "never move"),
         field(
             "effort", &S::effort,
             "work that cavity and edge may spend for each element that is not good enough, in steps of programmes of "
             "ten nodes; easily mended ones leave theirs to others, and what is not mended when it is spent is "
             "listed")
             .at_least(0),
         field("theta", &S::theta, "what a correction leaves of a node's offset")
             .unit("shares of the offset")
             .above(0)
             .below(1),
         field("max_corrections", &S::max_corrections, "corrections before a node goes to the middle of its chord")
             .at_least(1)
             .at_most(10000),
         field("min_scaled_jacobian", &S::min_scaled_jacobian, validity_doc).at_least(0).below(1)},
        {}};
    return description;
}

const Description<Commit>& Described<Commit>::get() {
    static const Description<Commit> description{"commit", "Makes the planned nodes the mesh's own.", {}, {}};
    return description;
}

const Description<Reinsert>& Described<Reinsert>::get() {
    using S = Reinsert;
    static const Description<S> description{
        "reinsert",
        "The global algorithm of the P2 cavity operator: every vertex is reinserted, its ball as the cavity, which "
        "curves, "
        "validates, relaxes and commits its edges. No element that is valid stops being so at any time. In place of "
        "curve, "
        "validate, relax and commit.",
        {field("curve", &S::curve, "how a cavity's edges find their nodes: the options of the stage curve"),
         field("relax", &S::relax,
               "what a cavity does about elements that are not valid: the options of the stage relax"),
         field("max_turns", &S::max_turns,
               "turns over the vertices; after the first only those with nodes that neighbours kept from their places")
             .at_least(1)
             .at_most(1000)},
        {}};
    return description;
}

const Choice<Stage>& Described<Stage>::get() {
    static const Choice<Stage> choice{"stages",
                                      "One step of the pipeline.",
                                      {{"elevate", "linear to quadratic"},
                                       {"curve", "plan where nodes go"},
                                       {"validate", "judge every element"},
                                       {"relax", "mend what is not valid"},
                                       {"commit", "make the plan the mesh"},
                                       {"reinsert", "curve cavity by cavity"}}};
    return choice;
}

}  // namespace camber::config
