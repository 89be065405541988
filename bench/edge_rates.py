#!/usr/bin/env python3
"""Rates of placing edge nodes, beside the paper's method: prints a Markdown table of what build/bin/bench_edge measures.

    bench/edge_rates.py build/bin/bench_edge [--repeats 3]

The methods and fields are described at the top of bench/edge.cpp. A cell has the edges a second of one thread as a multiple of
those of `paper_reference` (which itself has its rate), and the mean true length over the chord's. Rates are medians.
"""
import argparse
import json
import subprocess

METHODS = ("paper_reference", "paper_points", "camber", "camber_length", "default")


def measured(program, repeats):
    """{field: {method: counters}}, medians of the repeats."""
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
