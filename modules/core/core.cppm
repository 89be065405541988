/// Base module: value types, outcomes, columns, parallel loops, meshes and topology.
export module camber.core;
export import :columns;
export import :execution;
export import :mesh;
export import :outcome;
export import :shape;
export import :simplices;
export import :tensors;
