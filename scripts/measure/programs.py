"""Running programs, and asking frame_bench."""
import json
import math
import os
import subprocess
import sys
import time


def log(text):
    print(f"bench: {text}", file=sys.stderr, flush=True)


class Cost:
    def __init__(self, wall_s, cpu_s, rss_bytes):
        self.wall_s, self.cpu_s, self.rss_bytes = wall_s, cpu_s, rss_bytes


def run(*command, output=None):
    """Runs a program to its end; what it printed is thrown away, or goes to `output`.  RSS is the peak."""
    start = time.perf_counter()
    process = subprocess.Popen([str(word) for word in command], stdout=output or subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    wall_s = time.perf_counter() - start
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"bench: {command[0]} failed with exit status {process.returncode}")
    return Cost(wall_s, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024)


def read(*command):
    return subprocess.run([str(word) for word in command], check=True, stdout=subprocess.PIPE, text=True).stdout


def through_pipe(*command):
    """As run(), with a reader at the end of a pipe that throws the bytes away."""
    with subprocess.Popen(["cat"], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL) as reader:
        cost = run(*command, output=reader.stdin)
        reader.stdin.close()
    return cost


def drop_pages(path):
    file = os.open(path, os.O_RDONLY)
    os.fsync(file)
    os.posix_fadvise(file, 0, 0, os.POSIX_FADV_DONTNEED)
    os.close(file)


class FrameBench:
    """frame_bench, open for questions about one model.  Without a mesh, pictures are held against the model's own leaves."""

    def __init__(self, bench, model, mesh=None, surface=None, threads=0, backend="cpu"):
        command = [bench.program("frame_bench"), model, "--threads", threads, "--backend", backend]
        command += ["--reference", mesh] if mesh else []
        command += ["--surface", surface] if surface else []
        self.process = subprocess.Popen([str(word) for word in command], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        text=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.stdin.close()
        self.process.wait()

    def ask(self, camera, threshold, **case):
        line = dict(camera, threshold=threshold, **case)
        print(json.dumps(line), file=self.process.stdin, flush=True)
        answer = self.process.stdout.readline()
        if not answer:
            sys.exit("bench: frame_bench ended early")
        return json.loads(answer)

    def threshold_for(self, camera, psnr_db):
        """The largest threshold at which smooth splats reach `psnr_db`; None where the leaves do not."""
        if (self.ask(camera, 0, compare=True)["psnr_db"] or math.inf) < psnr_db:
            return None
        low, high = -6.0, 4.0  # powers of two of a pixel
        for _ in range(10):
            middle = (low + high) / 2
            psnr = self.ask(camera, 2 ** middle, compare=True)["psnr_db"]
            low, high = (middle, high) if psnr is None or psnr >= psnr_db else (low, middle)
        return 2 ** low
