/// Extends displacements of edge nodes from curves over faces and from the boundary into the volume, on a whole mesh or
/// its parts.
export module camber.extension;
export import :parts;
export import :displacement;
export import :energy;
