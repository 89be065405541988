// Usage: recipes VERB IN OUT. Reads a mesh, curves, remeshes, repairs or adapts it in memory by one call, and writes
// it. The bytes equal those of `camber VERB IN -o OUT` with default options; `adapt` uses the field and the numbers
// below.
#include <cstddef>
#include <cstdio>
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
import camber.recipes;

using namespace camber;

static Outcome<Mesh<3>> run_recipe(const std::string& verb, Mesh<3> mesh, const StepWrapper& around) {
    const auto taken = [](auto of) { return std::move(of.mesh); };
    if (verb == "curve") return curve_mesh<3>(std::move(mesh), {}, {}, around).map(taken);
    if (verb == "repair")
        return run_step(around, "repair",
                        [&](const Execution& e) { return repair_mesh(std::move(mesh), {}, e).map(taken); });
    if (verb == "adapt")
        return adapt_mesh<3>(std::move(mesh), "tanh((z-1)/0.3)", {.cycles = {.cycles = 2, .complexity = {300}}}, around)
            .map(taken);
    return remesh_mesh<3>(std::move(mesh), {}, {}, around).map(taken);
}

int main(int, char** arguments) {
    const Execution all;
    const std::string verb = arguments[1], in = arguments[2], out = arguments[3];
    std::ifstream file(in, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    const auto bytes = std::as_bytes(std::span(text));
    const auto decoded = decode_mesh(bytes, in, all);
    const auto mesh = run_recipe(verb, std::get<Mesh<3>>(decoded.value().mesh), without_wrapper(all));
    if (!mesh) {
        std::fprintf(stderr, "%s\n", describe(mesh.error()).c_str());
        return 1;
    }
    const auto chunks = (*format_to_write(mesh_formats(), out))->encode(*mesh, {}, {}, all);
    std::ofstream to(out, std::ios::binary);
    for (const auto& chunk : chunks.value())
        to.write(reinterpret_cast<const char*>(chunk.data()), static_cast<std::streamsize>(chunk.size()));
    return 0;
}
