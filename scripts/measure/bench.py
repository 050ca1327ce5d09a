"""What is measured with: programs, meshes, models, cameras."""
import json
import math
import os
import pathlib
import subprocess
import sys

from .programs import FrameBench, log, read, run
from .tables import Goals, Tables

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
DATA = ROOT.parent / "shared/data"
KINDS = ["square", "circle", "ellipse", "smooth"]
BOUNDED_KINDS = ["ellipse", "smooth"]  # only these are promised an error bound


class Bench:
    def __init__(self, options):
        self.quick = options.quick
        self.out = pathlib.Path(options.out or ROOT / "build/report").resolve()
        self.out.mkdir(parents=True, exist_ok=True)
        self.build_folder = pathlib.Path(options.build).resolve() if options.build else self.make_release()
        self.tables = Tables(self.out)
        self.size = [320, 180] if self.quick else [1280, 720]
        self.runs = 3 if self.quick else 21      # of a frame
        self.slow_runs = 2 if self.quick else 7  # of a program
        self.goals = Goals()
        self.bounds = {}     # of models: centre and radius
        self.at_psnr = {}    # rows of frames of x16, by PSNR
        self.mesh, self.name = self.find_mesh(options.mesh)

    def make_release(self):
        log("building build/release")
        subprocess.run(["scripts/install-packages"], cwd=ROOT, check=True)
        names = ["qs-build", "qs-info", "qs-path", "qs-render", "qs-compare", "qs-fetch", "coral", "subdivide", "paint",
                 "bandwidth", "frame_bench", "fetch_bench", "budget_bench", "backend_bench", "ppve_bench",
                 "point_view_bench", "terrain", "stability_tests", "pm-build", "pm-serve", "pm-fetch", "pm_bench", "pm_fronts"]
        for command in (["cmake", "--preset", "release", "-DQS_BENCH=ON"],
                        ["cmake", "--build", "--preset", "release", "--target", *names]):
            done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            if done.returncode != 0:
                sys.exit(done.stdout + "bench: the build failed")
        return ROOT / "build/release"

    def find_program(self, name):
        places = (self.build_folder / folder / name for folder in ("bin", "tests/bench", "tests/stability"))
        return next((str(place) for place in places if place.exists()), None)

    def program(self, name):
        return self.find_program(name) or sys.exit(f"bench: {self.build_folder} has no {name}")

    def find_mesh(self, mesh):
        dragon = DATA / "dragon.ply"
        if mesh:
            return pathlib.Path(mesh).resolve(), pathlib.Path(mesh).stem
        if not self.quick and dragon.exists():
            return dragon, "dragon"
        made = self.out / "coral.ply"
        run(self.program("coral"), "--resolution", 64 if self.quick else 512, "-o", made)
        return made, "coral"

    def say_set_up(self):
        cache = dict(line.split("=", 1) for line in (self.build_folder / "CMakeCache.txt").read_text().splitlines()
                     if "=" in line and not line.startswith(("#", "//")))
        compiler = read(cache.get("CMAKE_CXX_COMPILER:FILEPATH") or cache["CMAKE_CXX_COMPILER:STRING"], "--version")
        kind = cache["CMAKE_BUILD_TYPE:STRING"]
        flags = cache.get(f"CMAKE_CXX_FLAGS_{kind.upper()}:STRING", "")
        cpu = [line.split(":", 1)[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")]
        width, height = self.size
        self.load = os.getloadavg()
        self.set_up = (f"# {read(self.program('qs-render'), '--version').strip()}, {compiler.splitlines()[0]} {flags}, "
              f"{os.cpu_count()} threads, {cpu[0] if cpu else 'unknown processor'}\n"
              f"# {self.name} {self.vertices[self.name]:,} vertices, frames {width}x{height}, {self.runs} runs of a frame "
              f"after 3, {self.slow_runs} of a program after 1, seed none; load average {self.load[0]:.2f}\n"
              "# median: of the runs; min: the best; spread: distance of the quartiles by the median")
        print(self.set_up, flush=True)

    def model(self, name):
        return self.out / f"{name}.qs"

    def prepare_mesh(self):
        """Where nothing but the given mesh is measured."""
        self.meshes = self.models = {self.name: self.mesh}
        self.vertices = {self.name: header_count(self.mesh)}

    def prepare(self):
        """Meshes: the given one, x4, x16, and a painted one; beside the dragon a CT head.  Models: of these, and of a cloud."""
        self.meshes = {self.name: self.mesh}
        stamp = f"{self.mesh} {self.mesh.stat().st_size} {self.mesh.stat().st_mtime_ns}"
        stamp_file = self.out / f"{self.name}.made-from"
        is_kept = stamp_file.exists() and stamp_file.read_text() == stamp
        for times, label in ((1, "x4"), (2, "x16")):
            name = f"{self.name}-{label}"
            self.meshes[name] = self.out / f"{name}.ply"
            if not (is_kept and self.meshes[name].exists()):
                log(f"making {name}")
                run(self.program("subdivide"), self.mesh, times, self.meshes[name])
        painted = f"{self.name}-painted"
        self.meshes[painted] = self.out / f"{painted}.ply"
        if not (is_kept and self.meshes[painted].exists()):
            run(self.program("paint"), self.mesh, self.meshes[painted])
        stamp_file.write_text(stamp)
        head, cloud = DATA / "ct-cranium-skin-bone.ply", DATA / "autzen-stadium-crop.ply"
        if self.name == "dragon" and head.exists():
            self.meshes["ct-head"] = head
        self.models = dict(self.meshes)  # what each is built from
        if self.name == "dragon" and cloud.exists():
            self.models["lidar"] = cloud
        self.x4, self.x16, self.painted = f"{self.name}-x4", f"{self.name}-x16", painted
        self.vertices = {name: header_count(path) for name, path in self.models.items()}

    def fit(self, name):
        """The camera that sees the model along -z (the CT head along -y, its face; the cloud from above) from 2.85 radii.
        A subdivided mesh is the same surface as the one that it is made from, and is seen from the same place."""
        if name.startswith(f"{self.name}-"):
            return self.fit(self.name)
        if name not in self.bounds:
            info = json.loads(read(self.program("qs-info"), "--json", self.model(name)))
            self.bounds[name] = info["origin"], info["scale"]
        centre, radius = self.bounds[name]
        side, up = self.SIDES.get(name, ([0, 0, 1], [0, 1, 0]))
        return {"eye": [c + 2.85 * radius * s for c, s in zip(centre, side)], "target": centre, "up": up, "fovy": 30,
                "size": self.size}

    def add_mesh(self, name, path):
        self.meshes[name] = path
        self.vertices[name] = header_count(path)

    SIDES = {"ct-head": ([0, 1, 0], [0, 0, 1]), "lidar": ([0, -math.sqrt(0.5), math.sqrt(0.5)], [0, 0, 1])}

    def frames_of(self, name, threads=0, backend="cpu"):
        """Its pictures are held against its mesh (a cloud's against its own leaves), distances against the smallest that
        is the same surface."""
        surface = self.mesh if name.startswith(self.name) else self.meshes.get(name)
        return FrameBench(self, self.model(name), self.meshes.get(name), surface, threads, backend)

    def close_up(self, fit):
        """8 times closer by focal length; of the dragon, at its head."""
        centre, radius = self.bounds[self.name]
        aim = [-0.39, 0.42, 0.2] if self.name == "dragon" else [0, 0, 0]
        return dict(fit, target=[c + radius * a for c, a in zip(centre, aim)],
                    fovy=math.degrees(2 * math.atan(math.tan(math.radians(15)) / 8)))



def header_count(path):
    """The vertices of a PLY, by its header."""
    with open(path, "rb") as file:
        for line in file:
            words = line.split()
            if words[:2] == [b"element", b"vertex"]:
                return int(words[2])
            if words[:1] == [b"end_header"]:
                break
    sys.exit(f"bench: {path}: not a PLY with vertices")
