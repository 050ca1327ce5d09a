"""Progressive meshes: the experiments of Kim, Lee and Kobbelt (View-dependent mesh streaming with minimal latency, 2005) with
the paper's figures beside ours, and error against bytes beside the other kinds of models on the same paths."""
import contextlib
import json
import os
import shutil
import subprocess

from . import links
from .programs import log, read, run

PROGRAMS = ["pm-build", "pm-serve", "pm-fetch", "pm_bench", "pm_clients", "pm_fronts", "qs-path", "qs-render", "qs-info"]
SERVICES = {"views": [], "one way": ["--one-way"], "lists": ["--lists"]}
SHARES = {"1/200": 1 / 200, "1/1000": 1 / 1000}  # of the picture's height
PATHS = ["orbit", "dolly", "walk"]
PAPER_PACKET_BYTES = 80
HALF_MEGABYTE = 500_000
VIEWS_A_SECOND = 10
STARTING_S = 2


def lacks(bench):
    missing = [name for name in PROGRAMS if not bench.find_program(name)]
    return f"the programs {', '.join(missing)}" if missing else ""


def measure(bench):
    if lacks(bench):
        log(f"progressive meshes are left out: they need {lacks(bench)}")
        return
    folder = bench.out / "progressive"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    Progressive(bench, folder).measure()


