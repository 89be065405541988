#include "generated.hpp"
#include "property.hpp"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

using namespace camber;

namespace {

Solution some_solution(std::uint64_t seed) {
    generated::Random random(seed);
    Solution solution{.dimension = 2 + static_cast<int>(random.below(2)), .rows = random.below(30)};
    for (std::size_t i = 0, n = 1 + random.below(4); i < n; ++i)
        solution.fields.push_back(FieldKind{1 + static_cast<int>(random.below(4))});
    Buffer<double> values;
    for (std::size_t i = 0; i < solution.rows * row_width(solution); ++i) values.push_back(random.real());
    solution.values = std::move(values);
    return solution;
}

std::string message(const std::string& text) {
    const auto decoded = decode_gmf_solution(generated::bytes_of(text), "in.sol", {});
    return decoded ? "no error" : describe(decoded.error());
}

}  // namespace

TEST_CASE("GMF solutions are restored to the last bit") {
    testing::property("decoding an encoded solution restores it", [](std::uint64_t seed) {
        const auto solution = some_solution(seed);
        const GmfOptions options{*rc::gen::element(GmfEncoding::ascii, GmfEncoding::binary),
                                 *rc::gen::element(0, 2, 3, 4)};
        const auto bytes = generated::joined(*encode_gmf_solution(solution, options, {}));
        const auto back = decode_gmf_solution(bytes, "file", {});
        if (!back) RC_FAIL(describe(back.error()));
        RC_ASSERT(back->solution == solution);
        RC_ASSERT(generated::same_bits(back->solution.values, solution.values));
        RC_ASSERT(back->notices.empty());
    });
}

TEST_CASE("a truncated GMF solution gives an error or the same solution") {
    testing::property("a solution that is cut anywhere gives an error or the same solution", [](std::uint64_t seed) {
        const auto solution = some_solution(seed);
        const GmfOptions options{*rc::gen::element(GmfEncoding::ascii, GmfEncoding::binary), *rc::gen::element(0, 4)};
        auto bytes = generated::joined(*encode_gmf_solution(solution, options, {}));
        bytes.resize(*rc::gen::inRange<std::size_t>(0, bytes.size()));
        const auto back = decode_gmf_solution(bytes, "file", {});
        RC_ASSERT(!back || back->solution == solution);
    });
}

TEST_CASE("GMF text solutions have one row per line") {
    Solution solution{.dimension = 2, .fields = {FieldKind::symmetric_tensor}, .rows = 2};
    solution.values = Buffer<double>{1, 0.25, 3, 4, -5e-7, 6};
    const auto text = generated::text_of(generated::joined(*encode_gmf_solution(solution, {GmfEncoding::ascii}, {})));
    CHECK(text == "MeshVersionFormatted 2\n\nDimension 2\n\nSolAtVertices\n2\n1 3\n1 0.25 3\n4 -5e-07 6\n\nEnd\n");
}

TEST_CASE("invalid GMF solutions are rejected") {
    const std::string head = "MeshVersionFormatted 2\nDimension 3\n";
    CHECK(message(head + "Vertices 0 End") ==
          "in.sol: line 1: the file has no SolAtVertices (give a solution (.sol, .solb))");
    CHECK(message(head + "SolAtVertices 1 1 7 0 End") ==
          "in.sol: line 3: a field of SolAtVertices has type 7, not 1 to 4");
    CHECK(message(head + "SolAtVertices 1 0 End") == "in.sol: line 3: SolAtVertices has no list of fields");
    CHECK(message(head + "SolAtVertices 2\n2 1 2\n0 0 0 0\n0 0 nan 0\nEnd") ==
          "in.sol: line 6: vertex 2: a value is infinite or not a number (the program that wrote the file failed "
          "there. Write it again)");
    CHECK(message(head + "SolAtVertices 2\n1 1\n0\nEnd").starts_with("in.sol: line 3: SolAtVertices announces 2 rows"));

    Solution solution{.dimension = 3, .fields = {FieldKind::scalar}, .rows = 2};
    CHECK(encode_gmf_solution(solution, {}, {}).error().kind == ErrorKind::usage);
    solution.fields.clear();
    CHECK(encode_gmf_solution(solution, {}, {}).error().kind == ErrorKind::usage);
}
