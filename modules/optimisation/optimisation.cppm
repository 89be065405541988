/// Small optimisation problems constrained by element determinants: linear and quadratic programs; the node of one
/// edge; several nodes and vertices; the minimum of det J of an element.
export module camber.optimisation;
export import :edge_program;
export import :small_programs;
