/// Riemannian metrics: SPD algebra, log-Euclidean fields on back meshes, operations on fields, and lengths and
/// distortion of elements.
export module camber.metric;
export import :back_mesh;
export import :back_models;
export import :operations;
export import :packs;
export import :spd;
export import :unit_mesh;
