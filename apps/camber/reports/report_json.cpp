module;
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
#include <nlohmann/json.hpp>
module camber.reports;
import camber.core;
import camber.recipes;
import camber.transfer;
import :json;

namespace camber::run {

namespace {

/// The keys that stand first.
Json head(const OriginReport& o) {
    return {{"format", report_format},
            {"program", {{"name", "camber"}, {"version", o.version}}},
            {"input", json_of(o)},
            {"config", Json::parse(o.config)},
            {"units",
             {{"lengths", "those of the input mesh"},
              {"metric", "1/length^2"},
              {"angles", "degrees"},
              {"times", "seconds"},
              {"memory", "bytes"}}}};
}

}  // namespace

std::string to_json(const Report& report) {
    Json j = report.origin ? head(*report.origin) : Json::object();
    add_fields(j, report, report.mesh.is_surface_alone() ? Reported::surface : Reported::volume);
    return j.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace camber::run
