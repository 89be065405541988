#pragma once
#include <doctest/doctest.h>

import camber.core;
import camber.io;

namespace camber::testing {

/// Whether a file's mesh is an M, which is LinearMesh<D> or QuadraticMesh<D>.
template <class M>
bool holds(const AnyMesh& mesh) {
    return mesh_as<M>(mesh).has_value();
}

/// A file's mesh as an M; a test whose file holds another mesh fails.
template <class M>
M mesh_in(const AnyMesh& mesh) {
    const auto same = mesh_as<M>(mesh);
    REQUIRE(same.has_value());
    return *same;
}

}  // namespace camber::testing
