module;
#include <cstddef>
module camber.io:mfem_sections;
import camber.core;
import :listing;
import :mfem_source;
import :refused;

/// The sections of an MFEM file, in their order.
namespace camber::mfem {

/// What the sections before the vertices have, of degree 1.
template <int K>
struct Topology {
    listing::Simplices<K> elements;
    listing::Simplices<K - 1> boundary;
    Buffer<Group> groups;
    Refused refused;
};

/// Elements and boundary, with the names of their attributes. Errors: input, unsupported (too many).
template <int K>
[[nodiscard]] Outcome<Topology<K>> read_topology(Source& source);

/// The field that says where the nodes are.
struct NodeField {
    int order = 1, components = 0;
    bool by_components = false;  ///< Ordering 0: all x, then all y
};

/// Where the nodes are, and how many there are.
struct Vertices {
    std::size_t count = 0;
    NodeField field;
    bool has_nodes = false;
};

/// Errors: input, unsupported (nodes of another space).
[[nodiscard]] Outcome<Vertices> read_vertices_head(Source& source);

/// The coordinates of so many nodes. Errors: input.
template <int D>
[[nodiscard]] Outcome<Buffer<Vec<D>>> read_points(Source& source, std::size_t count, bool by_components);

}  // namespace camber::mfem
