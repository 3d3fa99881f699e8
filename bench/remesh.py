#!/usr/bin/env python3
"""Remeshing: carreau simplify beside mmgs and MeshLab's quadric decimation at the same number of triangles; see README.md."""
import argparse
import json
import os
import subprocess
import sys
import tempfile

import numpy as np

from common import cpu_seconds, read_obj

BISECTIONS = 14


def shapes(vertices, triangles):
    """q = 4 sqrt(3) area / sum of squared edge lengths."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    squares = sum(((p - q) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a)))
    return 4 * np.sqrt(3) * area / squares


def write_medit(path, vertices, triangles):
    with open(path, "w") as out:
        out.write(f"MeshVersionFormatted 2\nDimension 3\nVertices\n{len(vertices)}\n")
        np.savetxt(out, np.c_[vertices, np.zeros(len(vertices))], fmt="%.12g %.12g %.12g %d")
        out.write(f"Triangles\n{len(triangles)}\n")
        np.savetxt(out, np.c_[triangles + 1, np.zeros(len(triangles), int)], fmt="%d")
        out.write("End\n")


def read_medit(path):
    """Vertices and triangles of what mmgs writes."""
    words = open(path).read().split()

    def block(name, width, kind):
        at = words.index(name) + 1
        count = int(words[at])
        return np.array(words[at + 1:at + 1 + count * width], kind).reshape(count, width)
    return block("Vertices", 4, float)[:, :3], block("Triangles", 4, int)[:, :3] - 1


def run_mmgs(mmgs, source, wanted, folder, *more):
    """The run whose -hausd, found by bisection, gives the wanted count: seconds and mesh."""
    vertices, triangles = read_obj(source)
    used, inverse = np.unique(triangles, return_inverse=True)
    vertices, triangles = vertices[used], inverse.reshape(-1, 3)
    medit, out = os.path.join(folder, "in.mesh"), os.path.join(folder, "out.mesh")
    write_medit(medit, vertices, triangles)
    diagonal = np.linalg.norm(np.ptp(vertices, axis=0))
    low, high = 1e-6 * diagonal, 0.1 * diagonal
    best = None
    for _ in range(BISECTIONS):
        sag = (low * high) ** 0.5
        seconds = cpu_seconds([mmgs, "-v", "0", "-in", medit, "-out", out, "-hausd", str(sag), "-hgrad", "1.5", *more])
        mesh = read_medit(out)
        best = (seconds, mesh) if best is None or abs(len(mesh[1]) - wanted) <= abs(len(best[1][1]) - wanted) else best
        if abs(len(mesh[1]) - wanted) <= 0.01 * wanted:
            break
        low, high = (sag, high) if len(mesh[1]) > wanted else (low, sag)
    return best


QEM = """
import sys, time, pymeshlab
ms = pymeshlab.MeshSet()
ms.load_new_mesh(sys.argv[1])
ms.meshing_remove_unreferenced_vertices()
start = time.process_time()
ms.meshing_decimation_quadric_edge_collapse(targetfacenum=int(sys.argv[2]), preservetopology=True, preservenormal=True,
                                            preserveboundary=True)
print(time.process_time() - start)
ms.save_current_mesh(sys.argv[3])
"""


def run_meshlab(source, wanted, folder):
    out = os.path.join(folder, "qem.obj")
    done = subprocess.run([sys.executable, "-c", QEM, source, str(wanted), out], capture_output=True, text=True)
    return (float(done.stdout.split()[-1]), read_obj(out)) if done.returncode == 0 else None


def run_carreau(carreau, source, arguments, folder):
    out = os.path.join(folder, "out.obj")
    seconds = cpu_seconds([carreau, "simplify", source, "-o", out, "--threads", "1", "-q", *arguments])
    return (seconds, read_obj(out)) if seconds is not None else None


def distance(carreau, source, mesh, folder):
    """Largest and root mean square distance, both ways, as shares of the diagonal."""
    path = os.path.join(folder, "compared.obj")
    with open(path, "w") as out:
        np.savetxt(out, mesh[0], fmt="v %.12g %.12g %.12g")
        np.savetxt(out, mesh[1] + 1, fmt="f %d %d %d")
    found = subprocess.run([carreau, "compare", source, path, "--json", "-", "-q"], capture_output=True, text=True)
    relative = json.loads(found.stdout)["relative"]
    return relative["max"], relative["rms"]


def main():
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("--carreau", default="target/release/carreau")
    p.add_argument("--mmgs", default="mmgs_O3", help="the program of the package mmgpy")
    p.add_argument("--triangles", type=int, nargs="+", default=[21437, 5094])
    p.add_argument("--deviation", type=float, nargs="+", default=[14, 36], help="one for every count")
    p.add_argument("files", nargs="*", metavar="MESH.obj")
    a = p.parse_args()
    print("CPU seconds on one thread. carreau and mmgs: the whole process, mmgs at the -hausd that gives the count; "
          "MeshLab: the call alone\n")
    print("| file | method | triangles | CPU s | shape min | shape mean | distance % | rms % |")
    print("|---|---|---|---|---|---|---|---|")
    for source in a.files:
        for wanted, angle in zip(a.triangles, a.deviation):
            with tempfile.TemporaryDirectory() as folder:
                count = ["--triangles", str(wanted)]
                runs = {
                    "carreau": run_carreau(a.carreau, source, [*count, "--deviation", str(angle)], folder),
                    "mmgs": run_mmgs(a.mmgs, source, wanted, folder),
                    "carreau --anisotropic": run_carreau(a.carreau, source, [*count, "--anisotropic"], folder),
                    "mmgs -A": run_mmgs(a.mmgs, source, wanted, folder, "-A"),
                    "carreau --geometric": run_carreau(a.carreau, source, [*count, "--geometric"], folder),
                    "MeshLab quadrics": run_meshlab(source, wanted, folder),
                }
                for method, run in runs.items():
                    if run is None:
                        print(f"| {os.path.basename(source)} | {method} | failed | | | | | |", flush=True)
                        continue
                    seconds, mesh = run
                    q = shapes(*mesh)
                    far, rms = distance(a.carreau, source, mesh, folder)
                    print(f"| {os.path.basename(source)} | {method} | {len(mesh[1])} | {seconds:.2f} | {q.min():.3f} | "
                          f"{q.mean():.3f} | {100 * far:.3f} | {100 * rms:.4f} |", flush=True)


if __name__ == "__main__":
    main()
