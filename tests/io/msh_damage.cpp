// Damaged MSH files give errors or the same value and never allocate memory for a false count.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "generated.hpp"
#include "msh_swapped.hpp"
#include "property.hpp"
#include "sanitized.hpp"

import camber.core;
import camber.bezier;
import camber.io;

using namespace camber;

namespace {

constexpr std::array kinds{
    MshOptions{MshVersion::v4, MshEncoding::binary}, MshOptions{MshVersion::v4, MshEncoding::ascii},
    MshOptions{MshVersion::v2, MshEncoding::binary}, MshOptions{MshVersion::v2, MshEncoding::ascii}};

/// True if all indices of a decoded mesh are in range.
bool is_consistent(const AnyMesh& any) {
    return std::visit(
        [](const auto& whole) {
            const auto mesh = straight_simplices(whole);
            const std::size_t n = mesh.points.size();
            bool consistent = mesh.point_references.size() == n;
            const auto check = [&](const auto& kind) {
                consistent = consistent && kind.references.size() == kind.size() && kind.entities.size() == kind.size();
                for (const auto& simplex : kind.vertices)
                    for (const VertexId v : simplex) consistent = consistent && v.index() < n;
            };
            check(mesh.elements);
            check(mesh.facets);
            check(mesh.edges);
            const auto check_associations = [&](const auto& all) {
                for (const auto& on : all) consistent = consistent && on.item.index() < n;
            };
            check_associations(mesh.geometry.on_points);
            check_associations(mesh.geometry.on_curves);
            check_associations(mesh.geometry.on_surfaces);
            return consistent;
        },
        any);
}

generated::Bytes some_file(std::uint64_t seed, MshOptions kind) {
    const auto mesh = generated::quadratic<3>(seed, 3);
    Buffer<double> values(mesh.linear.points.size() + mesh.edges.size(), 0.5);
    const auto fields = MeshFields{}.with({"u", Centring::node, FieldKind::scalar, Column<double>(std::move(values))});
    auto bytes = seed % 2 == 0 ? generated::joined(*encode_msh(as_mesh(generated::mesh<2>(seed, 4)), {}, kind, {}))
                               : generated::joined(*encode_msh(as_mesh(mesh), fields, kind, {}));
    return kind.encoding == MshEncoding::binary && seed % 4 < 2 ? msh_swapped::swapped(bytes) : bytes;
}

}  // namespace

TEST_CASE("an MSH file cut at any byte gives an error or the same mesh") {
    for (const MshOptions kind : kinds)
        for (const std::uint64_t seed : {1U, 2U}) {
            const auto whole = some_file(seed, kind);
            const auto mesh = decode_msh(whole, "file", {.threads = 1});
            REQUIRE(mesh.has_value());
            for (std::size_t n = 0; n < whole.size(); n += testing::less_if_sanitized(1, 2)) {
                const generated::Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(n));
                const auto decoded = decode_msh(cut, "file", {.threads = 1});
                CAPTURE(n);
                if (decoded) {
                    REQUIRE(decoded->mesh == mesh->mesh);
                } else {
                    REQUIRE(!decoded.error().what.empty());
                    REQUIRE(decoded.error().where.starts_with("file: "));
                }
            }
        }
}

TEST_CASE("an MSH file with noise gives an error or a consistent mesh") {
    testing::property("random bytes of an MSH file are replaced", [](std::uint64_t seed) {
        generated::Random random(seed);
        for (const MshOptions kind : kinds) {
            auto bytes = some_file(seed, kind);
            for (std::size_t i = 1 + random.below(6); i > 0; --i)
                bytes[random.below(bytes.size())] = static_cast<std::byte>(random.below(256));
            if (const auto decoded = decode_msh(bytes, "file", {.threads = 1}))
                RC_ASSERT(is_consistent(decoded->mesh));
            else
                RC_ASSERT(decoded.error().where.starts_with("file"));
        }
    });
}

TEST_CASE("a text MSH file with any invalid word gives an error or a consistent mesh") {
    for (const MshVersion version : {MshVersion::v2, MshVersion::v4})
        for (const std::uint64_t seed : {1U, 2U}) {
            const std::string text = generated::text_of(some_file(seed, {version, MshEncoding::ascii}));
            std::size_t attempts = 0;
            for (std::size_t at = 0; at < text.size();) {
                const std::size_t end = std::min(text.find_first_of(" \n", at), text.size());
                for (const std::string_view word : {"-1", "2147483647", "-2147483648", "999999999999999999",
                                                    "-9223372036854775808", "1e400", "x", ""}) {
                    if (++attempts % testing::less_if_sanitized(1, 3) != 0)
                        continue;  // 3: a different word at each
                                   // position
                    const std::string changed = text.substr(0, at) + std::string(word) + text.substr(end);
                    const auto decoded = decode_msh(generated::bytes_of(changed), "file", {.threads = 1});
                    CAPTURE(changed);
                    if (decoded)
                        REQUIRE(is_consistent(decoded->mesh));
                    else
                        REQUIRE(decoded.error().kind != ErrorKind::memory);
                }
                at = end + 1;
            }
        }
}

TEST_CASE("a binary MSH file with any invalid number gives an error or a consistent mesh") {
    for (const MshOptions kind : {kinds[0], kinds[2]})
        for (const std::uint64_t seed : {1U, 2U}) {
            const auto whole = some_file(seed, kind);
            for (std::size_t at = 0; at + 8 <= whole.size(); ++at)
                for (const int high : {0x7f, 0x80, 0xff}) {
                    if (testing::is_sanitized && high != std::array{0x7f, 0x80, 0xff}[at % 3]) continue;
                    auto bytes = whole;
                    for (std::size_t i = 0; i < 8; ++i) bytes[at + i] = static_cast<std::byte>(high);
                    const auto decoded = decode_msh(bytes, "file", {.threads = 1});
                    CAPTURE(at);
                    if (decoded)
                        REQUIRE(is_consistent(decoded->mesh));
                    else
                        REQUIRE(decoded.error().kind != ErrorKind::memory);
                }
        }
}
