#!/usr/bin/env python3
"""Principal curvatures: carreau beside libigl's principal_curvature on the same meshes; see README.md."""
import os
import statistics

from common import arguments, carreau_seconds, libigl_seconds, read_obj


def main():
    a = arguments(__doc__)
    print("CPU seconds on one thread, medians; carreau: the process but for reading, libigl: the call alone\n")
    print("| file | triangles | corrected | ball | libigl | libigl / corrected | libigl / ball |\n|---|---|---|---|---|---|---|")
    for source in a.files:
        triangles = len(read_obj(source)[1])
        corrected, ball, igl = [], [], []
        for _ in range(a.runs):  # alternating, so that a busy machine is busy for all
            corrected.append(carreau_seconds(a.carreau, "curvature", source))
            igl.append(libigl_seconds(source, a.radius))
            ball.append(carreau_seconds(a.carreau, "curvature", source, "--estimator", "normal-cycle-ball"))
        c, b = statistics.median(corrected), statistics.median(ball)
        if None in igl:
            print(f"| {os.path.basename(source)} | {triangles} | {c:.3f} | {b:.3f} | failed | | |")
        else:
            i = statistics.median(igl)
            print(f"| {os.path.basename(source)} | {triangles} | {c:.3f} | {b:.3f} | {i:.3f} | {i / c:.1f} | {i / b:.1f} |")


if __name__ == "__main__":
    main()
