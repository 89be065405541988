module;
#include <cstddef>
#include <span>
#include <string_view>
module camber.io;
import camber.core;

/// Of builds that do not know the CGNS library.
namespace camber {

namespace {

auto absent() {
    return fail(ErrorKind::unsupported, "this build of Camber has no CGNS", {}, {},
                "install the library (Debian: libcgns-dev) and build again, or take another format");
}

}  // namespace

bool knows_cgns() { return false; }

Outcome<DecodedMesh> decode_cgns(std::span<const std::byte>, std::string_view, const DecodeOptions&, const Execution&) {
    return absent();
}

template <int D>
Outcome<Chunks> encode_cgns(const LinearMesh<D>&, const MeshFields&, const Execution&) {
    return absent();
}
template <int D>
Outcome<Chunks> encode_cgns(const QuadraticMesh<D>&, const MeshFields&, const Execution&) {
    return absent();
}

#define CAMBER_INSTANTIATE(D)                                                                           \
    template Outcome<Chunks> encode_cgns<D>(const LinearMesh<D>&, const MeshFields&, const Execution&); \
    template Outcome<Chunks> encode_cgns<D>(const QuadraticMesh<D>&, const MeshFields&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
