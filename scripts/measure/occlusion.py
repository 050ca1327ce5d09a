"""What leaving out what surfaces hide saves, by the real renderer on real paths."""
import json

from .programs import log, run


def measure(bench):
    rows = []
    # The head lies on its back where y is up, as qs-path takes it; and it sits.
    for name, ups in [(bench.name, "y")] + [(n, "yz") for n in bench.meshes if n == "ct-head"]:
        log(f"occlusion in {name}")
        for up in ups:
            for path in ("orbit", "dolly", "walk"):
                rows.append(row_of(bench, name, path, up))
    bench.tables.write("occlusion", "occlusion: splats left out and time, whole paths at 1 px", rows)
    saved = [row["saved_by_auto"] for row in rows if row["name"] == "ct-head"]
    if saved:
        bench.goals.add("splats that occlusion saves on the CT head, worst path", "1", 0.3, None, min(saved), True)


def row_of(bench, name, path, up):
    cameras = bench.out / "occlusion.jsonl"
    run(bench.program("qs-path"), path, bench.model(name), "--frames", 4 if bench.quick else 12, "--up", up, "-o", cameras)
    splats, best_ms = {}, {}
    for _ in range(1 if bench.quick else 4):  # in turn, so that a machine that slows down does so for all
        for mode in ("off", "auto", "on"):
            splats[mode], ms = drawn(bench, name, cameras, mode)
            best_ms[mode] = min(ms, best_ms.get(mode, ms))
    return {"name": name, "path": path, "up": up, "splats": splats["off"], "splats_saved": 1 - splats["on"] / splats["off"],
            "saved_by_auto": 1 - splats["auto"] / splats["off"], "ms_off": best_ms["off"],
            "time_by_off": best_ms["on"] / best_ms["off"], "auto_time_by_off": best_ms["auto"] / best_ms["off"]}


def drawn(bench, name, cameras, mode):
    """The splats and the milliseconds of all frames."""
    report = bench.out / "occlusion-frames.jsonl"
    width, height = bench.size
    run(bench.program("qs-render"), bench.model(name), "--path", cameras, "--resolution", f"{width},{height}", "--backend", "cpu",
        "--occlusion", mode, "--report", report, "--quiet")
    lines = [json.loads(line) for line in open(report)]
    return sum(line["splats"] for line in lines), sum(line["ms"]["traverse"] + line["ms"]["draw"] for line in lines)
