"""Building: speed, memory, size, and how well the codes fit."""
import json
import statistics
import subprocess

from .programs import log, run
from .tables import spread


def measure(bench):
    rows, stages = [], []
    for name, mesh in bench.models.items():
        log(f"building {name}")
        report = bench.out / "build.json"
        colour = [] if name == bench.painted else ["--no-colour"]
        command = [bench.program("qs-build"), mesh, "-o", bench.model(name), *colour, "--quiet", "--report", report]
        run(*command)
        costs = [run(*command) for _ in range(bench.slow_runs)]
        made = json.loads(report.read_text())
        wall = spread([cost.wall_s for cost in costs])
        rss = max(cost.rss_bytes for cost in costs)
        rows.append({"name": name, "vertices": made["vertices_in"], "runs": len(costs), "median_s": wall["median"],
                     "min_s": wall["min"], "spread": wall["spread"],
                     "vertices_per_s": made["vertices_in"] / wall["median"],
                     "cpu_s": statistics.median(cost.cpu_s for cost in costs), "rss_bytes": rss,
                     "rss_per_vertex": rss / made["vertices_in"], "bytes_per_vertex": made["bytes_per_vertex"],
                     "leaf_inflation_mean": made["leaf_inflation_mean"],
                     "leaf_inflation_max": made["leaf_inflation_max"],
                     "inner_inflation_mean": made["inner_inflation_mean"], "levels": made["levels"],
                     "verified": is_verified(bench, name)})
        stages += [{"name": name, "stage": stage, "ms": ms} for stage, ms in made["ms"].items()]
    bench.tables.write("build", "building, all stages, page cache warm", rows)
    bench.tables.write("build-stages", "stages of the last run", stages)
    bench.built = {row["name"]: row for row in rows}
    x16, painted = bench.built[bench.x16], bench.built[bench.painted]

    def largest(key):
        return max(row[key] for row in rows)
    bench.goals.add("build, x16", "vertices/s", 3e6, 6e6, x16["vertices_per_s"], True, x16["vertices"] / x16["min_s"])
    bench.goals.add("build, x16, memory", "B/vertex", 110, 80, x16["rss_per_vertex"])
    bench.goals.add("file, no colour, largest of the models", "B/vertex", 5.5, 5.0,
                    max(row["bytes_per_vertex"] for row in rows if row is not painted))
    bench.goals.add("file, colour", "B/vertex", 8, 7, painted["bytes_per_vertex"])
    bench.goals.add("models with a fault (qs-info --verify)", "count", 0, None,
                    sum(not row["verified"] for row in rows))
    bench.goals.add("leaf inflation, mean, largest of the models", "1", 1.25, 1.15, largest("leaf_inflation_mean"))
    bench.goals.add("leaf inflation, worst of all models", "1", 3, 2, largest("leaf_inflation_max"))
    bench.goals.add("inner inflation, mean, largest of the models", "1", 1.25, 1.15, largest("inner_inflation_mean"))


def build(bench, names):
    """Models that other parts measure, without a look at how they are built."""
    for name in names:
        log(f"building {name}")
        run(bench.program("qs-build"), bench.models[name], "-o", bench.model(name), "--no-colour", "--quiet")


def is_verified(bench, name):
    return subprocess.run([bench.program("qs-info"), "--verify", bench.model(name)],
                          stdout=subprocess.DEVNULL).returncode == 0
