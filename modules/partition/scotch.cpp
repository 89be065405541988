module;
#include <cstddef>
#include <cstdint>
#include <cstdio>
// Needed by scotch.h, which uses FILE.
#include <scotch.h>

#include <algorithm>
#include <limits>
#include <type_traits>
module camber.partition;
import camber.core;

namespace camber {

namespace {

constexpr int done = 0;

template <class Structure, int (*begin)(Structure*), void (*end)(Structure*)>
class ScotchStructure {
  public:
    ScotchStructure() : is_valid_(begin(&structure_) == done) {}
    ScotchStructure(const ScotchStructure&) = delete;
    ScotchStructure(ScotchStructure&&) = delete;
    ScotchStructure& operator=(const ScotchStructure&) = delete;
    ScotchStructure& operator=(ScotchStructure&&) = delete;
    ~ScotchStructure() {
        if (is_valid_) end(&structure_);
    }
    [[nodiscard]] bool is_valid() const { return is_valid_; }
    [[nodiscard]] Structure* get() { return &structure_; }

  private:
    Structure structure_{};
    bool is_valid_;
};
using Graph = ScotchStructure<SCOTCH_Graph, SCOTCH_graphInit, SCOTCH_graphExit>;
using Strategy = ScotchStructure<SCOTCH_Strat, SCOTCH_stratInit, SCOTCH_stratExit>;
using Context = ScotchStructure<SCOTCH_Context, SCOTCH_contextInit, SCOTCH_contextExit>;

auto failed() { return fail(ErrorKind::internal, "Scotch could not partition the mesh"); }

}  // namespace

Outcome<Buffer<std::int32_t>> parts_of_graph(const DualGraph& graph, std::size_t parts) {
    constexpr auto most = static_cast<std::size_t>(std::numeric_limits<SCOTCH_Num>::max());
    if (graph.neighbours.size() >= most || graph.size() >= most)
        return fail(ErrorKind::unsupported, "has more faces between elements than Scotch can number", {}, {},
                    "build with a Scotch of 64-bit integers");
    if (graph.size() == 0) return Buffer<std::int32_t>();
    const Buffer<SCOTCH_Num> starts(graph.starts.begin(), graph.starts.end());
    const Buffer<SCOTCH_Num> neighbours(graph.neighbours.begin(), graph.neighbours.end());
    Buffer<SCOTCH_Num> part(graph.size());
    Graph whole, bound;
    Strategy strategy;
    Context context;
    if (!whole.is_valid() || !bound.is_valid() || !strategy.is_valid() || !context.is_valid()) return failed();
    // One thread and a fixed seed make the result reproducible.
    if (SCOTCH_contextOptionSetNum(context.get(), SCOTCH_OPTIONNUMDETERMINISTIC, 1) != done ||
        SCOTCH_contextOptionSetNum(context.get(), SCOTCH_OPTIONNUMRANDOMFIXEDSEED, 1) != done ||
        SCOTCH_contextRandomClone(context.get()) != done ||
        SCOTCH_contextThreadSpawn(context.get(), 1, nullptr) != done)
        return failed();
    SCOTCH_contextRandomSeed(context.get(), 1);
    SCOTCH_contextRandomReset(context.get());
    if (SCOTCH_graphBuild(whole.get(), 0, static_cast<SCOTCH_Num>(graph.size()), starts.data(), nullptr, nullptr,
                          nullptr, static_cast<SCOTCH_Num>(neighbours.size()), neighbours.data(), nullptr) != done ||
        SCOTCH_contextBindGraph(context.get(), whole.get(), bound.get()) != done ||
        SCOTCH_graphPart(bound.get(), static_cast<SCOTCH_Num>(parts), strategy.get(), part.data()) != done)
        return failed();
    return Buffer<std::int32_t>(part.begin(), part.end());
}

}  // namespace camber
