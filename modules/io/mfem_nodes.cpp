module;
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
module camber.io;
import camber.core;
import :mfem_sections;
import :mfem_source;

namespace camber::mfem {

namespace {

std::optional<int> order_of(std::string_view collection) {
    if (collection == "Linear" || collection == "H1_2D_P1" || collection == "H1_3D_P1") return 1;
    if (collection == "Quadratic" || collection == "H1_2D_P2" || collection == "H1_3D_P2") return 2;
    return std::nullopt;
}

Outcome<NodeField> read_field_head(Source& source) {
    NodeField field;
    if (auto begun = source.expect("FiniteElementSpace"); !begun) return fail(begun.error());
    if (auto begun = source.expect("FiniteElementCollection:"); !begun) return fail(begun.error());
    const auto order = order_of(source.words.next());
    if (!order)
        return source.refuse_here("its nodes are of another space than H1 of order 1 or 2",
                                  "project them with Mesh::SetCurvature(2)");
    field.order = *order;
    if (auto begun = source.expect("VDim:"); !begun) return fail(begun.error());
    const auto components = source.number("components");
    if (!components) return fail(components.error());
    if (auto begun = source.expect("Ordering:"); !begun) return fail(begun.error());
    const auto ordering = source.number("the ordering");
    if (!ordering) return fail(ordering.error());
    if ((*components != 2 && *components != 3) || (*ordering != 0 && *ordering != 1))
        return source.fail_here("VDim is not 2 or 3, or Ordering not 0 or 1");
    field.components = static_cast<int>(*components);
    field.by_components = *ordering == 0;
    return field;
}

}  // namespace

Outcome<Vertices> read_vertices_head(Source& source) {
    Vertices vertices;
    if (auto begun = source.expect("vertices"); !begun) return fail(begun.error());
    const auto count = source.count("vertices", 1);
    if (!count) return fail(count.error());
    vertices.count = *count;
    Words ahead = source.words;
    vertices.has_nodes = ahead.next() == "nodes";
    if (vertices.has_nodes) {
        source.words = ahead;
        auto field = read_field_head(source);
        if (!field) return fail(std::move(field.error()));
        vertices.field = *field;
        return vertices;
    }
    const auto components = source.number("coordinates of a vertex");
    if (!components) return fail(components.error());
    if (*components != 2 && *components != 3)
        return source.fail_here("vertices have " + std::to_string(*components) + " coordinates, not 2 or 3");
    vertices.field.components = static_cast<int>(*components);
    return vertices;
}

template <int D>
Outcome<Buffer<Vec<D>>> read_points(Source& source, std::size_t count, bool by_components) {
    if (count > source.left() / 2 + 1)
        return source.fail_here(std::to_string(count) + " nodes are wanted, more than follow");
    Buffer<Vec<D>> points(count);
    for (std::size_t i = 0; i < count * D; ++i) {
        const std::size_t node = by_components ? i % count : i / D, component = by_components ? i / count : i % D;
        if (!read_number(source.words, points[node][static_cast<int>(component)]))
            return source.fail_here("coordinate " + std::to_string(i + 1) + " of " + std::to_string(count * D) +
                                    " is missing or malformed");
    }
    return points;
}

template Outcome<Buffer<Vec<2>>> read_points<2>(Source&, std::size_t, bool);
template Outcome<Buffer<Vec<3>>> read_points<3>(Source&, std::size_t, bool);

}  // namespace camber::mfem
