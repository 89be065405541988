/// Repairs invalid elements: changes the positions of a judged proposal at minimum cost. Also repairs whole meshes in
/// one call.
export module camber.repair;
export import :method;
import :moved_mesh;
export import :options;
import :state;
