"""Frames along whole paths: what the goals say of one view, for all of them."""
import json
import statistics

from .programs import log, run


def measure(bench):
    by_psnr = [(bench.at_psnr[psnr] or {}).get("threshold_px") for psnr in (35, 40)]
    subjects = [(bench.name, (0, 1)), (bench.x16, by_psnr)] + [(n, (0, 1)) for n in bench.meshes if n == "ct-head"]
    rows = []
    for name, thresholds in subjects:
        log(f"frames of {name} along paths")
        for path in ("orbit", "dolly", "walk"):
            cameras = cameras_of(bench, name, path)
            with bench.frames_of(name) as frames:
                rows += [row_of(bench, name, path, frames, cameras, threshold) for threshold in thresholds if threshold is not None]
    bench.tables.write("paths", "frames along paths, smooth", rows)
    set_goals(bench, rows, by_psnr)


def cameras_of(bench, name, path):
    file = bench.out / "paths.jsonl"
    run(bench.program("qs-path"), path, bench.model(name), "--frames", 4 if bench.quick else 16,
        "--up", "z" if name == "ct-head" else "y", "-o", file)
    return [dict(json.loads(line), size=bench.size) for line in open(file)]


def row_of(bench, name, path, frames, cameras, threshold):
    """Every frame is timed, every fourth held against the mesh."""
    answers = [frames.ask(camera, threshold, runs=3, compare=i % 4 == 0, distance=i % 4 == 0)
               for i, camera in enumerate(cameras)]
    held = [a for a in answers if "psnr_db" in a]
    psnr = [a["psnr_db"] for a in held if a["psnr_db"] is not None]
    ratios = [a["error_bound_px"] / a["measured_error_px"] for a in held if a["error_bound_px"] and a["measured_error_px"]]
    times = sorted(a["ms"]["median"] for a in answers)
    return {"name": name, "path": path, "threshold_px": threshold, "frames": len(times),
            "median_ms": statistics.median(times), "p95_ms": times[round(0.95 * (len(times) - 1))],
            "median_splats": statistics.median(a["splats"] for a in answers),
            "ns_a_splat": statistics.median(1e6 * a["ms"]["median"] / max(1, a["splats"]) for a in answers),
            "median_psnr_db": statistics.median(psnr) if psnr else None, "min_psnr_db": min(psnr, default=None),
            "bound_by_measured": statistics.median(ratios) if ratios else None, "holes": sum(a["holes"] for a in held)}


def set_goals(bench, rows, by_psnr):
    for name, threshold, what, must, stretch in ((bench.name, 0, "leaves", 8, 4), (bench.x16, by_psnr[0], "35 dB of fit", 8, 4),
                                                 (bench.x16, by_psnr[1], "40 dB of fit", 25, 12)):
        for path in ("orbit", "dolly", "walk"):
            found = [row for row in rows if (row["name"], row["path"], row["threshold_px"]) == (name, path, threshold)]
            if found and threshold is not None:
                bench.goals.add(f"frame, {'x16, ' if name == bench.x16 else ''}{path}, {what}, median", "ms", must, stretch,
                                found[0]["median_ms"])
    for name, threshold, what, must, stretch in ((bench.name, 0, "leaves", 34.5, 36.5), (bench.name, 1, "1 px of error", 30, 31.5),
                                                 (bench.x16, by_psnr[0], "x16, 35 dB of fit", 35, None)):
        psnr = [row["median_psnr_db"] for row in rows if (row["name"], row["threshold_px"]) == (name, threshold)]
        if threshold is not None:
            bench.goals.add(f"frames along paths, {what}: PSNR, median, worst path", "dB", must, stretch,
                            min((value for value in psnr if value is not None), default=None), True)
