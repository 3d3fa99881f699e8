"""What the measurements share."""
import argparse
import json
import os
import resource
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path


def arguments(description):
    """The command line of the measurements beside libigl."""
    p = argparse.ArgumentParser(description=description)
    p.add_argument("--carreau", default="target/release/carreau")
    p.add_argument("--runs", type=int, default=5)
    p.add_argument("--radius", type=int, default=5, help="libigl's, default 5 as there")
    p.add_argument("files", nargs="*", metavar="MESH.obj")
    return p.parse_args()


def peer_parser(doc):
    """What the measurements beside peers that run in processes of their own (--peer) have in common."""
    p = argparse.ArgumentParser(description=doc.splitlines()[0])
    p.add_argument("--carreau", default="target/release/carreau")
    p.add_argument("--runs", type=int, default=3)
    p.add_argument("--timeout", type=float, default=300, metavar="S")
    p.add_argument("--docs", metavar="PAGE.md", help="put the table between the page's markers")
    p.add_argument("--peer", nargs=3, metavar=("NAME", "IN", "OUT"), help=argparse.SUPPRESS)
    p.add_argument("files", nargs="*", metavar="MESH")
    return p


def read_obj(path):
    """Vertices and triangles of an OBJ file; polygons are fanned."""
    import numpy as np
    vertices, faces = [], []
    with open(path) as lines:
        for line in lines:
            words = line.split()
            if words and words[0] == "v":
                vertices.append([float(x) for x in words[1:4]])
            elif words and words[0] == "f":
                ids = [int(w.split("/")[0]) for w in words[1:]]
                ids = [i - 1 if i > 0 else len(vertices) + i for i in ids]
                faces += [[ids[0], ids[k], ids[k + 1]] for k in range(1, len(ids) - 1)]
    return np.array(vertices), np.array(faces, np.int64)


def commit():
    """What the checkout is at, with a plus where files have changed."""
    def git(*arguments):
        done = subprocess.run(["git", *arguments], cwd=Path(__file__).parent, capture_output=True, text=True)
        return done.stdout.strip()
    return git("rev-parse", "--short", "HEAD") + ("+" if git("status", "--porcelain", "--untracked-files=no") else "")


def around(page, name):
    """The text of a page before, between and after the markers of that name; both must be there."""
    begin, end = f"<!-- generated: {name} -->", f"<!-- end: {name} -->"
    before, found, rest = Path(page).read_text().partition(begin)
    between, closed, after = rest.partition(end)
    if not found or not closed:
        raise SystemExit(f"{page}: the markers {begin} and {end} are missing")
    return before + begin, between, end + after


def write_between(page, name, text):
    """Puts text between the page's markers of that name; other text stays."""
    before, _, after = around(page, name)
    Path(page).write_text(f"{before}\n\n{text.strip()}\n\n{after}")


# A child's peak memory begins at its parent's, so a small process in between starts and measures it.
MEASURE = """
import resource, subprocess, sys
if float(sys.argv[2]):
    resource.setrlimit(resource.RLIMIT_CPU, (int(float(sys.argv[2])) + 1,) * 2)
status = subprocess.run(sys.argv[3:], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL).returncode
usage = resource.getrusage(resource.RUSAGE_CHILDREN)
print(status, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, file=open(sys.argv[1], "w"))
"""


def measured(command, timeout=None):
    """(exit code or None where the time was over, CPU seconds, peak MiB, stderr) of one process. The time is the processor's,
    so that a busy machine changes nothing; what waits without working is ended after ten times as long."""
    with tempfile.TemporaryFile() as errors, tempfile.NamedTemporaryFile("r") as usage:
        process = subprocess.Popen([sys.executable, "-S", "-c", MEASURE, usage.name, str(timeout or 0), *command], stderr=errors, start_new_session=True)
        try:
            process.wait(10 * timeout if timeout else None)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        errors.seek(0)
        said = errors.read().decode("utf-8", "replace")
        found = usage.read().split()
    if not found:
        return None, float(timeout or 0), 0.0, said
    over = int(found[0]) in (-signal.SIGXCPU, -signal.SIGKILL) and timeout and float(found[1]) > timeout
    return None if over else int(found[0]), float(found[1]), float(found[2]), said


def cpu_seconds(command):
    """CPU seconds of a process, with everything that it does; None where it fails."""
    def spent():
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime
    before = spent()
    status = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode
    return spent() - before if status == 0 else None


def carreau_seconds(binary, verb, source, *options):
    """CPU seconds of the process on one thread but for the share that its record gives to reading; None where it fails."""
    with tempfile.TemporaryDirectory() as folder:
        record = os.path.join(folder, "record.json")
        seconds = cpu_seconds([binary, verb, source, "--threads", "1", "-q", "--json", record, *options])
        if seconds is None:
            return None
        with open(record) as file:
            stages = json.load(file)["seconds"]
        return seconds * (1 - stages["read"] / stages["total"])


def libigl_seconds(source, radius):
    """CPU seconds of libigl's principal_curvature alone, in a process of its own: adjacency included, reading not."""
    out = subprocess.run([sys.executable, __file__, source, str(radius)], capture_output=True, text=True)
    return float(out.stdout) if out.returncode == 0 and out.stdout else None


def beside_libigl(a, verbs):
    """Prints a table of CPU seconds: verbs of carreau by the names of their rows, and libigl's principal_curvature."""
    print("CPU seconds on one thread, medians; carreau: the process but for reading, libigl: the call alone\n")
    print("| file | tool | triangles | CPU s |\n|---|---|---|---|")
    for source in a.files:
        seconds = {name: [] for name in (*verbs, "libigl")}
        for _ in range(a.runs):  # alternating, so that a busy machine is busy for all
            for name, verb in verbs.items():
                seconds[name].append(carreau_seconds(a.carreau, verb[0], source, *verb[1:]))
            seconds["libigl"].append(libigl_seconds(source, a.radius))
        triangles = len(read_obj(source)[1])
        for name, found in seconds.items():
            median = "failed" if None in found else f"{statistics.median(found):.3f}"
            print(f"| {os.path.basename(source)} | {name} | {triangles} | {median} |", flush=True)


if __name__ == "__main__":
    import igl
    vertices, faces = read_obj(sys.argv[1])
    start = time.process_time()
    igl.principal_curvature(vertices, faces, int(sys.argv[2]))
    print(time.process_time() - start)
