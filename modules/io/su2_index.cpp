// Finds the blocks of an SU2 file.
module;
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io;
import camber.core;

namespace camber::su2 {

namespace {

auto fail_at(const std::string& place, std::string what, std::string remedy = damaged) {
    return fail(ErrorKind::input, std::move(what), place, {}, std::move(remedy));
}

std::optional<std::int64_t> number_of(std::string_view word) {
    Words words{word.data(), word.data() + word.size()};
    std::int64_t value = 0;
    if (!read_number(words, value)) return std::nullopt;
    return value;
}

class Index {
  public:
    Index(std::string_view text, std::string_view name) : lines_(text) {
        zone_.name = std::string(name);
        zone_.text = text;
    }

    Outcome<File> make() && {
        while (const auto line = lines_.next())
            if (auto done = take(*line); !done) return fail(std::move(done.error()));
        file_.ended = lines_.ended();
        if (auto ended = end_zone(zone_.end()); !ended) return fail(std::move(ended.error()));
        if (!std::cmp_equal(zones_, file_.zones.size()))
            return fail_at(file_.zones.front().end(), "NZONE announces " + std::to_string(zones_) + " zones, but " +
                                                          std::to_string(file_.zones.size()) + " follow");
        return std::move(file_);
    }

  private:
    Outcome<Done> end_zone(const std::string& place) {
        if (!zone_.dimension || !zone_.elements || !zone_.points)
            return fail_at(place, (zones_ > 1 ? "zone " + std::to_string(zone_.number) : std::string("the file")) +
                                      " lacks one of NDIME, NELEM and NPOIN");
        const std::size_t markers = zone_.markers.size() + zone_.parallel_markers;
        if (!std::cmp_equal(zone_.markers_announced.value_or(0), markers))
            return fail_at(place, "NMARK announces " + std::to_string(zone_.markers_announced.value_or(0)) +
                                      " markers, but " + std::to_string(markers) + " follow");
        file_.zones.push_back(std::move(zone_));
        zone_ = {};
        zone_.name = file_.zones.back().name;
        zone_.text = file_.zones.back().text;
        return Done{};
    }

    Outcome<Done> take(std::string_view line) {
        const auto [key, value] = entry_of(line);
        if (key.empty()) return unexpected_row(line);
        if (key == "MARKER_TAG") return marker(value);
        if (key == "NDIME") return single(line, value, zone_.dimension);
        if (key == "NMARK") return single(line, value, zone_.markers_announced);
        if (key == "NELEM") return block(line, value, zone_.elements);
        if (key == "NPOIN") return block(line, value, zone_.points);
        if (key == "NZONE") return zones(line, value);
        if (key == "IZONE") return begin_zone(line, value);
        if (zone_.foreign_blocks++ == 0) zone_.first_foreign = std::string(key.substr(0, 40));
        in_foreign_ = true;
        return Done{};
    }

    /// A row that follows no keyword is accepted in an unknown block, otherwise it is an error.
    Outcome<Done> unexpected_row(std::string_view line) {
        if (in_foreign_) return Done{};
        return fail_at(zone_.place(line), "is neither a keyword with = nor one of the announced rows");
    }

    Outcome<Done> single(std::string_view line, std::string_view value, std::optional<std::int64_t>& into) {
        in_foreign_ = false;
        const auto number = number_of(value);
        if (!number) return fail_at(zone_.place(line), "the number after = is missing or malformed");
        if (into) return fail_at(zone_.place(line), "occurs a second time", "remove one, or begin a zone (IZONE=)");
        into = number;
        return Done{};
    }

    Outcome<Done> zones(std::string_view line, std::string_view value) {
        in_foreign_ = false;
        const auto number = number_of(value);
        if (!number || *number < 1) return fail_at(zone_.place(line), "the number after = is missing or malformed");
        zones_ = *number;
        return Done{};
    }

    /// Begins a zone. Blocks before the first header of a zone belong to that zone.
    Outcome<Done> begin_zone(std::string_view line, std::string_view value) {
        in_foreign_ = false;
        const auto number = number_of(value);
        if (!number) return fail_at(zone_.place(line), "the number after = is missing or malformed");
        if (zone_.elements || zone_.points)
            if (auto ended = end_zone(zone_.place(line)); !ended) return ended;
        zone_.number = *number;
        return Done{};
    }

    Outcome<Block> rows(std::string_view line, std::string_view value) {
        in_foreign_ = false;
        const auto number = number_of(value);
        if (!number || *number < 0) return fail_at(zone_.place(line), "the number after = is missing or malformed");
        const auto count = static_cast<std::uint64_t>(*number);
        if (count > lines_.left() / 2 + 1)
            return fail_at(zone_.place(line), "announces " + std::to_string(count) + " rows, but fewer follow");
        if (count > max_entities)
            return fail(ErrorKind::unsupported, "has more rows than 32 bits can number", zone_.place(line));
        Lines ahead = lines_;  // between the count and the rows, a SEND_RECEIVE marker has a line SEND_TO
        if (const auto row = ahead.next(); row && entry_of(*row).key == "SEND_TO") lines_ = ahead;
        Block result{static_cast<std::size_t>(count), lines_};
        for (std::size_t i = 0; i < result.count; ++i) {
            const auto row = lines_.next();
            if (!row || row->find('=') != std::string_view::npos)
                return fail_at(row ? zone_.place(*row) : zone_.end(),
                               "row " + std::to_string(i + 1) + " of " + std::to_string(count) + " is missing");
        }
        return result;
    }

    Outcome<Done> block(std::string_view line, std::string_view value, std::optional<Block>& into) {
        if (into) return fail_at(zone_.place(line), "occurs a second time", "remove one, or begin a zone (IZONE=)");
        return rows(line, value).map([&](Block result) {
            into = std::move(result);
            return Done{};
        });
    }

    Outcome<Done> marker(std::string_view tag) {
        const auto line = lines_.next();
        if (!line || entry_of(*line).key != "MARKER_ELEMS")
            return fail_at(line ? zone_.place(*line) : zone_.end(), "MARKER_TAG is not followed by MARKER_ELEMS");
        return rows(*line, entry_of(*line).value).map([&](Block result) {
            result.tag = std::string(tag);
            if (tag == "SEND_RECEIVE")
                ++zone_.parallel_markers;
            else
                zone_.markers.push_back(std::move(result));
            return Done{};
        });
    }

    Lines lines_;
    File file_;
    Zone zone_;
    std::int64_t zones_ = 1;
    bool in_foreign_ = false;
};

}  // namespace

Outcome<File> find_blocks(std::string_view text, std::string_view name) { return Index(text, name).make(); }

}  // namespace camber::su2
