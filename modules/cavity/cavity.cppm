/// The P2 operator: edges curved by the metric or for the shape of elements, on a whole mesh or cavity by cavity; what
/// is not valid repaired; proposals and patches committed.
export module camber.cavity;
export import :edge_target;
export import :curve;
export import :extension;
export import :shape;
export import :star;
export import :patch;
export import :reinsert;
export import :commit;
export import :schedule;
export import :reinsert_all;
export import :edge_models;
export import :repair;
