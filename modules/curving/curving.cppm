/// Target positions of nodes, before validity is checked: edges curved by a metric, by a solution, or for the shape of
/// their elements; the displacement of boundary curves extended over faces; the cost of a node off its target.
export module camber.curving;
export import :edges;
export import :mesh_nodes;
export import :solution_nodes;
