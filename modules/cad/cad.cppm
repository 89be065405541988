/// CAD models: reads STEP, IGES and BREP files, projects points onto faces and edges, associates the boundary of a
/// mesh, and provides the geometry.
export module camber.cad;
export import :geometry;
export import :model;
