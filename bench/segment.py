#!/usr/bin/env python3
"""Segmentation: the whole of carreau segment beside libigl's curvature alone on the same meshes; see README.md."""
import os
import statistics

from common import arguments, carreau_seconds, libigl_seconds, read_obj


def main():
    a = arguments(__doc__)
    verbs = ["curvature", "segment"]
    print("CPU seconds on one thread, medians; carreau: the process but for reading, libigl: the call alone\n")
    print("| file | triangles | curvature | segment | libigl | libigl / curvature | libigl / segment |")
    print("|---|---|---|---|---|---|---|")
    for source in a.files:
        seconds = {name: [] for name in [*verbs, "libigl"]}
        for _ in range(a.runs):  # alternating, so that a busy machine is busy for all
            for verb in verbs:
                seconds[verb].append(carreau_seconds(a.carreau, verb, source))
            seconds["libigl"].append(libigl_seconds(source, a.radius))
        row = [os.path.basename(source), str(len(read_obj(source)[1]))]
        median = {name: None if None in all else statistics.median(all) for name, all in seconds.items()}
        row += ["failed" if m is None else f"{m:.3f}" for m in median.values()]
        row += ["" if None in (median["libigl"], median[v]) else f"{median['libigl'] / median[v]:.1f}" for v in verbs]
        print("| " + " | ".join(row) + " |", flush=True)


if __name__ == "__main__":
    main()
