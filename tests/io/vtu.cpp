// VTU files: what can be told without a reader. What they hold is checked by tests/pipelines/test_formats.py.
#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "generated.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.io;

using namespace camber;

namespace {

template <int D>
MeshFields some_fields(const QuadraticMesh<D>& mesh) {
    const std::size_t nodes = mesh.linear.points.size() + mesh.edges.size();
    const std::size_t cells = mesh.linear.elements.size() + mesh.linear.facets.size() + mesh.linear.edges.size();
    return MeshFields{}
        .with({"number", Centring::cell, FieldKind::scalar, Column<std::int32_t>(Buffer<std::int32_t>(cells, 3))})
        .with({"tensor", Centring::node, FieldKind::symmetric_tensor,
               Column<double>(Buffer<double>(nodes * sym_size<D>, 0.5))});
}

template <int D>
void laws() {
    testing::property("the same bytes for any number of threads; sizes announced", [](std::uint64_t seed) {
        const auto mesh = generated::quadratic<D>(seed, seed % 9);
        const VtuOptions options{*rc::gen::element(VtuCells::quadratic, VtuCells::lagrange)};
        const auto fields = some_fields(mesh);
        const auto one = generated::joined(*encode_vtu(as_mesh(mesh), fields, options, {.threads = 1}));
        RC_ASSERT(one == generated::joined(*encode_vtu(as_mesh(mesh), fields, options, {.threads = 3})));
        const std::string text = generated::text_of(one);
        RC_ASSERT(text.find("NumberOfPoints=\"" + std::to_string(mesh.linear.points.size() + mesh.mid_nodes.size()) +
                            "\"") < text.size());
        RC_ASSERT(text.ends_with("\n</AppendedData>\n</VTKFile>\n"));
    });
    testing::property("a mesh whose columns do not fit is refused", [](std::uint64_t seed) {
        auto mesh = generated::quadratic<D>(seed, 1 + seed % 9);
        mesh.mid_nodes = Buffer<LagrangeNode<D>>(mesh.edges.size() + 1);
        const auto broken = encode_vtu(as_mesh(mesh), {}, {}, {});
        RC_ASSERT(!broken && broken.error().kind == ErrorKind::internal);
    });
}

}  // namespace

TEST_CASE("VTU files in 2D") { laws<2>(); }
TEST_CASE("VTU files in 3D") { laws<3>(); }

TEST_CASE("fields of another mesh are refused by name") {
    const auto mesh = generated::quadratic<3>(5, 4);
    const auto fields =
        MeshFields{}.with({"speed <m/s>", Centring::node, FieldKind::vector, Column<double>(Buffer<double>(7, 0.0))});
    const auto refused = encode_vtu(as_mesh(mesh), fields, {}, {});
    REQUIRE_FALSE(refused.has_value());
    CHECK(refused.error().kind == ErrorKind::usage);
    CHECK(describe(refused.error()).find("\"speed <m/s>\" does not have one row for each") == 10);
}

TEST_CASE("names are told to XML as they are") {
    LinearMesh<2> mesh;
    const auto fields = MeshFields{}.with({"a<b & \"c\"", Centring::node, FieldKind::scalar, Column<double>{}});
    const auto text = generated::text_of(generated::joined(*encode_vtu(as_mesh(mesh), fields, {}, {})));
    CHECK(text.find("Name=\"a&lt;b &amp; &quot;c&quot;\"") < text.size());
}

TEST_CASE("fields are values: one more is another, the same name is replaced") {
    const MeshField one{"x", Centring::node, FieldKind::scalar, Column<double>(Buffer<double>{1})};
    MeshField two = one;
    two.values = Column<double>(Buffer<double>{2});
    const MeshFields first = MeshFields{}.with(one);
    const MeshFields second = first.with(two);
    CHECK(first.size() == 1);
    CHECK(second.size() == 1);
    CHECK(*first.find("x", Centring::node) == one);
    CHECK(*second.find("x", Centring::node) == two);
    CHECK(second.find("x", Centring::cell) == nullptr);
}

TEST_CASE("fields all at once are as one after the other") {
    testing::property("few names", [](std::uint64_t seed) {
        generated::Random random(seed);
        std::vector<MeshField> given;
        MeshFields one_by_one;
        for (std::size_t i = 0, n = random.below(12); i < n; ++i) {
            given.push_back({std::string(1, "abcd"[random.below(4)]),
                             random.below(2) == 0 ? Centring::node : Centring::cell, FieldKind::scalar,
                             Column<std::int32_t>(Buffer<std::int32_t>{static_cast<std::int32_t>(i)})});
            one_by_one = std::move(one_by_one).with(given.back());
        }
        RC_ASSERT(MeshFields(std::move(given)) == one_by_one);
    });
}

TEST_CASE("what VTU has no place for") {
    LinearMesh<3> mesh;
    CHECK(not_in_vtu(as_mesh(mesh)).empty());
    mesh.corners = Buffer<VertexId>{VertexId(0)};
    mesh.edges.required = Buffer<std::uint32_t>{0, 1};
    const auto losses = not_in_vtu(as_mesh(mesh));
    REQUIRE(losses.size() == 2);
    CHECK(losses[0].what == "VTU has no place for 1 corners");
    CHECK(losses[1].what == "VTU has no place for 2 required entities");
}
