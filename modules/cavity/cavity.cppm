/// The P2 operator: edges curved by the metric, on a whole mesh or cavity by cavity; proposals and patches committed.
export module camber.cavity;
export import :edge_target;
export import :curve;
export import :star;
export import :patch;
export import :reinsert;
export import :commit;
export import :schedule;
export import :reinsert_all;
export import :edge_models;
export import :repair;
