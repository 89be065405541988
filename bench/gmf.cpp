// Time of binary GMF files compared with a copy of the same bytes.
#include <benchmark/benchmark.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

import camber.core;
import camber.bezier;
import camber.io;
import camber.shapes;

using namespace camber;

namespace {

const LinearMesh<3>& block() {
    static const LinearMesh<3> mesh = *generate(BoxOptions<3>{.cells = {55, 55, 55}});
    return mesh;
}
const QuadraticMesh<3>& quadratic_block() {
    static const QuadraticMesh<3> mesh = *elevate(block(), Execution{});
    return mesh;
}

std::vector<std::byte> joined(const Chunks& chunks) {
    std::vector<std::byte> bytes;
    for (const auto& chunk : chunks) bytes.insert(bytes.end(), chunk.begin(), chunk.end());
    return bytes;
}

template <class Mesh>
std::vector<std::byte> file_of(const Mesh& mesh) {
    return joined(*encode_gmf_mesh(as_mesh(mesh), GmfOptions{.encoding = GmfEncoding::binary}, Execution{}));
}

template <class Mesh>
void copy(benchmark::State& state, const Mesh& mesh) {
    const auto bytes = file_of(mesh);
    for (auto _ : state) {
        std::vector<std::byte> to(bytes.size());
        std::memcpy(to.data(), bytes.data(), bytes.size());
        benchmark::DoNotOptimize(to.data());
    }
    state.SetBytesProcessed(static_cast<std::int64_t>(state.iterations() * bytes.size()));
}

template <class Mesh>
void encode(benchmark::State& state, const Mesh& mesh) {
    const auto size = file_of(mesh).size();
    for (auto _ : state)
        benchmark::DoNotOptimize(
            encode_gmf_mesh(as_mesh(mesh), GmfOptions{.encoding = GmfEncoding::binary}, Execution{}));
    state.SetBytesProcessed(static_cast<std::int64_t>(state.iterations() * size));
}

template <class Mesh>
void decode(benchmark::State& state, const Mesh& mesh) {
    const auto bytes = file_of(mesh);
    for (auto _ : state) benchmark::DoNotOptimize(decode_gmf_mesh(bytes, "bench", Execution{}));
    state.SetBytesProcessed(static_cast<std::int64_t>(state.iterations() * bytes.size()));
}

}  // namespace

int main(int argc, char** argv) {
    const auto add = [](const char* name, auto run) {
        benchmark::RegisterBenchmark(name, run)->Unit(benchmark::kMillisecond)->UseRealTime();
    };
    add("linear/copy", [](benchmark::State& s) { copy(s, block()); });
    add("linear/encode", [](benchmark::State& s) { encode(s, block()); });
    add("linear/decode", [](benchmark::State& s) { decode(s, block()); });
    add("quadratic/copy", [](benchmark::State& s) { copy(s, quadratic_block()); });
    add("quadratic/encode", [](benchmark::State& s) { encode(s, quadratic_block()); });
    add("quadratic/decode", [](benchmark::State& s) { decode(s, quadratic_block()); });
    benchmark::Initialize(&argc, argv);
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
