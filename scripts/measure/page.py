"""The report as one page that needs nothing beside it."""
import html

from .tables import form

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1c2733; background: #fff; max-width: 74rem; margin: 2rem auto; padding: 0 1.5rem; }
h1 { font-size: 1.7rem; margin-bottom: .2rem; } h2 { font-size: 1.2rem; margin: 2.2rem 0 .3rem; }
pre.setup { color: #55636f; font-size: 12px; white-space: pre-wrap; }
p { max-width: 50rem; margin: .3rem 0 .8rem; }
svg { max-width: 100%; height: auto; }
table { border-collapse: collapse; font-size: 12.5px; font-variant-numeric: tabular-nums; }
th, td { padding: .15rem .6rem; text-align: right; white-space: nowrap; } th { color: #55636f; font-weight: 600; border-bottom: 1px solid #c8d0d8; }
td:first-child, th:first-child { text-align: left; } tr:nth-child(even) td { background: #f4f6f8; }
td.word { text-align: left; } td.stretch { color: #10743c; font-weight: 600; } td.met { color: #10743c; } td.MISSED, td.NO { color: #b3261e; font-weight: 600; }
details { margin: .4rem 0 1rem; overflow-x: auto; } summary { cursor: pointer; color: #34618c; }
"""

# Sections: title, what it says, plots, tables; what was not measured is left out.
SECTIONS = [
    ("Goals", "What was to be reached, and what was. The goals are set for the dragon.", [], ["goals"]),
    ("Error against run time",
     "One view, every kind of splat, thresholds from 16 px of error down to a quarter: what each millisecond buys. "
     "Squares and circles are the original's kinds, drawn by the same code; a few points of OpenGL, where it is there, draw the "
     "same cuts. A cloud has no surface to compare with: its "
     "pictures are held against its own leaves. Beyond the PSNR at which two exact renderers agree (Back ends, the mesh "
     "itself) figures mean nothing.",
     ["error-against-time", "silhouette-against-time"], ["error-against-time", "equal-time"]),
    ("Measured error beside guaranteed bound",
     "Each frame comes with a bound on how far any drawn point is from the surface, in pixels. Along three paths, and "
     "frame by frame: the bound is never below the measured maximum.",
     ["bound-along-paths", "bound"], ["bound-summary"]),
    ("Along whole paths",
     "Every frame of a path is timed, every fourth held against the mesh; thresholds are those that reach 35 and 40 dB in the "
     "fitted view, or all detail (0).", [], ["paths"]),
    ("Occlusion",
     "What leaving out what surfaces hide saves: splats, of those drawn without; and the time, by the time without. auto "
     "decides frame by frame; where nothing is hidden, it is what the looking costs.", [], ["occlusion"]),
    ("Triangles as leaves",
     "From the fitted view up to 64 times nearer: leaves that are points, triangles where they are large and splats where they "
     "are not, and the mesh itself as the model has it, all of its triangles.", [], ["triangles", "triangles-build"]),
    ("Cost against size of the model",
     "The same surface with 4, 16 and 64 times as many vertices, drawn at the same PSNR. An exponent of 0 means that a "
     "frame costs its pixels, 1 that it costs the model.",
     ["size"], ["size"]),
    ("Threads",
     "Measured on 1 and 2 threads. Beyond that a model: tasks and tiles as they were timed, each taken by the thread that "
     "is free first; imbalance is what this loses, and the serial part what no thread can share.",
     ["threads"], ["threads"]),
    ("Frame budgets",
     "--budget chooses the threshold of each frame so that it is drawn in time: predicted from what a cut would hold, and "
     "corrected by what frames took. Beside it the original's way, which follows the time of the frame before. The path "
     "of jumps has the frames of the other three in random order.", [], ["budgets"]),
    ("Back ends", "The same cut drawn by each back end that this machine has, and how far its frames are from the CPU's.",
     [], ["backends"]),
    ("Samples", "Anti-aliasing: several samples a pixel, held against the mesh drawn with 16.", [], ["samples"]),
    ("Frames", "The fitted view at leaves and at 1 px of error.", [], ["frames"]),
    ("Cuts", "What is read of a model for a view.", [], ["cut"]),
    ("Building", "All stages, from the mesh in the page cache to the model on disk.", ["build"], ["build", "build-stages"]),
    ("Compression", "The model as qs-build --compress has it, and how fast its blocks are brought into their plain form.",
     [], ["compression"]),
    ("The first bytes", "What a prefix of a model draws.", ["prefixes"], ["prefixes"]),
    ("Streaming: error against bytes and seconds",
     "The model arrives over a link, from nginx through qs-fetch, whose daemon makes it slow; PSNR is that of the whole frame "
     "against the picture of the whole model. Beside the orders: the file from its beginning on, as fast as the link brings it, "
     "and the whole of it by curl.", ["streaming-seconds", "streaming-bytes"], ["streaming-summary", "streaming-first"]),
    ("Streaming: links, motion, clients",
     "How soon the first block of a new view is there, what frames of a moving camera lack, and what the daemon costs.", [],
     ["streaming-links", "streaming-motion", "streaming-presence", "streaming-throughput", "streaming-clients"]),
    ("Progressive meshes",
     "The experiments of Kim, Lee and Kobbelt, the paper's figures beside: what a view costs as they have it and by their two "
     "variations; what a server keeps of a client; bytes, faces and times of a walk that is made twice; bytes until a view "
     "is satisfied beside streams that do not depend on the view, in the order of levels (the paper's) and of error; and "
     "pictures after so many bytes. Then error against bytes beside points and points with triangles as leaves.",
     ["pm-paths", "pm-memory", "pm-bytes", "pm-faces"],
     ["pm-services", "pm-fixed-tolerance", "pm-fixed-bytes", "pm-paths", "pm-tolerance", "pm-memory-summary", "pm-clients",
      "pm-idle-clients", "pm-session"]),
    ("Point sampling",
     "The server of ppve-sample, at 1280x800: how long an image takes and what of the scene it reads, how small it gets beside "
     "the paper's codec, and whole updates on a way: sample, leave out what the client has, code, keep.",
     [], ["sampling", "codecs", "updates"]),
    ("Remote points",
     "What qs-render makes of such a server, 2560x1600: the bytes of updates against whole frames, how wrong frames are while "
     "the eye moves on and when it rests, and the time of drawing.",
     ["points-in-motion"], ["point-traffic", "point-views", "point-drawing", "point-session"]),
    ("Whole programs", "From start to end, with writing.", [], ["programs", "steadiness"]),
    ("Yardsticks", "What the figures stand beside.", [], ["yardsticks", "bandwidth"]),
    ("Stiff and extreme cases",
     "Coordinates, scales, cameras and files that break builders and renderers, each with the bound that its test holds it "
     "to.", [], ["stability"]),
]
OPEN = {"goals", "equal-time", "size", "threads", "backends", "budgets", "bound-summary", "paths", "occlusion", "triangles",
        "streaming-summary", "streaming-links", "streaming-motion", "pm-services", "pm-fixed-tolerance", "pm-paths", "yardsticks"}  # not folded


def write(bench):
    parts = [f"<!doctype html><html lang='en'><head><meta charset='utf-8'><title>qs-tools: error against run time, {html.escape(bench.name)}"
             f"</title><style>{STYLE}</style></head><body><h1>Error against run time</h1>"
             f"<pre class='setup'>{html.escape(bench.set_up)}\n# made by: scripts/bench</pre>"
             f"<p><strong>{html.escape(bench.goals.summary())}</strong></p>"]
    for title, text, plots, tables in SECTIONS:
        shown = [bench.tables.shown[name] + (name,) for name in tables if name in bench.tables.shown]
        if not shown:
            continue
        parts.append(f"<h2>{html.escape(title)}</h2><p>{html.escape(text)}</p>")
        parts += [inline_svg(bench.out / f"{plot}.svg") for plot in plots if (bench.out / f"{plot}.svg").exists()]
        parts += [table(*entry) for entry in shown]
    parts.append("</body></html>\n")
    page = bench.out / "report.html"
    page.write_text("\n".join(parts))
    return page


def inline_svg(path):
    text = path.read_text()
    # Names of gradients and markers are the same in every plot.
    text = text.replace("gnuplot_", f"{path.stem}_").replace("gp", f"{path.stem}-gp")
    return "<div>" + text[text.index("<svg"):] + "</div>"


def table(title, columns, rows, name):
    head = "".join(f"<th>{html.escape(key.replace('_', ' '))}</th>" for key in columns)
    body = "".join("<tr>" + "".join(cell(row.get(key)) for key in columns) + "</tr>" for row in rows)
    state = " open" if name in OPEN else ""
    return (f"<details{state}><summary>{html.escape(title)} ({html.escape(name)}.csv)</summary>"
            f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></details>")


def cell(value):
    kind = ""
    if isinstance(value, str):
        kind = f" class='{value if value in ('stretch', 'met', 'MISSED', 'NO') else 'word'}'"
    return f"<td{kind}>{html.escape(form(value))}</td>"
