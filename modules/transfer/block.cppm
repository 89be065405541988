module;
#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>
module camber.transfer:block;
import camber.core;
import :fields;

namespace camber {

/// All fields of one degree as one: the components of all of them side by side, which share matrices and places.
struct Block {
    int degree = 2;
    std::vector<std::size_t> fields;    ///< their numbers
    std::size_t components = 0;         ///< of all of them
    Buffer<double> old_values, values;  ///< at the old and at the new nodes
};

/// The block of a degree; `values` are those of all fields at the new nodes.
[[nodiscard]] inline Block block_of(int degree, std::span<const TransferField> fields,
                                    const std::vector<Buffer<double>>& values) {
    Block block{.degree = degree, .fields = {}, .components = 0, .old_values = {}, .values = {}};
    std::size_t old_nodes = 0, new_nodes = 0;
    for (std::size_t f = 0; f < fields.size(); ++f) {
        if (fields[f].degree != degree) continue;
        const auto components = static_cast<std::size_t>(fields[f].components);
        block.fields.push_back(f);
        block.components += components;
        old_nodes = fields[f].values.size() / components;
        new_nodes = values[f].size() / components;
    }
    block.old_values = Buffer<double>(old_nodes * block.components);
    block.values = Buffer<double>(new_nodes * block.components);
    std::size_t first = 0;
    const auto put = [&](const auto& from, std::size_t components, Buffer<double>& to) {
        for (std::size_t n = 0; n * components < from.size(); ++n)
            std::copy_n(from.data() + n * components, components, to.data() + n * block.components + first);
    };
    for (const std::size_t f : block.fields) {
        const auto components = static_cast<std::size_t>(fields[f].components);
        put(fields[f].values, components, block.old_values);
        put(values[f], components, block.values);
        first += components;
    }
    return block;
}

/// Puts the new values of a block back into those of its fields.
inline void put_back(const Block& block, std::span<const TransferField> fields, std::vector<Buffer<double>>& values) {
    std::size_t first = 0;
    for (const std::size_t f : block.fields) {
        const auto components = static_cast<std::size_t>(fields[f].components);
        for (std::size_t n = 0; n * components < values[f].size(); ++n)
            std::copy_n(block.values.data() + n * block.components + first, components,
                        values[f].data() + n * components);
        first += components;
    }
}

}  // namespace camber
