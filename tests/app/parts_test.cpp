// The text of `camber --version --verbose`.
#include <doctest/doctest.h>

#include <vector>

#include "help.hpp"

using camber::app::Part;
using camber::app::parts_of_build;
using camber::app::version_text;

TEST_CASE("a build with all parts lists their libraries") {
    const std::vector<Part> parts{{"pages", "three.js 0.187.0", ""}, {"CAD models", "OpenCASCADE 7.6.3", ""}};
    CHECK(version_text("1.2.3", parts) ==
          "1.2.3\npages       three.js 0.187.0\nCAD models  OpenCASCADE 7.6.3\nNothing is missing.");
}

TEST_CASE("a missing part is listed with the command that adds it") {
    const std::vector<Part> parts{{"pages", "three.js 0.187.0", ""}, {"partitions", "", "./x setup && ./x build"}};
    CHECK(version_text("1.2.3", parts) ==
          "1.2.3\npages       three.js 0.187.0\npartitions  missing; ./x setup && ./x build\nMissing parts: 1");
}

TEST_CASE("each part of a build has its libraries or the command that adds it") {
    const auto parts = parts_of_build();
    CHECK(parts.size() >= 5);
    for (const Part& part : parts) CHECK(part.libraries.empty() != part.command.empty());
}
