/// The boundary's shape: features, the P3 surrogate made from the mesh alone, analytic surfaces, projection, and the
/// nodes of boundary edges. The partitions fans, given_directions, junctions, tangents, heights and normals export
/// nothing: they serve the surrogate.
export module camber.surface;
export import :boundary;
export import :features;
export import :geometry;
export import :surrogate;
