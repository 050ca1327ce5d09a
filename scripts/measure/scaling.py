"""Cost against the size of the model at constant quality, and against the number of threads."""
import contextlib
import heapq
import math
import statistics

from .frames import ROUNDS
from .programs import log, run


def measure_size(bench):
    """The same surface in 1, 4, 16 and 64 times as many vertices, each drawn as coarsely as PSNR allows."""
    quality_db = leaves_psnr(bench) - 0.5
    sizes = [bench.name, bench.x4, bench.x16] + ([] if bench.quick else [make_x64(bench)])
    rows = []
    with contextlib.ExitStack() as stack:
        frames = {name: stack.enter_context(bench.frames_of(name)) for name in sizes}
        thresholds = {}
        for name in sizes:
            log(f"threshold of {name} for {quality_db:.1f} dB")
            threshold = frames[name].threshold_for(bench.fit(name), quality_db)
            if threshold is not None:
                thresholds[name] = threshold
        # In rounds, so that what else the machine does meanwhile is shared by all sizes.
        runs = max(1, bench.runs // ROUNDS)
        rounds = [{name: frames[name].ask(bench.fit(name), threshold, runs=runs, compare=True)
                   for name, threshold in thresholds.items()} for _ in range(ROUNDS)]
        for name, threshold in thresholds.items():
            answers = [answer[name] for answer in rounds]
            a = answers[0]
            rows.append({"name": name, "vertices": bench.vertices[name], "file_bytes": bench.model(name).stat().st_size,
                         "threshold_px": threshold, "psnr_db": a["psnr_db"], "runs": runs * ROUNDS,
                         "median_ms": statistics.median(answer["ms"]["median"] for answer in answers),
                         "min_ms": min(answer["ms"]["min"] for answer in answers), "splats": a["splats"],
                         "nodes_visited": a["nodes_visited"], "touched_bytes": a["touched_bytes"]})
    for key in ("median_ms", "touched_bytes"):
        exponent = exponent_of([(row["vertices"], row[key]) for row in rows])
        for row in rows:
            row[f"exponent_{key}"] = exponent
    bench.tables.write("size", f"cost against size of the model, fit, smooth, {quality_db:.1f} dB", rows)


def leaves_psnr(bench):
    return next(row["psnr_db"] for row in bench.frames
                if (row["name"], row["kind"], row["threshold_px"]) == (bench.name, "smooth", 0))


def make_x64(bench):
    name = f"{bench.name}-x64"
    mesh = bench.out / f"{name}.ply"
    if not mesh.exists() or mesh.stat().st_mtime < bench.meshes[bench.x16].stat().st_mtime:
        log(f"making {name}")
        run(bench.program("subdivide"), bench.mesh, 3, mesh)
    log(f"building {name}")
    run(bench.program("qs-build"), mesh, "-o", bench.model(name), "--no-colour", "--quiet")
    bench.add_mesh(name, mesh)
    return name


def exponent_of(points):
    """Of the power law that fits the points best: the slope of the line through their logarithms."""
    if len(points) < 2:
        return None
    logs = [(math.log(x), math.log(y)) for x, y in points]
    mean_x, mean_y = (sum(values) / len(logs) for values in zip(*logs))
    return sum((x - mean_x) * (y - mean_y) for x, y in logs) / sum((x - mean_x) ** 2 for x, _ in logs)


def measure_threads(bench):
    """Frames on 1 and 2 threads as measured; on more as a model says that knows each task's and each tile's time."""
    rows = []
    for name, threshold in ((bench.name, 0), (bench.x16, (bench.at_psnr[35] or {}).get("threshold_px", 1))):
        log(f"threads for {name}")
        camera = bench.fit(name)
        measured = {}
        for threads in (1, 2):
            with bench.frames_of(name, threads) as frames:
                measured[threads] = frames.ask(camera, threshold, runs=bench.runs)
                if threads == 1:
                    parts = frames.ask(camera, threshold, parts=True)["parts"]
        one = measured[1]["ms"]["median"]
        # The parts were timed with a clock in every task: their sum is brought to that of the frames without.
        scale = one / (parts["begin_ms"] + sum(parts["tasks_ms"]) + parts["finish_ms"])
        tiles = [count * parts["finish_ms"] / max(1, sum(parts["tile_splats"])) for count in parts["tile_splats"]]
        for threads in (1, 2, 4, 16, 64):
            serial = scale * parts["begin_ms"]
            cut, draw = (scale * makespan(times, threads) for times in (parts["tasks_ms"], tiles))
            known = measured.get(threads)
            modelled = serial + cut + draw
            ideal = scale * (parts["begin_ms"] + (sum(parts["tasks_ms"]) + sum(tiles)) / threads)
            # What is read and written at least: nodes, splats twice, pixels.
            floor = 1000 * (measured[1]["visited_bytes"] + 64 * measured[1]["splats"] + 16 * bench.size[0] * bench.size[1]) / bench.bandwidth
            rows.append({"name": name, "threads": threads, "measured_ms": known and known["ms"]["median"],
                         "modelled_ms": modelled, "speed_up": one / (known["ms"]["median"] if known else modelled),
                         "serial_ms": serial, "tasks_ms": cut, "tiles_ms": draw, "imbalance_ms": modelled - ideal,
                         "bandwidth_floor_ms": floor,
                         "limit": limit_of(serial, modelled - ideal, floor, modelled)})
    bench.tables.write("threads", "frames by threads: 1 and 2 measured, more by a model of its tasks and tiles", rows)


def makespan(times, threads):
    """When the last of some tasks ends, each taken in turn by the thread that is free first."""
    free = [0.0] * threads
    for time in times:
        heapq.heappush(free, heapq.heappop(free) + time)
    return max(free)


def limit_of(serial, imbalance, floor, all_ms):
    parts = {"work": all_ms - serial - imbalance, "serial part": serial, "imbalance": imbalance}
    return "memory bandwidth" if floor > all_ms else max(parts, key=parts.get)
