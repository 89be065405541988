/// CAD models: read from STEP, IGES and BREP files, points put onto their faces and edges, the boundary of a mesh
/// associated with them, and the geometry that this makes.
export module camber.cad;
export import :geometry;
export import :model;
