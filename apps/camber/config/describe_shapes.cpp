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

namespace {

constexpr const char* length = "model units";

template <class S>
Field<S> seed_field() {
    return field("seed", &S::seed, "another seed, another mesh of the same kind; the same seed, the same bytes");
}

template <int D>
Description<ShellOptions<D>> shell_description(std::string name, std::string doc) {
    using S = ShellOptions<D>;
    const std::string wall = D == 3 ? "sphere" : "circle";
    return {
        std::move(name),
        std::move(doc),
        {field("centre", &S::centre, "of both " + wall + "s").unit(length),
         field("inner_radius", &S::inner_radius, "radius of the inner " + wall).unit(length).above(0),
         field("outer_radius", &S::outer_radius, "radius of the outer " + wall).unit(length).above(0),
         field("inner_size", &S::inner_size, "edge length at the inner " + wall + " (above its layers)")
             .unit(length)
             .above(0),
         field("outer_size", &S::outer_size,
               "edge length at the outer " + wall + " (below its layers); prisms ignore it")
             .unit(length)
             .above(0),
         field("inner_layer", &S::inner_layer, "layers on the inner " + wall),
         field("outer_layer", &S::outer_layer, "layers on the outer " + wall),
         field("structure", &S::structure,
               "unstructured: Delaunay of spread points; prisms: rows of prisms along random diagonals, fast at any "
               "size"),
         field("jitter", &S::jitter, "largest random move of a point").unit("edge lengths").at_least(0).at_most(0.3),
         field("inner_reference", &S::inner_reference, "reference of the inner " + wall),
         field("outer_reference", &S::outer_reference, "reference of the outer " + wall), seed_field<S>()},
        {}};
}

template <int D>
Description<BoxOptions<D>> box_description(std::string name, std::string doc) {
    using S = BoxOptions<D>;
    return {std::move(name),
            std::move(doc),
            {field("low", &S::low, "corner of the least coordinates").unit(length),
             field("high", &S::high, "corner of the largest coordinates").unit(length),
             field("cells", &S::cells, "cells along each axis").at_least(1),
             field("jitter", &S::jitter, "largest random move of a vertex along each axis")
                 .unit("cell sizes")
                 .at_least(0)
                 .at_most(0.5),
             seed_field<S>()},
            {}};
}

}  // namespace

const Words& Described<ShellStructure>::get() {
    static const Words words{{"unstructured", "prisms"}};
    return words;
}

const Description<BoundaryLayer>& Described<BoundaryLayer>::get() {
    using S = BoundaryLayer;
    static const Description<S> description{
        "layer",
        "Thin layers along a wall, prisms cut to simplices.",
        {field("count", &S::count, "number of layers; 0 for none").at_least(0).at_most(1000),
         field("first_height", &S::first_height, "height of the layer at the wall").unit(length).above(0),
         field("growth", &S::growth, "height of a layer over that of the one nearer to the wall").above(0),
         field("material", &S::material, "reference of the layers' elements; that of the others is 1"),
         field("interface", &S::interface,
               "reference of the facets between the layers and the others, where their materials differ")},
        {}};
    return description;
}

const Description<ShellOptions<3>>& Described<ShellOptions<3>>::get() {
    static const auto description = shell_description<3>("shell", "The volume between two concentric spheres.");
    return description;
}

const Description<ShellOptions<2>>& Described<ShellOptions<2>>::get() {
    static const auto description = shell_description<2>("annulus", "The area between two concentric circles (2D).");
    return description;
}

const Description<BoxOptions<3>>& Described<BoxOptions<3>>::get() {
    static const auto description =
        box_description<3>("box", "An axis-aligned box; references 1 to 6 at low x, high x, low y, …");
    return description;
}

const Description<BoxOptions<2>>& Described<BoxOptions<2>>::get() {
    static const auto description =
        box_description<2>("rectangle", "A rectangle (2D); references 1 to 4 at low x, high x, low y, high y.");
    return description;
}

const Description<BumpOptions>& Described<BumpOptions>::get() {
    using S = BumpOptions;
    static const Description<S> description{
        "bump",
        "A channel with a smooth bump on its floor (2D); references: 1 inlet, 2 outlet, 3 floor, 4 ceiling.",
        {field("length", &S::length, "length of the channel").unit(length).above(0),
         field("height", &S::height, "height of the channel").unit(length).above(0),
         field("bump_height", &S::bump_height, "height of the bump in the middle; negative: a dent").unit(length),
         field("bump_width", &S::bump_width, "from foot to foot").unit(length).above(0),
         field("cells", &S::cells, "cells along the channel, and across it above the layers").at_least(1),
         field("floor_layer", &S::floor_layer, "layers on the floor"),
         field("jitter", &S::jitter, "largest random move of a vertex along each axis")
             .unit("cell sizes")
             .at_least(0)
             .at_most(0.5),
         seed_field<S>()},
        {}};
    return description;
}

const Choice<Shape>& Described<Shape>::get() {
    static const Choice<Shape> choice{"generate",
                                      "A domain that Camber meshes itself.",
                                      {{"shell", "between two spheres"},
                                       {"annulus", "between two circles (2D)"},
                                       {"box", "a box"},
                                       {"rectangle", "a rectangle (2D)"},
                                       {"bump", "a channel with a bump (2D)"}}};
    return choice;
}

}  // namespace camber::config
