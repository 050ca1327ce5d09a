"""Models that arrive over a link: error against bytes and against seconds for every order, beside the whole file by curl
and in its own order; how soon things are there; what a cache and many clients cost."""
import concurrent.futures
import json
import math
import shutil
import statistics
import time

from . import links
from .programs import log, read, run

ORDERS = ["gain", "level", "radius", "screen", "y", "sweep"]
COMPRESSED = "gain of the compressed model"
IN_FILE_ORDER = "the file from its beginning"
BY_CURL = "the whole file by curl"
LEVELS_DB = [20, 25, 30, 35]
FIRST_BYTES = 13312
HOME = links.Link("384 kbit/s", 40)  # where orders differ most, and goals are set
FRAMES_A_SECOND = 15
# How long is looked at, by rate.
SLOW_S = 10  # a whole file that takes longer is fetched by curl and qs-fetch at the same time
SECONDS = {"384 kbit/s": 20, "8 Mbit/s": 4, "100 Mbit/s": 2}
BUDGET_BYTES = 1 << 20
DETAILS = ["--splat", "smooth", "--threshold", "1", "--quiet"]


def lacks(bench):
    """What it cannot do without here; empty where all is there."""
    if not links.nginx_program():
        return "nginx"
    if not shutil.which("openssl"):
        return "openssl"
    if not all(map(bench.find_program, ["qs-fetch", "fetch_bench"])):
        return "programs built with HTTP"
    if "--snapshot" not in read(bench.program("qs-render"), "--help"):
        return "a qs-render that draws from URLs"
    return ""


def measure(bench):
    if lacks(bench):
        log(f"streaming is left out: it needs {lacks(bench)}")
        return
    folder = bench.out / "streaming"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    with links.web_server(folder, bench.out) as port:
        Streaming(bench, folder, port).measure()


