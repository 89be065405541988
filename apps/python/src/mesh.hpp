#pragma once
// A mesh as Python has it: columns as arrays.
#include <pybind11/pybind11.h>

#include <cstddef>
#include <cstdint>

import camber.core;
import camber.io;

namespace camber::python {

/// The value behind camber.Mesh: immutable.
struct MeshHandle {
    DecodedMesh value;
    /// Of each node the number, from 1, of the point that it was given as, 0: of none; empty: 1, 2, 3 …
    Column<std::uint32_t> given_as = {};

    [[nodiscard]] int dimension() const;
    [[nodiscard]] int degree() const;
    [[nodiscard]] std::size_t vertices() const;
    /// Vertices and, of degree 2, the edges' nodes.
    [[nodiscard]] std::size_t nodes() const;
};

/// Nodes are numbered as the mesh has them, whatever its file did.
[[nodiscard]] MeshHandle handle_of(DecodedMesh mesh);

void bind_mesh(pybind11::module_& module);

}  // namespace camber::python
