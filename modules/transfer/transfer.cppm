/// Transfer of fields between meshes: interpolation, or local projection that preserves integrals.
export module camber.transfer;
export import :transferred;
