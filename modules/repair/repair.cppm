/// Repairs elements that are not valid: places of a judged proposal change until they are, at the least loss of what
/// was wanted; and whole meshes in one call.
export module camber.repair;
export import :guide;
export import :options;
export import :repaired;
export import :relax;
export import :method;
export import :remaining;
export import :mesh;
export import :on_geometry;
export import :uncross;
import :moved_mesh;
import :by_optimisation;
import :growth;
import :held_vertices;
import :min_invalid;
import :local_extension;
import :rounds;
import :slides;
import :state;
import :surface_alone;
import :trial;
import :vertex_moves;
