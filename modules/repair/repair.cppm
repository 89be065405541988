/// Repairs elements that are not valid: places of a judged proposal change until they are, at the least loss of what
/// was wanted; and whole meshes in one call.
export module camber.repair;
export import :method;
import :moved_mesh;
export import :options;
import :state;