class Progressive:
    def __init__(self, bench, folder):
        self.bench, self.folder = bench, folder
        self.model = bench.out / f"{bench.name}.pm"
        self.goal = bench.goals.add
        self.frames = 8 if bench.quick else 32
        self.paths = {}

    def measure(self):
        self.build()
        self.make_cameras()
        self.measure_tolerances()
        self.measure_services()
        self.measure_session()
        self.measure_memory()
        self.measure_fixed_tolerance()
        self.measure_fixed_bytes()
        self.measure_clients()
        self.measure_paths()

    # ---- model and cameras ----

    def build(self):
        log(f"building {self.model.name}")
        cost = run(self.bench.program("pm-build"), self.bench.mesh, "-o", self.model, "--quiet")
        report = self.folder / "build.json"
        run(self.bench.program("pm-build"), self.bench.mesh, "-o", self.folder / "again.pm", "--threads", 1, "--quiet",
            "--report", report)
        alone = json.loads(report.read_text())
        collapses_a_s = 1000 * alone["details"] / alone["ms"]["collapse"]
        self.info = json.loads(read(self.bench.program("qs-info"), "--json", self.model))
        self.bench.tables.write("pm-build", "building a progressive mesh", [
            {"name": self.bench.name, "wall_s": cost.wall_s, "cpu_s": cost.cpu_s, "rss_bytes": cost.rss_bytes,
             "file_bytes": self.model.stat().st_size, "collapses_a_s_one_thread": collapses_a_s,
             "support_s_one_thread": alone["ms"]["support"] / 1000}])
        self.goal("progressive mesh, build", "s", 5, 3, cost.wall_s)
        self.goal("progressive mesh, memory of the build", "B", 200e6, None, cost.rss_bytes)
        self.goal("progressive mesh, collapses on one thread", "1/s", 200e3, 350e3, collapses_a_s, True)

    def make_cameras(self):
        """All of the model in the frame from 2.6 radii, and 0.3 radii above a place on it; 45 degrees, 16:9."""
        splats = json.loads(read(self.bench.program("qs-info"), "--json", self.bench.model(self.bench.name)))
        centre, radius = splats["origin"], splats["scale"]
        aim = [-0.39, 0.42, 0.2] if self.bench.name == "dragon" else [0, 0, 0.9]
        place = [c + radius * a for c, a in zip(centre, aim)]
        self.cameras = {
            "fit": {"eye": [centre[0], centre[1], centre[2] + 2.6 * radius], "target": centre, "fovy": 45},
            "close": {"eye": [place[0], place[1], place[2] + 0.3 * radius], "target": place, "fovy": 45}}
        for name, camera in self.cameras.items():
            self.paths[name] = self.folder / f"{name}.jsonl"
            self.paths[name].write_text(json.dumps(camera) + "\n")
        for name in PATHS:
            self.paths[name] = self.folder / f"{name}.jsonl"
            run(self.bench.program("qs-path"), name, self.bench.model(self.bench.name), "--frames",
                self.frames if name == "walk" else max(4, self.frames // 4), "-o", self.paths[name])

    def size_words(self):
        return "{},{}".format(*self.bench.size)

    def pixels(self, share):
        return share * self.bench.size[1]

    # ---- servers ----

    @contextlib.contextmanager
    def server(self):
        """Gives its process and the place of the model."""
        socket, ready = self.folder / "socket", self.folder / "ready"
        with open(ready, "w") as out:
            process = subprocess.Popen([self.bench.program("pm-serve"), self.model, "--listen", socket, "--quiet"], stdout=out)
        with links.ended(process):
            links.wait_for(lambda: ready.stat().st_size > 0, "pm-serve")
            yield process, f"pm://{socket}/{self.bench.name}"

    def fetch(self, place, *words):
        report = self.folder / "frames.jsonl"
        run(self.bench.program("pm-fetch"), place, "--resolution", self.size_words(), "--quiet", "--report", report, *words)
        return [json.loads(line) for line in report.read_text().splitlines()]

    def count(self, what, *words):
        return [json.loads(line) for line in read(self.bench.program("pm_bench"), what, self.model, *words).splitlines()]

    # ---- how wrong ----

    def measure_tolerances(self):
        lines = [json.loads(line) for line in read(self.bench.program("pm_fronts"), self.model, "1").splitlines()]
        views = [line for line in lines if "rms" in line]
        self.bench.tables.write("pm-tolerance", "error of the meshes that views get, by their tolerance", views,
                                ["view", "tolerance", "splits", "faces", "rms", "p999", "max", "within_1_1"])
        self.goal("progressive mesh, share of the surface within 1.1 tolerances, worst view", "1", 0.999, None,
                  min(view["within_1_1"] for view in views), True)
        self.goal("progressive mesh, faces folded over at a random half", "1", 0.05, None, lines[-1]["folded"])
        self.measure_folds(lines[-1])

    def measure_folds(self, with_test):
        """Faces turned by more than 90 degrees from the input's where half of all splits, at random, are done."""
        model = self.folder / "unchecked.pm"
        run(self.bench.program("pm-build"), self.bench.mesh, "-o", model, "--no-flip-test", "--quiet")
        without = json.loads(read(self.bench.program("pm_fronts"), model, "1").splitlines()[-1])
        self.bench.tables.write("pm-folds", "faces folded over at a random front of half the splits, by the flip test of pm-build", [
            {"flip_test": word, "splits": line["splits"], "moved_faces": line["moved_faces"], "folded": line["folded"]}
            for word, line in (("on", with_test), ("off", without))])

    # ---- the paper's section 6.3 ----

    def measure_services(self):
        """Views as the paper has them, and its two variations; the server's time by many clients one after the other."""
        rows = []
        clients = 2 if self.bench.quick else 10
        for service, words in SERVICES.items():
            for view, share, *more in [(v, s, "--path", self.paths[v], "--threshold", self.pixels(SHARES[s]))
                                       for v in ("fit", "close") for s in SHARES] + [("whole model", "0", "--all")]:
                with self.server() as (process, place):
                    before = cpu_s(process.pid)
                    runs = 1 if view == "whole model" else clients
                    for _ in range(runs):
                        frame = self.fetch(place, *more, *words)[0]
                    spent = cpu_s(process.pid) - before
                base = self.opened_bytes(words)
                splits = frame["splits_received"]
                rows.append({"service": service, "view": f"{view} {share}", "splits": splits,
                             "bytes_down": frame["bytes_down"], "bytes_up": frame["bytes_up"], "requests": frame["requests"],
                             "bytes_a_split": (frame["bytes_down"] - base) / splits,
                             "server_us_a_split": 1e6 * spent / runs / splits})
        self.bench.tables.write("pm-services", "what a view costs by views, one way and by lists; bytes a split without the "
                                "base mesh", rows)
        of = {(row["service"], row["view"]): row for row in rows}
        for view in ("fit 1/1000", "close 1/1000", "whole model 0"):
            self.goal(f"progressive mesh, bytes a split, {view}", "B", 9, 6.5, of["views", view]["bytes_a_split"])
        self.goal("progressive mesh, whole model", "B", 3.0e6, 1.7e6, of["views", "whole model 0"]["bytes_down"])
        self.goal("progressive mesh, splits, fit 1/1000", "count", 12500, 11000, of["views", "fit 1/1000"]["splits"])
        for view, must, stretch in (("fit 1/1000", 115e3, 65e3), ("close 1/1000", 155e3, 90e3), ("fit 1/200", 60e3, 40e3)):
            self.goal(f"progressive mesh, bytes with the base mesh, {view}", "B", must, stretch, of["views", view]["bytes_down"])

    def opened_bytes(self, words):
        """What is received before the first split."""
        if not hasattr(self, "bases"):
            self.bases = {}
        key = tuple(words)
        if key not in self.bases:
            with self.server() as (_, place):
                # So coarse that nothing is wanted.
                frame = self.fetch(place, "--path", self.paths["fit"], "--threshold", 1e6, *words)[0]
            self.bases[key] = frame["bytes_down"]
        return self.bases[key]

    # ---- figures 7 and 8 ----

    def measure_session(self):
        drawn = self.folder / "drawn.jsonl"
        run(self.bench.program("qs-render"), self.model, "--path", self.paths["walk"], "--resolution", self.size_words(),
            "--quiet", "--report", drawn)
        drawing = [json.loads(line)["ms"]["draw"] for line in drawn.read_text().splitlines()]
        with self.server() as (_, place):
            frames = self.fetch(place, "--path", self.paths["walk"], "--threshold", 1)
        rows, up, down = [], 0, 0
        for frame, draw_ms in zip(frames, drawing):
            up, down = up + frame["bytes_up"], down + frame["bytes_down"]
            rows.append({"frame": frame["frame"], "bytes_up": up, "bytes_down": down, "splits_received": frame["splits_received"],
                         "faces": frame["faces"], "refine_ms": frame["refine_ms"], "draw_ms": draw_ms,
                         "done_ms": frame["done_ms"]})
        self.bench.tables.write("pm-session", "figures 7 and 8: a walk through the model, twice; bytes add up", rows)
        second = rows[len(rows) // 2 - 1]
        more = rows[-1]["bytes_down"] - second["bytes_down"] + rows[-1]["bytes_up"] - second["bytes_up"]
        self.goal("progressive mesh, second round of walk, bytes both ways (paper's figure 7: 0)", "B", 0, None, more)

    # ---- figure 6 ----

    def measure_memory(self):
        """From the middle of the path on the client asks for twice the quality, as in the paper."""
        rows = self.count("session", self.paths["walk"], self.size_words(), "2", "1")
        self.bench.tables.write("pm-memory", "figure 6: what a server keeps of a client: sent bits, the paper's window of active "
                                "tags, its list of a front (12 bytes a node and a bit each)", rows)
        last = rows[-1]
        self.bench.tables.write("pm-memory-summary", "figure 6 in one line; the paper says that the window takes less than 10 % "
                                "of the front", [
            {"who": "paper, Buddha", "by_front": "window below 0.1"},
            {"who": f"window, {self.bench.name}", "by_front": f"{last['window_allocated_bytes'] / last['front_bytes']:.3f}"},
            {"who": f"sent bits, {self.bench.name}", "by_front": f"{last['sent_bits_bytes'] / last['front_bytes']:.3f}"}])
        self.goal("progressive mesh, server's record of a client", "B", 100e3, 60e3, last["session_bytes"])

    # ---- figure 9 ----

    def measure_fixed_tolerance(self):
        rows = [
            {"model": "bunny, in the paper", "view": "", "by": "views, 80 bytes", "bytes": 177120, "splits": 2214, "faces": 4534},
            {"model": "bunny, in the paper", "view": "", "by": "by levels, 24 bytes", "bytes": 827688, "splits": 34487,
             "faces": 68884},
            {"model": "dragon, in the paper", "view": "", "by": "views, 80 bytes", "bytes": 946400, "splits": 11830,
             "faces": 23672},
            {"model": "dragon, in the paper", "view": "", "by": "by levels, 24 bytes", "bytes": 3816384, "splits": 159016,
             "faces": 318048}]
        thresholds = [self.pixels(share) for share in SHARES.values()]
        for view in ("fit", "close"):
            for line in self.count("bytes", self.paths[view], self.size_words(), *thresholds):
                share = list(SHARES)[thresholds.index(line["threshold_px"])]
                rows.append({"model": self.bench.name, "view": f"{view} {share}", "by": line["by"], "bytes": line["bytes"],
                             "splits": line["splits"], "faces": line["faces"]})
        self.bench.tables.write("pm-fixed-tolerance", "figure 9: bytes until a view is satisfied, with the base mesh; by levels "
                                "and sorted by error is all of the model to that detail", rows)

    # ---- figure 10 ----

    def measure_fixed_bytes(self):
        """The paper's half megabyte, and what buys as many of our splits as it bought of the paper's."""
        view_bytes = self.bases[()]
        with self.server() as (_, place):
            fit = self.fetch(place, "--path", self.paths["fit"], "--threshold", self.pixels(1 / 1000))[0]
        a_split = (fit["bytes_down"] - view_bytes) / fit["splits_received"]
        as_many = int(view_bytes + a_split * HALF_MEGABYTE / PAPER_PACKET_BYTES)
        rows = []
        for budget in (as_many, HALF_MEGABYTE):
            for view in ("fit", "close"):
                for line in self.count("budget", self.paths[view], self.size_words(), budget, self.folder):
                    rows.append({"budget_bytes": budget, "view": view, "by": line["file"].removesuffix(".ply"),
                                 "bytes": line["bytes"], "splits": line["splits"], "faces": line["faces"],
                                 "psnr_db": self.psnr_of(self.folder / line["file"], self.paths[view])})
        self.bench.tables.write("pm-fixed-bytes", "figure 10: pictures after so many bytes, against the mesh; by-levels-24 is the "
                                "paper's stream that does not depend on the view, 24 bytes a split", rows)

    def psnr_of(self, mesh, path):
        model, report = self.folder / "part.pm", self.folder / "part.jsonl"
        run(self.bench.program("pm-build"), mesh, "-o", model, "--lossless", "--quiet")
        run(self.bench.program("qs-render"), model, "--path", path, "--resolution", self.size_words(), "--threshold", 0,
            "--reference", self.bench.mesh, "--report", report, "--quiet")
        return json.loads(report.read_text().splitlines()[0])["psnr_db"]

    # ---- clients ----

    def measure_clients(self):
        """Clients that walk through the model in real time, ten views a second each, and clients that do nothing."""
        path, rows = self.folder / "steady.jsonl", []
        run(self.bench.program("qs-path"), "walk", self.bench.model(self.bench.name), "--frames", 16 if self.bench.quick else 200,
            "-o", path)
        for count in (4,) if self.bench.quick else (1, 20, 100):
            with self.server() as (process, place):
                before = rss_bytes(process.pid)
                address, _, name = place.removeprefix("pm://").rpartition("/")
                walk = json.loads(read(self.bench.program("pm_clients"), "walk", address, name, path, self.size_words(),
                                       1, count, VIEWS_A_SECOND))
                rows.append(dict(walk, server_cpu_s=cpu_s(process.pid), server_rss_before_bytes=before,
                                 server_rss_bytes=rss_bytes(process.pid), server_peak_bytes=peak_bytes(process.pid)))
        self.bench.tables.write("pm-clients", f"clients of one server, walk at {VIEWS_A_SECOND} views/s, beginning at the same time; "
                                "late: not answered when the next view comes", rows)
        # The first view brings much of the model, to all clients at once.
        steady = [row["clients"] for row in rows if row["last_late_s"] < STARTING_S]
        if not self.bench.quick:
            self.goal("progressive mesh, clients of one server without falling behind", "count", 20, 100, max(steady, default=0),
                      True)
        # All that the process takes more than before, answers that are being made and buffers included.
        last = rows[-1]
        self.goal(f"progressive mesh, server's memory of each of {last['clients']} clients that walk", "B", 100e3, 60e3,
                  (last["server_peak_bytes"] - last["server_rss_before_bytes"]) / last["clients"])
        self.measure_idle_clients(20 if self.bench.quick else 1000)

    def measure_idle_clients(self, count):
        with self.server() as (process, place):
            address, _, name = place.removeprefix("pm://").rpartition("/")
            before = rss_bytes(process.pid)
            with subprocess.Popen([self.bench.program("pm_clients"), "idle", address, name, str(count)], text=True,
                                  stdin=subprocess.PIPE, stdout=subprocess.PIPE) as clients:
                if clients.stdout.readline() != "ready\n":
                    raise SystemExit("bench: a client of pm-serve failed")
                after = rss_bytes(process.pid)
                clients.stdin.close()
        self.bench.tables.write("pm-idle-clients", "memory of a server by clients that have opened the model and do nothing", [
            {"clients": count, "rss_before_bytes": before, "rss_after_bytes": after, "bytes_a_client": (after - before) / count}])
        self.goal(f"progressive mesh, memory of {count} idle clients", "B", 100e6, None, after - before)

    # ---- the comparison that nobody has made ----

    def measure_paths(self):
        """Bytes until every frame of a path was complete, and how far pictures are from the mesh: points, points with triangles
        as leaves, and progressive meshes, by threshold."""
        if not self.has_web():
            log("error against bytes of splat models is left out: it needs nginx and programs built with HTTP")
        thresholds = [4] if self.bench.quick else [8, 4, 2, 1]
        rows = []
        for path in PATHS:
            for kind, source in self.sources():
                for threshold in thresholds:
                    rows.append(dict({"path": path, "kind": kind, "threshold_px": threshold},
                                     **self.along(source, path, threshold)))
        self.bench.tables.write("pm-paths", "error against bytes on the same paths: bytes until all frames were complete, PSNR and "
                                "error against the mesh", rows)

    def has_web(self):
        return links.nginx_program() and self.bench.find_program("qs-fetch")

    def sources(self):
        yield "progressive mesh", None
        if not self.has_web():
            return
        for kind, words in (("points", []), ("triangle leaves", ["--leaf", "triangle"])):
            model = self.folder / f"{kind.split()[0]}.qs"
            if not model.exists():
                run(self.bench.program("qs-build"), self.bench.mesh, "-o", model, "--no-colour", "--quiet", *words)
            yield kind, model

    def along(self, source, path, threshold):
        report = self.folder / "along.jsonl"
        words = ["--path", self.paths[path], "--frames", f"0:{self.frames_of(path)}", "--resolution", self.size_words(),
                 "--threshold", threshold, "--reference", self.bench.mesh, "--report", report, "--quiet"]
        if source is None:
            with self.server() as (_, place):
                run(self.bench.program("qs-render"), place, *words)
        else:
            with links.web_server(self.folder, self.folder) as port, links.daemon(self.bench, self.folder / "cache"):
                run(self.bench.program("qs-render"), f"http://127.0.0.1:{port}/{source.name}", *words, "--cache",
                    self.folder / "cache", "--settle", "--no-prefetch")
        frames = [json.loads(line) for line in report.read_text().splitlines()]
        down = sum(frame["bytes_down"] for frame in frames) if source is None else frames[-1]["stream"]["bytes_fetched"]
        psnr = [99.0 if frame["psnr_db"] is None else frame["psnr_db"] for frame in frames]  # equal ones have none
        return {"bytes": down, "mean_psnr_db": sum(psnr) / len(psnr), "min_psnr_db": min(psnr),
                "measured_error_px": max(frame["measured_error_px"] for frame in frames),
                "holes": sum(frame["holes"] for frame in frames), "mean_iou": sum(f["coverage_iou"] for f in frames) / len(frames)}

    def frames_of(self, path):
        """Of the walk one round, every frame of the others."""
        count = len(self.paths[path].read_text().splitlines())
        return min(8, count // 2) if path == "walk" else count


def cpu_s(pid):
    with open(f"/proc/{pid}/stat") as file:
        fields = file.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def rss_bytes(pid):
    return status_bytes(pid, "VmRSS")


def peak_bytes(pid):
    return status_bytes(pid, "VmHWM")


def status_bytes(pid, key):
    with open(f"/proc/{pid}/status") as file:
        return next(int(line.split()[1]) * 1024 for line in file if line.startswith(key))
