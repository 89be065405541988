"""The tables of keys in docs/report.md, from `camber schema` of the three reports.

    python3 tests/pipelines/report_page.py build/bin/camber --write
"""
import json
import subprocess
import sys
from pathlib import Path

PAGE = Path(__file__).resolve().parents[2] / "docs" / "report.md"
END = "<!-- end of the keys -->\n"


def rows_of(properties, path, known):
    """(key, unit, meaning) of all leaves; a repeated object gets one row."""
    rows = []
    for key, schema in properties.items():
        name, meaning = f"{path}{key}", schema.get("description", "")
        inner = schema
        if schema.get("type") == "array" and schema["items"].get("type") == "object":
            name, inner = name + "[]", schema["items"]
        others = inner.get("additionalProperties")
        if others and not inner.get("properties"):
            inner, others, name = others, None, name + ".NAME"
        if not inner.get("properties"):
            rows.append((name, schema.get("unit", ""), meaning))
            continue
        shape = json.dumps(inner["properties"])
        if known.get(shape, name) != name:
            rows.append((f"{name}.KEY", "", f"{meaning}: keys as those of `{known[shape]}`"))
            continue
        known[shape] = name
        rows += rows_of(inner["properties"] | ({"NAME": others} if others else {}), f"{name}.", known)
    return rows


def table(rows):
    return "| key | unit | meaning |\n|---|---|---|\n" + "".join(f"| `{key}` | {unit} | {meaning} |\n" for key, unit, meaning in rows)


def properties_of(camber, report):
    done = subprocess.run([camber, "schema", report], check=True, capture_output=True, text=True)
    properties = json.loads(done.stdout)["properties"]
    properties.pop("histograms", None)
    return properties


def tables_of_run(camber, known):
    """The table of the run, then a section for each part that is an object."""
    few = 4
    run, parts = [], []
    for key, schema in properties_of(camber, "report").items():
        rows = rows_of({key: schema}, "", known)
        is_part = schema.get("type") == "object" and (len(rows) > few or rows[0][0].endswith(".KEY"))
        if is_part:
            parts.append(f"\n### `{key}`\n\n{schema['description'][0].upper()}{schema['description'][1:]}.\n\n{table(rows)}")
        else:
            run += rows
    return f"### The run\n\n{table(run)}{''.join(parts)}"


def page(camber):
    """The page with the tables of this build."""
    known, text = {}, PAGE.read_text(encoding="utf-8")
    for name, tables in (("report.json", lambda: tables_of_run(camber, known)),
                         ("check --json", lambda: table(rows_of(properties_of(camber, "check"), "", known))),
                         ("geometry --json", lambda: table(rows_of(properties_of(camber, "geometry"), "", known)))):
        mark = f"<!-- keys of {name} -->\n"
        begin = text.index(mark) + len(mark)
        text = text[:begin] + "\n" + tables() + "\n" + text[text.index(END, begin):]
    return text


if __name__ == "__main__":
    if "--write" in sys.argv:
        PAGE.write_text(page(sys.argv[1]), encoding="utf-8")
    else:
        print(page(sys.argv[1]))
