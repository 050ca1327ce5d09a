"""The plots: each gnuplot script of plots/ as SVG and PNG; it is given `folder`, which has the tables, and `name`."""
import pathlib
import re
import subprocess

SCRIPTS = pathlib.Path(__file__).resolve().parent / "plots"


def draw(bench):
    for script in sorted(SCRIPTS.glob("*.gp")):
        table = bench.out / f"{table_of(script)}.csv"
        if not table.exists():
            continue
        width, height = size_of(script, table)
        for form, extension, scale in (("svg", "svg", 1), ("pngcairo", "png", 1.5)):
            terminal = (f"set terminal {form} size {scale * width:.0f},{scale * height:.0f} enhanced background 'white'; "
                        f"set output '{bench.out}/{script.stem}.{extension}'; folder = '{bench.out}'; name = '{bench.name}'")
            subprocess.run(["gnuplot", "-e", terminal, script], check=True)


def size_of(script, table):
    """As its first line says: of all, or of a row of plots, each of a name in the table's first column."""
    width, height, are_rows = re.match(r"# size (\d+),(\d+)( for two names)?", script.read_text()).groups()
    names = {line.split(",")[0] for line in table.read_text().splitlines()[1:]}
    return int(width), int(height) * ((len(names) + 1) // 2 if are_rows else 1)


def table_of(script):
    """The table that a script reads first."""
    return re.search(r"/([a-z-]+)\.csv", script.read_text()).group(1)
