// Names of operations in tables.
#pragma once

#include <array>
#include <cstddef>
#include <string>

#include "random_operations.hpp"

import camber.core;
import camber.cavity;

namespace camber::testing {

inline const char* word(Operation operation) {
    switch (operation) {
        case Operation::insert: return "insertion";
        case Operation::collapse: return "collapse";
        case Operation::swap_edge: return "edge swap";
        case Operation::swap_face: return "face swap";
        case Operation::reinsert: return "reinsertion";
        case Operation::move: return "move";
        case Operation::any_cavity: return "any cavity";
    }
    return "";
}
inline std::string name_of(Kind kind) {
    if (kind.operation == Operation::any_cavity)
        return kind.place == VertexPlace::inside ? "any cavity, a new point" : "any cavity, a vertex";
    constexpr std::array places{"inside", "surface", "line", "corner"};
    return std::string(word(kind.operation)) + ", " + places[static_cast<std::size_t>(kind.place)];
}

}  // namespace camber::testing
