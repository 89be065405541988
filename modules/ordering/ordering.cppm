/// In which order a mesh's vertices and elements stand in memory: how good it is, a better one, and meshes brought from
/// one into the other and back.
export module camber.ordering;
export import :morton;
export import :renumbering;
export import :space_filling;
