"""What our figures are held beside: memory bandwidth, and the original programs."""
import json

from .frames import row_of
from .programs import read

# The original programs (Rusinkiewicz and Levoy, QSplat 1.0), as measured on a machine of this kind with the
# same meshes: build and size of the dragon x16; its software renderer on one core, the dragon in a fitted view.
QSPLAT = {
    "build_x16_cpu_s": 11.2, "build_rss_per_vertex": 116, "bytes_per_vertex": 6.65,
    "bytes_per_vertex_colour": 9.5, "leaf_inflation_mean": 1.23, "leaf_inflation_max": 60,
    "frame_leaves_ms": 26, "frame_leaves_psnr": 21.8, "frame_x16_ms": 142, "frame_x16_psnr": 24.9,
    "growth_squares": 0.061,
}


def measure_bandwidth(bench):
    lines = read(bench.program("bandwidth"), 16 if bench.quick else 256).splitlines()
    rows = [json.loads(line) for line in lines]
    bench.bandwidth = max(row["median_bytes_per_s"] for row in rows if row["what"] == "read")
    bench.tables.write("bandwidth", "yardstick: memory bandwidth", rows)


def compare_with_qsplat(bench):
    if bench.name != "dragon":
        return
    built, leaves = bench.built, row_of(bench, bench.name, "smooth", 0)
    at_35 = bench.at_psnr[35] or {}
    squares = row_of(bench, bench.name, "square", 0)
    figures = [("build x16, processor time", "s", "build_x16_cpu_s", built[bench.x16]["cpu_s"]),
               ("build x16, memory", "B/vertex", "build_rss_per_vertex", built[bench.x16]["rss_per_vertex"]),
               ("file, no colour", "B/vertex", "bytes_per_vertex", built[bench.name]["bytes_per_vertex"]),
               ("file, colour", "B/vertex", "bytes_per_vertex_colour", built[bench.painted]["bytes_per_vertex"]),
               ("leaf inflation, mean", "1", "leaf_inflation_mean", built[bench.name]["leaf_inflation_mean"]),
               ("leaf inflation, worst", "1", "leaf_inflation_max", built[bench.name]["leaf_inflation_max"]),
               ("frame, leaves (one core; ours all)", "ms", "frame_leaves_ms", leaves["median_ms"]),
               ("its PSNR", "dB", "frame_leaves_psnr", leaves["psnr_db"]),
               ("frame, x16 (one core; ours all)", "ms", "frame_x16_ms", at_35.get("median_ms")),
               ("its PSNR", "dB", "frame_x16_psnr", at_35.get("psnr_db")),
               ("silhouette growth, squares", "1", "growth_squares", squares["growth"])]
    bench.tables.write("yardsticks", "the original QSplat, measured on a machine of this kind", [
        {"what": what, "unit": unit, "original": QSPLAT[key], "here": here,
         "original_by_here": QSPLAT[key] / here if here and unit != "dB" else None} for what, unit, key, here in figures])
