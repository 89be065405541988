"""What the pages quote from docs/results.json: tables, and numbers in sentences.

    python3 bench/result_pages.py            # writes them into the pages
    python3 bench/result_pages.py --check    # tells which pages differ; exit code 1 if one does

A table stands between `<!-- table NAME -->` and `<!-- end of table -->`; TABLES has what makes it. The command line that
bench/results.py calls for it stands between `<!-- command NAME -->` and `<!-- end of command -->`. A number in a sentence
has its place and format behind it: `0.95<!-- shape/spheres-fine/smallest .2f -->`.
"""
import argparse
import json
import re
import sys
from pathlib import Path

import curvature_table

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "docs" / "results.json"
TABLE = re.compile(r"(<!-- table (\w+) -->\n).*?(<!-- end of table -->)", re.DOTALL)
COMMAND = re.compile(r"(<!-- command (\w+) -->\n).*?(<!-- end of command -->)", re.DOTALL)
WIDTH = 150
NUMBER = re.compile(r"([-−]?\d[\d.]*(?:e[-+]?\d+)?)(<!-- (\w+)/([^/>]+)/(\w+) (z?\.?\d*[dfg]) -->)")
SIX = ["spheres-coarse", "spheres-fine", "layer-single", "layer-double", "cube-cylinder", "polar-100k"]
# (what, vertices, edges, tetrahedra, corrected, length reduction, kept, smallest Jacobian, seconds) as the paper's tables have them
PAPER = {"paper-spheres-coarse": ("spheres, coarse", "270", "1 552", "1 145", "36", "0.0190 → 0.0178", "94 %", "", "0.023"),
         "paper-spheres-fine": ("spheres, fine", "3 577", "23 058", "18 517", "627", "0.0093 → 0.0032", "34 %", "", "0.89"),
         "paper-layer-single": ("layer, single", "2 095", "12 182", "9 120", "276", "0.0258 → 0.0192", "74 %", "", "0.26"),
         "paper-layer-double": ("layers, double", "9 372", "63 081", "–", "1 029", "0.0492 → 0.0445", "90 %",
                                "1e-9 over all its cases", "1.56")}


def grouped(n):
    return f"{n:,}".replace(",", " ")


def markdown(titles, rows):
    lines = [titles, ["---"] * len(titles), *rows]
    return "".join("| " + " | ".join(map(str, line)) + " |\n" for line in lines)


def reductions(row):
    return f"{row['reduction_before']:.5f} → {row['reduction']:.5f}"


def distances(row):
    return f"{row['straight_distance']:.2g} → {row['distance']:.2g}"


def meshes(results):
    return markdown(["mesh", "vertices", "tetrahedra", "edges", "volume edges", "largest anisotropy"],
                    [[name, *(grouped(row[key]) for key in ("vertices", "elements", "edges", "volume_edges")),
                      f"{row['anisotropy']:.{0 if row['anisotropy'] > 10 else 1}f}"] for name, row in results["curving"]["rows"].items()])


def runs(name, distance):
    """A table of runs, one a line."""
    def make(results):
        titles = ["mesh", "elements", "mean length reduction: before → after correction", "kept", "largest", "mean curvature",
                  "not valid before", "relaxed volume edges", "surface edges", "longer than straight",
                  "smallest scaled Jacobian", *(["distance to the geometry: straight → curved", "s"] if distance else [])]
        rows = []
        for mesh, row in results[name]["rows"].items():
            rows.append([mesh, grouped(row["elements"]), reductions(row), f"{row['kept']:.2f} %", f"{row['largest_reduction']:.3f}",
                         f"{row['curvature']:.3f}", row["invalid_before"], row["relaxed_volume_edges"],
                         row["relaxed_surface_edges"], row["longer"], f"{row['smallest']:.2g}",
                         *([distances(row), f"{row['seconds']:.2g}"] if distance else [])])
        return markdown(titles, rows)
    return make


def paper(results):
    rows = []
    for case, theirs in PAPER.items():
        ours = {way: results["paper"]["rows"][f"{case} {way}"] for way in ("default", "relax", "reinsert")}
        first = ours["default"]
        rows.append([theirs[0], "the paper", *theirs[1:]])
        counts = [grouped(first[key]) for key in ("vertices", "edges", "elements", "corrected_elements")]
        for way, row in ours.items():
            who = {"default": "Camber", "relax": "by θ-relaxation", "reinsert": "by cavities, `reinsert`"}[way]
            lengths = f"{row['reduction_before']:.4f} → {row['reduction']:.4f}" if way == "default" else f"→ {row['reduction']:.4f}"
            rows.append(["", who, *(counts if way == "default" else [""] * 4), lengths, f"{row['kept']:.0f} %",
                         f"{row['smallest']:.2g}", f"{row['seconds']:.2g}"])
    return markdown(["case", "who", "vertices", "edges", "tetrahedra", "corrected", "mean length reduction before → after", "kept",
                     "smallest scaled Jacobian", "seconds"], rows)


