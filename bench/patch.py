#!/usr/bin/env python3
"""Quad pairing: carreau beside Gmsh and MeshLab on the same files; see README.md."""
import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile

import numpy as np

from common import measured, read_obj

OURS = {
    "carreau default": ["patch"],
    "carreau matching": ["patch", "--strategy", "matching", "--min-cells", "1"],
    "carreau cardinality": ["patch", "--strategy", "matching-cardinality", "--min-cells", "1"],
}

# Peers whose share of paired triangles carreau is asked for, too: shapes compare at the same share alone.
SHARED_WITH = ("gmsh blossom", "meshlab shape")
# Halvings of 90 degrees: .02 degrees, less than a table shows.
BISECTIONS = 12


def gmsh_recombine(source, target, algorithm):
    """Recombines the discrete surface of an OBJ file, vertices fixed."""
    import gmsh
    vertices, triangles = read_obj(source)
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Mesh.RecombinationAlgorithm", algorithm)
    gmsh.option.setNumber("Mesh.RecombineNodeRepositioning", 0)
    gmsh.option.setNumber("Mesh.RecombineOptimizeTopology", 0)
    gmsh.option.setNumber("Mesh.RecombineMinimumQuality", 1e-3)
    tag = gmsh.model.addDiscreteEntity(2)
    gmsh.model.mesh.addNodes(2, tag, np.arange(1, len(vertices) + 1), vertices.ravel())
    gmsh.model.mesh.addElementsByType(tag, 2, [], (triangles + 1).ravel())
    gmsh.model.mesh.setRecombine(2, tag)
    gmsh.model.mesh.recombine()
    quads = gmsh.model.mesh.getElementsByType(3)[1].reshape(-1, 4).astype(np.int64) - 1
    np.save(target, quads)
    gmsh.finalize()


def meshlab_pair(source, target, level):
    """MeshLab's quad-dominant pairing; the quads are read back from its OBJ file."""
    import pymeshlab
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(source)
    meshes.apply_filter("meshing_tri_to_quad_dominant", level=level)
    out = target + ".obj"
    meshes.save_current_mesh(out)
    quads = []
    with open(out) as lines:
        for line in lines:
            if line.startswith("f "):
                ids = [int(word.split("/")[0]) - 1 for word in line.split()[1:]]
                if len(ids) == 4:
                    quads.append(ids)
    np.save(target, np.array(quads, np.int64).reshape(-1, 4))


def judge(vertices, triangles, quads):
    """(share of triangles in true pairs, mean Q in degrees, bad quads)."""
    n = len(vertices)

    def key(t):
        t = np.sort(t, axis=1)
        return (t[:, 0] * n + t[:, 1]) * n + t[:, 2] if n < 2_000_000 else None
    known = np.sort(key(triangles))

    def has(t):
        k = key(t)
        at = np.minimum(np.searchsorted(known, k), len(known) - 1)
        return known[at] == k

    def angle(o, a, b):
        u, v = vertices[a] - vertices[o], vertices[b] - vertices[o]
        return np.degrees(np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), (u * v).sum(axis=1)))
    a, b, c, d = quads.T
    first = has(quads[:, [0, 1, 2]]) & has(quads[:, [0, 2, 3]])
    second = has(quads[:, [0, 1, 3]]) & has(quads[:, [1, 2, 3]]) & ~first
    corners = np.stack([
        np.where(first, angle(a, b, c) + angle(a, c, d), angle(a, b, d)),
        np.where(first, angle(b, c, a), angle(b, d, a) + angle(b, c, d)),
        np.where(first, angle(c, a, b) + angle(c, d, a), angle(c, d, b)),
        np.where(first, angle(d, a, c), angle(d, a, b) + angle(d, b, c)),
    ], axis=1)[first | second]
    q = np.abs(90 - corners).mean(axis=1)
    return 2 * len(corners) / len(triangles), q.mean(), int((corners.max(axis=1) > 150).sum())


def carreau_quads(layout):
    with open(layout) as file:
        patches = json.load(file)["patches"]
    out = []
    for p in patches:
        g = np.array(p["vertices"]).reshape(p["rows"] + 1, p["cols"] + 1)
        out.append(np.stack([g[:-1, :-1], g[:-1, 1:], g[1:, 1:], g[1:, :-1]], axis=-1).reshape(-1, 4))
    return np.concatenate(out), len(patches)


def at_share(carreau, source, triangles, share, folder):
    """Options with which as many triangles are paired as `share`, and a few more: the least --q-max that does."""
    low, high = 0.0, 90.0
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        options = [*OURS["carreau matching"], "--q-max", f"{middle:.3f}"]
        layout = os.path.join(folder, "share.json")
        subprocess.run([carreau, options[0], source, *options[1:], "--layout", layout, "-q"], check=True, stdout=subprocess.DEVNULL)
        paired = 2 * len(carreau_quads(layout)[0]) / triangles
        low, high = (low, middle) if paired >= share else (middle, high)
    return [*OURS["carreau matching"], "--q-max", f"{high:.3f}"]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--carreau", default="target/release/carreau")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--peer", nargs=3, metavar=("NAME", "IN", "OUT"), help=argparse.SUPPRESS)
    parser.add_argument("files", nargs="*", metavar="MESH.obj")
    a = parser.parse_args()
    peers = {"gmsh simple": lambda s, t: gmsh_recombine(s, t, 0), "gmsh blossom": lambda s, t: gmsh_recombine(s, t, 1),
             "meshlab fewest": lambda s, t: meshlab_pair(s, t, 0), "meshlab shape": lambda s, t: meshlab_pair(s, t, 2)}
    if a.peer:
        return peers[a.peer[0]](a.peer[1], a.peer[2])
    print("| file | tool | CPU s | MiB | paired | mean Q | bad | patches |\n|---|---|---|---|---|---|---|---|")
    for source in a.files:
        vertices, triangles = read_obj(source)
        with tempfile.TemporaryDirectory() as folder:
            runs, results = {}, {}

            def of_peer(name):
                out = os.path.join(folder, "quads.npy")
                runs.setdefault(name, []).append(measured([sys.executable, __file__, "--peer", name, source, out]))
                if runs[name][-1][0] == 0:
                    results[name] = np.load(out), None

            def of_carreau(name, options):
                layout = os.path.join(folder, "layout.json")
                runs.setdefault(name, []).append(measured([a.carreau, *options[:1], source, *options[1:], "--layout", layout]))
                results[name] = carreau_quads(layout)
            for name in peers:
                of_peer(name)
            ours = dict(OURS)
            for name in (name for name in SHARED_WITH if name in results):
                share = judge(vertices, triangles, results[name][0])[0]
                ours[f"carreau at the share of {name}"] = at_share(a.carreau, source, len(triangles), share, folder)
            for again in range(a.runs):  # alternating, so that a busy machine is busy for all
                for name, options in ours.items():
                    of_carreau(name, options)
                for name in peers if again else ():
                    of_peer(name)
            for name in (*ours, *peers):
                done = [f for f in runs[name] if f[0] == 0]
                if name not in results or not done:
                    print(f"| {os.path.basename(source)} | {name} | failed | | | | | |")
                    continue
                quads, patches = results[name]
                share, q, bad = judge(vertices, triangles, quads)
                seconds, mib = (statistics.median(f[k] for f in done) for k in (1, 2))
                print(f"| {os.path.basename(source)} | {name} | {seconds:.2f} | {mib:.0f} | {100 * share:.2f} % | {q:.1f}° | {bad} "
                      f"| {patches or '–'} |")


if __name__ == "__main__":
    main()
