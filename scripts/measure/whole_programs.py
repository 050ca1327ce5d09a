"""Programs from start to end: frames to a pipe and to files, single pictures."""
import json
import math
import statistics

from .programs import drop_pages, log, run, through_pipe
from .tables import spread


def measure(bench):
    rows = []
    width, height = bench.size
    found = bench.at_psnr[35]
    threshold = found["threshold_px"] if found else 1
    cameras, count = bench.out / "frames.jsonl", 6 if bench.quick else 120
    centre, radius = bench.bounds[bench.name]
    # The same distance as in the fitted view, round the model.
    run(bench.program("qs-path"), "orbit", "--bounds", ",".join(repr(v) for v in (*centre, radius)), "--frames", count,
        "--elevation", 0, "--distance", 2.85 * math.sin(math.radians(15)), "-o", cameras)
    psnr = path_psnr(bench, cameras, threshold)
    pictures = bench.out / "pictures"
    pictures.mkdir(exist_ok=True)
    common = [bench.program("qs-render"), bench.model(bench.x16), "--path", cameras, "--threshold", threshold,
              "--resolution", f"{width},{height}", "--quiet"]
    for name, more, must, stretch in (("y4m to a pipe", ["-o", "-"], 60, 100),
                                      ("PNG files", ["-o", pictures / "%04d.png"], 40, 60)):
        log(f"rendering to {name}")
        costs = [through_pipe(*common, *more) for _ in range(bench.slow_runs + 1)][1:]
        wall = spread([cost.wall_s for cost in costs])
        rows.append({"name": f"qs-render x16, {name}", "frames": count, "threshold_px": threshold, "psnr_db": psnr,
                     "runs": len(costs), "median_s": wall["median"], "min_s": wall["min"], "spread": wall["spread"],
                     "frames_per_s": count / wall["median"], "cpu_s": statistics.median(c.cpu_s for c in costs),
                     "rss_bytes": max(c.rss_bytes for c in costs)})
        bench.goals.add(f"frames, x16, 35 dB, {name}", "frames/s", must, stretch, count / wall["median"], True, count / wall["min"])
    for picture in pictures.iterdir():
        picture.unlink()
    measure_steadiness(bench, cameras, threshold)
    rows += single_pictures(bench, pictures / "one.png")
    bench.tables.write("programs", "whole programs", rows)


def measure_steadiness(bench, cameras, threshold):
    """Frames that nobody writes: how much their times vary along paths, and the memory beside what of the file is used."""
    rows = [steadiness_of(bench, "orbit", cameras, threshold)]
    for path in ("dolly", "walk"):
        other = bench.out / f"{path}.jsonl"
        run(bench.program("qs-path"), path, bench.model(bench.x16), "--frames", 6 if bench.quick else 120, "-o", other)
        rows.append(steadiness_of(bench, path, other, threshold))
    bench.tables.write("steadiness", "times of frames along paths of x16, nothing written", rows)
    bench.goals.add("frame times along an orbit of x16: 95th percentile by median", "1", 1.2, None, rows[0]["p95_by_median"],
                    best=rows[0]["best_by_median"])
    # What is to be seen changes along the others, and the times with it: a frame is held against those beside it.
    worst = max(rows, key=lambda row: row["p95_by_neighbours"])
    bench.goals.add("frame times along paths of x16: 95th percentile by the 9 frames around, worst path", "1", 1.2, None,
                    worst["p95_by_neighbours"], best=worst["best_by_neighbours"])
    bench.goals.add("memory of a render of x16 beyond the pages of the file that it uses, worst path", "MB", 60, None,
                    max(row["rss_bytes"] - row["used_bytes"] for row in rows) / 1e6)


def steadiness_of(bench, path, cameras, threshold):
    """Each path is drawn several times, and has the median of the runs: one run tells of what else the machine did."""
    report = bench.out / "steady.jsonl"
    width, height = bench.size
    costs, runs = [], []
    for _ in range(bench.slow_runs):
        costs.append(run(bench.program("qs-render"), bench.model(bench.x16), "--path", cameras, "--threshold", threshold,
                         "--resolution", f"{width},{height}", "--quiet", "--report", report))
        lines = [json.loads(line) for line in open(report)]
        settled = lines[len(lines) // 10:]
        runs.append([line["ms"]["traverse"] + line["ms"]["draw"] for line in settled])
    by_median, neighbours = [late_by_median(times) for times in runs], [late_by_neighbours(times) for times in runs]
    splats = [line["splats"] for line in settled]
    return {"path": path, "frames": len(lines), "runs": len(runs), "median_ms": statistics.median(map(statistics.median, runs)),
            "p95_by_median": statistics.median(by_median), "best_by_median": min(by_median),
            "p95_by_neighbours": statistics.median(neighbours), "best_by_neighbours": min(neighbours),
            # What of it is the paths': there are more splats in some frames than in others.
            "splats_p95_by_median": late_by_median(splats), "splats_p95_by_neighbours": late_by_neighbours(splats),
            "rss_bytes": max(cost.rss_bytes for cost in costs), "used_bytes": used_bytes(bench, cameras, threshold)}


def late_by_median(values):
    return late_of(values) / statistics.median(values)


def late_by_neighbours(values):
    """Each is held against the median of the 9 around it."""
    return late_of([value / statistics.median(values[max(0, i - 4):i + 5]) for i, value in enumerate(values)])


def late_of(values):
    """The 95th percentile."""
    return sorted(values)[int(0.95 * (len(values) - 1))]


def used_bytes(bench, cameras, threshold):
    """The pages of the file that any frame of the path uses.  The system maps those around them, too, where it has them in
    memory: they count against us."""
    with bench.frames_of(bench.x16) as frames:
        answers = [frames.ask(dict(json.loads(line), size=bench.size), threshold) for line in open(cameras)]
    return answers[-1]["used_bytes"]


def path_psnr(bench, cameras, threshold):
    """Median over some frames of the path."""
    lines = [json.loads(line) for line in open(cameras)]
    with bench.frames_of(bench.x16) as frames:
        return statistics.median(frames.ask(dict(line, size=bench.size), threshold, compare=True)["psnr_db"]
                                 for line in lines[::max(1, len(lines) // 8)])


def single_pictures(bench, picture):
    """A new process for each picture; with the page cache warm, and with the model's pages dropped."""
    rows = []
    width, height = bench.size
    model = bench.model(bench.name)
    for threshold in (0, 1):
        for is_dropped in (False, True):
            costs = []
            for _ in range(2 * bench.slow_runs + 1):
                if is_dropped:
                    drop_pages(model)
                costs.append(run(bench.program("qs-render"), model, "--threshold", threshold, "--resolution",
                                 f"{width},{height}", "-o", picture, "--quiet"))
            wall = spread([cost.wall_s for cost in costs[1:]])
            rss = max(cost.rss_bytes for cost in costs)
            rows.append({"name": f"qs-render, one picture, {'file not cached' if is_dropped else 'file cached'}",
                         "frames": 1, "threshold_px": threshold, "runs": len(costs) - 1,
                         "median_s": wall["median"], "min_s": wall["min"], "spread": wall["spread"],
                         "frames_per_s": 1 / wall["median"], "cpu_s": statistics.median(c.cpu_s for c in costs),
                         "rss_bytes": rss})
            if threshold == 0 and not is_dropped:
                bench.goals.add("one picture, new process, leaves", "ms", 100, 50, 1000 * wall["median"], best=1000 * wall["min"])
                bench.goals.add("one picture, new process, leaves: memory", "MB", 100, None, rss / 1e6)
    return rows
