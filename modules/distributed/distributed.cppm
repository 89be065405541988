/// Meshes in blocks, beyond one memory. A block is a run of a mesh's vertices and what hangs on them; which blocks
/// there are depends on the mesh alone, and who holds which does not matter to what comes out. A rank works on parts,
/// runs of its blocks with two rings of elements around. Ranks move what parts know between them, and know nothing of
/// elements.
export module camber.distributed;
export import :adaptation;
export import :blocks;
export import :partition;
export import :parts;
export import :ranks;
