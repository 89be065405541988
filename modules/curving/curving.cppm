/// Where nodes ought to be, before validity is asked for: volume edges curved by a metric, or for the shape of their
/// elements; the boundary's displacement extended into the volume; and what it costs an edge to have its node
/// elsewhere.
export module camber.curving;
export import :edges;
export import :mesh_nodes;
export import :solution_nodes;
