#pragma once
#include <doctest/doctest.h>

import camber.core;
import camber.io;

namespace camber::testing {

/// True if the mesh of a file is an M, which is `LinearMesh<D>` or `QuadraticMesh<D>`.
template <class M>
bool holds(const AnyMesh& mesh) {
    return mesh_as<M>(mesh).has_value();
}

/// Returns the mesh of a file as an M; the test fails if it is another mesh.
template <class M>
M mesh_in(const AnyMesh& mesh) {
    const auto same = mesh_as<M>(mesh);
    REQUIRE(same.has_value());
    return *same;
}

}  // namespace camber::testing
