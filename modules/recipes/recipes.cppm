/// What the program does to a mesh, for who embeds it: a recipe is one call, `curve_mesh`, `remesh_mesh`, `check_mesh`,
/// `metric_of_solution`
/// (`repair_mesh` is in camber.repair), and the longer steps of which pipelines are made: `propose_curves`,
/// `reinsert_nodes`, `make_guide`, `begin_remeshing`.
export module camber.recipes;
export import :curve_mesh;
export import :metric;
export import :remesh_mesh;
