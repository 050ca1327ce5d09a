"""The table of stiff and extreme cases, as its tests measure it."""
import csv
import os
import subprocess

from .programs import log


def measure(bench):
    log("stiff and extreme cases")
    file = bench.out / "stability.csv"
    environment = dict(os.environ, GTEST_FILTER="*Places*:*aplane*") if bench.quick else os.environ
    done = subprocess.run([bench.program("stability_tests"), "--table", file], stdout=subprocess.DEVNULL, env=environment)
    if not file.exists():
        raise SystemExit(f"bench: stability_tests left no table (exit status {done.returncode})")
    rows = [dict(row, bound=float(row["bound"]), measured=float(row["measured"])) for row in csv.DictReader(open(file))]
    for row in rows:
        holds = row["measured"] <= row["bound"] if row["relation"] == "<=" else row["measured"] >= row["bound"]
        row["holds"] = "yes" if holds else "NO"
    bench.tables.write("stability", "stiff and extreme cases: what is promised, and what was measured", rows)
    bench.goals.add("stiff and extreme cases beyond their bounds", "count", 0, None, sum(row["holds"] == "NO" for row in rows))
