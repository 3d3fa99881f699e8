#!/usr/bin/env python3
"""Every independent checker over every file of the corpus, for one executable; see README.md.

One row per room and category of files. What can become of a file:
  accepted   the run succeeded and its checker refuted nothing
  refused    exit code 3 with a message that names the file, and the file has a defect or is of a kind that the room does not
             take; for a sound surface it counts as failed
  unreached  exit code 4: the method says that it could not reach what was asked
  failed     the checker refuted the result, or the run ended in another way
  timeout    the run took more than --timeout seconds of the processor

Each result is appended to OUT/rows.jsonl as it comes; a second call goes on where the first one stopped. At the end
OUT/acceptance.json and OUT/acceptance.md are written, and --docs puts the table into a page between its markers.
"""
import argparse
import glob
import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from common import commit, measured, write_between

SURFACES = {".obj", ".off", ".ply", ".stl", ".mesh", ".meshb", ".vtk", ".vtu", ".vtp", ".glb", ".gltf"}
GRAPHS = {".cgr", ".cg", ".skel", ".swc", ".tgf"}
OUTCOMES = ("accepted", "refused", "unreached", "failed", "timeout")
PACKAGES = {"cad-step": "OCP", "cad-iges": "OCP"}
CHECKER_SECONDS = 900
# hex.py and nasty.py run the verb themselves and look at the clock on the wall.
PATIENCE = 4


class Room:
    """A verb with its options, the files that it writes and the checker's call; {x} is a file of the run's folder."""

    def __init__(self, verb, checker, options=(), out="out.ply", categories=("cad", "cad_labelled", "scan", "tubular")):
        self.verb, self.options, self.out, self.categories = verb, list(options), out, categories
        self.script, *self.checks = checker


ROOMS = {
    "segment": Room("segment", ["segment.py", "{in}", "{out}", "{truth}", "--record", "{record}", "--check-fit"]),
    "simplify": Room("simplify", ["remesh.py", "{in}", "{out}", "--record", "{record}", "--same-topology", "{features}", "{angle}"],
                     ["--deviation", "14"]),
    "enrich": Room("enrich", ["remesh.py", "{in}", "{out}", "--record", "{record}", "--same-topology", "{features}", "{angle}"],
                   ["--deviation", "8"]),
    "patch": Room("patch", ["patch.py", "{in}", "{layout}", "--record", "{record}", "--output-mesh", "{out}"],
                  ["--layout", "{layout}"], "out.obj"),
    "cad-step": Room("patch", ["cad.py", "{out}", "--mesh", "{in}", "--layout", "{layout}", "--record", "{record}", "{solid}", "--mass", "1e-4"],
                     ["--layout", "{layout}"], "out.step"),
    "cad-iges": Room("patch", ["cad.py", "{out}", "--mesh", "{in}", "--layout", "{layout}", "--record", "{record}", "--no-volume", "--mass", "1e-4"],
                     ["--layout", "{layout}"], "out.igs"),
    # The checker takes every edge above the angle for a feature.
    "field": Room("field", ["field.py", "{in}", "{layout}", "--record", "{record}", "{tags}"],
                  ["--layout", "{layout}", "--feature-angle", "35"]),
    "quad": Room("quad", ["quad.py", "{in}", "{out}", "--record", "{record}", "{tags}"], ["--quads", "3000"], "out.obj"),
    "skeleton": Room("skeleton", ["hex.py", "--kind", "skeleton"], categories=("tubular",)),
    "hex": Room("hex", ["hex.py", "--kind", "surface"], categories=("tubular",)),
    "hex-pair": Room("hex", ["hex.py", "--kind", "surface", "--pair"], categories=("tubular",)),
    "hex-graph": Room("hex", ["hex.py", "--kind", "graph"], categories=("graphs", "tubular")),
    "curvature": Room("curvature", ["curvature.py", "{out}", "--truth", "{truth}", "--kmax-p95", "10%"], categories=("samples",)),
    "nasty": Room("info", ["nasty.py"], categories=("nasty",)),
}
# Built-in models with exact curvatures: options of `carreau sample` by what the checker calls their truth.
SAMPLES = {"sphere:1": ["icosphere"], "torus:1,0.4": ["torus"], "cylinder:1": ["open-cylinder"]}
NASTY_VERBS = "info,convert,repair,curvature,segment,enrich,simplify,patch,field,quad,skeleton,hex,compare,view"


