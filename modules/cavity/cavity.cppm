/// Dynamic meshes, whose topology changes in time proportional to the change. Stars join cavities to a point. Patches
/// replace cavities in a mesh.
export module camber.cavity;
export import :mesh;
export import :patch;
export import :star;
