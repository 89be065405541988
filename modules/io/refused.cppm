module;
#include <cstddef>
#include <string>
#include <utility>
#include <vector>
module camber.io:refused;
import camber.core;
import :decode_options;

namespace camber {

/// What is to be done about cells that are not held.
inline constexpr const char* simplices_remedy =
    "give a mesh of edges, triangles and tetrahedra of degree 1 or 2; \"camber info FILE\" counts its cells and tells "
    "what splits them";

/// Counts what a file holds and Camber cannot, kind by kind in the order of their first mention.
class Refused {
  public:
    /// `kind`: in the plural.
    void count(const std::string& kind, std::size_t number = 1) {
        for (auto& [name, counted] : kinds_)
            if (name == kind) {
                counted += number;
                return;
            }
        if (kinds_.size() < max_kinds)
            kinds_.push_back({kind, number});
        else
            others_ += number;
    }

    [[nodiscard]] bool any() const { return !kinds_.empty(); }
    /// All of them, by kind.
    [[nodiscard]] std::vector<CellCount> counts() const {
        std::vector<CellCount> counts(kinds_);
        if (others_ > 0) counts.push_back({"of other kinds", others_});
        return counts;
    }

    /// Nothing where they are only counted; else an error of kind unsupported that names them all, if there are any.
    [[nodiscard]] Outcome<Done> verdict(std::string where, Unheld unheld) const {
        return unheld == Unheld::count ? Outcome<Done>(Done{}) : verdict(std::move(where));
    }
    /// An error of kind unsupported that names them all, if there are any.
    [[nodiscard]] Outcome<Done> verdict(std::string where) const {
        if (kinds_.empty()) return Done{};
        std::string text;
        constexpr std::size_t most = 12;
        for (std::size_t i = 0; i < kinds_.size() && i < most; ++i)
            text += (text.empty() ? "" : ", ") + std::to_string(kinds_[i].count) + " " + kinds_[i].kind;
        if (kinds_.size() > most || others_ > 0) text += " and more";
        return fail(ErrorKind::unsupported, "holds " + text + ", which Camber cannot hold", std::move(where), {},
                    simplices_remedy);
    }

  private:
    /// A damaged file may have any number of kinds.
    static constexpr std::size_t max_kinds = 64;
    std::size_t others_ = 0;
    std::vector<CellCount> kinds_;
};

}  // namespace camber