def sound(entry):
    """Whether the manifest finds nothing wrong with a surface."""
    defects = ("nonmanifold_edges", "nonmanifold_vertices", "inconsistent_edges", "degenerate_triangles", "duplicate_triangles")
    return "triangles" in entry and not any(entry.get(d) for d in defects)


class Run:
    """One acceptance run: where things are."""

    def __init__(self, options):
        self.binary = os.path.abspath(shutil.which(options.carreau) or options.carreau)
        self.shared, self.timeout = Path(options.shared).resolve(), options.timeout
        self.data, self.verify = self.shared / "data", self.shared / "verify"
        with open(self.data / "manifest.json") as file:
            self.manifest = {f["name"]: f for f in json.load(file)["files"]}

    def check(self, script, *arguments, timeout=CHECKER_SECONDS):
        """A checker's exit code and what it said."""
        command = [sys.executable, "-B", str(self.verify / script), *map(str, arguments)]
        try:
            done = subprocess.run(command, cwd=self.verify, capture_output=True, text=True, timeout=timeout)
        except subprocess.TimeoutExpired:
            return None, f"the checker took more than {timeout} s"
        return done.returncode, done.stdout + done.stderr

    def one(self, job):
        """Does one job: a list of rows."""
        room, name = job
        with tempfile.TemporaryDirectory() as folder:
            if room == "nasty":
                return self.nasty(name, Path(folder))
            if ROOMS[room].script == "hex.py":
                return [self.hexes(room, name, Path(folder))]
            return [self.surface(room, name, Path(folder))]

    def surface(self, room, name, folder):
        r = ROOMS[room]
        entry = self.manifest.get(name, {})
        files = {"in": self.data / name, "out": folder / r.out, "record": folder / "record.json", "layout": folder / "layout.json"}
        if room == "curvature":
            files["in"], files["truth"] = folder / "sample.ply", name.removeprefix("samples/")
            subprocess.run([self.binary, "sample", *SAMPLES[files["truth"]], "-o", files["in"], "-q"], check=True)
        if room == "segment":
            files["truth"] = self.labels(entry, folder)
        fill = {"{" + key + "}": str(value) for key, value in files.items()}
        # Edges listed in a Medit file are features; a watertight surface must become solids.
        fill["{tags}"] = "--tags" if name.endswith((".mesh", ".meshb")) else ""
        # What is an edge of a CAD part is noise of a scan.
        fill["{features}"], fill["{angle}"] = ("--features", "35") if name.startswith("cad") else ("", "")
        fill["{solid}"] = "--solid" if entry.get("watertight") else ""
        options = [fill.get(o, o) for o in r.options]
        command = [self.binary, r.verb, files["in"], "-o", files["out"], "--json", files["record"], *options]
        code, seconds, mib, error = measured(list(map(str, command)), self.timeout)
        row = {"room": room, "file": name, "code": code, "seconds": seconds, "mib": mib}
        if code != 0:
            outcome, reason = self.refusal(code, error, os.path.basename(name), sound(entry))
            return row | {"outcome": outcome, "reason": reason}
        status, said = self.check(r.script, *[c for c in (fill.get(c, c) for c in r.checks) if c])
        wrong = [line for line in said.splitlines() if line.startswith(("FAIL", "REJECTED", "UNREADABLE"))] or said.splitlines()[-1:]
        return row | {"outcome": "failed" if status else "accepted", "reason": "; ".join(wrong)[:400] if status else ""}

    @staticmethod
    def refusal(code, error, name, is_sound):
        """What a run that did not succeed counts as, and why."""
        if code in (None, 124):
            return "timeout", ""
        last = error.strip().splitlines()[-1] if error.strip() else "no message"
        named = name in error
        if code == 3 and named and not is_sound:
            return "refused", last
        if code == 4 and error.strip():
            return "unreached", last
        extra = " (a sound surface)" if code == 3 and is_sound else "" if named else " (the message does not name the file)"
        return "failed", f"exit code {code}: {last}{extra}"

    def labels(self, entry, folder):
        """The labels that come with a part; for the others one face, so that all checks but those against the truth hold."""
        if entry.get("sidecar"):
            return self.data / entry["sidecar"]
        path = folder / "truth.json"
        path.write_text(json.dumps({"tri_face": [0] * entry["triangles"], "faces": [{"type": "freeform"}]}))
        return path

    def hexes(self, room, name, folder):
        """hex.py runs the verb itself: it knows which graphs must be refused."""
        r, path, out = ROOMS[room], self.data / name, folder / "out.json"
        said = self.check(r.script, "--batch", path.parent, "--binary", self.binary, "--pattern", glob.escape(path.name), *r.checks,
                          "--timeout", PATIENCE * self.timeout, "--allow-refused", "--json", out, timeout=CHECKER_SECONDS + PATIENCE * self.timeout)[1]
        row = {"room": room, "file": name}
        if not out.exists() or not (files := json.loads(out.read_text())["files"]):
            return row | {"code": None, "seconds": 0, "mib": 0, "outcome": "failed", "reason": said[-400:]}
        found = files[0]
        outcome = {"ok": "accepted", "timeout": "timeout"}.get(found["status"], "failed")
        if outcome == "failed" and found["code"] in (3, 4, 5) and found["status"] in ("refused", "error"):
            malformed = found["status"] == "refused"
            outcome = "unreached" if found["code"] == 4 else "refused" if malformed else "failed"
        if outcome != "accepted" and found["failed"]:
            found["reason"] = "; ".join(map(str, found["failed"]))
        return row | {"code": found["code"], "seconds": found["seconds"], "mib": found["mib"], "outcome": outcome,
                      "reason": "" if outcome == "accepted" else found["reason"][:400]}

    def nasty(self, name, folder):
        """One broken file through every verb."""
        out = folder / "out.json"
        path = self.data / name
        said = self.check("nasty.py", "--batch", path.parent, "--binary", self.binary, "--only", glob.escape(path.name), "--verbs", NASTY_VERBS,
                          "--timeout", PATIENCE * self.timeout, "--json", out, timeout=None)[1]
        if not out.exists():
            return [{"room": "nasty", "file": name, "code": None, "seconds": 0, "mib": 0, "outcome": "failed", "reason": said[-400:]}]
        rows = []
        for run in json.loads(out.read_text())["runs"]:
            wrong = "; ".join(f"{kind}: {text}" for kind, text in run["violations"])
            outcome = "failed" if wrong else {0: "accepted", 4: "unreached"}.get(run["code"], "refused")
            rows.append({"room": run["verb"], "file": name, "code": run["code"], "seconds": run["seconds"], "mib": run["mib"],
                         "outcome": outcome, "reason": wrong or ("" if run["code"] == 0 else run["stderr"].strip()[-400:])})
        return rows


