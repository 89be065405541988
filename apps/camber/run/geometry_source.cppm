module;
#include <memory>
#include <optional>
export module camber.run:geometry_source;
import camber.core;
import camber.io;
import camber.cad;

export namespace camber::run {

/// What the shell has read of a config's geometry, where that is in a file.
struct GeometrySource {
    std::optional<CadModel> cad = {};
    std::shared_ptr<const AnyMesh> mesh = {};
};

}  // namespace camber::run
