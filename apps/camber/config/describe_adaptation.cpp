module;
#include <algorithm>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>
module camber.config;
import camber.core;
import camber.io;
import :codec;
import :description;
import :json;
import :values;

namespace camber::config {

namespace {

/// Whether any of the command's words has it.
bool has(const std::vector<std::string>& words, std::string_view part) {
    return std::ranges::any_of(words, [&](const std::string& word) { return word.find(part) != std::string::npos; });
}

/// What is wrong with the name of a file within a folder.
std::string wrong_name(const char* what, const std::string& name) {
    if (name.empty() || name.find('/') != std::string::npos || name.front() == '.')
        return in_quotes(what) + " is the name of a file within a cycle's folder, got " + in_quotes(name);
    return {};
}

std::string wrong_with(const Adaptation& a) {
    for (const std::string_view needed : {"{mesh}", "{solution}"})
        if (!a.solve.empty() && !has(a.solve, needed))
            return "\"solve\" has no " + std::string(needed) + ": the command is to be told which file it " +
                   (needed == "{mesh}" ? "reads" : "writes");
    if (auto wrong = wrong_name("mesh", a.mesh); !wrong.empty()) return wrong;
    if (auto wrong = wrong_name("solution", a.solution); !wrong.empty()) return wrong;
    if (a.mesh == a.solution) return "\"mesh\" and \"solution\" are one file";
    if (!format_to_write(mesh_formats(), a.mesh))
        return "\"mesh\" must end in " + camber::listed(endings_written(mesh_formats())) + ", got " + in_quotes(a.mesh);
    return {};
}

}  // namespace

const Description<Adaptation>& Described<Adaptation>::get() {
    static const Description<Adaptation> description{
        "adapt",
        "Cycles of the stages, each on the mesh that the one before made, until that has settled; a solver may be "
        "asked "
        "for the solution in between. Without a geometry of its own every cycle takes the boundary of the first mesh.",
        listed<Adaptation>(), wrong_with};
    return description;
}

}  // namespace camber::config
