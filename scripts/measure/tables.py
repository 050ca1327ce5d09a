"""Tables as text, as CSV and for the page; the goals that figures are held against."""
import csv
import math
import sys


def form(value):
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        if math.isinf(value) or math.isnan(value):
            return str(value)
        return f"{value:.0f}" if abs(value) >= 1e5 else f"{value:.4g}"
    return str(value)


def spread(values):
    """Median, minimum, and the distance of the quartiles by the median."""
    values = sorted(values)

    def at(part):
        return values[int(part * (len(values) - 1) + 0.5)]
    return {"median": at(0.5), "min": values[0], "spread": (at(0.75) - at(0.25)) / at(0.5)}


class Tables:
    """Tables as text and as CSV; those that were shown are kept for the page."""

    def __init__(self, folder):
        self.folder = folder
        self.shown = {}

    def write_csv(self, name, rows):
        with open(self.folder / f"{name}.csv", "w", newline="") as file:
            out = csv.DictWriter(file, list(rows[0]))  # None is an empty field
            out.writeheader()
            out.writerows(rows)

    def write(self, name, title, rows, shown=None):
        """`rows`: dictionaries; the first one has all keys.  `shown`: the columns of the text table."""
        self.write_csv(name, rows)
        shown = shown or list(rows[0])
        self.shown[name] = (title, shown, rows)
        cells = [shown] + [[form(row.get(key)) for key in shown] for row in rows]
        widths = [max(len(line[i]) for line in cells) for i in range(len(shown))]
        is_text = [isinstance(rows[0].get(key), str) for key in shown]
        print(f"\n## {title}  ({name}.csv)")
        for line in cells:
            print("  ".join(c.ljust(w) if left else c.rjust(w) for c, w, left in zip(line, widths, is_text)).rstrip())
        sys.stdout.flush()


class Goals:
    """Figures beside what was to be reached."""

    def __init__(self):
        self.rows = []

    def add(self, what, unit, must, stretch, measured, more_is_better=False, best=None):
        def holds(limit):
            return measured is not None and (measured >= limit if more_is_better else measured <= limit)
        verdict = "stretch" if stretch is not None and holds(stretch) else "met" if holds(must) else "MISSED"
        self.rows.append({"what": what, "unit": unit, "must": must, "stretch": stretch, "measured": measured,
                          "best_run": best, "verdict": verdict})

    def summary(self):
        missed = [row["what"] for row in self.rows if row["verdict"] == "MISSED"]
        return f"{len(self.rows) - len(missed)} of {len(self.rows)} goals met" + (f"; missed: {'; '.join(missed)}" if missed else "")
