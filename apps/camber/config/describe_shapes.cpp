module;
#include <array>
#include <functional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <nlohmann/json.hpp>
module camber.config;
import camber.core;
import camber.shapes;
import :codec;
import :description;
import :json;
import :values;

namespace camber::config {

const Description<BoundaryLayer>& Described<BoundaryLayer>::get() {
    static const Description<BoundaryLayer> description{
        "layer", "Thin layers along a wall, prisms cut to simplices.", listed<BoundaryLayer>(), {}};
    return description;
}

const Description<ShellOptions<3>>& Described<ShellOptions<3>>::get() {
    static const Description<ShellOptions<3>> description{
        "shell", "The volume between two concentric spheres.", listed<ShellOptions<3>>(), {}};
    return description;
}

const Description<ShellOptions<2>>& Described<ShellOptions<2>>::get() {
    static const Description<ShellOptions<2>> description{
        "annulus", "The area between two concentric circles (2D).", listed<ShellOptions<2>>(), {}};
    return description;
}

const Description<BoxOptions<3>>& Described<BoxOptions<3>>::get() {
    static const Description<BoxOptions<3>> description{
        "box", "An axis-aligned box; references 1 to 6 at low x, high x, low y, …", listed<BoxOptions<3>>(), {}};
    return description;
}

const Description<BoxOptions<2>>& Described<BoxOptions<2>>::get() {
    static const Description<BoxOptions<2>> description{
        "rectangle",
        "A rectangle (2D); references 1 to 4 at low x, high x, low y, high y.",
        listed<BoxOptions<2>>(),
        {}};
    return description;
}

const Description<BumpOptions>& Described<BumpOptions>::get() {
    static const Description<BumpOptions> description{
        "bump",
        "A channel with a smooth bump on its floor (2D); references: 1 inlet, 2 outlet, 3 floor, 4 ceiling.",
        listed<BumpOptions>(),
        {}};
    return description;
}

const Choice<Shape>& Described<Shape>::get() {
    static const auto choice = choice_of<Shape>(
        "generate", "A domain that Camber meshes itself.", key<ShellOptions<3>>("shell", "between two spheres"),
        key<ShellOptions<2>>("annulus", "between two circles (2D)"), key<BoxOptions<3>>("box", "a box"),
        key<BoxOptions<2>>("rectangle", "a rectangle (2D)"), key<BumpOptions>("bump", "a channel with a bump (2D)"));
    return choice;
}

}  // namespace camber::config
