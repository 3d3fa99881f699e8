#!/usr/bin/env python3
"""Principal curvatures: carreau beside libigl's principal_curvature on the same meshes; see README.md."""
import argparse
import os
import statistics

from common import cpu_seconds, libigl_seconds, read_obj


def carreau_seconds(binary, source, estimator):
    """CPU seconds of the whole process on one thread, reading included."""
    return cpu_seconds([binary, "curvature", source, "--estimator", estimator, "--threads", "1", "-q"])


def main():
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("--carreau", default="target/release/carreau")
    p.add_argument("--runs", type=int, default=5)
    p.add_argument("--radius", type=int, default=5, help="libigl's, default 5 as there")
    p.add_argument("files", nargs="*", metavar="MESH.obj")
    a = p.parse_args()
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
