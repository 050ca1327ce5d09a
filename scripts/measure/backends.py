"""The back ends that this machine has, beside the CPU's."""
import json

from .programs import log, read


def measure(bench):
    log("back ends")
    lines = read(bench.program("backend_bench"), bench.model(bench.name), "--runs", 3 if bench.quick else 11).splitlines()
    rows = [json.loads(line) for line in lines]
    if rows:
        bench.tables.write("backends", "back ends, leaves", rows)
