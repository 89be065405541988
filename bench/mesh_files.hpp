// Reads and writes meshes for programs that exit on failure. The includer imports camber.core and camber.io.
#pragma once

#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <ios>
#include <iterator>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace camber::bench {

template <class T>
T must(Outcome<T> outcome) {
    if (outcome) return std::move(*outcome);
    std::fprintf(stderr, "%s\n", describe(outcome.error()).c_str());
    std::exit(1);
}

inline std::vector<std::byte> bytes_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    const std::vector<char> chars{std::istreambuf_iterator<char>(file), {}};
    const auto bytes = std::as_bytes(std::span(chars));
    return {bytes.begin(), bytes.end()};
}

inline AnyMesh read_mesh(const std::string& path, const Execution& execution = {}) {
    return must(decode_mesh(bytes_of(path), path, execution)).mesh;
}

/// Writes a mesh in the format of the file name extension.
inline void write_mesh(const std::string& path, const AnyMesh& mesh) {
    const MeshFormat& format = *must(format_to_write(mesh_formats(), path));
    std::ofstream file(path, std::ios::binary);
    for (const auto& chunk : must(format.encode(mesh, {}, {}, Execution{})))
        file.write(reinterpret_cast<const char*>(chunk.data()), static_cast<std::streamsize>(chunk.size()));
    file.close();
    if (file) return;
    std::fprintf(stderr, "%s: cannot be written\n", path.c_str());
    std::exit(1);
}

}  // namespace camber::bench
