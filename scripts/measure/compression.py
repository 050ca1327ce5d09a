#!/usr/bin/env python3
"""What compression of models saves, beside other ways of coding the same points: the table of qs(5).

    scripts/measure/compression.py BIN_DIR MESH...     (BIN_DIR: where qs-build and qs-render are)

Bytes a vertex of plain and compressed files, of xz -9 on the plain file, and of Draco's coding of the mesh's vertices
(draco_encoder, where it is there), and the bytes of a prefix that draws the fitted view at 20, 25 and 30 dB PSNR.
Prefixes of the two forms that have the same blocks draw the same picture, so each is drawn once.
"""
import json
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile

PSNR_DB = (20, 25, 30)


def read(*command):
    return subprocess.run([str(word) for word in command], check=True, stdout=subprocess.PIPE).stdout


def block_places(data):
    """Where each block of a model begins and ends, by number."""
    if data[:8] == b"qs-model":
        size, = struct.unpack_from("<I", data, 16)
        return [(at, at + size) for at in range(1024, len(data) + 1 - size, size)]
    tables, = struct.unpack_from("<I", data, 12)
    blocks, = struct.unpack_from("<Q", data, 24 + 56)
    levels = 1
    while (blocks - 1) >> 8 * levels:
        levels += 1
    places = []

    def visit(level, page, at):
        listed = blocks if level == 0 else ((blocks - 1) >> 8 * level) + 1
        count = min(256, listed - 256 * page)
        sizes = struct.unpack_from(f"<{count}{'H' if level == 0 else 'Q'}", data, at + 4)
        at += 4 + count * (2 if level == 0 else 8)
        for entry, size in enumerate(sizes):
            if level > 0:
                visit(level - 1, 256 * page + entry, at)
                at += size
            else:
                places.append((at, at + size + 1))
                at += size + 1

    visit(levels - 1, 0, 280 + tables + 8)
    return places


class Measure:
    def __init__(self, bin_dir, mesh, folder):
        self.bin, self.mesh, self.folder = pathlib.Path(bin_dir), mesh, folder

    def psnr(self, prefix):
        path = self.folder / "prefix.qs"
        path.write_bytes(prefix)
        report = read(self.bin / "qs-render", path, "--threshold", 0, "--resolution", "640,360", "--reference", self.mesh,
                      "--report", "-", "-o", self.folder / "frame.png", "--quiet")
        return json.loads(report.splitlines()[0])["psnr_db"]

    def blocks_for(self, data, ends):
        """The fewest blocks for each PSNR, by halving; None where all of them are not enough."""
        seen = {}

        def psnr(blocks):
            if blocks not in seen:
                seen[blocks] = self.psnr(data[:ends[blocks - 1]])
            return seen[blocks]

        found = []
        for goal in PSNR_DB:
            low, high = 0, len(ends)
            while low + 1 < high:
                middle = (low + high) // 2
                low, high = (low, middle) if psnr(middle) >= goal else (middle, high)
            found.append(high if psnr(high) >= goal else None)
        return found

    def rows(self):
        xz = []
        for kib in (1, 4, 16):
            plain, coded = self.folder / "plain.qs", self.folder / "coded.qs"
            read(self.bin / "qs-build", self.mesh, "--no-colour", "--block-size", f"{kib}K", "-o", plain, "--quiet")
            read(self.bin / "qs-build", plain, "--compress", "-o", coded, "--quiet")
            vertices = json.loads(read(self.bin / "qs-info", plain, "--json"))["leaves"]
            data = plain.read_bytes()
            blocks = self.blocks_for(data, [end for _, end in block_places(data)])
            for name, file in (("plain", plain), ("compressed", coded)):
                file_bytes = file.read_bytes()
                ends = [end for _, end in block_places(file_bytes)]
                yield f"{name}, {kib} KiB", len(file_bytes) / vertices, [b and ends[b - 1] for b in blocks]
            if kib == 1:
                xz = [("xz -9 of plain, 1 KiB", len(read("xz", "-9", "-c", plain)) / vertices, None)]
        yield from xz
        if shutil.which("draco_encoder"):
            for bits in (11, 14):
                out = self.folder / "points.drc"
                read("draco_encoder", "-point_cloud", "-i", self.mesh, "-o", out, "-qp", bits, "-qn", 8, "-cl", 10)
                yield f"Draco points, {bits} bits", out.stat().st_size / vertices, None


def measure(bench):
    """Bytes and decoding for scripts/bench."""
    coded = bench.out / "compressed.qs"
    read(bench.program("qs-build"), bench.model(bench.name), "--compress", "-o", coded, "--quiet")
    made = json.loads(read(bench.program("qs-info"), coded, "--json"))
    decoded = json.loads(read(bench.program("decode_bench"), coded, 3 if bench.quick else 61))
    bench.tables.write("compression", "a compressed model, and decoding it on one core",
                       [{"name": bench.name, "bytes_per_vertex": made["bytes_per_vertex"], **decoded}])
    bench.goals.add("file, compressed, no colour", "B/vertex", 3.8, 3.0, made["bytes_per_vertex"])
    bench.goals.add("decoding compressed blocks, one core", "plain B/s", 3e8, 1e9, decoded["median_bytes_per_s"], True,
                    decoded["best_bytes_per_s"])


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    for mesh in sys.argv[2:]:
        print(f"{mesh}\n{'':26s} {'B/vertex':>9s}" + "".join(f"{f'{db} dB':>10s}" for db in PSNR_DB))
        with tempfile.TemporaryDirectory() as folder:
            for name, per_vertex, prefixes in Measure(sys.argv[1], mesh, pathlib.Path(folder)).rows():
                print(f"{name:26s} {per_vertex:9.3f}" + "".join(f"{p or '-':>10}" for p in prefixes or []), flush=True)


if __name__ == "__main__":
    main()
