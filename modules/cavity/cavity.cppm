/// The P2 operator: edges curved by the metric, proposals committed.
export module camber.cavity;
export import :curve;
export import :commit;
