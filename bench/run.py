#!/usr/bin/env python3
"""The whole comparison in one command: installs the peers from PyPI, runs every room's script, writes the tables.

    python3 bench/run.py                      all rooms on the default files of the corpus, tables into docs/comparison.md
    python3 bench/run.py quad hex             these rooms only: the other tables stay
    python3 bench/run.py remesh --files a.obj b.obj
    python3 bench/run.py --check              writes nothing; tells figures more than a tenth worse than the page's, exit 1

The peers go into a venv of their own (--venv, default target/bench/venv). A peer without a package for this machine is
left out of its tables, and named. Everything runs one process at a time, carreau and the peers in turns.
"""
import argparse
import datetime
import os
import platform
import subprocess
import sys
import venv
from pathlib import Path

from common import around, commit, write_between
from tables import compared, worse

ROOT = Path(__file__).resolve().parent.parent
ALWAYS = ["numpy", "scipy", "matplotlib", "trimesh"]
# Room: its packages, what its script is given, the files of the corpus that it runs on.
ROOMS = {
    "curvature": (["libigl"], [], ["scan/stanford-bunny.obj", "scan/kitten.obj", "cad/fandisk.obj"]),
    "segment": (["libigl"], [], ["scan/stanford-bunny.obj", "cad/fandisk.obj"]),
    "patch": (["gmsh", "pymeshlab"], [], ["scan/stanford-bunny.obj", "cad/fandisk.obj"]),
    "remesh": (["mmgpy", "pymeshlab"], ["--mmgs", "{bin}/mmgs_O3"], ["scan/stanford-bunny.obj", "cad/fandisk.obj"]),
    "decimate": (["pymeshlab", "fast-simplification", "meshoptimizer", "pyacvd", "pyvista"], [],
                 ["scan/stanford-bunny.obj", "cad/fandisk.obj", "cad/rocker-arm.obj"]),
    "quad": (["pyquadriflow", "pynanoinstantmeshes", "gmsh"], ["--shared", "{shared}"], [
        "cad/fandisk.obj", "cad/rocker-arm.obj", "cad/mambo_B0.mesh", "cad/mambo_B12.mesh", "cad/mambo_B18.mesh", "cad/mambo_M6.mesh",
        "cad_labelled/box_fillet_a_iso.ply", "cad_labelled/conrod_a_iso.ply", "cad_labelled/engine_mount_a_iso.ply",
        "cad_labelled/flange_a_iso.ply", "cad_labelled/gear_straight_a_iso.ply", "cad_labelled/pipe_elbow_a_iso.ply",
        "cad_labelled/stepped_shaft_a_iso.ply", "cad_labelled/u_bracket_a_iso.ply",
        "scan/kitten.obj"]),
    "acute": (["gmsh", "cadquery-ocp"], ["--shared", "{shared}"], []),
    "hex": (["compas_cgal", "skeletor"], [], ["tubular/cactus.obj", "tubular/dinopet.obj", "tubular/elephant.obj", "tubular/bigbuddy.obj",
                                               "tubular/tube_tree01.ply", "tubular/tube_y4.ply"]),
}
# Which tools do the same work; all of a table where nothing is said.
BESIDE = {
    # Patches are made by none; the shapes of pairs compare at the same share of triangles.
    "patch": {"carreau default": [], "carreau matching": ["meshlab fewest"], "carreau cardinality": [],
              "carreau at the share of gmsh blossom": ["gmsh blossom"],
              "carreau at the share of meshlab shape": ["meshlab shape"]},
    "remesh": {"carreau": ["mmgs"], "carreau --anisotropic": ["mmgs -A"], "carreau --geometric": ["MeshLab quadrics"]},
    # Even triangles, and triangles where the surface bends.
    "decimate": {"carreau": ["ACVD"], "carreau --geometric": ["MeshLab", "fast-simplification", "meshoptimizer"]},
}
TAKES_RUNS = {"curvature", "segment", "patch", "quad", "acute", "hex", "decimate"}


