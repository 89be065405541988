/// Dynamic meshes: topology updated at the cost of the change, cavities joined to a point, and patches that replace
/// cavities.
export module camber.cavity;
export import :mesh;
export import :patch;
export import :star;
