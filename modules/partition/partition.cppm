/// A mesh in parts, for solvers on several processes: parts of about as many elements each, with few faces between
/// them, and each of them as a mesh by itself that knows its place in the whole.
export module camber.partition;
export import :parts;
export import :pieces;
export import :graph;
