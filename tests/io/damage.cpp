// Damaged GMF files give errors or the same value.
#include "any_mesh.hpp"
#include "binary_file.hpp"
#include "generated.hpp"
#include "property.hpp"

#include <cstdint>
#include <limits>
#include <string>
#include <variant>

using namespace camber;

namespace {

const GmfOptions all_options[] = {
    {GmfEncoding::ascii, 2}, {GmfEncoding::binary, 2}, {GmfEncoding::binary, 3}, {GmfEncoding::binary, 4}};

template <class Mesh>
void check_truncation(const Mesh& mesh) {
    for (const GmfOptions options : all_options) {
        const auto whole = generated::joined(*encode_gmf_mesh(as_mesh(mesh), options, {}));
        for (std::size_t n = 0; n < whole.size(); ++n) {
            const generated::Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(n));
            const auto decoded = decode_gmf_mesh(cut, "file", {.threads = 1});
            CAPTURE(n);
            if (decoded && !decoded->notices.empty()) {  // cut at the end of a block, which is reported
                REQUIRE(decoded->notices[0].what == "the file has no keyword End, so it may be incomplete");
                REQUIRE(options.encoding == GmfEncoding::ascii);
            } else if (decoded) {
                REQUIRE(testing::holds<Mesh>(decoded->mesh));
                REQUIRE(testing::mesh_in<Mesh>(decoded->mesh) == mesh);
            } else {
                REQUIRE(!decoded.error().what.empty());
                REQUIRE(decoded.error().where.starts_with("file: "));
            }
        }
    }
}

/// True if all indices of a decoded mesh are in range.
template <int D>
bool is_consistent(const Mesh<D>& decoded_mesh) {
    const LinearMesh<D> mesh = straight_simplices(decoded_mesh);
    const std::size_t n = mesh.points.size();
    bool consistent = mesh.point_references.size() == n;
    const auto check = [&](const auto& kind) {
        consistent = consistent && kind.references.size() == kind.size();
        for (const auto& simplex : kind.vertices)
            for (const VertexId v : simplex) consistent = consistent && v.index() < n;
        for (const std::uint32_t i : kind.required) consistent = consistent && i < kind.size();
    };
    check(mesh.elements);
    check(mesh.facets);
    check(mesh.edges);
    for (const VertexId v : mesh.corners) consistent = consistent && v.index() < n;
    for (const auto& at : mesh.geometry.normals.at)
        consistent = consistent && at.vertex.index() < n && at.row < mesh.geometry.normals.table.size();
    return consistent && decoded_mesh.edge_nodes.size() == decoded_mesh.entities.edges.size();
}

void check_decoding(const generated::Bytes& bytes) {
    if (const auto mesh = decode_gmf_mesh(bytes, "file", {.threads = 1}))
        RC_ASSERT(std::visit([](const auto& m) { return is_consistent(m); }, mesh->mesh));
    if (const auto solution = decode_gmf_solution(bytes, "file", {.threads = 1}))
        RC_ASSERT(solution->solution.values.size() == solution->solution.rows * row_width(solution->solution));
}

generated::Bytes some_file(std::uint64_t seed) {
    const GmfOptions options = all_options[seed % 4];
    generated::Random random(seed);
    if (seed % 3 == 0) return generated::joined(*encode_gmf_mesh(as_mesh(generated::mesh<2>(seed, 4)), options, {}));
    if (seed % 3 == 1)
        return generated::joined(*encode_gmf_mesh(as_mesh(generated::quadratic<3>(seed, 3)), options, {}));
    Solution solution{.dimension = 3, .fields = {FieldKind::symmetric_tensor, FieldKind::scalar}, .rows = 3};
    Buffer<double> values;
    for (int i = 0; i < 21; ++i) values.push_back(random.real());
    solution.values = std::move(values);
    return generated::joined(*encode_gmf_solution(solution, options, {}));
}

}  // namespace

TEST_CASE("a GMF file cut at any byte gives an error or the same mesh") {
    check_truncation(generated::mesh<2>(2, 3));
    check_truncation(generated::mesh<3>(2, 2));
    check_truncation(generated::quadratic<2>(2, 2));
    check_truncation(generated::quadratic<3>(2, 2));
}

TEST_CASE("a GMF file with noise gives an error or a consistent mesh") {
    testing::property("random bytes are replaced",
                      [](std::uint64_t seed) {
                          auto bytes = some_file(seed);
                          generated::Random random(seed);
                          for (std::size_t i = 0, n = 1 + random.below(6); i < n; ++i)
                              bytes[random.below(bytes.size())] =
                                  static_cast<std::byte>(random.below(4) == 0 ? 0xff : random.below(256));
                          check_decoding(bytes);
                      },
                      {.count = 3000});
    testing::property("a piece of the file is copied to another position",
                      [](std::uint64_t seed) {
                          auto bytes = some_file(seed);
                          generated::Random random(seed);
                          const std::size_t from = random.below(bytes.size()),
                                            length = random.below(bytes.size() - from);
                          const generated::Bytes piece(bytes.begin() + static_cast<std::ptrdiff_t>(from),
                                                       bytes.begin() + static_cast<std::ptrdiff_t>(from + length));
                          bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(random.below(bytes.size())),
                                       piece.begin(), piece.end());
                          check_decoding(bytes);
                      },
                      {.count = 500});
    testing::property("random bytes follow the header",
                      [](std::uint64_t seed) {
                          generated::Random random(seed);
                          generated::Bytes bytes = random.below(2) == 0
                                                       ? generated::bytes_of("MeshVersionFormatted 2 Dimension 3 ")
                                                       : BinaryFile(1 + static_cast<int>(random.below(4)), false).bytes;
                          for (std::size_t i = 0, n = random.below(300); i < n; ++i)
                              bytes.push_back(static_cast<std::byte>(random.below(3) == 0 ? 0 : random.below(256)));
                          check_decoding(bytes);
                      },
                      {.count = 2000});
}

TEST_CASE("GMF files with excessive counts are rejected") {
    for (const int version : {2, 4})
        for (const std::int32_t keyword : {4, 5, 6, 8, 13, 14, 20, 24, 25, 30, 42, 60, 62, 127, 129, 133})
            for (const std::int64_t count :
                 {std::int64_t{2000000000}, std::int64_t{-1}, std::numeric_limits<std::int64_t>::max() / 4}) {
                BinaryFile file(version, false);
                file.dimension(3);
                if (keyword != 4) {
                    file.block(4, 1);
                    for (int c = 0; c < 3; ++c) file.real(0);
                    file.integer(0);
                    file.close();
                }
                if (keyword >= 127) {  // orderings are read only if there are rows to order
                    file.block(keyword == 127 ? 25 : keyword == 129 ? 24 : 30, 0);
                    file.close();
                }
                file.block(keyword, count);
                file.word(std::int32_t{1});
                file.word(std::int32_t{1});
                file.close();
                file.end();
                if (keyword == 62)
                    CHECK(!decode_gmf_solution(file.bytes, "file", {}));
                else if (version == 4 || count != std::numeric_limits<std::int64_t>::max() / 4)
                    CHECK(!decode_gmf_mesh(file.bytes, "file", {}));
            }
    CHECK(!decode_gmf_mesh(generated::bytes_of("MeshVersionFormatted 2 Dimension 3 Vertices 9000000000000000000 1 End"),
                           "file", {}));
    CHECK(!decode_gmf_solution(
        generated::bytes_of("MeshVersionFormatted 2 Dimension 3 SolAtVertices 1 1000000000 1 End"), "file", {}));
}
