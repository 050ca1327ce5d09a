"""error_bound_px against the measured error, by the real renderer on real paths."""
import json
import statistics

from .programs import log, run


def measure(bench):
    """error_bound_px against the measured error, by the real renderer on real paths."""
    rows, summary = [], []
    width, height = bench.size
    for name in [bench.name] + [n for n in bench.meshes if n == "ct-head"]:
        log(f"holding {name} against its error bounds")
        for path in ("orbit", "dolly", "walk"):
            cameras = bench.out / f"{path}.jsonl"
            up = "z" if name == "ct-head" else "y"
            run(bench.program("qs-path"), path, bench.model(name), "--frames", 4 if bench.quick else 8, "--up", up, "-o", cameras)
            for threshold in (0, 0.5, 1, 2, 4, 8):
                report = bench.out / "bound.jsonl"
                run(bench.program("qs-render"), bench.model(name), "--path", cameras, "--threshold", threshold, "--resolution",
                    f"{width},{height}", "--reference", bench.meshes[name], "--report", report, "--quiet")
                lines = [json.loads(line) for line in open(report)]
                rows += [{"name": name, "path": path, "threshold_px": threshold, "frame": line["frame"],
                          "error_bound_px": line["error_bound_px"], "measured_error_px": line["measured_error_px"],
                          "bound_by_measured": ratio(line), "psnr_db": line["psnr_db"], "holes": line["holes"]}
                         for line in lines]
                ratios = [ratio(line) for line in lines if ratio(line) is not None]
                summary.append({"name": name, "path": path, "threshold_px": threshold, "frames": len(lines),
                                "median_ratio": statistics.median(ratios) if ratios else None,
                                "min_ratio": min(ratios, default=None), "max_ratio": max(ratios, default=None),
                                "frames_without_bound": sum(line["error_bound_px"] is None for line in lines),
                                "holes": sum(line["holes"] for line in lines)})
    bench.tables.write_csv("bound", rows)
    bench.tables.write("bound-summary", "error_bound_px by measured_error_px, smooth", summary)
    ratios = [row["bound_by_measured"] for row in rows if row["bound_by_measured"] is not None]
    bench.goals.add("frames whose error exceeds error_bound_px", "count", 0, None, sum(r < 1 for r in ratios))
    bench.goals.add("error_bound_px / measured, median frame", "1", 2, 1.3, statistics.median(ratios))
    bench.goals.add("holes, all frames of the paths", "px", 0, None, sum(row["holes"] for row in rows))


def ratio(line):
    bound, measured = line["error_bound_px"], line["measured_error_px"]
    return bound / measured if bound is not None and measured else None
