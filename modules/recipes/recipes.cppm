/// What the program does to a mesh, for who embeds it: a recipe is one call, `curve_mesh`, `remesh_mesh`, `check_mesh`,
/// `metric_of_solution`
/// (`repair_mesh` is in camber.repair), and the longer steps of which pipelines are made: `propose_curves`,
/// `reinsert_nodes`, `make_guide`, `begin_remeshing`.
export module camber.recipes;
export import :boundary;
export import :metric_source;
export import :goal;
export import :curve_input;
export import :field;
export import :propose;
export import :guide;
export import :curve_mesh;
export import :reinsert_nodes;
export import :remesh_mesh;
export import :check_mesh;
export import :geometry_error;
export import :geometry_sizes;
export import :known_solution;
export import :metric_of_solution;
