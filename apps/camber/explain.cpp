#include "help.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>
#include <CLI/CLI.hpp>

#include "arguments.hpp"
import camber.app_shell;
import camber.commands;
import camber.config;
import camber.core;
import camber.recipes;
import camber.reports;

namespace camber::app {

namespace {

struct Term {
    std::string_view names;  ///< separated by "|"; lower case except for the first name
    std::string_view text;
};

constexpr std::array terms{
    // the mesh
    Term{"degree",
         "The degree of the polynomials that map an element. 1: straight; 2: curved (quadratic), with a node on each "
         "edge. Higher degrees are not supported."},
    Term{"dimension", "2: triangles in a plane. 3: tetrahedra, or triangles in space."},
    Term{"vertices|vertex|corner of elements", "The corners of the elements."},
    Term{"nodes|node", "All points that define the elements: the vertices and, with degree 2, one node on each edge."},
    Term{"elements|element|tetrahedra|triangles",
         "The cells of the mesh: triangles in 2D, tetrahedra in 3D. Element numbers start at 1, in the order of the "
         "file."},
    Term{"facets|facet|boundary triangles|boundary edges",
         "The edges (2D) or triangles (3D) of the boundary and of interfaces between materials."},
    Term{"reference|references",
         "The number that a file assigns to an element or a facet: a material, or a part of the boundary. Gmsh calls "
         "it a physical tag, MFEM an attribute."},
    Term{"ridge|ridges",
         "An edge of the boundary where the angle between facets exceeds the ridge angle, where references change, or "
         "that the file lists. No smooth surface crosses it."},
    Term{"corner|corners", "A vertex of the boundary where ridges end, branch or turn."},
    Term{"patch|patches", "A smooth part of the boundary between ridges."},
    Term{"interface|interfaces", "Facets between elements with different references."},
    Term{"inner nodes|inner node", "Nodes that are not on the boundary."},
    Term{"sound|soundness",
         "A mesh is sound if its elements fit together: conforming, oriented alike, without duplicate or unused nodes, "
         "with a closed boundary."},
    Term{"overlap|overlaps|elements that overlap", "Two elements overlap if they have interior points in common."},
    Term{"crossing|pairs of facets that cross|cross", "Two facets cross if they pass through each other."},
    // validity and quality
    Term{"valid|valid elements|certified",
         "An element is valid if its Jacobian determinant is certainly positive everywhere, with rounding included."},
    Term{"invalid|inverted|not valid",
         "An element is invalid if its Jacobian determinant is certainly not positive at some point."},
    Term{"undecided", "Neither validity nor invalidity could be proved. An undecided element does not count as valid."},
    Term{"Jacobian|det j|determinant",
         "The determinant of the map from the reference element to the element. The element is folded where it is not "
         "positive."},
    Term{"scaled Jacobian|scaled jacobians|smallest scaled jacobian",
         "The minimum of the Jacobian determinant over an element, divided by that of the straight element with the "
         "same vertices. 1: as good as straight; 0 or less: invalid. Knupp's scaled Jacobian is another quantity."},
    Term{"quality|mean ratio|smallest quality",
         "The mean ratio of a straight element: 1 for an equilateral one, 0 for a flat one, negative for an inverted "
         "one."},
    Term{"quality in the metric|distortion",
         "The mean ratio of an element measured in the metric, along its curves: 1 divided by its mean distortion. 1: "
         "regular in the metric; 0: folded."},
    Term{"curvature|mean curvature|largest curvature",
         "The distance of an edge's node from the middle of its chord, divided by the length of the chord. 0: "
         "straight."},
    Term{"repaired elements|repair", "Elements that became valid because nodes were moved."},
    Term{"raised elements", "Valid elements below the target scaled Jacobian that were improved."},
    Term{"relaxed edges|relaxed|relaxed volume edges|relaxed surface edges",
         "Edges whose node is not at its target position, because an element would not be valid or good enough there."},
    Term{"given up", "Elements that repair left invalid, because the work limit of the option effort was reached."},
    // metric
    Term{"metric",
         "A symmetric positive definite matrix at each point. It defines the requested size of elements in each "
         "direction: an edge of the requested size has length 1 in it."},
    Term{"natural|mesh-implied",
         "The metric in which all edges of a straight element have length 1: the current sizes of the mesh."},
    Term{"complexity",
         "The integral of the square root of the metric's determinant over the mesh. A mesh of unit edges has about 12 "
         "tetrahedra, or 2.6 triangles, per unit of complexity."},
    Term{"anisotropy|largest anisotropy",
         "The largest size of a metric divided by its smallest at one point. 1: the same in all directions."},
    Term{"gradation", "The largest ratio of the sizes at the two ends of an edge."},
    Term{"length in the metric|edge lengths|length",
         "The length of an edge measured in the metric. 1: the requested size."},
    Term{"unit length|edges of unit length",
         "An edge has unit length if its length in the metric is between 1/sqrt(2) and sqrt(2)."},
    Term{"length reduction|mean length reduction|largest length reduction",
         "The length of the chord divided by the length of the curved edge, both in the metric, less 1. Positive: the "
         "curve is shorter."},
    Term{"expected error|expected error of the solution",
         "The interpolation error that the metric predicts for the mesh."},
    Term{"elements expected", "The number of elements that a mesh of the metric has, by its complexity."},
    // geometry
    Term{"geometry error|distance|distance bound|geometry",
         "The distance between the boundary of the mesh and its geometry."},
    Term{"distance both ways|geometry, both ways|both ways",
         "The largest distance from the boundary to its geometry, and from the geometry to the boundary."},
    Term{"nodes off the geometry|vertices off the geometry|off the geometry",
         "Nodes or vertices of the boundary farther from the geometry than the tolerance allows."},
    Term{"surrogate",
         "The smooth cubic surface through the vertices of the mesh. It is the geometry if no other is specified."},
    Term{"CAD faces|cad edges|vertices off the cad model|ambiguous facets",
         "Faces and edges of the CAD model that facets and edges of the boundary are associated with. An association "
         "is ambiguous if two faces are about equally near."},
    Term{"slid on geometry", "Nodes of the boundary that repair moved along the geometry."},
    Term{"suspicious places|suspicious",
         "Places where another ridge angle changes the ridges, or where no smooth surface fits: knife edges, tips of "
         "cones."},
    // solutions and interpolation
    Term{"interpolant|interpolants",
         "The polynomial of degree 1 or 2 in each element that agrees with a field at the vertices, or at all nodes."},
    Term{"L2|error in l2", "The square root of the integral of the squared error."},
    Term{"H1|error in h1", "The L2 norm of the error of the gradient."},
    Term{"fields transferred|fields", "Fields of the input that were interpolated or projected onto the new mesh."},
    // remeshing and runs
    Term{"committed|commit", "The proposed node positions, or the result of an operation, became part of the mesh."},
    Term{"cavity|cavities committed",
         "A group of elements that an operation replaces. A committed cavity was replaced."},
    Term{"sweep|sweeps", "One pass of a method over all entities that are left to process."},
    Term{"block|blocks", "A part of the mesh that is processed separately, to limit memory."},
    Term{"rank|ranks", "A process of MPI."},
    Term{"cycle|cycles", "One iteration of adaptation: metric, remeshing, curving, transfer, and the solver."},
    Term{"converged",
         "The error of the cycles no longer decreases by the share of the option --convergence-tolerance."},
    Term{"threads", "The number of threads that were used. The result does not depend on it."},
    Term{"time", "Wall-clock time."},
    Term{"peak memory", "The largest memory of the process up to that time."},
};

char small(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

bool is_same(std::string_view name, std::string_view phrase) { return std::ranges::equal(name, phrase, {}, small); }

bool has_words(std::string_view phrase, std::string_view name) {
    for (std::size_t at = 0; at + name.size() <= phrase.size(); ++at) {
        const std::size_t end = at + name.size();
        const bool begins = at == 0 || std::isalnum(static_cast<unsigned char>(phrase[at - 1])) == 0;
        const bool ends = end == phrase.size() || std::isalnum(static_cast<unsigned char>(phrase[end])) == 0;
        if (begins && ends && is_same(name, phrase.substr(at, name.size()))) return true;
    }
    return false;
}

const Term* find_term(std::string_view phrase) {
    const Term* best = nullptr;
    std::size_t longest = 0;
    for (const Term& term : terms)
        for (std::size_t begin = 0; begin < term.names.size();) {
            const std::size_t end = std::min(term.names.find('|', begin), term.names.size());
            const std::string_view name = term.names.substr(begin, end - begin);
            if (is_same(name, phrase)) return &term;
            if (name.size() > longest && has_words(phrase, name)) {
                best = &term;
                longest = name.size();
            }
            begin = end + 1;
        }
    return best;
}

std::string_view name_of(const Term& term) { return term.names.substr(0, term.names.find('|')); }

constexpr std::size_t most_suggestions = 3;

std::string in_small_letters(std::string_view word) {
    std::string text(word);
    std::ranges::transform(text, text.begin(), small);
    return text;
}

std::string type_of(const CLI::Option& option) {
    if (option.get_items_expected_max() == 0) return "a flag";
    return option.get_option_text().empty() ? option.get_type_name() : option.get_option_text();
}

struct OptionUse {
    std::string text, type, default_value;
    std::vector<std::string> verbs;
};

std::vector<OptionUse> uses_of(const CLI::App& app, const std::string& name) {
    std::vector<OptionUse> uses;
    for (const CLI::App* const verb : app.get_subcommands({})) {
        const CLI::Option* const option = verb->get_option_no_throw("--" + name);
        if (option == nullptr || option->get_positional()) continue;
        const OptionUse use{option->get_description(), type_of(*option), option->get_default_str(), {}};
        const auto same = std::ranges::find_if(uses, [&](const OptionUse& other) {
            return other.text == use.text && other.type == use.type && other.default_value == use.default_value;
        });
        auto& found = same == uses.end() ? uses.emplace_back(use) : *same;
        found.verbs.push_back(verb->get_name());
    }
    return uses;
}

std::string paragraph(const std::string& text) {
    constexpr std::size_t indent = 2;
    return std::string(indent, ' ') + wrapped(text, text_width() - indent, indent) + "\n";
}

std::string option_text(const CLI::App& app, const std::string& name) {
    std::string text;
    for (const OptionUse& use : uses_of(app, name)) {
        text += (text.empty() ? "" : "\n") + ("--" + name + ", an option of camber " + joined(use.verbs) + "\n\n");
        text += paragraph(use.text) + "\n" + paragraph("Value: " + use.type);
        if (!use.default_value.empty()) text += paragraph("Default: " + use.default_value);
    }
    return text;
}

std::map<std::string, std::set<std::string>> options_by_group(const CLI::App& app) {
    std::map<std::string, std::set<std::string>> options;
    for (const CLI::App* const verb : app.get_subcommands({}))
        for (const CLI::Option* const option : verb->get_options())
            for (const std::string& name : option->get_lnames())
                if (!name.starts_with("help")) options[option->get_group()].insert("--" + name);
    return options;
}

std::string term_text(const Term& term) {
    return std::string(name_of(term)) + "\n\n" + paragraph(std::string(term.text));
}

/// Finds fields of report.json by key, path or table title: "min_scaled_jacobian".
std::string report_key_text(std::string name) {
    std::ranges::replace(name, ' ', '_');
    std::map<std::string_view, std::vector<run::ReportKey>> by_meaning;
    for (const run::ReportKey& key : run::report_keys())
        if (key.path == name || key.path.ends_with("." + name)) by_meaning[key.meaning].push_back(key);
    std::string text;
    for (const auto& [meaning, keys] : by_meaning) {
        std::vector<std::string> paths;
        for (const run::ReportKey& key : keys) paths.push_back(key.path);
        text += (text.empty() ? "" : "\n") + (joined(paths) + " of report.json\n\n") + paragraph(std::string(meaning));
        if (!keys.front().unit.empty()) text += paragraph("Unit: " + std::string(keys.front().unit));
    }
    return text;
}

std::vector<std::string> all_words(const CLI::App& app) {
    std::vector<std::string> words = config::topics();
    for (const auto& [group, names] : options_by_group(app))
        for (const std::string& name : names) words.push_back(name.substr(2));
    for (const Term& term : terms) words.emplace_back(name_of(term));
    for (const Verb& verb : verbs()) words.emplace_back(verb.name);
    std::ranges::sort(words);
    words.erase(std::ranges::unique(words).begin(), words.end());
    return words;
}

std::string list_of(const std::string& title, const std::vector<std::string>& words) {
    return title + ":\n" + paragraph(joined(words)) + "\n";
}

/// Successors of an old name; for an option only those on the command line.
std::vector<std::string> new_names(std::string_view name, bool is_option) {
    std::vector<std::string> names;
    for (const config::Rename& r : config::renames)
        if (r.old_name == name && (r.kind == config::NameKind::argument || !is_option))
            names.push_back((r.kind == config::NameKind::argument ? "--" : "") + std::string(r.new_name));
    std::ranges::sort(names);
    names.erase(std::ranges::unique(names).begin(), names.end());
    return names;
}

}  // namespace

Outcome<std::string> explanation_of(const CLI::App& app, std::string_view word) {
    const bool is_option = word.starts_with('-');
    std::string name(word.substr(std::min(word.find_first_not_of('-'), word.size())));
    name.erase(std::min(name.find('='), name.size()));
    if (is_option && name == "o") name = "output";
    std::string text;
    const auto add = [&](const std::string& part) {
        if (!part.empty()) text += (text.empty() ? "" : "\n") + part;
    };
    if (!is_option)
        if (const auto topic = config::explain(name)) add(*topic);
    add(option_text(app, name));
    if (!is_option)
        if (const Term* const term = find_term(in_small_letters(name))) add(term_text(*term));
    if (!is_option) add(report_key_text(in_small_letters(name)));
    if (!text.empty()) return text;
    if (const auto now = new_names(name, is_option); !now.empty())
        return camber::fail(camber::ErrorKind::usage, "was renamed to " + config::alternatives_text(now),
                            camber::shortened(word), {}, "see: camber explain " + now.front());
    const auto foreign = is_option ? find_foreign_option(name) : std::nullopt;
    if (foreign) return fail(ErrorKind::usage, "is not an option of Camber", shortened(word), {}, foreign->remedy);
    const auto near = config::nearest_words(name, all_words(app), most_suggestions);
    return fail(ErrorKind::usage, "unknown topic", shortened(word), {},
                near.empty() ? "camber explain without a word lists all words"
                             : "did you mean " + config::alternatives_text(near) + "?");
}

std::string list_explained_words(const CLI::App& app) {
    std::string text = "camber explain WORD explains a word of these groups.\n\n";
    for (const config::TopicGroup& group : config::topic_groups()) text += list_of(group.title, group.topics);
    for (const auto& [group, names] : options_by_group(app))
        text += list_of(group + " options", {names.begin(), names.end()});
    std::vector<std::string> names;
    names.reserve(std::size(terms));
    for (const Term& term : terms) names.emplace_back(name_of(term));
    text += list_of("Words of the tables", names);
    text.pop_back();
    return text;
}

Outcome<std::string> help_text_of(const CLI::App& app, const std::string& name) {
    const auto formatter = app.get_formatter();
    if (name.empty()) return formatter->make_help(&app, app.get_name(), CLI::AppFormatMode::Normal);
    for (const CLI::App* const verb : app.get_subcommands({}))
        if (verb->get_name() == name)
            return formatter->make_help(verb, app.get_name() + " " + name, CLI::AppFormatMode::Normal);
    if (auto text = explanation_of(app, name)) return text;
    return fail(unknown_verb(name));
}

}  // namespace camber::app
