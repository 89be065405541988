module;
#include <cstddef>
#include <cstdint>
module camber.partition;
import camber.core;

namespace camber {

Outcome<Buffer<std::int32_t>> parts_of_graph(const DualGraph& graph, std::size_t parts) {
    if (parts == 1) return Buffer<std::int32_t>(graph.size(), 0);
    return fail(ErrorKind::unsupported,
                "partitioning a mesh requires Scotch, which this build of Camber does not "
                "include",
                {}, {}, "install it (Debian: libptscotch-dev) and build again");
}

}  // namespace camber
