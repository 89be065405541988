module;
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>
export module camber.run:distances_report;
import camber.config;
import camber.core;
import camber.surface;

/// How far a boundary and its geometry are from each other, as it is told.
export namespace camber::run {

/// See OneWay.
struct OneWayReport {
    std::size_t samples = 0;
    double largest = 0, mean = 0;
    std::vector<double> from, to;
    std::size_t facet = 0;  ///< from 1; 0: none
};

struct EntityReport {
    std::string kind;                   ///< `face` and `edge` of a CAD model, `patch`, `ridge` …; `none`
    std::size_t number = 0;             ///< as its maker counts, from 1; 0: it has none
    std::string name;                   ///< as one says it
    std::vector<std::size_t> sides;     ///< of a curve: the numbers of the surfaces beside it
    std::vector<std::string> beside;    ///< of a curve between surfaces of two makers: as one says these
    bool is_flat = false;               ///< of a surface that facets lie on
    std::vector<Reference> references;  ///< of those facets
    std::size_t pieces = 0;             ///< facets, of a curve edges
    double measure = 0;                 ///< their area or length
    OneWayReport to_geometry, to_boundary;
};

struct DistancesReport {
    std::string geometry;  ///< as one says it: "CAD model wing.step, analytic surfaces, surrogate"
    OneWayReport to_geometry, to_boundary;
    std::vector<EntityReport> entities;
};

/// Entities are called as the geometry calls them, and it by the config.
template <int D>
[[nodiscard]] DistancesReport distances_report(const GeometryDistances<D>& distances, const Geometry<D>& geometry,
                                               const config::Geometry& config);

/// One object.
[[nodiscard]] std::string distances_json(const DistancesReport& report);
/// Two lines, the worst entity named; and one for each of the worst entities.
[[nodiscard]] std::string distance_rows(const DistancesReport& report);
[[nodiscard]] std::string entity_rows(const DistancesReport& report, std::size_t most);

}  // namespace camber::run
