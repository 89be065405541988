/// A mesh that changes: topology that is kept up to date at the cost of what is changed, cavities emptied and joined to
/// a point, the patches that this gives, and their commit.
export module camber.cavity;
export import :mesh;
export import :around;
export import :emptied;
export import :insertion;
export import :locate;
export import :make;
export import :operations;
export import :star;
export import :part;
export import :patch;
export import :compact;
export import :consistency;
import :check_patches;
import :draft;
import :flat_map;
import :orientation;
import :starring;
import :with_faces;
