module;
#include <cstddef>
#include <cstdint>
module camber.mpi;
import camber.core;
import camber.distributed;

namespace camber {

Outcome<Buffer<std::int32_t>> parts_of_graph(Ranks& /*ranks*/, const GraphRun& /*run*/, std::size_t /*parts*/) {
    return fail(ErrorKind::unsupported, "meshes are partitioned by PT-Scotch, without which Camber was built", {}, {},
                "install it (Debian: libptscotch-dev) and build again");
}

}  // namespace camber
