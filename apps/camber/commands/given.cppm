module;
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>
export module camber.commands:given;
import camber.core;
import camber.app_shell;
import camber.config;
import camber.distributed;
import camber.io;
import camber.run;

/// Runs of programs that have their meshes in memory and not in files.
export namespace camber::app {

/// What a caller has, by the names that a config or a verb's arguments have it by (config::is_in_memory).
struct Given {
    std::map<std::string, DecodedMesh, std::less<>> meshes = {};
    std::map<std::string, Solution, std::less<>> metrics = {};  ///< rows as a file of the mesh has them
    std::map<std::string, std::vector<run::NamedField>, std::less<>> solutions = {};
    run::Groups groups = {};  ///< names of references of an input mesh whose file has none
};

/// Where the names of references of a run's mesh are stored.
enum class NamesOfGroups : std::uint8_t {
    in_its_file,    ///< those that the format has no place for are lost, and reported
    by_the_caller,  ///< the caller has them
};

/// Whom a run is for: what it has in memory, who may stop it, who is told how far it is, and who shares it.
struct Host {
    Given given = {};
    NamesOfGroups names = NamesOfGroups::in_its_file;
    std::stop_token stop = stop_on_signals();
    ProgressTold told = {};  ///< none: the terminal
    std::shared_ptr<Ranks> ranks = one_rank();
    GraphPartitioner partition = {};  ///< of what several ranks hold; none: there is none
};

/// Those outputs that are files.
[[nodiscard]] config::Output files_of(config::Output output);

}  // namespace camber::app
