"""Point sampling, server and client, and nothing else."""
from . import point_views, sampling

PROGRAMS = ["ppve_bench", "point_view_bench", "terrain", "subdivide", "qs-path"]


def lacks(bench):
    missing = [name for name in PROGRAMS if not bench.find_program(name)]
    return f"the programs {', '.join(missing)}" if missing else ""


def measure(bench):
    sampling.measure(bench)
    point_views.measure(bench)
