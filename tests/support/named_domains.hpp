// Domains with curved surfaces, ridges, materials and surfaces that end inside, with the measures known from their
// geometry.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "domains.hpp"
#include "dynamic_measures.hpp"
#include "meshes.hpp"

import camber.core;
import camber.cavity;
import camber.surface;

namespace camber::testing {

template <int D>
struct NamedDomain {
    std::string name;
    LinearMesh<D> mesh;
    AnalyticGeometry<D> surfaces;  ///< curved surfaces, and surfaces that end at a curved one
    Sizes curved;  ///< measures known by formula, in the units of `measures`; all others are flat and constant
    double cell = 1;
    double ridge_angle_degrees = 40;
};

namespace named {

template <int D>
LatticeOptions<D> lattice(int cells, std::function<Vec<D>(const Vec<D>&)> place) {
    LatticeOptions<D> options;
    options.cells.fill(cells);
    options.place = std::move(place);
    return options;
}
template <int D>
double largest(const Vec<D>& p) {
    double most = 0;
    for (const double x : p.c) most = std::max(most, std::abs(x));
    return most;
}

}  // namespace named

/// The ball of radius 1 in the box from −2 to 2, each a material: cubes around the centre are mapped to spheres. The
/// number of cells per axis is a multiple of 4.
template <int D>
NamedDomain<D> ball_in_box(int cells) {
    const double cell = 4.0 / cells;
    const auto place = [cell](const Vec<D>& at) {
        Vec<D> p;
        for (int i = 0; i < D; ++i) p[i] = cell * at[i] - 2;
        const double m = named::largest(p);
        if (m == 0) return p;
        const Vec<D> u = p / m;
        return m <= 1 ? m / norm(u) * u : ((2 - m) / norm(u) + 2 * (m - 1)) * u;
    };
    const auto material_of = [](const std::array<Vec<D>, D + 1>& p) {
        return std::ranges::all_of(p, [](const Vec<D>& q) { return norm(q) < 1 + 1e-9; }) ? 1 : 2;
    };
    const auto reference_of = [](const std::array<Vec<D>, D>& face, const Vec<D>& within, FaceKind kind) -> Reference {
        return kind == FaceKind::boundary ? side_of_box<D>(face, within) : kind == FaceKind::interface ? 20 : 0;
    };
    const double pi = std::numbers::pi;
    const double ball = D == 2 ? 2 * pi : 8 * pi;  // D! times its volume
    return {"ball in a box",
            with_facets<D>(lattice_mesh(named::lattice<D>(cells, place)), material_of, reference_of),
            {{{20, Sphere<D>{{}, 1}}}},
            {{{D, 1}, ball}, {{D, 2}, (D == 2 ? 32 : 384) - ball}, {{D - 1, 20}, D == 2 ? 2 * pi : 8 * pi}},
            cell,
            75};  // larger than the angles between facets of a coarse ball, smaller than those of the box
}

/// A quarter of the shell (3D: pipe) between the radii 1 and 2; all its surfaces meet in ridges.
template <int D>
NamedDomain<D> quarter_shell(int cells) {
    const auto place = [cells](const Vec<D>& at) {
        const double radius = 1 + at[0] / cells;
        const double angle = std::numbers::pi / 2 * at[1] / cells;
        Vec<D> p = at / cells;
        p[0] = at[1] == cells ? 0 : radius * std::cos(angle);
        p[1] = radius * std::sin(angle);
        return p;
    };
    const auto reference_of = [](const std::array<Vec<D>, D>& face, const Vec<D>&, FaceKind kind) -> Reference {
        const auto all = [&](auto&& is_present) { return std::ranges::all_of(face, is_present); };
        const auto near = [](double a, double b) { return std::abs(a - b) < 1e-9; };
        if (kind != FaceKind::boundary) return 0;
        for (const int radius : {1, 2})
            if (all([&](const Vec<D>& p) { return near(std::hypot(p[0], p[1]), radius); })) return radius;
        for (int axis = 0; axis < 2; ++axis)
            if (all([&](const Vec<D>& p) { return p[axis] == 0; })) return 3 + axis;
        return all([](const Vec<D>& p) { return p[D - 1] == 0; }) ? 5 : 6;
    };
    const double pi = std::numbers::pi;
    NamedDomain<D> domain{
        "quarter of a shell",
        with_facets<D>(
            lattice_mesh(named::lattice<D>(cells, place)), [](const auto&) { return 1; }, reference_of),
        {},
        {},
        1.0 / cells};
    Vec<D> x, y;
    x[0] = y[1] = 1;
    domain.surfaces.surfaces = {{3, Plane<D>{{}, x}}, {4, Plane<D>{{}, y}}};
    for (const int radius : {1, 2})
        if constexpr (D == 2)
            domain.surfaces.surfaces.push_back({radius, Sphere<2>{{}, 1.0 * radius}});
        else
            domain.surfaces.surfaces.push_back({radius, Cylinder{{}, {{0, 0, 1}}, 1.0 * radius}});
    if constexpr (D == 2) {
        domain.curved = {{{2, 1}, 3 * pi / 2}, {{1, 1}, pi / 2}, {{1, 2}, pi}};
    } else {
        const Vec<3> z{{0, 0, 1}};
        domain.surfaces.surfaces.push_back({5, Plane<3>{{}, z}});
        domain.surfaces.surfaces.push_back({6, Plane<3>{z, z}});
        domain.curved = {{{3, 1}, 9 * pi / 2}, {{2, 1}, pi},         {{2, 2}, 2 * pi},
                         {{2, 5}, 3 * pi / 2}, {{2, 6}, 3 * pi / 2}, {{0, 0}, 3 * pi + 8}};
    }
    return domain;
}

/// A square (2D: a line) inside a box, with its rim inside as well. Cells have length 1; their number is a multiple of
/// 4.
template <int D>
NamedDomain<D> baffle_in_box(int cells) {
    const auto reference_of = [cells](const std::array<Vec<D>, D>& face, const Vec<D>& within,
                                      FaceKind kind) -> Reference {
        if (kind == FaceKind::boundary) return side_of_box<D>(face, within);
        const bool lies_there = std::ranges::all_of(face, [&](const Vec<D>& p) {
            bool is_within = p[1] == cells / 2.0;
            for (int axis = 0; axis < D; ++axis)
                is_within = is_within && p[axis] >= cells / 4.0 && p[axis] <= 3 * cells / 4.0;
            return is_within;
        });
        return lies_there ? 30 : 0;
    };
    return {"baffle in a box",
            with_facets<D>(
                lattice_mesh(named::lattice<D>(cells, [](const Vec<D>& p) { return p; })),
                [](const auto&) { return 1; }, reference_of),
            {},
            {},
            1};
}

template <int D>
std::vector<NamedDomain<D>> named_domains(int cells) {
    std::vector<NamedDomain<D>> all;
    all.push_back(ball_in_box<D>(cells));
    all.push_back(quarter_shell<D>(cells));
    all.push_back(baffle_in_box<D>(cells));
    return all;
}

}  // namespace camber::testing
