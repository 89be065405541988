// CAD file formats, units and invalid files.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <string>

#include "read.hpp"

import camber.core;
import camber.cad;

using namespace camber;
using namespace cad_tests;

TEST_CASE("STEP, IGES and BREP files give the same model") {
    for (const char* const ending : {".step", ".iges", ".brep"}) {
        CAPTURE(ending);
        const CadModel box = model_of(Kind::box, {1, 2, 3}, ending);
        CHECK(box.faces() == 6);
        CHECK(box.edges() == 12);
        CHECK(box.vertices() == 8);
        CHECK(distance(box.bounds().low, Vec<3>{}) <= 1e-12);
        CHECK(distance(box.bounds().high, Vec<3>{{1, 2, 3}}) <= 1e-12);
        const CadModel ball = model_of(Kind::ball, {2, 0, 0}, ending);
        CHECK(ball.faces() == 1);
        CHECK(std::abs(closest_on_face(ball, 0, {{1, 1, 1}}).distance - (2 - std::sqrt(3.0))) <= 1e-12);
    }
}

TEST_CASE("reading a model twice gives the same numbers") {
    const File file(".step");
    write_model(Kind::filleted_box, {2, 0.3, 0}, file);
    const auto a = read_cad(file.path(), {}), b = read_cad(file.path(), {});
    REQUIRE(a);
    REQUIRE(b);
    CHECK(a->faces() == 26);
    for (std::size_t v = 0; v < a->vertices(); ++v) CHECK(a->vertex(v) == b->vertex(v));
}

TEST_CASE("coordinates are in the unit of the file or of the mesh") {
    const File file(".step");
    write_model(Kind::box, {1000, 2000, 3000}, file, "M");
    const auto size = [&](CadUnit unit) {
        const auto model = read_cad(file.path(), {unit});
        REQUIRE(model);
        return model->bounds().high[0];
    };
    CHECK(size(CadUnit::file) == doctest::Approx(1).epsilon(1e-12));
    CHECK(size(CadUnit::m) == doctest::Approx(1).epsilon(1e-12));
    CHECK(size(CadUnit::mm) == doctest::Approx(1000).epsilon(1e-12));
    CHECK(size(CadUnit::in) == doctest::Approx(1000 / 25.4).epsilon(1e-12));
    const File inches(".iges");
    write_model(Kind::box, {25.4, 50.8, 76.2}, inches, "IN");
    const auto model = read_cad(inches.path(), {});
    REQUIRE(model);
    CHECK(model->bounds().high[2] == doctest::Approx(3).epsilon(1e-9));
}

TEST_CASE("files without a valid model are rejected") {
    const auto error_of = [](const std::string& path) {
        const auto model = read_cad(path, {});
        REQUIRE(!model);
        return model.error();
    };
    CHECK(error_of("wing.stl").kind == ErrorKind::usage);
    CHECK(error_of("no-such-file.step").kind == ErrorKind::input);
    CHECK(error_of("no-such-file.brep").kind == ErrorKind::input);
    for (const char* const ending : {".step", ".iges", ".brep"}) {
        CAPTURE(ending);
        const File file(ending);
        for (const char* const text : {"", "\0\1\2", "ISO-10303-21;\nHEADER;\n",
                                       "CASCADE Topology V1, (c) Matra-Datavision\nTShapes 9999999\n"}) {
            std::ofstream(file.path()) << text;
            CHECK(error_of(file.path()).kind == ErrorKind::input);
        }
    }
    const File empty(".brep");
    write_model(Kind::nothing, {}, empty);
    CHECK(error_of(empty.path()).what == "the model has no faces and no edges");
}
