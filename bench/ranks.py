#!/usr/bin/env python3
"""Measures curving by blocks on several ranks, and extrapolates to meshes that do not fit on this machine.

    python3 bench/ranks.py build/bin --elements 2e7 --ranks 4,8,4:2G,8:1G [--memory 2G] [--folder FOLDER]

`camber generate` makes a shell of prisms with layers, also on each number of ranks, which must give the same bytes. It is curved by `camber curve`
as a whole, and on each number of ranks with one thread each (`mpirun -n N camber-mpi curve`; N:SIZE sets the memory limit of each rank). With
--memory it is also curved within that limit, in a control group if the user may create one. Ranks share the available processors, so the efficiency
is that of CPU seconds: those of the first row with ranks divided by those of the others. All runs must write the same bytes.

The second table is an estimate: the cost for --on ELEMENTS,RANKS (1e9,1000) from the counters of the largest run.
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
    """Returns the wall-clock seconds of a command. Its output is shown if it fails."""
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
    """Creates a control group (version 2 or 1) with the limit. Returns None if that is impossible."""
    for root, limit in (("/sys/fs/cgroup/memory", "memory.limit_in_bytes"), ("/sys/fs/cgroup", "memory.max")):
        group = Path(root) / "camber-bench"
        try:
            group.mkdir(exist_ok=True)
            (group / limit).write_text(memory)
            return group
        except OSError:
            continue
    print("cannot create a control group: the memory limit is not enforced", file=sys.stderr)
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
    """Makes the mesh on the given number of ranks and prints the cost."""
    program = [options.bin / "camber"] if ranks is None else ["mpirun", "-n", ranks, options.bin / "camber-mpi"]
    line = [*program, "generate", "shell", "--structure", "prisms", "--elements", options.elements, "--set", "inner_layer/count=5", "-o", mesh]
    begin = time.perf_counter()
    run = subprocess.Popen(list(map(str, line)), stdout=subprocess.PIPE, text=True, env=os.environ | ROOT_OPTIONS)
    text = run.stdout.read()
    _, status, usage = os.wait4(run.pid, 0)
    if status != 0:
        sys.exit(f"{' '.join(map(str, line))}\n{text}")
    summary = next(line.strip() for line in text.splitlines() if "generated" in line)
    if ranks is None:  # peak of the process, which also writes the mesh
        summary += f"; at most {usage.ru_maxrss / 1024:.1f} MiB"
    print(f"generate, {'as a whole' if ranks is None else ranks}: {time.perf_counter() - begin:.1f} s, {summary}")


def on_paper(report, elements, ranks):
    """Estimates the cost for a mesh and a number of ranks from the counters of a run."""
    blocks, mesh = report["blocks"]["number"], report["mesh"]
    times = {t["stage"]: t["seconds"] for t in report["stages"]}
    share = report["ranks"]["number"]
    processor = sum(report["ranks"]["cpu_seconds"])
    surface_of_rank = times["surface"] * min(1, (os.cpu_count() or 1) / share)  # wall-clock time on shared processors
    of_surface = surface_of_rank * share  # each rank builds the whole
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
