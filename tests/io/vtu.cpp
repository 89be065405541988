// VTU encoding without a reader. tests/pipelines/test_formats.py checks the content of the files.
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
void check_properties() {
    testing::property(
        "VTU bytes do not depend on the number of threads and state the number of points", [](std::uint64_t seed) {
            const auto mesh = generated::quadratic<D>(seed, seed % 9);
            const VtuOptions options{*rc::gen::element(VtuCells::quadratic, VtuCells::lagrange)};
            const auto fields = some_fields(mesh);
            const auto one = generated::joined(*encode_vtu(as_mesh(mesh), fields, options, {.threads = 1}));
            RC_ASSERT(one == generated::joined(*encode_vtu(as_mesh(mesh), fields, options, {.threads = 3})));
            const std::string text = generated::text_of(one);
            RC_ASSERT(text.find("NumberOfPoints=\"" +
                                std::to_string(mesh.linear.points.size() + mesh.mid_nodes.size()) + "\"") <
                      text.size());
            RC_ASSERT(text.ends_with("\n</AppendedData>\n</VTKFile>\n"));
        });
    testing::property("a mesh with columns of different lengths is rejected", [](std::uint64_t seed) {
        auto mesh = generated::quadratic<D>(seed, 1 + seed % 9);
        mesh.mid_nodes = Buffer<LagrangeNode<D>>(mesh.edges.size() + 1);
        const auto broken = encode_vtu(as_mesh(mesh), {}, {}, {});
        RC_ASSERT(!broken && broken.error().kind == ErrorKind::internal);
    });
}

}  // namespace

TEST_CASE("VTU encoding is independent of threads and rejects invalid columns in 2D") { check_properties<2>(); }
TEST_CASE("VTU encoding is independent of threads and rejects invalid columns in 3D") { check_properties<3>(); }

TEST_CASE("VTU rejects fields of another mesh by name") {
    const auto mesh = generated::quadratic<3>(5, 4);
    const auto fields =
        MeshFields{}.with({"speed <m/s>", Centring::node, FieldKind::vector, Column<double>(Buffer<double>(7, 0.0))});
    const auto refused = encode_vtu(as_mesh(mesh), fields, {}, {});
    REQUIRE_FALSE(refused.has_value());
    CHECK(refused.error().kind == ErrorKind::usage);
    CHECK(describe(refused.error()).find("\"speed <m/s>\" does not have one row for each") == 10);
}

TEST_CASE("VTU escapes field names in XML") {
    LinearMesh<2> mesh;
    const auto fields = MeshFields{}.with({"a<b & \"c\"", Centring::node, FieldKind::scalar, Column<double>{}});
    const auto text = generated::text_of(generated::joined(*encode_vtu(as_mesh(mesh), fields, {}, {})));
    CHECK(text.find("Name=\"a&lt;b &amp; &quot;c&quot;\"") < text.size());
}

TEST_CASE("adding a field of the same name replaces it in a copy") {
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

TEST_CASE("fields given together equal fields added one by one") {
    testing::property("fields with repeated names equal those added one by one", [](std::uint64_t seed) {
        generated::Random random(seed);
        std::vector<MeshField> fields;
        MeshFields one_by_one;
        for (std::size_t i = 0, n = random.below(12); i < n; ++i) {
            fields.push_back({std::string(1, "abcd"[random.below(4)]),
                              random.below(2) == 0 ? Centring::node : Centring::cell, FieldKind::scalar,
                              Column<std::int32_t>(Buffer<std::int32_t>{static_cast<std::int32_t>(i)})});
            one_by_one = std::move(one_by_one).with(fields.back());
        }
        RC_ASSERT(MeshFields(std::move(fields)) == one_by_one);
    });
}

TEST_CASE("VTU reports corners and required entities that it cannot store") {
    LinearMesh<3> mesh;
    CHECK(not_in_vtu(as_mesh(mesh)).empty());
    mesh.corners = Buffer<VertexId>{VertexId(0)};
    mesh.edges.required = Buffer<std::uint32_t>{0, 1};
    const auto losses = not_in_vtu(as_mesh(mesh));
    REQUIRE(losses.size() == 2);
    CHECK(losses[0].what == "VTU has no place for 1 corners");
    CHECK(losses[1].what == "VTU has no place for 2 required entities");
}
