/// Ranks that are processes of MPI, and what they do together by libraries over it. No type of MPI is in this
/// interface.
export module camber.mpi;
export import :ranks;
export import :graph;
