/// A mesh that changes: topology that is kept up to date at the cost of what is changed, cavities emptied and joined to
/// a point, the patches that this gives, and their commit.
export module camber.cavity;
export import :mesh;
export import :patch;
export import :star;
