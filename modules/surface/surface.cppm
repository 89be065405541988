/// Shape of the boundary: features, P3 surrogate from the mesh, analytic surfaces, projection, nodes of boundary edges.
export module camber.surface;
export import :boundary;
export import :features;
export import :geometry;
export import :surrogate;
