#!/usr/bin/env python3
"""Curving by blocks on several ranks, and what that says of a mesh that no machine here holds.

    python3 bench/ranks.py build/bin --elements 2e7 --ranks 4,8,4:2G,8:1G [--memory 2G] [--folder FOLDER]

A shell of prisms with layers (`camber generate`, and by each number of ranks: the same bytes) is curved by `camber curve` as a whole, on each number of ranks with a thread
each (`mpirun -n N camber-mpi curve`; N:SIZE within so much memory each), and within a memory where one is given; in a control group with that limit where this
user may make one. Ranks share the processors that are there: the efficiency is that of processor seconds: of the first
row by ranks over those of the others. All must write the same bytes.

The second table is on paper: what the counters of the largest run say a block costs, for --on ELEMENTS,RANKS (1e9,1000).
"""
import argparse
import filecmp
import json
import os
import resource
import subprocess
import sys
import time
from pathlib import Path

ROOT_OPTIONS = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1"}


def timed(line, **options):
    """Seconds on the wall of a command; its output is shown where it fails."""
    begin = time.perf_counter()
    run = subprocess.run(list(map(str, line)), capture_output=True, text=True, env=os.environ | ROOT_OPTIONS, **options)
    if run.returncode != 0:
        sys.exit(f"{' '.join(map(str, line))}\n{run.stdout}{run.stderr}")
    return time.perf_counter() - begin


def report_of(path):
    return json.loads(Path(path).read_text())


def largest(numbers):
    return max(numbers)


def row(name, seconds, report):
    ranks = report["ranks"]
    return {"name": name, "seconds": seconds, "processor": sum(ranks["cpu_seconds"]), "peak": largest(ranks["peak_bytes"]),
            "sent": largest(ranks["sent_bytes"]), "rounds": ranks["rounds"], "ranks": ranks["number"]}


def shown(rows):
    one = next((r["processor"] for r in rows if r["rounds"] is not None), float("nan"))
    print("| run | seconds | processor seconds | efficiency | peak of a rank | sent by a rank | exchanges |\n|---|---|---|---|---|---|---|")
    for r in rows:
        efficiency = "" if r["rounds"] is None else f"{one / r['processor']:.2f}"
        sent = "" if r["rounds"] is None else f"{r['sent'] / 1e6:.0f} MB"
        print(f"| {r['name']} | {r['seconds']:.1f} | {r['processor']:.1f} | {efficiency} | {r['peak'] / 1e6:.0f} MB | {sent} | "
              f"{'' if r['rounds'] is None else r['rounds']} |")


def whole(camber, mesh, out):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = timed([camber, "curve", mesh, "-o", out, "--report", out.with_suffix(".json"), "--quiet"])
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    peak = largest([step["peak_bytes"] for step in report_of(out.with_suffix(".json"))["stages"]])
    return {"name": "as a whole, all threads", "seconds": seconds, "processor": processor, "peak": peak, "rounds": None}


def limited_group(memory):
    """A control group (version 2, or 1) with that limit, or nothing where it cannot be made."""
    for root, limit in (("/sys/fs/cgroup/memory", "memory.limit_in_bytes"), ("/sys/fs/cgroup", "memory.max")):
        group = Path(root) / "camber-bench"
        try:
            group.mkdir(exist_ok=True)
            (group / limit).write_text(memory)
            return group
        except OSError:
            continue
    print("no control group can be made: the run keeps to the memory by itself", file=sys.stderr)
    return None


def within_memory(camber, mesh, out, memory):
    group = limited_group(memory)

    def enter():
        if group is not None:
            (group / "cgroup.procs").write_text(str(os.getpid()))

    seconds = timed([camber, "curve", mesh, "-o", out, "--memory", memory, "--report", out.with_suffix(".json"), "--quiet"], preexec_fn=enter)
    cells = row(f"within {memory}" + (" (control group)" if group else ""), seconds, report_of(out.with_suffix(".json")))
    if group is not None:
        group.rmdir()
    return cells


def generated(options, mesh, ranks):
    """Makes the mesh on so many ranks; what that took, as the program tells it."""
    program = [options.bin / "camber"] if ranks is None else ["mpirun", "-n", ranks, options.bin / "camber-mpi"]
    line = [*program, "generate", "shell", "--structure", "prisms", "--elements", options.elements, "--set", "inner_layer/count=5", "-o", mesh]
    begin = time.perf_counter()
    run = subprocess.Popen(list(map(str, line)), stdout=subprocess.PIPE, text=True, env=os.environ | ROOT_OPTIONS)
    text = run.stdout.read()
    _, status, usage = os.wait4(run.pid, 0)
    if status != 0:
        sys.exit(f"{' '.join(map(str, line))}\n{text}")
    summary = next(line.strip() for line in text.splitlines() if "generated" in line)
    if ranks is None:  # of the whole process, that the mesh is written by too
        summary += f"; at most {usage.ru_maxrss / 1024:.1f} MiB"
    print(f"generate, {'as a whole' if ranks is None else ranks}: {time.perf_counter() - begin:.1f} s, {summary}")


