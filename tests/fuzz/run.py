#!/usr/bin/env python3
"""Runs the libFuzzer programs of a sanitized build on their corpora.

    tests/fuzz/run.py build-sanitize                            all targets, 60 s each
    tests/fuzz/run.py build-sanitize mesh config --seconds 10   some targets

BUILD/fuzz/TARGET keeps the inputs that a run adds; BUILD/fuzz/found keeps inputs that fail. Exit code 1: an input failed. Damaged CAD files
have a script of their own: tests/cad/mutations.py.
"""
import argparse
import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HERE = Path(__file__).resolve().parent
LIMITS = ["-max_len=8192", "-timeout=20", "-rss_limit_mb=3000", "-malloc_limit_mb=512", "-print_final_stats=1"]


def run(build: Path, target: str, seconds: int) -> bool:
    """Runs one target and prints its result. Returns False if an input failed."""
    added, found = build / "fuzz" / target, build / "fuzz" / "found"
    added.mkdir(parents=True, exist_ok=True)
    found.mkdir(exist_ok=True)
    dictionary = HERE / f"{target}.dict"
    command = [build / "bin" / f"fuzz_{target}", f"-max_total_time={seconds}", *LIMITS, f"-artifact_prefix={found}/{target}-",
               *([f"-dict={dictionary}"] if dictionary.exists() else []), added, HERE / "corpus" / target]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
    if done.returncode == 0:
        units = re.search(r"^stat::number_of_executed_units: *(\d+)", done.stdout, re.M)
        print(f"fuzz {target}: {units[1] if units else '?'} inputs in {seconds} s, no failure", flush=True)
        return True
    lines = [line for line in done.stdout.splitlines() if not re.match(r"#\d|INFO|NEW_FUNC", line)]
    print("\n".join(lines[-60:]))
    print(f"fuzz {target}: an input failed. It is in {found}; repeat: {command[0]} {found}/{target}-…", flush=True)
    return False


def main() -> int:
    targets = sorted(path.name for path in (HERE / "corpus").iterdir())
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=Path)
    parser.add_argument("targets", nargs="*", metavar="TARGET", help=", ".join(targets))
    parser.add_argument("--seconds", type=int, default=60, help="for each target, at least 1")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    options = parser.parse_args()
    if unknown := [target for target in options.targets if target not in targets]:
        parser.error(f"unknown target {unknown[0]}; targets: {', '.join(targets)}")
    if options.seconds < 1:
        parser.error("--seconds must be at least 1")
    if missing := [target for target in options.targets or targets if not (options.build / "bin" / f"fuzz_{target}").exists()]:
        parser.error(f"{options.build}/bin has no fuzz_{missing[0]}: run ./x build sanitize")
    with ThreadPoolExecutor(options.jobs) as pool:
        return 0 if all(list(pool.map(lambda target: run(options.build, target, options.seconds), options.targets or targets))) else 1


if __name__ == "__main__":
    sys.exit(main())