def jobs(run, options, offset=0, sample=1):
    """(room, file) of everything there is, or of every sample-th file of each category."""
    for room, r in ROOMS.items():
        if options.room and room not in options.room:
            continue
        wanted = GRAPHS if room == "hex-graph" else SURFACES if r.script == "hex.py" else None
        for category in r.categories:
            if category == "samples":
                yield from ((room, f"samples/{truth}") for truth in SAMPLES)
                continue
            files = [f for f in run.manifest.values() if f["category"] == category and f["bytes"] <= 1024 * options.largest]
            if wanted:
                surface = wanted is SURFACES
                files = [f for f in files if Path(f["name"]).suffix.lower() in wanted and bool(f.get("triangles")) == surface]
            elif category != "nasty":
                # Volume meshes and graphs are no surfaces; what becomes of them is nasty.py's and hex.py's business.
                files = [f for f in files if f.get("triangles") and Path(f["name"]).suffix.lower() in SURFACES
                         and not {"Tetrahedra", "Hexahedra"} & set(f.get("cells", {}))]
            else:
                files = [f for f in files if not f["name"].endswith((".bin", ".json"))]
            for f in sorted(files, key=lambda f: f["name"])[offset::sample]:
                yield room, f["name"]


def table(rows, files):
    """Markdown: one line per room and category; `files` is how many files each of them has."""
    lines = ["| room | category | files | runs | accepted | refused | unreached | failed | timeout | median s | worst s | most MiB |",
             "|---|---|---|---|---|---|---|---|---|---|---|---|"]
    groups = {}
    for row in rows:
        groups.setdefault((row["room"], row["file"].split("/")[0]), []).append(row)
    order = list(ROOMS)
    for (room, category), part in sorted(groups.items(), key=lambda g: (g[0][1] == "nasty", order.index(g[0][0]) if g[0][0] in order else 99, g[0])):
        counts = [sum(r["outcome"] == o for r in part) for o in OUTCOMES]
        seconds = sorted(r["seconds"] for r in part)
        of = files["nasty" if category == "nasty" else room, category]
        lines.append(f"| {room} | {category} | {of} | {len(part)} | " + " | ".join(str(c) if c else "–" for c in counts)
                     + f" | {seconds[len(seconds) // 2]:.2f} | {seconds[-1]:.1f} | {max(r['mib'] for r in part):.0f} |")
    return "\n".join(lines)


