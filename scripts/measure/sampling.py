"""The server of remote point sampling: sampling, codecs, whole updates; 1280x800, a bound of 1/100 pixel."""
import json

from .bench import DATA
from .programs import log, read, run

COLUMNS = 2161  # of the refined terrain: 5 million triangles
VIEWS = ["orbit", "half", "close", "walk"]


def measure(bench):
    scenes = find_scenes(bench)
    lines = {name: measure_scene(bench, *scene) for name, scene in scenes.items()}
    bench.tables.write("sampling", "point sampling: the rasteriser, view by view",
                       [sampling_row(name, line) for name, of in lines.items() for line in of if line["view"] in VIEWS])
    codecs = [codec_row(name, line) for name, of in lines.items() for line in of if line["view"] in VIEWS]
    bench.tables.write("codecs", "point sampling: our codec beside the paper's LZW (of exact floats), on one thread", codecs)
    updates = {name: next(line for line in of if line["view"] == "updates") for name, of in lines.items()}
    bench.tables.write("updates", "point sampling: whole updates on a way, all but the first",
                       [update_row(name, line) for name, line in updates.items()])
    add_goals(bench, lines, codecs, updates)


def find_scenes(bench):
    """Path, up axis.  Those of the paper's sizes, where ../shared/data has what they are made of; else the benchmark's mesh."""
    if bench.quick or not (DATA / "dem-bigtujunga.pgm").exists():
        return {bench.name: (bench.mesh, "y")}
    terrain, lucy = bench.out / "terrain.ply", bench.out / "lucy-x4.ply"
    if not terrain.exists():
        log("refining the terrain")
        run(bench.program("terrain"), DATA / "dem-bigtujunga.pgm", COLUMNS, terrain)
    if not lucy.exists():
        run(bench.program("subdivide"), DATA / "lucy-100k.ply", 1, lucy)
    return {"terrain 5.0 M": (terrain, "z"), "lucy 0.4 M": (lucy, "y"), "CT head 1.1 M": (DATA / "ct-cranium-skin-bone.ply", "y")}


def measure_scene(bench, path, up):
    log(f"sampling {path}")
    return [json.loads(line) for line in
            read(bench.program("ppve_bench"), path, "--up", up, "--runs", 3 if bench.quick else 11).splitlines()]


def sampling_row(name, line):
    return {"scene": name, "view": line["view"], "pixels": line["pixels"], "triangles_tested": line["triangles_tested"],
            "triangles_drawn": line["triangles_drawn"], "clusters_touched": line["clusters_touched"],
            "clusters_hidden": line["clusters_hidden"], "clusters": line["clusters"],
            "touched_share": line["bytes_touched"] / line["bytes"], "bound_px": line["bound_px"],
            "median_ms": line["sample_ms"]["median"], "min_ms": line["sample_ms"]["min"],
            "one_thread_cpu_ms": line["sample_1_ms"]["cpu_min"], "per_s": 1000 / line["sample_ms"]["median"]}


def codec_row(name, line):
    def faster(of, ours):  # by processor time, which other work on the machine leaves alone
        return line[of]["cpu_min"] / line[ours]["cpu_min"]
    return {"scene": name, "view": line["view"], "lzw_bytes": line["lzw_bytes"], "planes_bytes": line["planes_bytes"],
            "bytes_by_lzw": line["planes_bytes"] / line["lzw_bytes"], "exact_by_lzw": line["exact_bytes"] / line["lzw_bytes"],
            "lzw_encode_ms": line["lzw_encode_ms"]["cpu_min"], "encode_ms": line["encode_1_ms"]["cpu_min"],
            "encode_by_lzw": faster("lzw_encode_ms", "encode_1_ms"), "lzw_decode_ms": line["lzw_decode_ms"]["cpu_min"],
            "decode_ms": line["decode_1_ms"]["cpu_min"], "decode_by_lzw": faster("lzw_decode_ms", "decode_1_ms"),
            "encode_by_lzw_all_threads": line["lzw_encode_ms"]["min"] / line["encode_ms"]["min"]}


def update_row(name, line):
    return {"scene": name, "updates": line["updates"], "kept_share": line["kept_share"], "bytes_an_update": line["bytes_an_update"],
            "points": line["points"], **{f"{stage}_ms": line[f"{stage}_ms"]["median"] for stage in
                                         ("sample", "eliminate", "encode", "insert", "update")},
            "update_cpu_ms": line["update_ms"]["cpu_min"], "per_s": 1000 / line["update_ms"]["median"]}


def add_goals(bench, lines, codecs, updates):
    goals = {"terrain 5.0 M": (15, None), "lucy 0.4 M": (30, None), "CT head 1.1 M": (12, 20)}
    for name, (must, stretch) in goals.items():
        for measured in [lines[name]] if name in lines else []:
            slowest, best = (max(line["sample_ms"][kind] for line in measured if line["view"] in VIEWS) for kind in ("median", "min"))
            bench.goals.add(f"point sampling, {name}, slowest view", "1/s", must, stretch, 1000 / slowest, True, 1000 / best)
    goals = {"terrain 5.0 M": (8, 12), "lucy 0.4 M": (30, None), "CT head 1.1 M": (12, 20)}
    for name, (must, stretch) in goals.items():
        if name in updates:
            times = updates[name]["update_ms"]
            bench.goals.add(f"point sampling, {name}, whole updates", "1/s", must, stretch, 1000 / times["median"], True,
                            1000 / times["min"])
    if bench.quick:
        return  # small pictures of a small mesh: its bytes are another matter
    bench.goals.add("depth images, bytes by LZW's, bound 1/100 px, worst", "1", 0.42, None, max(row["bytes_by_lzw"] for row in codecs))
    bench.goals.add("depth images, exact, bytes by LZW's, worst", "1", 0.55, None, max(row["exact_by_lzw"] for row in codecs))
    bench.goals.add("depth images, encoding by LZW's speed, one thread, worst", "1", 5, None, min(row["encode_by_lzw"] for row in codecs), True)
    bench.goals.add("depth images, encoding by LZW's speed, all threads, worst", "1", 10, None,
                    min(row["encode_by_lzw_all_threads"] for row in codecs), True)
    bench.goals.add("depth images, decoding by LZW's speed, one thread, worst", "1", 2, None, min(row["decode_by_lzw"] for row in codecs), True)
