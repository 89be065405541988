"""The option tables in docs/algorithms contain the defaults of the program.

    python3 tests/pipelines/test_documented_options.py build/bin/camber [unittest arguments]
"""
import json
import pathlib
import re
import subprocess
import sys
import unittest

from program import CAMBER

PAGES = pathlib.Path(__file__).resolve().parents[2] / "docs" / "algorithms"
HEADING = re.compile(r"^## Options: `stages/(\w+)/…`$")
ROW = re.compile(r"^\| `(\w+)` \| `?([^|`]+)`? \|")


def defaults():
    """The defaults of each stage from the schema."""
    schema = json.loads(subprocess.run([CAMBER, "schema"], capture_output=True, check=True).stdout)
    stages = {}
    for stage in schema["properties"]["stages"]["items"]["oneOf"]:
        for name, options in stage.get("properties", {}).items():
            stages[name] = {key: option.get("default") for key, option in options["properties"].items()}
    return stages


def documented():
    """(page, stage, option, documented default) of every row."""
    for page in sorted(PAGES.glob("*.md")):
        stage = None
        for line in page.read_text(encoding="utf-8").splitlines():
            if line.startswith("## "):
                heading = HEADING.match(line)
                stage = heading[1] if heading else None
            row = ROW.match(line)
            if stage and row:
                yield page.name, stage, row[1], row[2].strip()


class DocumentedOptions(unittest.TestCase):
    def test_documented_defaults_equal_those_of_the_schema(self):
        known = defaults()
        rows = list(documented())
        self.assertGreater(len({stage for _, stage, _, _ in rows}), 2)
        for page, stage, option, written in rows:
            with self.subTest(page=page, option=option):
                self.assertIn(option, known[stage])
                default = known[stage][option]
                if default is None:
                    self.assertTrue(written.startswith("null"), written)
                    continue
                self.assertEqual(default if isinstance(default, str) else float(default),
                                 written if isinstance(default, str) else float(written))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
