module;
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
export module camber.config:renames;

/// Old names and their successors. An old name is an error that states the new one.
export namespace camber::config {

enum class NameKind : std::uint8_t {
    key,         ///< of an option or stage
    value,       ///< of an option
    argument,    ///< on the command line, without dashes
    report_key,  ///< of report.json, check --json, geometry --json and cycles.json
};

struct Rename {
    NameKind kind;
    std::string_view old_name, new_name;
};

inline constexpr auto renames = std::to_array<Rename>({
    {NameKind::key, "repair", "method"},
    {NameKind::key, "return_effort", "restore_effort"},
    {NameKind::key, "back_mesh", "background_mesh"},
    {NameKind::key, "smooth_loss", "max_smooth_error_increase"},
    {NameKind::key, "mend", "improve"},
    {NameKind::key, "wanted", "target_quality"},
    {NameKind::key, "bend_around", "neighbour_edges"},
    {NameKind::key, "loose_longest", "early_collapse_longest"},
    {NameKind::key, "loose_split", "early_split_longest"},
    {NameKind::key, "loose_shortest", "early_split_shortest"},
    {NameKind::key, "settled", "convergence_tolerance"},
    {NameKind::key, "seconds", "timeout"},
    {NameKind::key, "of", "entities"},
    {NameKind::value, "relax", "backtracking"},
    {NameKind::value, "as_curved", "auto"},
    {NameKind::value, "back", "background"},
    {NameKind::argument, "settled", "convergence-tolerance"},
    {NameKind::argument, "seconds", "timeout"},
    {NameKind::argument, "cad-seconds", "cad-timeout"},
    {NameKind::report_key, "surface_alone", "standalone_surface"},
    {NameKind::report_key, "floored_tensors", "corrected_tensors"},
    {NameKind::report_key, "near", "point"},
    {NameKind::report_key, "at", "point"},
    {NameKind::report_key, "largest_distance_near", "largest_distance_point"},
    {NameKind::report_key, "place_of_first_ridge", "first_ridge_point"},
    {NameKind::report_key, "faces_met", "matched_faces"},
    {NameKind::report_key, "edges_met", "matched_edges"},
    {NameKind::report_key, "vertices_met", "matched_vertices"},
    {NameKind::report_key, "lost_faces", "failed_faces"},
    {NameKind::report_key, "doubtful_facets", "ambiguous_facets"},
    {NameKind::report_key, "doubtful_edges", "ambiguous_edges"},
    {NameKind::report_key, "doubtful_vertices", "ambiguous_vertices"},
    {NameKind::report_key, "doubtful_facet", "ambiguous_facet"},
    {NameKind::report_key, "settled_facets", "resolved_facets"},
    {NameKind::report_key, "held_vertices", "partly_moved_vertices"},
    {NameKind::report_key, "joined", "virtual_faces"},
    {NameKind::report_key, "beside", "side_geometries"},
    {NameKind::report_key, "placed", "moved"},
    {NameKind::report_key, "best", "no_improvement"},
    {NameKind::report_key, "far", "too_far"},
    {NameKind::report_key, "walked", "on_other_facets"},
    {NameKind::report_key, "far_facets", "facets_beyond_bound"},
    {NameKind::report_key, "held_back", "limited"},
    {NameKind::report_key, "polished", "pattern_searches"},
    {NameKind::report_key, "exhausted", "not_converged"},
    {NameKind::report_key, "lost", "not_located"},
    {NameKind::report_key, "drawn_back", "limited_nodes"},
    {NameKind::report_key, "bound_is_asked", "bound_is_required"},
    {NameKind::report_key, "given_up", "unrepaired_elements"},
    {NameKind::report_key, "kept_boundary", "input_boundary"},
    {NameKind::report_key, "would_do", "sufficient_tolerance"},
    {NameKind::report_key, "bent_around", "neighbour_moves"},
    {NameKind::report_key, "programmes", "optimisation_problems"},
    {NameKind::report_key, "waits", "deferred"},
    {NameKind::report_key, "asked", "requested_complexity"},
    {NameKind::report_key, "of_fixed", "fixed_complexity"},
    {NameKind::report_key, "is_fixed_alone", "is_fixed_sufficient"},
    {NameKind::report_key, "kept", "unchanged"},
    {NameKind::report_key, "spread", "redistributed"},
    {NameKind::report_key, "unkept_materials", "unconserved_materials"},
    {NameKind::report_key, "given", "input"},
    {NameKind::report_key, "looked_at", "examined"},
    {NameKind::report_key, "cut_short", "truncated"},
    {NameKind::report_key, "straight_too", "also_when_straight"},
    {NameKind::report_key, "concern", "category"},
    {NameKind::report_key, "harms", "is_harmful"},
    {NameKind::report_key, "crowded_faces", "non_manifold_faces"},
    {NameKind::report_key, "crowded_edges", "non_manifold_edges"},
    {NameKind::report_key, "lone_edges", "isolated_edges"},
    {NameKind::report_key, "lone_facets", "isolated_facets"},
    {NameKind::report_key, "turned_facets", "misoriented_facets"},
    {NameKind::report_key, "turned_facet", "normal_deviation"},
    {NameKind::report_key, "straight_turned", "straight_inverted"},
    {NameKind::report_key, "same_boundary_turned", "same_boundary_inverted"},
    {NameKind::report_key, "curved_turned", "curved_inverted"},
    {NameKind::report_key, "processor_seconds", "cpu_seconds"},
    {NameKind::report_key, "complexity_wanted", "complexity_target"},
});

/// Empty if `candidates` contains no successor of the name.
[[nodiscard]] inline std::string new_name(NameKind kind, std::string_view old_name,
                                          std::span<const std::string> candidates) {
    for (const Rename& r : renames)
        if (r.kind == kind && r.old_name == old_name && std::ranges::find(candidates, r.new_name) != candidates.end())
            return std::string(r.new_name);
    return {};
}

}  // namespace camber::config
