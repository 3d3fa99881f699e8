#!/usr/bin/env python3
"""Decimation by the numbers: carreau simplify (graded and geometric) beside the decimators of PyPI; see README.md.

All to the same number of triangles. Measured: CPU seconds of the process with reading and writing, peak memory, shape of the
triangles, and the two-sided distance by `carreau compare`.
"""
import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile

from common import measured, read_obj

PEERS = {}


def peer(name):
    return lambda function: PEERS.setdefault(name, function)


@peer("MeshLab")
def meshlab(source, target, count):
    import pymeshlab
    ms = pymeshlab.MeshSet()
    ms.load_new_mesh(source)
    ms.meshing_decimation_quadric_edge_collapse(targetfacenum=count, preservetopology=True, preservenormal=True, preserveboundary=True)
    ms.save_current_mesh(target)


@peer("fast-simplification")
def fast(source, target, count):
    import fast_simplification
    vertices, triangles = read_obj(source)
    v, f = fast_simplification.simplify(vertices, triangles, target_count=count)
    save(target, v, f)


@peer("meshoptimizer")
def meshopt(source, target, count):
    import meshoptimizer
    import numpy as np
    vertices, triangles = read_obj(source)
    v, ids = vertices.astype(np.float32), triangles.astype(np.uint32).ravel()
    out = np.zeros(len(ids), np.uint32)
    n = meshoptimizer.simplify(out, ids, v, len(ids), len(v), v.strides[0], 3 * count, 1.0)
    save(target, v, out[:n].reshape(-1, 3))


@peer("ACVD")
def acvd(source, target, count):
    import numpy as np
    import pyacvd
    import pyvista
    vertices, triangles = read_obj(source)
    clusters = pyacvd.Clustering(pyvista.PolyData.from_regular_faces(vertices, triangles.astype(np.int64)))
    clusters.subdivide(2)
    clusters.cluster(count // 2)
    mesh = clusters.create_mesh()
    save(target, mesh.points, mesh.regular_faces)


def save(path, vertices, triangles):
    import numpy as np
    with open(path, "w") as out:
        np.savetxt(out, vertices, fmt="v %.9g %.9g %.9g")
        np.savetxt(out, np.asarray(triangles, dtype=np.int64) + 1, fmt="f %d %d %d")


def shapes(path):
    """Smallest and mean q = 4 sqrt(3) area / sum of squared edges."""
    import numpy as np
    vertices, triangles = read_obj(path)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    squares = sum(((p - q) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a)))
    q = 2 * np.sqrt(3) * np.linalg.norm(np.cross(b - a, c - a), axis=1) / np.maximum(squares, 1e-300)
    return len(triangles), q.min(), q.mean()


def main():
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    p.add_argument("--carreau", default="target/release/carreau")
    p.add_argument("--runs", type=int, default=3)
    p.add_argument("--share", type=float, default=0.1, help="triangles kept")
    p.add_argument("--timeout", type=float, default=300, metavar="S")
    p.add_argument("--peer", nargs=3, metavar=("NAME", "IN", "OUT"), help=argparse.SUPPRESS)
    p.add_argument("--count", type=int, help=argparse.SUPPRESS)
    p.add_argument("files", nargs="*", metavar="MESH")
    a = p.parse_args()
    if a.peer:
        PEERS[a.peer[0]](a.peer[1], a.peer[2], a.count)
        return
    print("| file | tool | triangles | CPU s | MiB | shape min | shape mean | distance % | rms % |\n|---|---|---|---|---|---|---|---|---|")
    for source in a.files:
        with tempfile.TemporaryDirectory() as folder:
            mesh = os.path.join(folder, "in.obj")
            subprocess.run([a.carreau, "repair", source, "-o", mesh, "-q"], check=True)
            count = round(a.share * len(read_obj(mesh)[1]))
            ours = [a.carreau, "simplify", mesh, "--triangles", str(count), "--threads", "1", "-q"]
            commands = {"carreau": ours, "carreau --geometric": [*ours, "--geometric"]}
            commands |= {name: [sys.executable, __file__, "--count", str(count), "--peer", name, mesh] for name in PEERS}
            runs = {}
            for _ in range(a.runs):
                for name, command in commands.items():
                    out = os.path.join(folder, name.replace(" ", "") + ".obj")
                    runs.setdefault(name, []).append(measured([*command, *(["-o"] if name not in PEERS else []), out], a.timeout))
            for name, found in runs.items():
                out = os.path.join(folder, name.replace(" ", "") + ".obj")
                done = [f for f in found if f[0] == 0]
                if not done or not os.path.exists(out):
                    print(f"| {os.path.basename(source)} | {name} | failed | | | | | | |", flush=True)
                    continue
                n, worst, mean = shapes(out)
                told = subprocess.run([a.carreau, "compare", mesh, out, "--json", "-", "-q"], capture_output=True, text=True)
                far = json.loads(told.stdout)["relative"] if told.returncode == 0 else {"max": float("nan"), "rms": float("nan")}
                seconds, mib = (statistics.median(f[k] for f in done) for k in (1, 2))
                print(f"| {os.path.basename(source)} | {name} | {n} | {seconds:.2f} | {mib:.0f} | {worst:.3f} | {mean:.3f} | "
                      f"{100 * far['max']:.3f} | {100 * far['rms']:.4f} |", flush=True)


if __name__ == "__main__":
    main()