def python_of(folder, packages):
    """The venv's Python, with these packages as far as there are any for this machine; (python, missing)."""
    python = folder / "bin" / "python"
    # One that was cut short has no pip.
    if not python.exists() or subprocess.run([python, "-m", "pip", "--version"], capture_output=True).returncode != 0:
        venv.create(folder, clear=True, with_pip=True)
    missing = []
    for package in dict.fromkeys(packages):
        done = subprocess.run([python, "-m", "pip", "install", "--quiet", "--only-binary", ":all:", package], capture_output=True, text=True)
        if done.returncode != 0:
            missing.append(package)
            print(f"left out: {package}: {(done.stderr.strip().splitlines() or ['?'])[-1]}", file=sys.stderr)
    return python, missing


def versions(python, packages):
    code = ("import importlib.metadata as m, sys\n"
            "for p in sys.argv[1:]:\n"
            "    try: print(p, m.version(p))\n"
            "    except m.PackageNotFoundError: pass")
    return subprocess.run([python, "-c", code, *packages], capture_output=True, text=True).stdout.splitlines()


def found(patterns, data):
    """The files of the corpus, the first of each pattern."""
    return [path for pattern in patterns for path in sorted(data.glob(pattern))[:1]]


def main():
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    p.add_argument("rooms", nargs="*", metavar="ROOM", help=f"default: {' '.join(ROOMS)}")
    p.add_argument("--carreau", default=str(ROOT / "target/release/carreau"))
    p.add_argument("--shared", default=os.environ.get("CARREAU_SHARED", str(ROOT / "../shared")), help="folder of data/ and verify/")
    p.add_argument("--files", nargs="+", help="instead of those of the corpus")
    p.add_argument("--runs", type=int, default=3)
    p.add_argument("--venv", default=str(ROOT / "target/bench/venv"))
    p.add_argument("--docs", default=str(ROOT / "docs/comparison.md"))
    p.add_argument("--check", action="store_true", help="tell what is worse than in the page, and leave it as it is")
    p.add_argument("--commit", help="what the executable was built from, default: the checkout's")
    a = p.parse_args()
    unknown = sorted(set(a.rooms) - set(ROOMS))
    if unknown:
        p.error(f"no such room: {', '.join(unknown)} (known: {' '.join(ROOMS)})")
    carreau, shared = os.path.abspath(a.carreau), Path(a.shared).resolve()
    if not os.path.exists(carreau):
        p.error(f"{carreau} is missing: cargo build --release, or --carreau FILE")
    failed, fallen = [], []
    for room in a.rooms or ROOMS:
        packages, options, patterns = ROOMS[room]
        python, missing = python_of(Path(a.venv), [*ALWAYS, *packages])
        files = a.files or found(patterns, shared / "data")
        fill = {"{bin}": str(python.parent), "{shared}": str(shared)}
        for key, value in fill.items():
            options = [o.replace(key, value) for o in options]
        runs = ["--runs", str(a.runs)] if room in TAKES_RUNS else []
        command = [python, Path(__file__).with_name(f"{room}.py"), "--carreau", carreau, *runs, *options, *files]
        done = subprocess.run(list(map(str, command)), cwd=ROOT, stdout=subprocess.PIPE, text=True)
        if done.returncode != 0 or "|" not in done.stdout:
            failed.append(room)
            continue
        table = compared(done.stdout, BESIDE.get(room, {}))
        if a.check:
            fallen += [f"{room}: {said}" for said in worse(table, around(a.docs, room)[1])]
            continue
        told = ", ".join(versions(python, packages)) + (f"; not installable here: {', '.join(missing)}" if missing else "")
        where = f"{platform.machine()}, {os.cpu_count()} processors, {datetime.date.today()}"
        write_between(a.docs, room, f"Commit {a.commit or commit()}; {told}; {where}; medians of {a.runs}.\n\n{table}")
        print(f"{room}: table written to {a.docs}")
    print(*fallen, sep="\n", end="\n" if fallen else "")
    if failed:
        raise SystemExit(f"failed: {', '.join(failed)}")
    if fallen:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
