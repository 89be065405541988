/// Pictures of meshes: what of a mesh is to be seen, with its curves.
export module camber.drawing;
export import :faces;
