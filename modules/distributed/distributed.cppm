/// Meshes in blocks, beyond the memory of one process. A block is a run of vertices with their elements. Blocks depend
/// only on the mesh; their distribution does not affect results. A rank works on parts: runs of blocks with two rings
/// of elements.
export module camber.distributed;
export import :adaptation;
export import :blocks;
export import :partition;
export import :parts;
export import :ranks;
