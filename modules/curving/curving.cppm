/// Target positions of nodes before validity checks: edges curved for a metric, a solution or element shapes, and
/// boundary displacements extended over faces.
export module camber.curving;
export import :edges;
export import :mesh_nodes;
export import :solution_nodes;
