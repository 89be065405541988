// Round trips of GMF files.
#include "any_mesh.hpp"
#include "generated.hpp"
#include "property.hpp"
#include "sanitized.hpp"

#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <variant>

using namespace camber;

namespace {

template <class Mesh>
Mesh decoded(const Chunks& chunks, const Execution& execution = {}) {
    const auto bytes = generated::joined(chunks);
    auto back = decode_gmf_mesh(bytes, "file", execution);
    if (!back) RC_FAIL(describe(back.error()));
    RC_ASSERT(back->notices.empty());
    RC_ASSERT(back->node_numbers.empty());  // encoders write mid nodes after the vertices, in the order of edges
    RC_ASSERT(testing::holds<Mesh>(back->mesh));
    return testing::mesh_in<Mesh>(back->mesh);
}

GmfOptions some_options() {
    return {*rc::gen::element(GmfEncoding::ascii, GmfEncoding::binary), *rc::gen::element(0, 2, 3, 4)};
}

template <int D>
void linear_round_trip(std::uint64_t seed) {
    const auto mesh = generated::mesh<D>(seed, *rc::gen::inRange<std::size_t>(0, 40));
    const auto back = decoded<LinearMesh<D>>(*encode_gmf_mesh(as_mesh(mesh), some_options(), {}));
    RC_ASSERT(back == mesh);
    RC_ASSERT(generated::same_bits(back.points, mesh.points));
    RC_ASSERT(generated::same_bits(generated::numbers_of(back.geometry.on_surfaces),
                                   generated::numbers_of(mesh.geometry.on_surfaces)));
}

template <int D>
void quadratic_round_trip(std::uint64_t seed) {
    const auto mesh = generated::quadratic<D>(seed, *rc::gen::inRange<std::size_t>(1, 40));
    RC_PRE(generated::holds_simplices(mesh.linear));
    const auto back = decoded<QuadraticMesh<D>>(*encode_gmf_mesh(as_mesh(mesh), some_options(), {}));
    RC_ASSERT(back == mesh);
    RC_ASSERT(generated::same_bits(back.mid_nodes, mesh.mid_nodes));
}

}  // namespace

TEST_CASE("GMF files restore the encoded mesh") {
    testing::property("linear 2D", linear_round_trip<2>);
    testing::property("linear 3D", linear_round_trip<3>);
    testing::property("quadratic 2D", quadratic_round_trip<2>);
    testing::property("quadratic 3D", quadratic_round_trip<3>);
}

TEST_CASE("GMF files and meshes do not depend on the number of threads") {
    // Large enough for several chunks of binary rows and several pieces of text.
    const auto mesh = generated::quadratic<3>(5, testing::less_if_sanitized(20000, 9000));
    for (const GmfEncoding encoding : {GmfEncoding::ascii, GmfEncoding::binary}) {
        const auto one = generated::joined(*encode_gmf_mesh(as_mesh(mesh), {encoding}, {.threads = 1}));
        const auto four = generated::joined(*encode_gmf_mesh(as_mesh(mesh), {encoding}, {.threads = 4}));
        CHECK(one == four);
        for (const int threads : {1, 4}) {
            const auto back = decode_gmf_mesh(one, "file", {.threads = threads});
            REQUIRE(back);
            CHECK(testing::mesh_in<QuadraticMesh<3>>(back->mesh) == mesh);
        }
    }
}

TEST_CASE("GMF text is read with any blanks, line ends and comments") {
    testing::property("blanks, line ends and comments do not change the mesh", [](std::uint64_t seed) {
        const auto mesh = generated::mesh<3>(seed, 6);
        const auto plain =
            generated::text_of(generated::joined(*encode_gmf_mesh(as_mesh(mesh), {GmfEncoding::ascii}, {})));
        generated::Random random(seed);
        std::string text = random.below(2) == 0 ? "" : "# Vertices 3\n";
        const std::string_view separators[] = {" ",   "\t",  "\n", "\r\n", "  ", " # comment with End and 7\n",
                                               "#\n", "\n\n"};
        for (const char c : plain)
            if (c == ' ' || c == '\n')
                text += separators[random.below(std::size(separators))];
            else
                text += c;
        const auto back = decode_gmf_mesh(generated::bytes_of(text), "file", {});
        if (!back) RC_FAIL(describe(back.error()));
        RC_ASSERT(testing::mesh_in<LinearMesh<3>>(back->mesh) == mesh);
    });
}

TEST_CASE("the GMF encoder writes the requested version") {
    const auto mesh = generated::mesh<2>(3, 4);
    const auto version_of = [&](int requested) {
        return static_cast<int>(
            generated::joined(*encode_gmf_mesh(as_mesh(mesh), {GmfEncoding::binary, requested}, {}))[4]);
    };
    CHECK(version_of(0) == 2);
    CHECK(version_of(3) == 3);
    CHECK(version_of(4) == 4);
    for (const int requested : {-1, 1, 5}) {
        const auto chunks = encode_gmf_mesh(as_mesh(mesh), {GmfEncoding::binary, requested}, {});
        REQUIRE(!chunks);
        CHECK(chunks.error().kind == ErrorKind::usage);
    }
}

TEST_CASE("GMF omits empty blocks except Vertices") {
    const auto text =
        generated::text_of(generated::joined(*encode_gmf_mesh(as_mesh(LinearMesh<2>{}), {GmfEncoding::ascii}, {})));
    CHECK(text == "MeshVersionFormatted 2\n\nDimension 2\n\nVertices\n0\n\nEnd\n");
}
