/// Displacements of edge nodes extended over simplices: those of the boundary's curves over its faces, those of the
/// boundary into the volume; on a whole mesh or on parts of it.
export module camber.extension;
export import :parts;
export import :displacement;
export import :energy;
