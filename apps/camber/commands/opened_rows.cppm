module;
#include <memory>
#include <optional>
#include <string>
#include <vector>
module camber.commands:opened_rows;
import camber.core;
import camber.distributed;
import camber.io;
import camber.ordering;

namespace camber::app {

/// A mesh to be curved: rows that are read as they are asked for, or those of a mesh in memory.
template <int D>
struct Opened {
    std::unique_ptr<MeshRows<D>> rows;
    std::optional<LinearMesh<D>> mesh = {};  ///< in memory, in the order to work in
    std::optional<BetterOrder> order = {};   ///< how that came of the file's
    std::optional<Lift> lift = {};
};

/// A file whose rows several read: none of it is held. Errors: input; unsupported where it is of the other dimension.
template <int D>
[[nodiscard]] Outcome<Opened<D>> mapped(const std::string& path);

/// The same of a file of degree 2. All ranks call it. Errors: of any rank; unsupported where it is of another form than
/// QuadraticRows takes.
template <int D>
[[nodiscard]] Outcome<std::unique_ptr<QuadraticRows<D>>> mapped_quadratic(const std::string& path, Ranks& ranks);

/// What simplices a binary file has. Errors: input.
[[nodiscard]] Outcome<GmfShape> shape_of_file(const std::string& path);

/// A mesh of degree 1 in memory, made sound, in an order in which what is near is near.
template <int D>
[[nodiscard]] Outcome<Opened<D>> prepared(LinearMesh<D> given, std::vector<std::string>& notices,
                                          const Execution& execution);

}  // namespace camber::app
