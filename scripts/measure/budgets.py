"""How well qs-render --budget holds the time of frames, beside feedback alone, as the original has it."""
import json
import random

from .programs import log, read, run


def measure(bench):
    rows = []
    for name in (bench.x16,):
        for path, cameras in make_paths(bench, name).items():
            log(f"budgets for {name}, {path}")
            for budget_ms in ((16,) if bench.quick else (10, 16, 33)):
                # The finest threshold is small, so that there is something to hold back.
                out = read(bench.program("budget_bench"), bench.model(name), cameras, "--budget", budget_ms, "--threshold", 0.1)
                rows += [{"name": name, "path": path, "budget_ms": budget_ms, "method": a["method"],
                          "share_in_time": a["share_in_time"], "first_ms": a["first_ms"], "median_ms": a["median_ms"],
                          "p95_ms": a["p95_ms"], "max_ms": a["max_ms"], "off_prediction": a["median_off_prediction"],
                          "median_threshold_px": a["median_threshold_px"], "median_splats": a["median_splats"]}
                         for a in map(json.loads, out.splitlines())]
    bench.tables.write("budgets", "frames within 1.2 times their budget", rows)
    ours = [row["share_in_time"] for row in rows if row["path"] != "jumps" and row["method"] == rows[0]["method"]]
    bench.goals.add("frames within 1.2 budgets, worst path and budget", "1", 0.95, None, min(ours), True)


def make_paths(bench, name):
    """The three paths, and all their frames in random order."""
    paths, lines = {}, []
    for path in ("orbit", "dolly", "walk"):
        paths[path] = bench.out / f"budget-{path}.jsonl"
        run(bench.program("qs-path"), path, bench.model(name), "--frames", 8 if bench.quick else 96, "-o", paths[path])
        lines += paths[path].read_text().splitlines()
    random.Random(1).shuffle(lines)
    paths["jumps"] = bench.out / "budget-jumps.jsonl"
    paths["jumps"].write_text("\n".join(lines) + "\n")
    return paths
