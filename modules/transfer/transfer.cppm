/// Fields that follow a mesh that changed: interpolated at the new nodes, or projected where the mesh changed so that
/// what they hold in all is kept.
export module camber.transfer;
export import :transferred;
