/// Dynamic meshes, whose topology changes at the cost of the change; stars, which join cavities to a point; and
/// patches, which replace cavities.
export module camber.cavity;
export import :mesh;
export import :patch;
export import :star;
