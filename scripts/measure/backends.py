"""The back ends that this machine has, beside the CPU's."""
import json
import re

from .programs import log, read


def found(bench):
    """Those of OpenGL that start here, one of each renderer."""
    lines = read(bench.program("qs-render"), "--list-backends").splitlines()
    renderers = {}
    for line in lines:
        if match := re.match("(osmesa|egl) +(.*OpenGL.*)", line):
            renderers.setdefault(match[2], match[1])
    return list(renderers.values())


def measure(bench):
    if not bench.find_program("backend_bench"):
        return log("back ends of OpenGL are left out: the build has none")
    log("back ends")
    size = ["--width", bench.size[0], "--height", bench.size[1]]
    lines = read(bench.program("backend_bench"), bench.model(bench.name), "--mesh", bench.mesh, *size,
                 "--runs", 2 if bench.quick else 11).splitlines()
    rows = [{"backend": a["backend"], "renderer": a.get("renderer"), "draws": a.get("kind", "the mesh itself"),
             "median_ms": a["ms"]["median"], "min_ms": a["ms"]["min"],
             "psnr_db_against_cpu": a["against_cpu"].get("psnr_db")} for a in map(json.loads, lines)]
    bench.tables.write("backends", "back ends at 1 px of error, and the mesh by its triangles", rows)
    exact = [row["psnr_db_against_cpu"] for row in rows if row["draws"] == "the mesh itself" and row["backend"] == "osmesa"]
    if exact:
        bench.goals.add("two exact renderers against each other", "dB", 55, None, exact[0], True)
