/// The base of every module: small value types, outcomes, columns, parallel loops, mesh values and their topology.
export module camber.core;
export import :columns;
export import :execution;
export import :mesh;
export import :outcome;
export import :shape;
export import :simplices;
export import :tensors;
