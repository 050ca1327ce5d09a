"""Triangles as leaves: what they take, and error and time against zoom, beside points and the mesh itself."""
import json
import math

from .programs import log, run
from .tables import spread

ZOOMS = [1, 2, 4, 8, 16, 32, 64]
# Leaf, and options: points; splats and triangles; the mesh, all of its triangles.
DRAWN = {"points": ("point", []), "hybrid": ("triangle", []), "mesh": ("triangle", ["--triangle-size", 0, "--threshold", 0])}


def measure(bench):
    log(f"triangles of {bench.name}")
    measure_building(bench)
    cameras = write_cameras(bench)
    rows = [row for name in DRAWN for row in zoom_rows(bench, name, cameras)]
    bench.tables.write("triangles", "triangles as leaves: error and time against zoom", rows)
    at = {(row["drawn"], row["zoom"]): row for row in rows}
    bench.goals.add("triangle leaves, 4x zoom, PSNR", "dB", 45, 49, at["hybrid", 4]["psnr_db"], True)
    bench.goals.add("triangle leaves, 64x zoom, PSNR below that of the mesh", "dB", 1, None,
                    at["mesh", 64]["psnr_db"] - at["hybrid", 64]["psnr_db"])
    # On the outline two exact renderers differ, too: there one pixel may be the mesh's and not the model's.
    bench.goals.add("triangle leaves, 1x to 64x zoom, holes inside and show-through", "px", 0, None,
                    sum(row["holes_inside"] + row["show_through"] for row in rows if row["drawn"] == "hybrid"))
    bench.goals.add("triangle leaves, 1x zoom, time by that of points", "1", 1.1, None,
                    at["hybrid", 1]["min_ms"] / at["points", 1]["min_ms"])


def model(bench):
    return bench.model(f"{bench.name}-triangles")


def measure_building(bench):
    report = bench.out / "build.json"
    command = [bench.program("qs-build"), bench.mesh, "--leaf", "triangle", "--no-colour", "-o", model(bench), "--quiet",
               "--report", report]
    run(*command)
    costs = [run(*command) for _ in range(bench.slow_runs)]
    made = json.loads(report.read_text())
    wall = spread([cost.wall_s for cost in costs])
    info = json.loads(run_json(bench, model(bench)))
    bench.tables.write("triangles-build", "triangles as leaves: building and size", [
        {"name": bench.name, "triangles": made["triangles_in"], "runs": len(costs), "median_s": wall["median"],
         "min_s": wall["min"], "spread": wall["spread"], "triangles_per_s": made["triangles_in"] / wall["median"],
         "rss_bytes": max(cost.rss_bytes for cost in costs), "bytes_per_triangle": made["bytes_per_triangle"],
         "corners_per_triangle": info["corners"] / info["triangles_present"], "smooth": made["triangles_smooth"],
         "lattice_bits": made["lattice_bits"], "vertices_merged": made["vertices_merged"],
         "fan_out": info["fan_out_mean"]}])
    bench.goals.add("triangle leaves, build", "triangles/s", 3e6, None, made["triangles_in"] / wall["median"], True,
                    made["triangles_in"] / wall["min"])
    bench.goals.add("triangle leaves, file, no colour", "B/triangle", 14, None, made["bytes_per_triangle"])


def run_json(bench, path):
    out = bench.out / "triangles-info.json"
    run(bench.program("qs-info"), path, "--report", out)
    return out.read_text()


def write_cameras(bench):
    """The fitted view, nearer and nearer by focal length, towards where the close-up looks."""
    fit = bench.fit(bench.name)
    near = bench.close_up(fit)["target"]
    path = bench.out / "zoom.jsonl"
    with open(path, "w") as file:
        for zoom in ZOOMS:
            target = [c + (n - c) * (1 - 1 / zoom) for c, n in zip(fit["target"], near)]
            fovy = math.degrees(2 * math.atan(math.tan(math.radians(15)) / zoom))
            file.write(json.dumps({"eye": fit["eye"], "target": target, "up": fit["up"], "fovy": fovy, "t": 0}) + "\n")
    return path


def zoom_rows(bench, name, cameras):
    leaf, options = DRAWN[name]
    path = model(bench) if leaf == "triangle" else bench.model(bench.name)
    report = bench.out / "triangles.jsonl"
    width, height = bench.size
    draw = [bench.program("qs-render"), path, "--path", cameras, "--resolution", f"{width},{height}", "--backend", "cpu",
            "--quiet", "--report", report, *options]
    run(*draw, "--reference", bench.mesh)
    measured = lines_of(report)
    times = []
    for _ in range(bench.slow_runs):
        run(*draw)
        times.append([line["ms"]["traverse"] + line["ms"]["draw"] for line in lines_of(report)])
    return [{"drawn": name, "zoom": zoom, "splats": line["splats"], "triangles": line["triangles"],
             "median_ms": spread(ms)["median"], "min_ms": min(ms), "psnr_db": line["psnr_db"],
             "coverage_iou": line["coverage_iou"], "growth": line["silhouette_growth"], "holes": line["holes"],
             "holes_inside": line["holes_inside"], "show_through": line["show_through"],
             "error_bound_px": line["error_bound_px"], "measured_error_px": line["measured_error_px"],
             "bytes_touched": line["bytes_touched"]}
            for zoom, line, ms in zip(ZOOMS, measured, zip(*times))]


def lines_of(report):
    with open(report) as file:
        return [json.loads(line) for line in file]