def report(rows, files, options):
    """The whole generated text."""
    tried = len({(r["job"], r["file"]) for r in rows})
    sampling = "every file" if tried == sum(files.values()) else "as many files as the table says"
    builds = {}
    for r in rows:
        builds[r.get("commit", "?")] = builds.get(r.get("commit", "?"), 0) + 1
    built = ", ".join(f"{b} ({n} runs)" for b, n in builds.items()) if len(builds) > 1 else "".join(builds)
    head = (f"Commit {built}; {sampling}; {options.timeout:.0f} s of the processor for a run. {len(rows)} runs, "
            + ", ".join(f"{sum(r['outcome'] == o for r in rows)} {o}" for o in OUTCOMES) + ".\n")
    notes = []
    for outcome in ("failed", "timeout", "unreached"):
        for r in sorted((r for r in rows if r["outcome"] == outcome), key=lambda r: (r["room"], r["file"])):
            # Names of files as they are within the corpus, wherever it lies.
            folder = f"{Path(options.shared).resolve()}/data/"
            reason = r["reason"].replace(folder, "").replace("|", "\\|").replace("\n", " ")[:220]
            notes.append(f"- {outcome}: {r['room']} `{r['file']}`" + (f": {reason}" if reason else ""))
    return "\n".join([head, table(rows, files), "", *notes]).rstrip()


def summary(rows):
    """The outcome in one sentence."""
    counts = {o: sum(r["outcome"] == o for r in rows) for o in OUTCOMES}
    files = len({r["file"] for r in rows})
    return (f"{len(rows):,} runs on {files:,} files: {counts['accepted']:,} results accepted, {counts['refused']:,} inputs refused with a message that "
            f"holds, {counts['unreached']} runs that told that they could not reach what was asked, {counts['failed']} failed, {counts['timeout']} out of time.")


