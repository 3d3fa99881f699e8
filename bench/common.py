"""What the measurements share."""
import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time

import numpy as np


def arguments(description):
    """The command line of the measurements beside libigl."""
    p = argparse.ArgumentParser(description=description)
    p.add_argument("--carreau", default="target/release/carreau")
    p.add_argument("--runs", type=int, default=5)
    p.add_argument("--radius", type=int, default=5, help="libigl's, default 5 as there")
    p.add_argument("files", nargs="*", metavar="MESH.obj")
    return p.parse_args()


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


if __name__ == "__main__":
    import igl
    vertices, faces = read_obj(sys.argv[1])
    start = time.process_time()
    igl.principal_curvature(vertices, faces, int(sys.argv[2]))
    print(time.process_time() - start)
