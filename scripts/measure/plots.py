"""The plots: each gnuplot script of plots/ as SVG and PNG; it is given `folder`, which has the tables, and `name`."""
import pathlib
import re
import subprocess

SCRIPTS = pathlib.Path(__file__).resolve().parent / "plots"


def draw(bench):
    for script in sorted(SCRIPTS.glob("*.gp")):
        width, height = map(int, re.match(r"# size (\d+),(\d+)", script.read_text()).groups())
        if not (bench.out / f"{table_of(script)}.csv").exists():
            continue
        for form, extension, scale in (("svg", "svg", 1), ("pngcairo", "png", 1.5)):
            terminal = (f"set terminal {form} size {scale * width:.0f},{scale * height:.0f} enhanced background 'white'; "
                        f"set output '{bench.out}/{script.stem}.{extension}'; folder = '{bench.out}'; name = '{bench.name}'")
            subprocess.run(["gnuplot", "-e", terminal, script], check=True)


def table_of(script):
    """The table that a script reads first."""
    return re.search(r"/([a-z-]+)\.csv", script.read_text()).group(1)
