#!/usr/bin/env python3
"""Writes camber/verbs.py, the verbs with the program's arguments, from the descriptions of the arguments.

    python3 apps/python/make_verbs.py build/python > apps/python/camber/verbs.py

A test checks that the file is up to date.
"""

import json
import os
import re
import sys
import textwrap

HEAD = '''"""The verbs: `camber curve`, `remesh`, `repair`, `adapt`, `check`, `geometry`, `transfer` and `generate` over meshes in
memory, with the program's own arguments as keywords.

Made by make_verbs.py from the descriptions of the program's arguments: `camber curve --help`. None is the default
everywhere: what the program does without the argument.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal

import numpy as np

from . import _verbs
from .mesh import Made, Mesh

Progress = Callable[[str, float], Any]
'''

# Arguments for files and the terminal, and those that have another form in Python.
NOT_HERE = {
    "input", "output", "format", "partition", "quiet", "verbose", "force", "print-config", "dry-run", "histogram", "json", "flat", "report",
    "output-solution", "output-metric", "solve", "shape", "old_mesh", "new_mesh", "old", "new",
}
OF_FILES = {"folder", "from", "mesh-file", "solution-file", "timeout", "vtu", "plots", "page"}
VERBS = {
    "curve": ("mesh", "Made", {"blocks", "memory"}),  # blocks work on files
    "remesh": ("mesh", "Made", set()),
    "repair": ("mesh", "Made", set()),
    "adapt": ("mesh", "Made", OF_FILES),
    "check": ("mesh", "dict[str, Any]", {"vtu", "page", "threads", "elements"}),
    "geometry": ("mesh", "dict[str, Any]", {"surface", "threads"}),
    "transfer": ("old_mesh, new_mesh, solution", "dict[str, np.ndarray]", {"solution", "threads"}),
    "generate": ("shape", "Mesh", set()),
}
# Types of values in memory, in addition to text.
TYPES = {
    "metric": "str | float | np.ndarray | Mapping[str, Any] | None",
    "solution": "str | np.ndarray | Mapping[str, Any] | None",
    "geometry": "str | Mapping[str, Any] | Mesh | Made | None",
    "geometry-error": 'float | Literal["none"] | None',
    "size": "Mapping[int | str, float] | Sequence[str] | None",
    "set": "Mapping[str, Any] | None",
    ("adapt", "complexity"): "float | Sequence[float] | None",
    "fields": "Sequence[str] | None",
    ("check", "field"): "str | Sequence[str] | None",
    ("check", "metric"): "str | float | np.ndarray | Mapping[str, Any] | None",
}
MORE = {
    "metric": "an array at the vertices: sizes (v,) or tensors (v, D, D)",
    "solution": "an array, or {name: array}, at the vertices or nodes: (n,), (n, D), (n, D, D)",
    "geometry": "a mesh: its boundary",
    "size": "{reference: size}",
    "set": "{path: value}",
}
# Replacements in the program's help texts.
HERE = {
    "and the exit code is 1": "and `success` is False",
    "exit code 1": "`success` is False",
    " (.sol, .solb)": "",
    ", at the limit of cycles, or by Ctrl-C": " or at the limit of cycles",
    "OUTPUT is": "The result is",
    "on MESH": "on the mesh",
    ", separated by commas": "",
    ". Can be repeated": "",
}
MESH = {
    "mesh": "the mesh: a camber.Mesh, what another verb made, or a mesh of meshio's, PyVista's or VTK's",
    "shape": "its name, or the config's object as a dict",
    "old_mesh": "the mesh that the fields are on",
    "new_mesh": "the mesh that they are brought to",
}


def python_name(name):
    return name.replace("-", "_")


def in_python(text):
    text = re.sub(r"(?<![\w-])--([a-z][a-z-]*[a-z])", lambda m: m[1].replace("-", "_"), text)
    for there, here in HERE.items():
        text = text.replace(there, here)
    return text.strip()


def type_of(verb, argument):
    name, kind = argument["name"], argument["type"]
    for key in ((verb, name), name):
        if key in TYPES:
            return TYPES[key]
    if argument["flag"]:
        return "bool | None"
    if re.fullmatch(r"[a-z_0-9]+(\|[a-z_0-9]+)+", kind):
        return "Literal[" + ", ".join(f'"{w}"' for w in kind.split("|")) + "] | None"
    if argument["many"]:
        return "Sequence[str] | None"
    if kind.startswith(("INT", "UINT")):
        return "int | None"
    if kind.startswith("FLOAT"):
        return "float | None"
    return "str | None"


def limits_of(kind):
    found = re.search(r"[\[(][^\[\]()]*, [^\[\]()]*[\])]$", kind)
    return f" In {found[0]}." if found else ""


def sentence(argument):
    text = in_python(argument["help"])
    text += "" if text.endswith(".") else "."
    if argument["name"] in MORE:
        text += f" Or {MORE[argument['name']]}."
    text += limits_of(argument["type"])
    if argument["default"] and "efault" not in text:
        text += f" Default: {argument['default']}."
    return text


def wrapped(text, indent, hanging="    "):
    return textwrap.fill(text, 116, initial_indent=indent, subsequent_indent=indent + hanging,
                         break_long_words=False, break_on_hyphens=False)


def about(text):
    """Return the paragraphs without examples of the command line."""
    kept = [p for p in text.split("\n\n") if not p.startswith("  ")]
    return [in_python(p) for p in kept]


def function(verb, described):
    subject, returns, without = VERBS[verb]
    arguments = [a for a in described["arguments"] if a["name"] not in NOT_HERE | without and not a["positional"]]
    lines = ["@_verbs.with_new_names", f"def {verb}("]
    for part in subject.split(", "):
        lines.append(f"    {part}: Any,")
    lines.append("    *,")
    if verb == "adapt":
        lines.append("    solve: Callable[[Mesh, Mapping[str, np.ndarray], int], Any] | None = None,")
    for a in arguments:
        lines.append(f"    {python_name(a['name'])}: {type_of(verb, a)} = None,")
    lines.append("    progress: Progress | None = None,")
    lines.append(f") -> {returns}:")
    first, *rest = about(described["about"])
    paragraphs = [first if first.endswith(".") else first + "."] + rest
    lines.append('    """' + wrapped(paragraphs[0], "    ", "").strip())
    for paragraph in paragraphs[1:]:
        lines += ["", wrapped(paragraph, "    ", "")]
    lines.append("")
    for part in subject.split(", "):
        lines.append(wrapped(f"{part}: {MESH.get(part, 'the fields: an array, or {name: array}')}.", "    "))
    if verb == "adapt":
        lines.append(wrapped("solve: called with each mesh, the solution before brought to it ({} of the first), and the "
                             "cycle; gives the solution on it, an array or {name: array} at its vertices or nodes.", "    "))
    for a in arguments:
        lines.append(wrapped(f"{python_name(a['name'])}: {sentence(a)}", "    "))
    lines.append(wrapped("progress: called with the stage and its share, from 0 to 1, now and then; False from it stops "
                         "the work, and Stopped is raised.", "    "))
    lines.append('    """')
    lines.append("    options = locals()")
    lines.append(f"    return _verbs.{verb}(options)")
    return "\n".join(lines).replace("\\", "\\\\")


def main():
    sys.path.insert(0, os.path.join(sys.argv[1], "camber"))  # the extension only: the package imports the generated file
    import _camber

    described = json.loads(_camber.arguments())
    functions = [function(verb, described[verb]) for verb in VERBS]
    sys.stdout.write(HEAD + "".join("\n\n" + f + "\n" for f in functions))


if __name__ == "__main__":
    main()
