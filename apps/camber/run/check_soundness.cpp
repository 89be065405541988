module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
module camber.run;
import camber.core;
import camber.validity;
import camber.soundness;
import :check;
import :check_parts;
import :file_numbers;

namespace camber::run {

namespace {

constexpr std::array<ConcernText, concern_count> texts{{
    {"conformity", "no element twice, no face of more than two, no vertex inside a face"},
    {"orientation", "no element reversed, inverted or flat"},
    {"nodes", "none unused, none at the place of another"},
    {"boundary", "all of it listed, once, and nothing else"},
    {"closure", "the boundary is closed, and meets itself at no vertex or edge"},
    {"walls", "no element has two faces on one smooth wall"},
}};

/// Whether `first` and `other` of a defect are vertices or nodes, which the file may number in another way.
struct Vertices {
    bool first = false, other = false;
};
Vertices vertices_of(Defect defect) {
    switch (defect) {
        case Defect::distant_vertex:
        case Defect::distant_node:
        case Defect::hanging_vertex:
        case Defect::unused_vertex:
        case Defect::pinched_vertex: return {.first = true};
        case Defect::duplicate_vertex:
        case Defect::slit_vertex:
        case Defect::coincident_node:
        case Defect::open_edge:
        case Defect::crowded_edge: return {.first = true, .other = true};
        default: return {};
    }
}

}  // namespace

Concern concern_of(Defect defect) {
    switch (defect) {
        case Defect::repeated_element:
        case Defect::contradicting_element:
        case Defect::crowded_face:
        case Defect::hanging_vertex: return Concern::conformity;
        case Defect::reversed_element:
        case Defect::tangled_element:
        case Defect::flat_element:
        case Defect::tiny_element: return Concern::orientation;
        case Defect::distant_vertex:
        case Defect::distant_node:
        case Defect::duplicate_vertex:
        case Defect::unused_vertex:
        case Defect::slit_vertex:
        case Defect::coincident_node: return Concern::nodes;
        case Defect::stray_facet:
        case Defect::tiny_facet:
        case Defect::repeated_facet:
        case Defect::contradicting_facet:
        case Defect::missing_facet:
        case Defect::no_facets:
        case Defect::missing_interface:
        case Defect::inner_facet:
        case Defect::lone_edge: return Concern::boundary;
        case Defect::open_edge:
        case Defect::crowded_edge:
        case Defect::pinched_vertex: return Concern::closure;
        case Defect::wall_element: return Concern::walls;
    }
    return Concern::conformity;
}

ConcernText text_of(Concern concern) { return texts[static_cast<std::size_t>(concern)]; }

SoundnessReport soundness_report(Soundness soundness, const FileNumbers& numbers) {
    SoundnessReport report{.sound = soundness.sound(), .empty = soundness.empty, .findings = {}};
    report.findings.reserve(defect_count);
    for (std::size_t i = 0; i < defect_count; ++i) {
        const Defect defect{static_cast<std::uint8_t>(i)};
        Finding& found = soundness.findings[i];
        const auto [first, other] = vertices_of(defect);
        if (first && found.first > 0) found.first = numbers(found.first - 1);
        if (other && found.other > 0) found.other = numbers(found.other - 1);
        report.findings.push_back({key(defect), concern_of(defect), found.count, found.first, found.other,
                                   gravity(defect) != Gravity::harmless,
                                   found.count > 0 ? sentence(soundness, defect) : std::string()});
    }
    return report;
}

}  // namespace camber::run
