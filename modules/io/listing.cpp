module;
#include <array>
#include <cstddef>
#include <string>
#include <utility>
module camber.io;
import camber.core;
import camber.bezier;

namespace camber::listing {

namespace {

constexpr std::size_t row_grain = 4096;

template <int D>
Outcome<Done> check_points(const Mesh<D>& mesh, const Execution& execution) {
    FirstFault first;
    auto done = each(
        execution, mesh.points.size(),
        [&](std::size_t v) {
            if (!is_finite(mesh.points[v])) first.note(v);
        },
        row_grain);
    if (!done || !first.any()) return done;
    return fail(ErrorKind::input, "a coordinate is infinite or not a number", mesh.name,
                Entity{"vertex", mesh.number_of(VertexId(first.row()))},
                "what wrote the file failed there: write it anew");
}

enum class RowFault { none, unknown_point, repeated };

template <std::size_t N>
RowFault fault_of(const std::array<VertexId, N>& nodes, std::size_t points) {
    for (std::size_t n = 0; n < N; ++n) {
        if (!nodes[n].valid() || nodes[n].index() >= points) return RowFault::unknown_point;
        for (std::size_t m = 0; m < n; ++m)
            if (nodes[m] == nodes[n]) return RowFault::repeated;
    }
    return RowFault::none;
}

template <int N>
Outcome<Done> check_rows(const std::string& name, const Rows<N>& rows, std::size_t points, const Execution& execution) {
    FirstFault first;
    auto done = each(
        execution, rows.size(),
        [&](std::size_t i) {
            if (fault_of(rows.nodes[i], points) != RowFault::none) first.note(i);
        },
        row_grain);
    if (!done || !first.any()) return done;
    const std::size_t i = first.row();
    const bool repeated = fault_of(rows.nodes[i], points) == RowFault::repeated;
    return fail(ErrorKind::input, repeated ? "a node occurs twice" : "a node is not one of those that the file lists",
                rows.origin.place ? rows.origin.place(i) : name, Entity{rows.origin.noun, rows.origin.number_of(i)},
                repeated ? "remove it: it has no volume" : "the file is damaged, or joined of two");
}

}  // namespace

template <int D>
Outcome<Done> check(const Mesh<D>& mesh, const Execution& execution) {
    return check_points(mesh, execution).and_then([&](Done) {
        return for_each_dimension(mesh, [&](const auto& kind) {
            return check_rows(mesh.name, kind.curved, mesh.points.size(), execution).and_then([&](Done) {
                return check_rows(mesh.name, kind.straight, mesh.points.size(), execution);
            });
        });
    });
}

template <int K>
Outcome<Done> reorder(Buffer<std::array<VertexId, quadratic_nodes<K>>>& simplices, const NodeOrder<K>& order,
                      const Execution& execution) {
    return each(
        execution, simplices.size(),
        [&](std::size_t i) {
            const auto before = simplices[i];
            for (std::size_t n = 0; n < order.size(); ++n) simplices[i][order[n]] = before[n];
        },
        4096);
}

template Outcome<Done> reorder<1>(Buffer<std::array<VertexId, 3>>&, const NodeOrder<1>&, const Execution&);
template Outcome<Done> reorder<2>(Buffer<std::array<VertexId, 6>>&, const NodeOrder<2>&, const Execution&);
template Outcome<Done> reorder<3>(Buffer<std::array<VertexId, 10>>&, const NodeOrder<3>&, const Execution&);
template Outcome<Done> check<2>(const Mesh<2>&, const Execution&);
template Outcome<Done> check<3>(const Mesh<3>&, const Execution&);

}  // namespace camber::listing
