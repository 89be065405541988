/// What is not valid repaired: places of a judged proposal changed until its elements are, at the least loss of what
/// was wanted.
export module camber.repair;
export import :relax;
export import :passes;
import :held_vertices;
import :nodewise;
import :state;
import :rounds;
import :vertex_moves;
