#!/usr/bin/env python3
"""Principal curvatures: carreau beside libigl's principal_curvature on the same meshes; see README.md."""
import argparse
import os
import statistics
import subprocess
import sys
import time

import numpy as np


def read_obj(path):
    """Vertices and triangles of an OBJ file; polygons are fanned."""
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


def libigl_seconds(source, radius):
    """CPU seconds of libigl alone, in a process of its own: adjacency included, reading not."""
    out = subprocess.run([sys.executable, __file__, "--peer", source, str(radius)], capture_output=True, text=True)
    return float(out.stdout) if out.returncode == 0 and out.stdout else None


def peer(source, radius):
    import igl
    vertices, faces = read_obj(source)
    start = time.process_time()
    igl.principal_curvature(vertices, faces, radius)
    print(time.process_time() - start)


def carreau_seconds(binary, source, estimator):
    """CPU seconds of the whole process on one thread, reading included."""
    before = os.times()
    subprocess.run([binary, "curvature", source, "--estimator", estimator, "--threads", "1", "-q"], check=True)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def main():
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("--carreau", default="target/release/carreau")
    p.add_argument("--runs", type=int, default=5)
    p.add_argument("--radius", type=int, default=5, help="libigl's, default 5 as there")
    p.add_argument("--peer", nargs=2, help=argparse.SUPPRESS)
    p.add_argument("files", nargs="*", metavar="MESH.obj")
    a = p.parse_args()
    if a.peer:
        return peer(a.peer[0], int(a.peer[1]))
    print("CPU seconds, medians; carreau: the whole process with reading, libigl: the call alone\n")
    print("| file | triangles | corrected | ball | libigl | libigl / corrected | libigl / ball |\n|---|---|---|---|---|---|---|")
    for source in a.files:
        triangles = len(read_obj(source)[1])
        corrected, ball, igl = [], [], []
        for _ in range(a.runs):  # alternating, so that a busy machine is busy for all
            corrected.append(carreau_seconds(a.carreau, source, "corrected"))
            igl.append(libigl_seconds(source, a.radius))
            ball.append(carreau_seconds(a.carreau, source, "normal-cycle-ball"))
        c, b = statistics.median(corrected), statistics.median(ball)
        if None in igl:
            print(f"| {os.path.basename(source)} | {triangles} | {c:.3f} | {b:.3f} | failed | | |")
        else:
            i = statistics.median(igl)
            print(f"| {os.path.basename(source)} | {triangles} | {c:.3f} | {b:.3f} | {i:.3f} | {i / c:.1f} | {i / b:.1f} |")


if __name__ == "__main__":
    main()