def main():
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    p.add_argument("--carreau", default="target/release/carreau")
    p.add_argument("--shared", default=os.environ.get("CARREAU_SHARED", "../shared"), help="folder of data/ and verify/")
    p.add_argument("--sample", type=int, default=1, metavar="N", help="every N-th file of each category")
    p.add_argument("--offset", type=int, default=0, metavar="K", help="begin with the K-th file")
    p.add_argument("--largest", type=float, default=1e9, metavar="KIB", help="no larger files")
    p.add_argument("--room", action="append", choices=ROOMS, help="these rooms only, repeatable")
    p.add_argument("--jobs", type=int, default=1)
    p.add_argument("--timeout", type=float, default=120, metavar="S")
    p.add_argument("--out", default="target/acceptance", help="folder of the results; rows that are there are not done again")
    p.add_argument("--again", action="append", default=[], choices=OUTCOMES, help="do these again, repeatable")
    p.add_argument("--mix", action="store_true", help="rows of other executables count, too: after a mend, with --again failed")
    p.add_argument("--docs", metavar="PAGE.md", help="put the table between the page's markers")
    p.add_argument("--marker", default="acceptance", metavar="NAME", help="the name of these markers")
    p.add_argument("--commit", help="what the executable was built from, default: the checkout's")
    p.add_argument("--strict", action="store_true", help="exit code 1 where something failed or took too long")
    options = p.parse_args()
    missing = sorted({package for room, package in PACKAGES.items() if not options.room or room in options.room} - {
        package for package in PACKAGES.values() if subprocess.run([sys.executable, "-c", f"import {package}"], capture_output=True).returncode == 0})
    if missing:
        p.error(f"packages are missing: {', '.join(missing)} (pip install -r SHARED/verify/requirements.txt)")
    run, out = Run(options), Path(options.out)
    out.mkdir(parents=True, exist_ok=True)
    built = options.commit or commit()
    stamp = hashlib.sha256(Path(run.binary).read_bytes()).hexdigest()[:16]
    kept = out / "rows.jsonl"
    lines = [json.loads(line) for line in kept.read_text().splitlines()] if kept.exists() else []
    # What was done again stands twice in the file: the later row counts.
    lines = list({(r["job"], r["file"], r["room"]): r for r in lines if options.mix or r["stamp"] == stamp}.values())
    again = {(r["job"], r["file"]) for r in lines if r["outcome"] in options.again}
    lines = [r for r in lines if (r["job"], r["file"]) not in again]
    done = {(r["job"], r["file"]) for r in lines}
    # What other calls have done counts, too, whatever they left out.
    wanted = set(jobs(run, options))
    rows = [r for r in lines if (r["job"], r["file"]) in wanted]
    open_jobs = [j for j in jobs(run, options, options.offset, options.sample) if j not in done]
    with ThreadPoolExecutor(options.jobs) as pool, open(kept, "a") as file:
        for job, found in zip(open_jobs, pool.map(run.one, open_jobs)):
            for row in found:
                row |= {"job": job[0], "stamp": stamp, "commit": built}
                rows.append(row)
                file.write(json.dumps(row) + "\n")
                if row["outcome"] in ("failed", "timeout"):
                    print(f"{row['outcome']} {row['room']} {row['file']}: {row['reason'][:200]}", file=sys.stderr)
            file.flush()
    text = report(rows, Counter((room, file.split("/")[0]) for room, file in wanted), options)
    (out / "acceptance.md").write_text(text + "\n")
    (out / "acceptance.json").write_text(json.dumps({"commit": built, "rows": rows}, indent=1) + "\n")
    if options.docs:
        write_between(options.docs, options.marker, text)
        if f"<!-- generated: {options.marker}-summary -->" in Path(options.docs).read_text():
            write_between(options.docs, f"{options.marker}-summary", summary(rows))
    print(text)
    return int(options.strict and any(r["outcome"] in ("failed", "timeout") for r in rows))


if __name__ == "__main__":
    sys.exit(main())
