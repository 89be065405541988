module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>

#include <fmt/format.h>
module camber.run;
import camber.core;
import camber.io;
import :file_numbers;

namespace camber::run {

std::string called(std::size_t place, std::uint64_t tag) {
    return tag == 0 ? fmt::format("{}", place) : fmt::format("{} (tag {})", place, tag);
}

std::string name_in(const Groups& groups, int dimension, Reference reference) {
    const auto found = std::ranges::find_if(
        groups, [&](const Group& g) { return g.dimension == dimension && g.reference == reference; });
    return found == groups.end() ? std::string() : found->name;
}

std::string called(const Groups& groups, int dimension, Reference reference) {
    const std::string name = name_in(groups, dimension, reference);
    return name.empty() ? fmt::format("{}", reference) : fmt::format("{} {}", reference, name);
}

FileNumbers numbers_of(const DecodedMesh& mesh) { return {mesh.node_numbers, mesh.tags}; }

Groups groups_of(const AnyMesh& mesh) {
    return std::visit(
        [](const auto& m) {
            if constexpr (requires { m.linear; })
                return Groups(m.linear.groups.begin(), m.linear.groups.end());
            else
                return Groups(m.groups.begin(), m.groups.end());
        },
        mesh);
}

}  // namespace camber::run
