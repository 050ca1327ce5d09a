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
    bench.goals.add("frame times along an orbit of x16: 95th percentile by median", "1", 1.2, None, rows[0]["p95_by_median"])
    # What is to be seen changes along the others, and the times with it: a frame is held against those beside it.
    bench.goals.add("frame times along paths of x16: 95th percentile by the 9 frames around, worst path", "1", 1.2, None,
                    max(row["p95_by_neighbours"] for row in rows))
    bench.goals.add("memory of a render of x16 beyond the blocks used, worst path", "MB", 60, None,
                    max(row["rss_bytes"] - row["used_bytes"] for row in rows) / 1e6)


def steadiness_of(bench, path, cameras, threshold):
    report = bench.out / "steady.jsonl"
    width, height = bench.size
    cost = run(bench.program("qs-render"), bench.model(bench.x16), "--path", cameras, "--threshold", threshold, "--resolution",
               f"{width},{height}", "--quiet", "--report", report)
    lines = [json.loads(line) for line in open(report)]
    times = [line["ms"]["traverse"] + line["ms"]["draw"] for line in lines[len(lines) // 10:]]
    median, late = statistics.median(times), late_of(times)
    return {"path": path, "frames": len(lines), "median_ms": median, "p95_ms": late, "p95_by_median": late / median,
            "p95_by_neighbours": late_of(by_neighbours(times)), "rss_bytes": cost.rss_bytes,
            "used_bytes": used_bytes(bench, cameras, threshold)}


def late_of(values):
    """The 95th percentile."""
    return sorted(values)[int(0.95 * (len(values) - 1))]


def by_neighbours(times):
    """Each by the median of the 9 around it."""
    return [time / statistics.median(times[max(0, i - 4):i + 5]) for i, time in enumerate(times)]


def used_bytes(bench, cameras, threshold):
    """The blocks that any frame of the path uses."""
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
