"""Runs the program in a temporary folder, for the tests of this directory."""
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

CAMBER = str(Path(sys.argv[1] if len(sys.argv) > 1 else "build/bin/camber").resolve())
SANITIZED = os.environ.get("CAMBER_SANITIZED") == "1"  # sanitized runs take twenty times as long
ROOT = Path(__file__).resolve().parents[2]
CONFIGS = ROOT / "configs"
sys.path.insert(0, str(ROOT / "tests" / "oracle"))


class Folder(tempfile.TemporaryDirectory):
    """A working directory that is deleted at the end of the test. The configs write into out/."""

    def __init__(self):
        super().__init__()
        (self.path / "out").mkdir()

    @property
    def path(self):
        return Path(self.name)

    def camber(self, *arguments, **options):
        return subprocess.run([CAMBER, *map(str, arguments)], cwd=self.name, capture_output=True, text=True,
                              timeout=600, **options)

    def files(self):
        return sorted(str(p.relative_to(self.name)) for p in self.path.rglob("*") if p.is_file())


def report_of(path):
    return json.loads(Path(path).read_text())
