module;
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <tuple>
export module camber.run:order;
import camber.core;
import camber.config;

/// Which stage may come after which: one table.
export namespace camber::run {

/// What a run holds, as far as the order of its stages goes; each holds more than the one before.
enum class Holds : std::uint8_t {
    straight_mesh,
    curved_mesh,    ///< of degree 2
    planned_nodes,  ///< and places for its nodes; a mesh that was read with its curves begins so: its own nodes
};

/// What a stage does about places that are planned for nodes and are not the mesh's.
enum class Places : std::uint8_t {
    keeps,
    plans,  ///< makes or changes them
    commits,
    refuses  ///< changes the mesh itself: there must be none
};

/// A stage of the pipeline: it runs where the run holds from `least` to `most`.
template <class Options>
struct StageRow {
    std::string_view name;
    Holds least = Holds::straight_mesh, most = Holds::planned_nodes;
    std::optional<Holds> makes = {};  ///< none: holds what it held
    Places places = Places::keeps;
};

/// One row for each alternative of config::Stage; forgotten, it does not compile.
inline constexpr std::tuple stage_rows{
    StageRow<config::Elevate>{"elevate", Holds::straight_mesh, Holds::straight_mesh, Holds::curved_mesh},
    StageRow<config::Curve>{"curve", Holds::curved_mesh, Holds::planned_nodes, Holds::planned_nodes, Places::plans},
    StageRow<config::Validate>{"validate", Holds::curved_mesh, Holds::planned_nodes},
    StageRow<config::Relax>{"relax", Holds::planned_nodes, Holds::planned_nodes, {}, Places::plans},
    StageRow<config::Commit>{"commit", Holds::planned_nodes, Holds::planned_nodes, {}, Places::commits},
    StageRow<config::Reinsert>{"reinsert", Holds::curved_mesh, Holds::planned_nodes, Holds::planned_nodes,
                               Places::commits},
    StageRow<config::Collapse>{"collapse", Holds::straight_mesh, Holds::planned_nodes, {}, Places::refuses},
    StageRow<config::Split>{"split", Holds::straight_mesh, Holds::planned_nodes, {}, Places::refuses},
    StageRow<config::Swap>{"swap", Holds::straight_mesh, Holds::planned_nodes, {}, Places::refuses},
    StageRow<config::Smooth>{"smooth", Holds::straight_mesh, Holds::planned_nodes, {}, Places::refuses},
    StageRow<config::Mend>{"mend", Holds::straight_mesh, Holds::planned_nodes, {}, Places::refuses},
    StageRow<config::Remesh>{"remesh", Holds::straight_mesh, Holds::planned_nodes, {}, Places::refuses},
};

/// Whether a stage is a pass that changes the topology.
template <class Options>
[[nodiscard]] constexpr bool changes_topology() {
    return std::get<StageRow<Options>>(stage_rows).places == Places::refuses;
}

/// Whether these stages can run one after the other on a mesh of that degree, before anything is done. Errors name the
/// stage's JSON path: usage (a stage that must come before it is missing, or one is there that must not), or without
/// the path input (the mesh is of degree 1, or of degree 2, and its stages take it as it is).
[[nodiscard]] Outcome<Done> check_order(std::span<const config::Stage> stages, int degree);

}  // namespace camber::run
