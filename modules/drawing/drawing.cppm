/// Pictures of meshes: what of a mesh is to be seen, with its curves, on paper; as pixels or as an SVG file. No display
/// and no graphics processor is needed.
export module camber.drawing;
export import :colour;
export import :faces;
export import :image;
export import :marks;
export import :drawn_face;
export import :scene;
export import :view;
