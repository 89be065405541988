// camber.repair from outside: a mesh is read, repaired in memory by one call, and written. The bytes are those of
// `camber repair MESH -o OUT`, whose defaults these are.
#include <cstddef>
#include <fstream>
#include <ios>
#include <iterator>
#include <span>
#include <string>
#include <utility>
#include <variant>

import camber.core;
import camber.bezier;
import camber.io;
import camber.repair;

using namespace camber;

int main(int, char** arguments) {
    const Execution all;
    std::ifstream file(arguments[1], std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    const auto bytes = std::as_bytes(std::span(text));
    const auto decoded = (*format_to_read(mesh_formats(), bytes, arguments[1]))->decode(bytes, arguments[1], all);
    const auto repaired = repair_mesh(std::get<QuadraticMesh<3>>(decoded.value().mesh), {}, all);
    const auto* format = *format_to_write(mesh_formats(), arguments[2]);
    const auto chunks = format->encode(repaired.value().mesh, {}, {}, all);
    std::ofstream out(arguments[2], std::ios::binary);
    for (const auto& chunk : chunks.value())
        out.write(reinterpret_cast<const char*>(chunk.data()), static_cast<std::streamsize>(chunk.size()));
    return repaired->after.all_valid() ? 0 : 1;
}
