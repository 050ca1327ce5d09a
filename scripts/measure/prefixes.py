"""What the first bytes of a model draw."""
from .programs import FrameBench

SIZES = [4096, 8192, 13312] + [1 << k for k in range(15, 32)]


def measure(bench):
    rows = []
    for name in (bench.name, bench.x16):
        whole = bench.model(name).stat().st_size
        sizes = [size for size in SIZES if size < whole] + [whole]
        for size in sizes if name == bench.name else [8192, 13312]:
            if size > whole:
                continue
            prefix = bench.out / "prefix.qs"
            prefix.write_bytes(bench.model(name).read_bytes()[:size])
            # The small mesh is the same surface and is read sooner.
            with FrameBench(bench, prefix, bench.mesh, bench.mesh) as frames:
                a = frames.ask(bench.fit(bench.name), 0, compare=True, distance=True)
            rows.append({"name": name, "bytes": size, "splats": a["splats"], "psnr_db": a["psnr_db"],
                         "growth": a["growth"], "holes": a["holes"], "error_bound_px": a["error_bound_px"],
                         "measured_error_px": a["measured_error_px"]})
    prefix.unlink()
    bench.tables.write("prefixes", "what the first bytes of a model draw, fit, smooth", rows)
    complete = [row["bytes"] for row in rows if row["name"] == bench.x16 and row["holes"] == 0] or \
               [row["bytes"] for row in rows if row["name"] == bench.name and row["holes"] == 0]
    bench.goals.add("first complete picture (no holes), x16", "B", 13312, 8192, min(complete, default=None))
