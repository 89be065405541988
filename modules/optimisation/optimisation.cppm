/// Small optimisation problems with the determinants of elements as their constraints: linear and quadratic programmes,
/// those of one edge's node over the elements around it, those of several nodes and vertices together, and where det J
/// of an element is lowest.
export module camber.optimisation;
export import :edge_programme;
export import :programmes;
