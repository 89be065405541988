module;
#include "cgns_library.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
module camber.io;
import camber.core;
import :cgns_reader;

/// How much the nodes of a file announce, before the library reads any: opening a file it reads many of them whole.
namespace camber::cgns {

namespace {

/// A file that only its nodes are asked of.
class Tree {
  public:
    Tree(const Library& lib, std::size_t file_bytes) : lib_(lib), file_bytes_(file_bytes), budget_(file_bytes) {}
    Tree(const Tree&) = delete;
    Tree& operator=(const Tree&) = delete;
    Tree(Tree&&) = delete;
    Tree& operator=(Tree&&) = delete;
    ~Tree() {
        if (is_open_) lib_.close_tree(file_);
    }

    /// What is no tree is told of by the library, which opens it next.
    [[nodiscard]] Outcome<Done> walk(const std::string& path, const std::string& name) {
        double root = 0;
        if (lib_.open_tree(path.c_str(), CGIO_MODE_READ, CGIO_FILE_NONE, &file_) != 0) return Done{};
        is_open_ = true;
        if (lib_.root_id(file_, &root) != 0) return Done{};
        return below(root, 0, name);
    }

  private:
    /// The standard's own trees are of twelve floors at most.
    static constexpr int max_depth = 32;
    static constexpr std::size_t bytes_of_a_node = 1024;  ///< in the library's memory

    [[nodiscard]] Outcome<Done> below(double node, int depth, const std::string& name) {
        int children = 0;
        if (depth > max_depth) return refused("has nodes nested deeper than " + std::to_string(max_depth), name);
        if (lib_.number_of_children(file_, node, &children) != 0) return Done{};
        for (int c = 1; c <= children; ++c) {
            double child = 0;
            int found = 0;
            cglong_t bytes = 0;
            if (lib_.children_ids(file_, node, c, 1, &found, &child) != 0 || found != 1) continue;
            // Nothing to ask of where a node has no data.
            const bool has_data = lib_.data_size(file_, child, &bytes) == 0 && bytes > 0;
            const bool fits =
                budget_.take(1, bytes_of_a_node) && (!has_data || budget_.take(static_cast<std::uint64_t>(bytes), 1));
            if (!fits)
                return refused("its nodes announce more than " +
                                   std::to_string(UnpackedBudget::most(file_bytes_) >> 20U) +
                                   " MiB, which is no mesh in a file of " + std::to_string(file_bytes_) + " bytes",
                               name);
            auto done = below(child, depth + 1, name);
            lib_.release_id(file_, child);
            if (!done) return done;
        }
        return Done{};
    }
    [[nodiscard]] static Outcome<Done> refused(std::string what, const std::string& name) {
        return fail(ErrorKind::input, std::move(what), name, {},
                    "the file is damaged; if it is whole, write it uncompressed");
    }

    const Library& lib_;
    std::size_t file_bytes_;
    UnpackedBudget budget_;
    int file_ = 0;
    bool is_open_ = false;
};

}  // namespace

Outcome<Done> check_nodes(const Library& lib, const std::string& path, std::size_t file_bytes,
                          const std::string& name) {
    return Tree(lib, file_bytes).walk(path, name);
}

}  // namespace camber::cgns
