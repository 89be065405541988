#!/usr/bin/env python3
"""Prints a Markdown table of the rates of edge optimisation measured by build/bin/bench_edge, relative to the method of the paper.

    bench/edge_rates.py build/bin/bench_edge [--repeats 3]

The methods and fields are described at the top of bench/edge.cpp. A cell has the edges per second of one thread as a multiple of
the rate of `paper_reference` (whose cell has the rate itself), and the mean ratio of true length and chord. Rates are medians.
"""
import argparse
import json
import subprocess

METHODS = ("paper_reference", "paper_points", "camber", "camber_length", "default")


def measured(program, repeats):
    """Returns {field: {method: counters}}, medians of the repeats."""
    words = [program, "--benchmark_format=json", "--benchmark_min_time=0.1", f"--benchmark_repetitions={repeats}",
             "--benchmark_report_aggregates_only=true"] if repeats > 1 else [program, "--benchmark_format=json", "--benchmark_min_time=0.1"]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    found = {}
    for row in json.loads(done.stdout)["benchmarks"]:
        if row.get("aggregate_name", "median") == "median":
            _, method, field = row["name"].removesuffix("_median").split("/")[:3]
            found.setdefault(field, {})[method] = row
    return found


def cell(row, reference):
    rate = row["edges_per_second"]
    return (f"{rate / reference:.1f} times" if rate != reference else f"{rate:.0f} /s") + f", {row['true_length']:.5f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", help="bench_edge")
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    print("| field, edges | " + " | ".join(f"`{method}`" for method in METHODS) + " |\n" + "|---" * (1 + len(METHODS)) + "|")
    for field, rows in measured(options.program, options.repeats).items():
        reference = rows["paper_reference"]
        edges = f"{reference['edges']:,.0f}".replace(",", " ")
        cells = [cell(rows[method], reference["edges_per_second"]) for method in METHODS]
        print(f"| {field}, {edges} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