def repair(results):
    found = results["repair"]["rows"]
    rows, last = [], None
    for key in found:
        case, bound, way = key.rsplit(" ", 2)
        if way != "relax":
            continue
        ways = {name: found[f"{case} {bound} {name}"] for name in ("relax", "edge", "cavity", "extension")}
        cells = [f"{r['lost']:.2g}, {r['min']:.2g}, {r['left'] if name == 'edge' else r['surface']}, {r['seconds']:.2f} s"
                 for name, r in ways.items()]
        rows.append([case if case != last else "", bound, ways["relax"]["before"], *cells,
                     f"{100 * ways['extension']['lost'] / ways['relax']['lost']:.1f} %"])
        last = case
    return markdown(["mesh", "bound", "below it", "relax: length reduction lost, smallest, surface edges, time",
                     "edge: length reduction lost, smallest, elements left, time",
                     "cavity: length reduction lost, smallest, surface edges, time",
                     "extension: the same", "extension's loss of relax's"], rows)


def shape(results):
    return markdown(["mesh", "elements", "not valid", "smallest scaled Jacobian", "s"],
                    [[name, grouped(row["elements"]), row["left"], f"{row['smallest']:.2f}", f"{row['seconds']:.2g}"]
                     for name, row in results["shape"]["rows"].items()])


def cavities(results):
    def cell(row):
        return (f"{row['reduction']:.5f}, {row['relaxed_volume_edges']}, {row['relaxed_surface_edges']}, {row['longer']}, "
                f"{row['smallest']:.2g}")
    whole, ours = results["curving"]["rows"], results["reinsert"]["rows"]
    return markdown(["mesh", "whole mesh: length reduction, relaxed volume and surface edges, longer edges, smallest scaled Jacobian",
                     "by cavities: the same", "cavities committed, sweeps"],
                    [[name, cell(whole[name]), cell(ours[name]), f"{grouped(ours[name]['patches'])}, {ours[name]['sweeps']}"]
                     for name in SIX])


def relaxation(results):
    default, other = results["curving"]["rows"], results["relaxation"]["rows"]
    rows = []
    for name in SIX:
        three = [default[name], other[name + " relax"], other[name + " segment"]]
        rows.append([name, f"{three[0]['reduction_before']:.5f}",
                     *(f"{r['reduction']:.5f}, {r['relaxed_surface_edges']}, {r['longer']}" for r in three)])
    return markdown(["mesh", "mean length reduction before", "after `cavity`: length reduction, relaxed surface edges, longer edges",
                     "after `relax`, the paper's", "after `segment`"], rows)


def starts(results):
    found = results["starts"]["rows"]
    names = {"energy": "best sector of the shell", "length": "the same, then the length lowered (default)"}
    return markdown(["start", *SIX[:4]], [[name, *(f"{found[f'{mesh} {end}']['reduction_before']:.5f}" for mesh in SIX[:4])]
                                          for end, name in names.items()])


def spheres(results):
    return markdown(["mesh", "radius of the sphere (triangles)", "straight", "curved", "ratio"],
                    [[key.rsplit(" ", 1)[0], f"{key.rsplit(' ', 1)[1]} ({grouped(row['cells'])})", f"{row['straight']:.3g}",
                      f"{row['curved']:.2g}", f"{row['ratio']:.3g}"]
                     for key, row in results["distances"]["rows"].items()])


def by_mesh(results):
    """{mesh: {way: row}} of the table curvature."""
    found = {}
    for key, row in results["curvature"]["rows"].items():
        mesh, way = key.split(", ")
        found.setdefault(mesh, {})[way] = row
    return found


def curvature(results):
    found = by_mesh(results)
    return markdown(curvature_table.titles(found), curvature_table.lines(found))


def curvature_took(results):
    found = by_mesh(results)
    return markdown(curvature_table.titles_of_took(found), curvature_table.took(found))


TABLES = {"meshes": meshes, "configs": runs("configs", True), "curving": runs("curving", False), "paper": paper,
          "repair": repair, "shape": shape, "cavities": cavities, "relaxation": relaxation, "starts": starts, "spheres": spheres,
          "curvature": curvature, "curvature_took": curvature_took}


def pages():
    return [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def wrapped(line):
    """A command line on several where it is long."""
    lines = [""]
    for word in re.findall(r"--set (?:'[^']*'|\S+)|\S+", line):
        if lines[-1] and len(lines[-1]) + len(word) > WIDTH:
            lines.append("    ")
        lines[-1] += ("" if not lines[-1].strip() else " ") + word
    return " \\\n".join(lines)


def command(results, name):
    return "```sh\n" + "\n".join(map(wrapped, results[name]["command"].splitlines())) + "\n```\n"


def written(text, results):
    """The page with what it quotes."""
    def number(match):
        value = results[match[3]]["rows"][match[4]][match[5]]
        return f"{int(value) if match[6] == 'd' else value:{match[6]}}" + match[2]
    text = TABLE.sub(lambda match: match[1] + TABLES[match[2]](results) + match[3], text)
    text = COMMAND.sub(lambda match: match[1] + command(results, match[2]) + match[3], text)
    return NUMBER.sub(number, text)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    check = parser.parse_args().check
    results = json.loads(RESULTS.read_text(encoding="utf-8"))
    differing = 0
    for page in pages():
        text = page.read_text(encoding="utf-8")
        new = written(text, results)
        if new == text:
            continue
        differing += 1
        print(f"{page.relative_to(ROOT)}: " + ("differs from docs/results.json" if check else "written"))
        if not check:
            page.write_text(new, encoding="utf-8")
    sys.exit(1 if check and differing else 0)


if __name__ == "__main__":
    main()
