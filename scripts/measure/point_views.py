"""The client of remote point sampling: traffic and what elimination leaves, error against time in motion, drawing.

Traffic is of an update at each camera of a path; motion is on a clock of its own, an answer being there one period after
its request, so that neither depends on the machine.  Server 1280x800, client 2560x1600.
"""
import json

from . import sampling
from .programs import log, read, run

NEAR = 0.22  # of the distance of an orbit: there a scene fills the picture


def measure(bench):
    name = bench.name
    size, screen = ("160,100", "320,200") if bench.quick else ("1280,800", "2560,1600")
    paths = {path: path_of(bench, name, path, 6 if bench.quick else 24) for path in ("orbit", "dolly", "walk")}

    def ask(path, **options):
        words = [word for key, value in options.items() for word in ([f"--{key}"] if value is True else [f"--{key}", value])]
        return json.loads(read(bench.program("point_view_bench"), bench.meshes[name], "--path", path, "--size", size, *words))

    log("traffic of remote points")
    traffic = [dict(name=name, path=path, rule=rule, **ask(cameras, what="traffic", eliminate=rule))
               for path, cameras in paths.items() for rule in ("filtered", "paper")]
    bench.tables.write("point-traffic", "remote points: bytes against whole frames, and what elimination leaves", traffic)

    motion, curves = [], []
    slow = {path: path_of(bench, name, path, frames) for path, frames in (("orbit", 480), ("walk", 1920))}  # 18 degrees a second
    for path, cameras in slow.items():
        for rate in (4,) if bench.quick else (1, 4, 8):
            # Ours, the larger splats of the paper instead of gaps closed, and requests for where the eye is.
            for scale, predicted, options in ((1, True, {}), (1.5, True, {"gaps": True}), (1, False, {"no-prediction": True})):
                log(f"remote points, {path}, {rate} updates a second, scale {scale}")
                row = ask(cameras, what="motion", rate=rate, scale=scale, screen=screen,
                          **({"seconds": 1} if bench.quick else {}), **options)
                curves += [dict(path=path, rate=rate, scale=scale, predicted=predicted, **point) for point in row.pop("curve")]
                motion.append(dict(name=name, path=path, scale=scale, **row))
    bench.tables.write("point-views", "remote points in motion: error, and then at rest", motion)
    bench.tables.write("point-curves", "remote points in motion: error against time", curves)

    drawn = measure_drawing(bench, size, screen)
    splatter = ask(paths["walk"], what="splatter", screen=screen, runs=3 if bench.quick else 9)
    bench.tables.write("point-drawing", "remote points: stereo pictures, and beside the splatter of models (one picture, all points)",
                       [{"what": what, "points": points, **times, "cpu": cpu} for what, points, times, cpu in
                        [(f"stereo, {drawn['updates']} updates arriving", drawn["points_an_eye"], drawn["stereo_ms"], drawn["cpu_ms"])] +
                        [(kind, splatter["points"], splatter[kind], None) for kind in ("words", "square", "ellipse")]])
    log("a long session of remote points")
    session = json.loads(read(bench.program("point_view_bench"), bench.meshes[name], "--path", paths["walk"], "--what", "session",
                              "--size", "96,60", "--points", 30000, "--updates", 100 if bench.quick else 10000))
    bench.tables.write("point-session", "remote points: what both sides keep of a long session, beside their limits", [session])
    add_session_goals(bench, session)
    if not bench.quick:
        add_goals(bench, traffic, motion, drawn)


def measure_drawing(bench, size, screen):
    """Of the terrain, where it is there: from near it has as many points in view as the budget takes."""
    scenes = sampling.find_scenes(bench)
    scene = next(iter(scenes))
    mesh, up = scenes[scene]
    orbit, near = bench.out / "points-near-orbit.jsonl", bench.out / "points-near.jsonl"
    run(bench.program("qs-path"), "orbit", mesh, "--frames", 96, "--fovy", 40, "--up", up, "-o", orbit)
    with open(near, "w") as out:
        for line in list(open(orbit))[:6 if bench.quick else 24]:
            camera = json.loads(line)
            camera["eye"] = [t + NEAR * (e - t) for e, t in zip(camera["eye"], camera["target"])]
            print(json.dumps(camera), file=out)
    log(f"drawing points of {scene} while updates arrive")
    return json.loads(read(bench.program("point_view_bench"), mesh, "--path", near, "--what", "draw", "--size", size, "--screen", screen))


def path_of(bench, name, path, frames):
    file = bench.out / f"points-{path}-{frames}.jsonl"
    run(bench.program("qs-path"), path, bench.meshes[name], "--frames", frames, "--fovy", 40, "-o", file)
    return file


def add_goals(bench, traffic, motion, drawn):
    ours = [row for row in traffic if row["rule"] == "filtered"]
    for key, must, what in (("bytes_by_whole", 0.40, "bytes by whole frames"), ("duplicates", 0.01, "duplicates"),
                            ("lost_share", 0.001, "detail lost by elimination"), ("coarse", 0.12, "coarse leftovers")):
        bench.goals.add(f"remote points, {what}, worst path", "1", must, None, max(row[key] for row in ours))
    held = [row for row in motion if (row["rate"], row["scale"], row["predicted"]) == (4, 1, True)]
    bench.goals.add("remote points, 4 updates/s, mean PSNR, worst path", "dB", 33, None, min(row["psnr_db"] for row in held), True)
    bench.goals.add("remote points, 4 updates/s, empty pixels, worst path", "1", 0.005, None, max(row["empty"] for row in held))
    bench.goals.add("remote points, 4 updates/s, empty pixels, worst frame", "1", 0.02, None, max(row["empty_most"] for row in held))
    bench.goals.add("remote points, at rest, PSNR", "dB", 40, None, min(row["rest_psnr_db"] for row in held), True)
    bench.goals.add("remote points, at rest, holes", "px", 0, None, sum(row["rest_holes"] for row in held))
    bench.goals.add(f"remote points, stereo 2560x1600, {drawn['points_an_eye'] / 1e6:.2g} M points an eye, updates arriving", "1/s",
                    15, None, 1000 / drawn["stereo_ms"]["median"], True, 1000 / drawn["stereo_ms"]["min"])
    bench.goals.add("remote points, frame time while updates arrive, 95th percentile by median", "1", 1.3, None,
                    drawn["stereo_ms"]["p95"] / drawn["stereo_ms"]["median"])


def add_session_goals(bench, session):
    for side, kept in (("server", "points"), ("server", "bytes"), ("client", "bytes")):
        bench.goals.add(f"remote points, {session['updates']} updates, {side}'s {kept} by its limit", "1", 1, None,
                        session[f"{side}_{kept}_most"] / session[f"{side}_{kept}_limit"])
    bench.goals.add(f"remote points, {session['updates']} updates, octrees out of step", "1", 0, None, session["out_of_step"])
