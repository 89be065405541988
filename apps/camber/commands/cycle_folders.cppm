module;
#include <string>
#include <utility>
#include <vector>
export module camber.commands:cycle_folders;
import camber.core;
import camber.config;
import camber.run;

namespace camber::app {

/// The folder of all cycles, and within it one of each: a cycle's is made as a part, and has its name once all of it is
/// there.
class CycleFolders {
  public:
    /// In a place that is kept: new, or with its cycles up to `last` and their table. Errors: usage, there are cycles
    /// already, or none to go on from; input, the table; write.
    [[nodiscard]] static Outcome<CycleFolders> anew(const std::string& folder);
    [[nodiscard]] static Outcome<CycleFolders> going_on(const std::string& folder, int last);
    /// Beside a file, and gone in the end.
    [[nodiscard]] static Outcome<CycleFolders> passing(const std::string& beside);

    CycleFolders(const CycleFolders&) = delete;
    CycleFolders& operator=(const CycleFolders&) = delete;
    CycleFolders(CycleFolders&& other) noexcept;
    CycleFolders& operator=(CycleFolders&&) = delete;
    ~CycleFolders();

    [[nodiscard]] bool is_kept() const { return is_kept_; }
    [[nodiscard]] const std::string& path() const { return path_; }
    [[nodiscard]] const std::vector<run::CycleRow>& rows() const { return rows_; }

    /// An empty folder for a cycle that is being made.
    [[nodiscard]] Outcome<std::string> part_of_cycle(int cycle) const;
    [[nodiscard]] std::string of_cycle(int cycle) const;
    /// The part becomes the cycle's folder, and the row one of the table, written with the series.
    [[nodiscard]] Outcome<Done> add(const run::CycleRow& row, const std::string& view);

    /// Names of references of the first mesh, beside the cycles: their files may have no place for them. Errors: write;
    /// input, the file; none: there are no names.
    [[nodiscard]] Outcome<Done> store_groups(const run::Groups& groups) const;
    [[nodiscard]] Outcome<run::Groups> groups() const;

  private:
    CycleFolders(std::string path, bool is_kept) : path_(std::move(path)), is_kept_(is_kept) {}

    std::string path_;
    bool is_kept_;
    std::vector<run::CycleRow> rows_;
};

}  // namespace camber::app
