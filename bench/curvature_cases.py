"""Meshes and fields of bench/curvature.py. Each field has a kind: `wall` and `front` are fields for which layers of a mesh are made; `smooth` and
`unrelated` are fields that are independent of the mesh, with their own scale and details that the mesh need not resolve."""
from dataclasses import dataclass, field

SPHERE, CIRCLE = "sqrt(x^2+y^2+z^2)", "sqrt(x^2+y^2)"
ERRORS = ("L2", "H1", "solved L2", "solved H1")
KINDS = ("wall", "front", "smooth", "unrelated")


def fronts(radius, at, widths):
    return {f"tanh((r-{at})/{width})": ("front", f"tanh(({radius}-{at})/{width})") for width in widths}


def layers(radius, widths, wall=1):
    return {f"exp(-(r-{wall})/{width})": ("wall", f"exp(-({radius}-{wall})/{width})") for width in widths}


def unrelated(size, dim=3):
    """Returns fields that are unrelated to the metrics of these meshes: a planar front, waves, a vortex and others. `size` is
    the size of the features in model units."""
    third = f"+0.3*z/{size}" if dim == 3 else ""
    return {label: ("unrelated", text) for label, text in {
        "planar front": f"tanh((0.6*x+0.7*y{'+0.4*z' if dim == 3 else ''}-0.4*{size})/(0.2*{size}))",
        "waves": f"sin(2*pi*x/{size})*cos(2*pi*y/{size})",
        "vortex": f"exp(-((x-0.3*{size})^2+(y-0.5*{size})^2)/(0.5*{size})^2)*(x-0.3*{size})",
        "other": f"1/(1+(x/{size}+0.4)^2+2*(y/{size}-0.1)^2)*exp(0.5*y/{size}{third})",
    }.items()}


def smooth(low, high):
    """Returns fields of the size of the mesh: L is its largest extent, the origin is the centre of its box, both rounded to L/50."""
    size = float(f"{max(b - a for a, b in zip(low, high)):.3g}")
    centre = [round((a + b) / 2 / size * 50) * size / 50 for a, b in zip(low, high)]
    x, y, *z = [f"({name}-{c:.6g})" if c else name for name, c in zip("xyz", centre)]
    product = "*".join([x, y, *z])
    return {label: ("smooth", text) for label, text in {
        "x³": f"{x}^3",
        "sin 2πx/L": f"sin(2*pi*{x}/{size:g})",
        "y e^(4x/L)": f"exp(4*{x}/{size:g})*{y}",
        "xyz (1+x/L)" if z else "xy (1+x/L)": f"{product}*(1+{x}/{size:g})",
    }.items()}


@dataclass
class Case:
    """A mesh from the folder, of a generated shape, or of a part with a CAD model."""
    fields: dict  # in addition to the smooth fields: {label: (kind, expression)}
    shape: dict = field(default_factory=dict)
    part: str = ""
    boundary: dict = field(default_factory=dict)  # {label: boundary data of the solver} if it is not the field
    metric: str = "natural"  # options of `camber curve` if the folder has no geometry
    geometry: str = "surrogate"


def shell(sizes, layer):
    return {"shell": dict(zip(("inner_size", "outer_size"), sizes)) | {"inner_layer": layer}}


def annulus(layer):
    return {"annulus": {"inner_radius": 1, "outer_radius": 3, "inner_size": 0.4, "outer_size": 0.6, "inner_layer": layer}}


def steep(first, growth, count):
    """Layers whose first height is at most a tenth of the sagitta of the wall."""
    return Case(WALL, shell((0.46, 1.75), {"count": count, "first_height": first, "growth": growth}))


WALL = layers(SPHERE, (0.05, 0.2)) | fronts(SPHERE, 1.1, (0.05,))
FLAT_WALL = layers(CIRCLE, (0.05, 0.2)) | fronts(CIRCLE, 1.1, (0.05,))
SHOCK = '{"field": {"spherical-shock": {"centre": [0, 0], "radius": 0.5, "min_size": 0.03, "size": 0.08, "width": 0.1}}}'
ACROSS = "((sqrt((x-30)^2+z^2)-30)^2+y^2)"  # square of the distance from the centre line of the bend
ENDS = "z < 0.001 || x > 29.999"
ZERO = "(100-s²)(1+y/50)"
BEND = {"exp(-(10-s)/5)": ("wall", f"exp(-(10-sqrt({ACROSS}))/5)"),  # s: distance from the centre line
        ZERO: ("smooth", f"(100-{ACROSS})*(1+0.02*y)")}  # 0 on the wall
CASES = {
    "polar-100k": Case(fronts(CIRCLE, 0.5, (0.005, 0.01, 0.03)) | unrelated(0.5)),
    "layer-single": Case(WALL | unrelated(5)),
    "layer-double": Case(WALL | unrelated(5)),
    "spheres-fine": Case(layers(SPHERE, (0.5,)) | fronts(SPHERE, 2, (0.5,)) | unrelated(5)),
    "spheres-coarse": Case(layers(SPHERE, (0.5,)) | fronts(SPHERE, 2, (0.5,)) | unrelated(5)),
    "cube-cylinder": Case(fronts(CIRCLE, 0.5, (0.1,)) | fronts(CIRCLE, 0.7, (0.1,)) | unrelated(0.5)),
    "circle-2d": Case(layers(CIRCLE, (0.1, 0.4)) | fronts(CIRCLE, 1.1, (0.05,)) | unrelated(2, 2),
                      annulus({"count": 6, "first_height": 0.02, "growth": 1.3})),
    "shock-2d": Case(fronts(CIRCLE, 0.5, (0.03, 0.1, 0.3)) | unrelated(0.5, 2),
                     {"rectangle": {"cells": [32, 32], "jitter": 0.2}}, metric=SHOCK, geometry="straight"),
    "layers-1.25": Case(WALL | unrelated(5), shell((0.46, 1.75), {"count": 8, "first_height": 0.02, "growth": 1.25})),
    "layers-1.4": Case(WALL | unrelated(5), shell((0.3, 1.6), {"count": 8, "first_height": 0.02, "growth": 1.4})),
    "bend": Case(BEND | unrelated(20), part="bend", boundary={ZERO: f"({ENDS}) ? {BEND[ZERO][1]} : 0"}),
    "elbow": Case(unrelated(20), part="elbow"),
    "block": Case(layers(CIRCLE, (4,), 8) | unrelated(20), part="block"),
    "steep-1.4": steep(0.0026, 1.4, 10),
    "steep-1.6": steep(0.0026, 1.6, 8),
    "steep-2.4": steep(0.0026, 2.4, 5),
    "steep-thin": steep(4.6e-5, 1.6, 17),
    "steep-2d": Case(FLAT_WALL, annulus({"count": 10, "first_height": 0.002, "growth": 1.4})),
}
SHOWN = ("layers-1.25", "circle-2d", "shock-2d", "bend")  # in docs/curvature.md
SAFE = ("circle-2d", "shock-2d", "layer-single", "layer-double", "spheres-fine", "cube-cylinder", "bend", "elbow", "block")
LAYERS = ("layer-single", "steep-1.4", "steep-1.6", "steep-2.4", "steep-thin", "steep-2d")
