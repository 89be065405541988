// Writes a straight mesh with vertices, elements and facets in random order, and prints a measure of its locality:
//
//     shuffled MESH [OUT [SEED]]
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <variant>

import camber.core;
import camber.io;
import camber.ordering;

#include "mesh_files.hpp"

using namespace camber;
using namespace camber::bench;

namespace {

template <class EntityId>
Permutation<EntityId> any_order(std::size_t count, std::mt19937_64& random) {
    Buffer<EntityId> ids(count);
    for (std::size_t i = 0; i < count; ++i) ids[i] = EntityId(i);
    std::shuffle(ids.begin(), ids.end(), random);
    return must(permutation(Column<EntityId>(std::move(ids)), Execution{}));
}

template <int K>
void shuffle_rows(Simplices<K>& simplices, Column<std::uint32_t>* marked, std::mt19937_64& random) {
    const auto order = any_order<FacetId>(simplices.size(), random);
    simplices.vertices = must(renumbered_rows(simplices.vertices, order.before, Execution{}));
    simplices.references = must(renumbered_rows(simplices.references, order.before, Execution{}));
    simplices.entities = must(renumbered_rows(simplices.entities, order.before, Execution{}));
    for (Column<std::uint32_t>* rows : {&simplices.required, marked}) {
        if (rows == nullptr) continue;
        auto ids = take(std::move(*rows));
        for (std::uint32_t& id : ids) id = order.after[id].value;
        *rows = std::move(ids);
    }
}

template <int D>
AnyMesh shuffled(const Mesh<D>& input, std::mt19937_64& random) {
    LinearMesh<D> mesh = must(as_linear(input));
    shuffle_rows(mesh.facets, D == 2 ? &mesh.ridges : nullptr, random);
    const Renumbering order{any_order<VertexId>(mesh.points.size(), random),
                            any_order<ElementId>(mesh.elements.size(), random)};
    return as_mesh(must(renumbered(std::move(mesh), order, Execution{})));
}

double scatter_of(const AnyMesh& mesh) {
    return std::visit([](const auto& m) { return must(scatter(straight_simplices(m), Execution{})); }, mesh);
}

}  // namespace

int main(int count, char** words) {
    if (count < 2) return std::fprintf(stderr, "shuffled MESH [OUT [SEED]]\n"), 2;
    const std::string from = words[1], to = count > 2 ? words[2] : "";
    std::mt19937_64 random(count > 3 ? static_cast<std::uint64_t>(std::strtod(words[3], nullptr)) : 1);
    const AnyMesh mesh = read_mesh(from);
    std::printf("%s: scatter %.4g\n", from.c_str(), scatter_of(mesh));
    if (to.empty()) return 0;
    const AnyMesh out = std::visit([&](const auto& m) { return shuffled(m, random); }, mesh);
    std::printf("%s: scatter %.4g\n", to.c_str(), scatter_of(out));
    write_mesh(to, out);
    return 0;
}
