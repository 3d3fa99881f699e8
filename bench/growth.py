#!/usr/bin/env python3
"""Growth: time and peak memory of every verb with the number of triangles, and its exponent; see README.md.

The models are procedural: a part (bracket) and a tube tree at growing resolution. The exponent is the slope of a line through
the logarithms, from the second size on. A size that takes more than --timeout seconds ends its verb's row.
"""
import argparse
import json
import os
import subprocess
import tempfile

from common import commit, measured, write_between

PART, TUBE = "bracket", "tube-tree"
# Verb, its options with {n} for a share of the triangles, its model, the extension of the output.
VERBS = {
    "info": (["info"], PART, None),
    "convert": (["convert"], PART, "vtu"),
    "repair": (["repair"], PART, "ply"),
    "curvature": (["curvature"], PART, "ply"),
    "segment": (["segment"], PART, "ply"),
    "patch": (["patch"], PART, "obj"),
    "patch to STEP": (["patch"], PART, "step"),
    "simplify": (["simplify", "--triangles", "{n/5}"], PART, "ply"),
    "simplify --geometric": (["simplify", "--geometric", "--triangles", "{n/5}"], PART, "ply"),
    "enrich": (["enrich", "--deviation", "2"], PART, "ply"),
    "field": (["field"], PART, "ply"),
    "quad": (["quad", "--quads", "{n/4}"], PART, "obj"),
    "skeleton": (["skeleton"], TUBE, "cgr"),
    "hex": (["hex"], TUBE, "mesh"),
    "compare": (["compare"], PART, None),
    "view": (["view"], PART, "html"),
}


def sample(carreau, model, wanted, folder):
    """A model with about this many triangles: (path, triangles). Their number grows with the square of the resolution."""
    resolution, path = 64, os.path.join(folder, f"{model}-{wanted}.ply")
    for _ in range(4):
        done = subprocess.run([carreau, "sample", model, "--resolution", str(resolution), "-o", path, "-q", "--json", "-"],
                              capture_output=True, text=True, check=True)
        triangles = json.loads(done.stdout)["output"]["faces"]
        if abs(triangles - wanted) < 0.05 * wanted:
            break
        resolution = max(4, round(resolution * (wanted / triangles) ** 0.5))
    return path, triangles


def exponent(sizes, values):
    """Slope of the logarithms, by least squares; None for fewer than two sizes."""
    import numpy as np
    if len(sizes) < 2:
        return None
    return float(np.polyfit(np.log(sizes), np.log(np.maximum(values, 1e-3)), 1)[0])


def finished(row):
    return row[1] is not None and row[1] >= 0


def measure(arguments):
    """{verb: [(triangles, CPU seconds, MiB), ...]}, appended to a file as it comes."""
    found = {}
    if arguments.keep and os.path.exists(arguments.keep):
        with open(arguments.keep) as file:
            found = json.load(file)
    with tempfile.TemporaryDirectory() as folder:
        for wanted in arguments.sizes:
            models = {}
            for name, (words, model, extension) in VERBS.items():
                rows = found.setdefault(name, [])
                over = rows and (not finished(rows[-1]) or rows[-1][0] >= 0.9 * wanted)
                if over or (arguments.verb and name not in arguments.verb):
                    continue
                if model not in models:
                    models[model] = sample(arguments.carreau, model, wanted, folder)
                path, triangles = models[model]
                words = [w.replace("{n/5}", str(triangles // 5)).replace("{n/4}", str(triangles // 4)) for w in words]
                inputs = [path, path] if name == "compare" else [path]
                out = ["-o", os.path.join(folder, "out." + extension)] if extension else []
                command = [arguments.carreau, words[0], *inputs, *words[1:], *out, "-q", "--threads", "1"]
                code, seconds, mib, _ = measured(command, arguments.timeout)
                # None: over time; below zero: failed.
                rows.append([triangles, seconds if code == 0 else None if code is None else -1, mib])
                print(name, *rows[-1], flush=True)
                if arguments.keep:
                    with open(arguments.keep, "w") as file:
                        json.dump(found, file)
    return found


def table(found, sizes):
    """Markdown: seconds and bytes per triangle at the largest size done, and the exponents."""
    head = " | ".join(f"{n // 1000} k" if n < 10 ** 6 else f"{n / 1e6:g} M" for n in sizes)
    lines = [f"| verb | {head} | exponent | kB per triangle |", "|---|" + "---|" * len(sizes) + "---|---|"]
    for name, rows in found.items():
        cells = []
        for n in sizes:
            at = next((r for r in rows if abs(r[0] - n) < 0.3 * n), None)
            cells.append("–" if at is None else "over" if at[1] is None else "failed" if at[1] < 0 else f"{at[1]:.2f}" if at[1] < 10 else f"{at[1]:.0f}")
        done = [r for r in rows if finished(r)]
        late = [r for r in done if r[1] > 0.05][-4:]
        e = exponent([r[0] for r in late], [r[1] for r in late]) if len(late) > 1 else None
        memory = f"{1.048576 * 1000 * done[-1][2] / done[-1][0]:.2f}" if done else "–"
        lines.append(f"| {name} | {' | '.join(cells)} | {'–' if e is None else f'{e:.2f}'} | {memory} |")
    return "\n".join(lines)


def plot(found, path):
    """Seconds and MiB over triangles, logarithmic."""
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot as plt
    figure, axes = plt.subplots(1, 2, figsize=(11, 4.6), layout="constrained")
    styles = ["-", "--", ":", "-."]
    for k, (name, rows) in enumerate(found.items()):
        done = [r for r in rows if finished(r)]
        for axis, column in zip(axes, (1, 2)):
            axis.loglog([r[0] for r in done], [max(r[column], 1e-3) for r in done], styles[k // 10 % 4], marker="o", markersize=3,
                        color=f"C{k % 10}", label=name)
    for axis, title in zip(axes, ("CPU seconds, one thread", "peak MiB")):
        axis.set_xlabel("triangles")
        axis.set_title(title)
        axis.grid(True, which="major", alpha=0.3)
    axes[1].legend(fontsize=7, loc="upper left", ncols=2)
    figure.savefig(path, dpi=110)


def main():
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    p.add_argument("--carreau", default="target/release/carreau")
    p.add_argument("--sizes", type=int, nargs="+", default=[10_000, 30_000, 100_000, 300_000, 1_000_000, 2_000_000])
    p.add_argument("--verb", action="append", choices=VERBS, help="these only, repeatable")
    p.add_argument("--timeout", type=float, default=600, metavar="S")
    p.add_argument("--keep", metavar="FILE.json", help="results so far: what is there is not measured again")
    p.add_argument("--plot", metavar="FILE.png")
    p.add_argument("--docs", metavar="PAGE.md", help="put the table between the page's markers")
    p.add_argument("--commit", help="what the executable was built from, default: the checkout's")
    a = p.parse_args()
    found = measure(a)
    text = (f"Commit {a.commit or commit()}; CPU seconds of the process on one thread, reading and writing included; peak memory at the "
            f"largest size done.\n\n{table(found, a.sizes)}")
    if a.plot:
        plot(found, a.plot)
    if a.docs:
        write_between(a.docs, "growth", text)
    print(text)


if __name__ == "__main__":
    main()