def on_paper(report, elements, ranks):
    """From the counters of a run to a mesh of so many elements on so many ranks."""
    blocks, mesh = report["blocks"]["number"], report["mesh"]
    times = {t["stage"]: t["seconds"] for t in report["stages"]}
    share = report["ranks"]["number"]
    processor = sum(report["ranks"]["cpu_seconds"])
    surface_of_rank = times["surface"] * min(1, (os.cpu_count() or 1) / share)  # by the clock, on processors that ranks share
    of_surface = surface_of_rank * share  # each rank makes all of it
    of_block = (processor - of_surface) / blocks
    facets = mesh["facets"] * (elements / mesh["elements"]) ** (2 / 3)
    blocks_there = elements / report["blocks"]["elements"]
    per_rank = -(-blocks_there // ranks)
    sent = largest(report["ranks"]["sent_bytes"]) / max(1, blocks / share) * per_rank
    peak = largest(report["ranks"]["peak_bytes"]) / max(1, blocks / share) * per_rank
    surface = surface_of_rank * facets / mesh["facets"]
    rounds = report["ranks"]["rounds"]
    latency = rounds * ranks * 1e-6  # an all-to-all of sizes: about a microsecond a rank
    print(f"\n{elements:.0e} elements on {ranks} ranks, from {mesh['elements']} on {share}\n\n| | |\n|---|---|")
    for name, value in (("blocks, of a rank at most", f"{blocks_there:.0f}, {per_rank:.0f}"),
                        ("processor seconds of a block", f"{of_block:.2f}"),
                        ("work of a rank on its blocks", f"{per_rank * of_block:.1f} s"),
                        ("the surface, which each rank makes whole", f"{facets:.2e} facets, {surface:.1f} s"),
                        ("sent by a rank", f"{sent / 1e6:.0f} MB, at 1 GB/s {sent / 1e9:.2f} s"),
                        ("exchanges", f"{rounds}, at a microsecond a rank {latency:.2f} s"),
                        ("memory of a rank", f"{peak / 1e6:.0f} MB, and the surface {facets * 600 / 1e6:.0f} MB")):
        print(f"| {name} | {value} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=Path)
    parser.add_argument("--elements", default="2e7")
    parser.add_argument("--ranks", default="1,2,4,8")
    parser.add_argument("--memory")
    parser.add_argument("--on", default="1e9,1000")
    parser.add_argument("--folder", type=Path, default=Path("."))
    options = parser.parse_args()
    camber, camber_mpi = options.bin / "camber", options.bin / "camber-mpi"
    mesh = options.folder / "ranks.meshb"
    generated(options, mesh, None)
    for ranks in options.ranks.split(","):
        ranks, again = ranks.partition(":")[0], options.folder / "again.meshb"
        generated(options, again, ranks)
        if not filecmp.cmp(mesh, again, shallow=False):
            sys.exit(f"{ranks} ranks generate OTHER BYTES")
        again.unlink()
    rows = [whole(camber, mesh, options.folder / "whole.meshb")]
    first = report = None
    sys.stdout.reconfigure(line_buffering=True)
    for text in options.ranks.split(","):
        ranks, _, memory = text.partition(":")
        out = options.folder / f"ranks-{ranks}{memory}.meshb"
        report_file = options.folder / "ranks.json"
        within = ["--memory", memory] if memory else []
        seconds = timed(["mpirun", "-n", ranks, camber_mpi, "curve", mesh, "-o", out, "--blocks", 262144, "--threads", 1, "--report", report_file, *within])
        report = report_of(report_file)
        rows.append(row(f"{ranks} rank{'s' if ranks != '1' else ''}" + (f", {memory} each" if memory else ""), seconds, report))
        if first is None:
            first = out
        else:
            print(f"{text} ranks: {'the same bytes' if filecmp.cmp(first, out, shallow=False) else 'OTHER BYTES'}")
            out.unlink()
    if options.memory:
        out = options.folder / "memory.meshb"
        rows.append(within_memory(camber, mesh, out, options.memory))
        print(f"within {options.memory}: {'the same bytes' if filecmp.cmp(first, out, shallow=False) else 'OTHER BYTES'}")
    shown(rows)
    elements, ranks = options.on.split(",")
    on_paper(report, float(elements), int(ranks))


if __name__ == "__main__":
    main()