class Streaming:
    def __init__(self, bench, folder, port):
        self.bench, self.folder, self.port = bench, folder, port
        self.cache = folder / "cache"
        self.home = links.Link("100 Mbit/s", 5) if bench.quick else HOME
        self.links = [self.home] if bench.quick else links.LINKS
        self.rows = []

    def url(self, name):
        return self.url_of(self.bench.model(name))

    def url_of(self, file):
        return f"http://127.0.0.1:{self.port}/{file.relative_to(self.bench.out)}"

    def measure(self):
        self.measure_links()
        self.measure_orders()
        self.measure_first_pictures()
        self.measure_close_up()
        self.measure_motion()
        self.measure_presence()
        self.measure_memory()
        self.measure_throughput()
        self.measure_clients()

    # ---- pictures ----

    def view(self, name):
        return self.bench.fit(name)

    def camera(self, view):
        def numbers(values):
            return ",".join(repr(float(value)) for value in values)
        width, height = self.bench.size
        return ["--camera-position", numbers(view["eye"]), "--camera-focal-point", numbers(view["target"]),
                "--camera-view-up", numbers(view["up"]), "--camera-view-angle", view["fovy"],
                "--resolution", f"{width},{height}"]

    def render(self, source, *words, report=None):
        command = [self.bench.program("qs-render"), source, *DETAILS, *words]
        run(*command, *(["--report", report] if report else []))
        return [json.loads(line) for line in report.read_text().splitlines()] if report else []

    def reference(self, name, view, label):
        picture = self.folder / f"whole-{label}.png"
        self.render(self.bench.model(name), *self.camera(view), "-o", picture)
        return picture

    def psnr(self, picture, reference):
        value = json.loads(read(self.bench.program("qs-compare"), "--json", reference, picture))["pictures"][0]["psnr_db"]
        return 99.0 if value is None else min(value, 99.0)  # equal ones have none

    def snapshots(self, url, view, link, order):
        """What is seen, at times that are as far apart as they are from the start."""
        seconds = 1 if self.bench.quick else SECONDS[link.rate_name]
        steps = 6 if self.bench.quick else 18
        times = ["0s"] + [f"{1000 * 0.1 * (seconds / 0.1) ** (i / (steps - 1)):.0f}ms" for i in range(steps)]
        report = self.folder / "frames.jsonl"
        with links.daemon(self.bench, self.cache, link):
            frames = self.render(url, *self.camera(view), "--cache", self.cache, "--order", order,
                                 "--snapshot", ",".join(times), "-o", self.folder / "at-%02d.png", report=report)
        return frames

    # ---- orders ----

    def measure_orders(self):
        name, view = self.bench.name, self.view(self.bench.name)
        reference = self.reference(name, view, "fit")
        for link in self.links:
            orders = ORDERS if link.name == HOME.name else ["gain", "sweep"]
            for order in orders:
                self.add_curve(self.url(name), view, link, order, order, reference)
        coded = self.folder / "coded.qs"
        run(self.bench.program("qs-build"), self.bench.model(name), "--compress", "-o", coded, "--quiet")
        self.add_curve(self.url_of(coded), view, self.home, "gain", COMPRESSED, reference)
        self.add_yardsticks(name, view, reference)
        self.bench.tables.write_csv("streaming", self.rows)
        self.summarise()

    def add_curve(self, url, view, link, order, label, reference):
        log(f"streaming {link.name}, {label}")
        for i, frame in enumerate(self.snapshots(url, view, link, order)):
            stream = frame["stream"]
            self.rows.append({"link": link.name, "order": label, "seconds": stream["elapsed_s"],
                              "bytes": stream["bytes_fetched"],
                              "psnr_db": self.psnr(self.folder / f"at-{i:02d}.png", reference),
                              "requests": stream["requests"],
                              "visible_blocks_missing": stream["visible_blocks_missing"],
                              "waiting_error_px": stream["waiting_error_px"],
                              "wasted_bytes": stream["wasted_bytes"]})

    def add_yardsticks(self, name, view, reference):
        """The file in its own order, as fast as the link brings it, and what curl takes for all of it."""
        whole = self.bench.model(name).read_bytes()
        sizes = [FIRST_BYTES << k for k in range(20) if FIRST_BYTES << k < len(whole)] + [len(whole)]
        prefix, picture = self.folder / "prefix.qs", self.folder / "prefix.png"
        psnr = {}
        for size in sizes:
            prefix.write_bytes(whole[:size])
            self.render(prefix, *self.camera(view), "-o", picture)
            psnr[size] = self.psnr(picture, reference)
        for link in self.links:
            for size in sizes:
                self.rows.append(self.row_of_yardstick(link, IN_FILE_ORDER, size, psnr[size], link.seconds_for(size)))
            self.rows.append(self.row_of_yardstick(link, BY_CURL, len(whole), psnr[len(whole)], self.curl_s[link.name]))

    @staticmethod
    def row_of_yardstick(link, order, size, psnr_db, seconds):
        return {"link": link.name, "order": order, "seconds": seconds, "bytes": size, "psnr_db": psnr_db, "requests": 1}

    def curve(self, link_name, order, key):
        return [(row[key], row["psnr_db"]) for row in self.rows if row["link"] == link_name and row["order"] == order]

    def summarise(self):
        summary = []
        for link in self.links:
            for order in ORDERS + [COMPRESSED, IN_FILE_ORDER, BY_CURL]:
                if not self.curve(link.name, order, "seconds"):
                    continue
                row = {"link": link.name, "order": order}
                for level in LEVELS_DB:
                    row[f"s_to_{level}_db"] = reaching(self.curve(link.name, order, "seconds"), level)
                for level in LEVELS_DB:
                    row[f"bytes_to_{level}_db"] = reaching(self.curve(link.name, order, "bytes"), level)
                summary.append(row)
        self.bench.tables.write("streaming-summary", f"seconds and bytes to a PSNR, {self.bench.name}, fit, smooth", summary)
        at_home = {row["order"]: row for row in summary if row["link"] == self.home.name}
        gain, sweep = at_home["gain"], at_home["sweep"]
        goal = self.bench.goals.add
        goal(f"streaming, {self.home.name}, gain, to 20 dB", "s", 2.2, 1.8, gain["s_to_20_db"])
        goal(f"streaming, {self.home.name}, gain, to 25 dB", "s", 6, None, gain["s_to_25_db"])
        goal(f"streaming, {self.home.name}, sweeps, to 20 dB", "s", 3.3, None, sweep["s_to_20_db"])
        if gain["bytes_to_25_db"] and sweep["bytes_to_25_db"]:
            goal("streaming, bytes of gain to 25 dB, by those of sweeps", "1", 0.75, None,
                 gain["bytes_to_25_db"] / sweep["bytes_to_25_db"])
        goal("streaming, gain behind another order at equal bytes, below 35 dB", "dB", 0.5, None,
             max(self.behind(order) for order in ORDERS[1:] if order in at_home))

    def behind(self, order):
        ours, theirs = self.curve(self.home.name, "gain", "bytes"), self.curve(self.home.name, order, "bytes")
        return max([at(theirs, size) - psnr for size, psnr in ours
                    if psnr < 35 and theirs[0][0] <= size <= theirs[-1][0]], default=0.0)

    # ---- links ----

    def measure_links(self):
        """The whole file, and a change of view."""
        name, rows = self.bench.name, []
        size = self.bench.model(name).stat().st_size
        noise = self.bench.out / "streaming-noise"
        noise.write_bytes(bytes(8 << 20))
        self.curl_s = {}
        for link in self.links:
            log(f"link of {link.name}")
            # Each has a link of its own, and next to nothing to compute where links are slow.
            with links.relay(link, self.port) as port, links.daemon(self.bench, self.cache, link):
                with concurrent.futures.ThreadPoolExecutor(1 if size < SLOW_S * link.bytes_per_s else 2) as pool:
                    by_curl = pool.submit(run, "curl", "-s", "-o", self.folder / "by-curl",
                                          f"http://127.0.0.1:{port}/{self.bench.model(name).name}")
                    by_us = pool.submit(run, self.bench.program("qs-fetch"), "get", self.url(name), "--cache", self.cache,
                                        "-o", self.folder / "got")
                    self.curl_s[link.name], got = by_curl.result().wall_s, by_us.result().wall_s
            with links.daemon(self.bench, self.cache, link):
                jump = json.loads(read(self.bench.program("fetch_bench"), "jump", self.cache,
                                       f"http://127.0.0.1:{self.port}/{noise.name}"))
                server = links.status(self.bench, self.cache)["servers"][0]
            rows.append({"link": link.name, "file_bytes": size, "at_the_rate_s": 2 * link.round_trip_s + size / link.bytes_per_s,
                         "curl_s": self.curl_s[link.name], "qs_fetch_s": got, "first_useful_s": jump["first_useful_s"],
                         "first_useful_worst_s": jump["worst_s"], "goal_s": 1.5 * link.round_trip_s + 0.1,
                         "estimated_bytes_per_s": server["bytes_per_s"],
                         "estimated_round_trip_ms": server["round_trip_ms"]})
        noise.unlink()
        self.bench.tables.write("streaming-links", "the whole file, and the first useful block after a change of view", rows)
        self.bench.goals.add("streaming, links where the first useful block is late (1.5 round trips + 100 ms)", "count", 0,
                             None, sum(row["first_useful_s"] > row["goal_s"] for row in rows))

    # ---- what is there, and when ----

    def measure_first_pictures(self):
        """Of a model and of one 16 times as large, and over TLS."""
        certificate = self.folder / "tls" / "certificate.pem"
        certificate.parent.mkdir()
        links.make_certificate(certificate)
        rows = []
        with links.web_server(certificate.parent, self.bench.out, certificate) as tls_port:
            for name in [self.bench.name] if self.bench.quick else [self.bench.name, self.bench.x16]:
                of_tls = f"https://127.0.0.1:{tls_port}/{self.bench.model(name).relative_to(self.bench.out)}"
                for link in self.links:
                    rows.append(self.first_picture(name, link, self.url(name), round_trips=2))
                    rows.append(self.first_picture(name, link, of_tls, round_trips=3, certificate=certificate))
        self.bench.tables.write("streaming-first", "the first complete picture: two round trips, three over TLS, and 13 KiB", rows)
        slow = [row for row in rows if row["link"].startswith(self.home.rate_name)]
        self.bench.goals.add(f"streaming, first picture at {self.home.rate_name}, beyond round trips, worst", "s", 0.12, None,
                             max(row["beyond_round_trips_s"] for row in slow))
        self.bench.goals.add("streaming, first picture, beyond round trips and 13 KiB, worst", "s", 0.1, None,
                             max(row["beyond_13_kib_s"] for row in rows))
        self.bench.goals.add("streaming, first picture, bytes, worst model", "B", FIRST_BYTES + 1024, None,
                             max(row["bytes"] for row in slow))

    def first_picture(self, name, link, url, round_trips, certificate=None):
        report = self.folder / "frames.jsonl"
        with links.daemon(self.bench, self.cache, link, certificate=certificate):
            frames = self.render(url, *self.camera(self.view(name)), "--cache", self.cache, "--snapshot", "0s",
                                 "-o", self.folder / "at-%02d.png", report=report)
        stream = frames[0]["stream"]
        beyond_s = stream["first_picture_s"] - round_trips * link.round_trip_s
        return {"name": name, "link": link.name, "round_trips": round_trips, "first_picture_s": stream["first_picture_s"],
                "bytes": stream["bytes_fetched"], "beyond_round_trips_s": beyond_s,
                "beyond_13_kib_s": beyond_s - FIRST_BYTES / link.bytes_per_s}

    def measure_close_up(self):
        report = self.folder / "frames.jsonl"
        name = self.bench.name
        view = self.bench.close_up(self.view(name))
        with links.daemon(self.bench, self.cache):
            frames = self.render(self.url(name), *self.camera(view), "--cache", self.cache, "--settle", "--no-prefetch",
                                 "-o", self.folder / "at-%02d.png", report=report)
        part = frames[-1]["stream"]["bytes_fetched"] / self.bench.model(name).stat().st_size
        self.bench.goals.add("streaming, 8x close-up, part of the file", "1", 1 / 8, 1 / 10, part)

    def measure_motion(self):
        """A camera that goes on, whatever has arrived."""
        link = links.Link("8 Mbit/s", 150)
        name, rows = self.bench.name, []
        paths = {"orbit": self.orbit(name, 120), "pan": self.pan(name)}
        for path, lines in paths.items():
            for is_ahead in (True, False):
                rows.append(self.along(name, path, lines, link, is_ahead))
        self.bench.tables.write("streaming-motion", "along a path, 15 frames a second: what is there of what frames need", rows)
        goal = self.bench.goals.add
        goal("streaming, moving, 8 Mbit/s 150 ms: what is there, orbit", "1", 0.96, None, rows[0]["hit_rate"], True)
        goal("streaming, moving, 8 Mbit/s 150 ms: what is there, steady pan", "1", 0.99, None, rows[2]["hit_rate"], True)
        goal("streaming, moving: fetched and never drawn, without prefetch, worst", "1", 0.05, None,
             max(row["wasted"] for row in rows if not row["prefetch"]))
        self.measure_second_run(name)

    def along(self, name, path, lines, link, is_ahead):
        log(f"streaming {name}, {path}, {'with' if is_ahead else 'without'} prefetch")
        cameras, report = self.folder / f"{path}.jsonl", self.folder / "frames.jsonl"
        cameras.write_text("".join(json.dumps(line) + "\n" for line in lines))
        with links.daemon(self.bench, self.cache, link):
            frames = self.render(self.url(name), *self.path_words(cameras), "--realtime", FRAMES_A_SECOND,
                                 *([] if is_ahead else ["--no-prefetch"]), report=report)
        # The first two seconds are for what is there when the camera begins to move: not all of the first view.
        moving = [frame["stream"] for frame in frames[self.still():]]
        stream = frames[-1]["stream"]
        return {"path": path, "link": link.name, "prefetch": is_ahead,
                "hit_rate": statistics.mean(frame["hit_rate"] for frame in moving),
                "worst": min(frame["hit_rate"] for frame in moving),
                "visible_hit_rate": statistics.mean(frame["visible_hit_rate"] for frame in moving),
                "bytes": stream["bytes_fetched"],
                "wasted": stream["wasted_bytes"] / max(1, stream["bytes_fetched"]),
                "seconds": stream["elapsed_s"]}

    def path_words(self, cameras):
        width, height = self.bench.size
        return ["--path", cameras, "--resolution", f"{width},{height}", "--cache", self.cache]

    def measure_second_run(self, name):
        cameras, report = self.folder / "again.jsonl", self.folder / "frames.jsonl"
        cameras.write_text("".join(json.dumps(line) + "\n" for line in self.orbit(name, 90)[::8]))
        words = [*self.path_words(cameras), "--settle", "--no-prefetch"]
        with links.daemon(self.bench, self.cache):
            self.render(self.url(name), *words, report=report)
        with links.daemon(self.bench, self.cache, keep=True):
            again = self.render(self.url(name), *words, report=report)
            sent = links.status(self.bench, self.cache)["body_bytes"]
        self.bench.goals.add("streaming, second run of the same path", "B", 0, None,
                             max(sent, again[-1]["stream"]["bytes_fetched"]))

    def still(self):
        """Frames until the camera begins to move."""
        return 4 if self.bench.quick else 2 * FRAMES_A_SECOND

    def moments(self):
        """The times of frames, and how far each is along the way, 0 to 1."""
        frames = 16 if self.bench.quick else 8 * FRAMES_A_SECOND
        still = self.still()
        return [(frame / FRAMES_A_SECOND, max(0, frame - still) / (frames - 1 - still)) for frame in range(frames)]

    def orbit(self, name, degrees):
        """About the object."""
        view = self.view(name)
        distance = math.dist(view["eye"], view["target"])
        lines = []
        for t, part in self.moments():
            angle = math.radians(degrees * part)
            eye = [view["target"][0] + distance * math.sin(angle), view["target"][1],
                   view["target"][2] + distance * math.cos(angle)]
            lines.append(dict(eye=eye, target=view["target"], up=view["up"], fovy=view["fovy"], t=t))
        return lines

    def pan(self, name):
        """Across the close-up, by a third of the object's radius: some 2,400 pixels of it."""
        view = self.bench.close_up(self.view(name))
        radius = self.bench.bounds[name][1]
        lines = []
        for t, part in self.moments():
            move = [0.35 * radius * part, 0, 0]
            lines.append(dict(eye=[a + b for a, b in zip(view["eye"], move)],
                              target=[a + b for a, b in zip(view["target"], move)], up=view["up"], fovy=view["fovy"], t=t))
        return lines

    def measure_presence(self):
        """What streaming costs where all blocks are there, beside the local file."""
        name, report = self.bench.name, self.folder / "frames.jsonl"
        view = self.view(name)
        cameras = self.folder / "still.jsonl"
        frames = 6 if self.bench.quick else 40
        cameras.write_text((json.dumps(dict(eye=view["eye"], target=view["target"], up=view["up"], fovy=view["fovy"])) + "\n")
                           * frames)
        width, height = self.bench.size
        words = ["--path", cameras, "--resolution", f"{width},{height}"]
        times = {"url": [], "file": []}
        with links.daemon(self.bench, self.cache):
            run(self.bench.program("qs-fetch"), "get", self.url(name), "--cache", self.cache, "-o", self.folder / "got")
            for _ in range(3):
                for kind, source in (("file", [self.bench.model(name)]), ("url", [self.url(name), "--cache", self.cache])):
                    drawn = self.render(source[0], *source[1:], *words, report=report)
                    times[kind] += [frame["ms"]["total"] for frame in drawn[1:]]
        rows = [{"source": kind, "frames": len(values), "median_ms": statistics.median(values), "min_ms": min(values)}
                for kind, values in times.items()]
        self.bench.tables.write("streaming-presence", "frames with all blocks there, from a URL and from a file", rows)
        self.bench.goals.add("streaming, frame time with all blocks there, by that of a local file", "1", 1.05, None,
                             min(times["url"]) / min(times["file"]))

    def measure_memory(self):
        """Of a client that draws the same view of a model and of one 16 times as large, from as many bytes."""
        rows, frames = [], self.folder / "frames.jsonl"
        names = [self.bench.name] if self.bench.quick else [self.bench.name, self.bench.x16]
        for name in names:
            with links.daemon(self.bench, self.cache):
                cost = run(self.bench.program("qs-render"), self.url(name), *DETAILS, *self.camera(self.view(name)),
                           "--cache", self.cache, "--byte-budget", BUDGET_BYTES, "-o", self.folder / "at.png",
                           "--report", frames)
            stream = json.loads(frames.read_text())["stream"]
            rows.append({"name": name, "file_bytes": self.bench.model(name).stat().st_size,
                         "bytes_fetched": stream["bytes_fetched"], "client_rss_bytes": cost.rss_bytes})
        self.bench.tables.write("streaming-memory", "a client's memory, with the cache's pages that it maps", rows)
        self.bench.goals.add("streaming, memory of a client, model x16 by model", "1", 1.1, None,
                             rows[-1]["client_rss_bytes"] / rows[0]["client_rss_bytes"])

    # ---- the daemon ----

    def measure_throughput(self):
        """Beside curl, which gets ranges of 64 KiB on one connection."""
        size = (16 if self.bench.quick else 64) << 20
        noise = self.bench.out / "streaming-noise"
        with open(noise, "wb") as file:
            file.truncate(size)
        url = f"http://127.0.0.1:{self.port}/{noise.name}"
        ranges = self.folder / "ranges.curl"
        ranges.write_text("".join(f'url = "{url}"\nrange = "{at}-{at + 65535}"\noutput = "{self.folder}/got"\n'
                                  for at in range(0, size, 65536)))
        curl, ours = [], []
        for _ in range(self.bench.slow_runs):
            curl.append(run("curl", "-s", "--config", ranges).wall_s)
            with links.daemon(self.bench, self.cache):
                ours.append(run(self.bench.program("qs-fetch"), "prefetch", url, "--bytes", size, "--cache", self.cache).wall_s)
        noise.unlink()
        rows = [{"program": program, "runs": len(values), "median_s": statistics.median(values), "min_s": min(values),
                 "best_bytes_per_s": size / min(values)}
                for program, values in (("curl, 64 KiB ranges", curl), ("qs-fetch prefetch", ours))]
        self.bench.tables.write("streaming-throughput", "throughput on loopback", rows)
        self.bench.goals.add("streaming, throughput on loopback, by curl's", "1", 0.9, None, min(curl) / min(ours), True)

    def measure_clients(self):
        count = 100 if self.bench.quick else 1000
        noise = self.bench.out / "streaming-noise"
        with open(noise, "wb") as file:
            file.truncate(64 << 20)
        with links.daemon(self.bench, self.cache) as process:
            row = json.loads(read(self.bench.program("fetch_bench"), "clients", self.cache,
                                  f"http://127.0.0.1:{self.port}/{noise.name}", count))
            row["daemon_rss_bytes"] = peak_rss(process.pid)
            row["daemon_idle_ticks"] = idle_ticks(process.pid)
        noise.unlink()
        self.bench.tables.write("streaming-clients", "clients that want blocks of their own, and the same ones, at a time", [row])
        self.bench.goals.add("streaming, clients of one daemon", "count", count, None, row["clients"], True)
        self.bench.goals.add("streaming, processor time of an idle daemon in a second", "ticks", 0, None,
                             row["daemon_idle_ticks"])


def reaching(curve, level):
    """Where a curve first reaches a level; between two of its points as if it were straight."""
    before = None
    for x, y in curve:
        if y >= level:
            if before is None or y == before[1]:
                return x
            return before[0] + (x - before[0]) * (level - before[1]) / (y - before[1])
        before = (x, y)
    return None


def at(curve, x):
    """The height of a curve, likewise."""
    for (x0, y0), (x1, y1) in zip(curve, curve[1:]):
        if x0 <= x <= x1:
            return y0 if x1 == x0 else y0 + (y1 - y0) * (x - x0) / (x1 - x0)
    return curve[-1][1]


def peak_rss(pid):
    with open(f"/proc/{pid}/status") as file:
        return next(int(line.split()[1]) * 1024 for line in file if line.startswith("VmHWM"))


def idle_ticks(pid):
    def ticks():
        with open(f"/proc/{pid}/stat") as file:
            fields = file.read().rsplit(")", 1)[1].split()
        return int(fields[11]) + int(fields[12])
    time.sleep(0.3)
    before = ticks()
    time.sleep(1)
    return ticks() - before
