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

from common import read_obj

PEERS = {
    "carreau default": ["patch"],
    "carreau matching": ["patch", "--strategy", "matching", "--min-cells", "1"],
    "carreau cardinality": ["patch", "--strategy", "matching-cardinality", "--min-cells", "1"],
}


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


def timed(command):
    """(CPU seconds, peak MiB) of one process."""
    with tempfile.NamedTemporaryFile("w+") as usage:
        code = ("import resource,subprocess,sys;r=subprocess.run(sys.argv[2:],stdout=subprocess.DEVNULL,stderr=subprocess.DEVNULL);"
                "u=resource.getrusage(resource.RUSAGE_CHILDREN);"
                "open(sys.argv[1],'w').write(f'{r.returncode} {u.ru_utime+u.ru_stime} {u.ru_maxrss/1024}')")
        subprocess.run([sys.executable, "-S", "-c", code, usage.name, *command], check=True)
        status, seconds, mib = open(usage.name).read().split()
    return (float(seconds), float(mib)) if status == "0" else None


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
            for _ in range(a.runs):
                for name, options in PEERS.items():
                    layout = os.path.join(folder, "layout.json")
                    runs.setdefault(name, []).append(timed([a.carreau, *options[:1], source, *options[1:], "--layout", layout]))
                    results[name] = carreau_quads(layout)
                for name in peers:
                    out = os.path.join(folder, "quads.npy")
                    runs.setdefault(name, []).append(timed([sys.executable, __file__, "--peer", name, source, out]))
                    if runs[name][-1]:
                        results[name] = np.load(out), None
            for name, figures in runs.items():
                if name not in results or None in figures:
                    print(f"| {os.path.basename(source)} | {name} | failed | | | | | |")
                    continue
                quads, patches = results[name]
                share, q, bad = judge(vertices, triangles, quads)
                seconds, mib = (statistics.median(f[k] for f in figures) for k in (0, 1))
                print(f"| {os.path.basename(source)} | {name} | {seconds:.2f} | {mib:.0f} | {100 * share:.2f} % | {q:.1f}° | {bad} "
                      f"| {patches or '–'} |")


if __name__ == "__main__":
    main()
