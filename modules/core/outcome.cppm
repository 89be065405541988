module;
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <tl/expected.hpp>
export module camber.core:outcome;
import :quoted;

export namespace camber {

/// What went wrong, coarsely: the shell maps it to an exit code.
enum class ErrorKind {
    usage,        ///< a wrong option or config: exit code 2
    input,        ///< a bad input file or mesh: 3
    unsupported,  ///< well-formed, but not something that Camber can hold: 3
    write,        ///< an output could not be written: 3
    stopped,      ///< the caller asked to stop: 130
    memory,       ///< not enough memory: 4
    internal,     ///< a broken promise of Camber itself: 4
};

/// A mesh entity as its file numbers it (from 1): `tetrahedron 1234`.
struct Entity {
    std::string kind;
    std::uint64_t number = 0;
};

/// Why a stage gave no value. `what` is one sentence without a full stop; `where` is a file with its
/// place (line or byte) or a JSON path; `remedy` says what the user can do. Printed by `describe`.
struct Error {
    ErrorKind kind = ErrorKind::internal;
    std::string what;
    std::string where;
    std::optional<Entity> entity;
    std::string remedy;
};

/// A value, or why there is none.
template <class T>
using Outcome = tl::expected<T, Error>;

/// The value of a successful stage that returns nothing else.
struct Done {};

/// An outcome without a value.
[[nodiscard]] inline tl::unexpected<Error> fail(Error error) { return tl::unexpected<Error>(std::move(error)); }

/// The same from the parts of an Error.
[[nodiscard]] inline tl::unexpected<Error> fail(ErrorKind kind, std::string what, std::string where = {},
                                                std::optional<Entity> entity = {}, std::string remedy = {}) {
    return tl::unexpected<Error>(Error{kind, std::move(what), std::move(where), std::move(entity), std::move(remedy)});
}

/// One line: `where: entity: what (remedy)`. Each part is at most 4096 bytes long, as paths are.
[[nodiscard]] inline std::string describe(const Error& e) {
    constexpr std::size_t longest = 4096;
    std::string line;
    if (!e.where.empty()) line += shortened(e.where, longest) + ": ";
    if (e.entity) line += e.entity->kind + " " + std::to_string(e.entity->number) + ": ";
    line += shortened(e.what, longest);
    if (!e.remedy.empty()) line += " (" + shortened(e.remedy, longest) + ")";
    return line;
}

}  // namespace camber
