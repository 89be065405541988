/// Stages of a run on whole meshes: boundary and metric, node positions (`propose_curves`), reinsertion, repair guides,
/// start of remeshing (`begin_remeshing`), distances from the geometry, `check_mesh`.
export module camber.stages;
export import :curve;
export import :metric;
export import :remesh;
