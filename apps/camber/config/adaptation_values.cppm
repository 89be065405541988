module;
#include <cstdint>
#include <string>
#include <tuple>
#include <vector>
export module camber.config:adaptation_values;
import camber.core;

/// What a config says of adapting a mesh turn after turn, as plain values.
export namespace camber::config {

/// Which cycle's mesh is the result of an adaptation.
enum class ResultOfCycles : std::uint8_t { automatic, best, last };
[[nodiscard]] constexpr auto words(ResultOfCycles) {
    return words_of(Word{ResultOfCycles::automatic, "auto"}, Word{ResultOfCycles::best, "best"},
                    Word{ResultOfCycles::last, "last"});
}

/// Cycles of a pipeline's stages, each on the mesh that the one before made; a solver may be asked for the solution
/// after each.
struct Adaptation {
    int cycles = 0;                       ///< 0: the stages run once
    std::vector<double> complexity = {};  ///< by cycle, the last for all after it; empty: as the metric says
    std::vector<std::string> solve = {};  ///< a command and its arguments; empty: nobody is asked
    double seconds = 0;                   ///< that it may take; 0: any
    std::string folder = {};              ///< empty: beside the mesh that is made, and gone in the end
    std::string mesh = "mesh.meshb", solution = "solution.sol";  ///< names of files within a cycle's folder
    std::string exact = {};                                      ///< empty: not known
    double settled = 0.1;
    ResultOfCycles result = ResultOfCycles::automatic;

    [[nodiscard]] bool is_asked() const { return cycles > 0; }

    [[nodiscard]] static constexpr auto options() {
        using S = Adaptation;
        return std::tuple(
            option("cycles", &S::cycles,
                   "how often the stages run at most, each time on the mesh that they made before; 0: once, and "
                   "nothing else of this counts")
                .at_least(0)
                .at_most(1000),
            option("complexity", &S::complexity,
                   "the metric's complexity by cycle, the last one for all after it; empty: as the metric says")
                .above(0)
                .count(0, 1000),
            option("solve", &S::solve,
                   "a command and its arguments, run without a shell for the solution on the first mesh and on every "
                   "one that is made; in them {mesh} and {solution} are the files that it reads and is to write, "
                   "{guess} the solution before, brought to the mesh, {cycle} the cycle's number, {folder} its folder. "
                   "Empty: none. camber run takes it with --allow-commands alone")
                .count(0, 1000),
            option("seconds", &S::seconds, "how long the command may take; 0: any time").unit("s").at_least(0),
            option("folder", &S::folder,
                   "where the cycles are kept, each in a folder of its own; empty: beside the output's mesh, with its "
                   "name and .cycles, where there is a command; else nothing is kept"),
            option("mesh", &S::mesh, "the name of a cycle's mesh file, whose ending is its format"),
            option("solution", &S::solution,
                   "the name of the file that the command writes: rows at the mesh's vertices or nodes, in its file's "
                   "order, or a mesh file with fields at its nodes"),
            option("exact", &S::exact,
                   "the exact solution as an expression of x, y and z, whose errors are told by cycle; empty: not "
                   "known"),
            option("settled", &S::settled,
                   "cycles end once the least error of the last complexity has fallen by no more than this share over "
                   "two cycles; without an error, once the unit edges in the metric of the mesh's own solution rise by "
                   "no more than a fifth of it in one; 0: never before their number")
                .at_least(0)
                .at_most(1),
            option("result", &S::result,
                   "best: the mesh with the least error among those of the last complexity; last: the mesh of the last "
                   "cycle; auto: last if the solver's command has {cycle}, with which each cycle may solve another "
                   "problem, otherwise best"));
    }
    friend bool operator==(const Adaptation&, const Adaptation&) = default;
};

}  // namespace camber::config
