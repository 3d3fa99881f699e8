#!/usr/bin/env python3
"""Skeletons: carreau skeleton beside CGAL's mean curvature flow (compas_cgal) and skeletor's wavefronts; see README.md.

Measured: CPU seconds of the process with reading and writing, peak memory, nodes, cycles beside the genus of the surface, and
the share of the nodes that lie inside. Hexahedra along skeletons have no peer on PyPI; what carreau's are worth is in docs/hex.md.
"""
import json
import os
import statistics
import subprocess
import sys
import tempfile

from common import measured, peer_parser, read_obj, write_between

PEERS = {}


def peer(name):
    return lambda function: PEERS.setdefault(name, function)


@peer("CGAL")
def cgal(source, target):
    from compas_cgal.skeletonization import mesh_skeleton
    vertices, triangles = read_obj(source)
    lines = mesh_skeleton((vertices.tolist(), triangles.tolist()))
    save(target, [(tuple(map(float, a)), tuple(map(float, b))) for a, b in lines])


@peer("skeletor")
def wavefront(source, target):
    import skeletor
    import trimesh
    vertices, triangles = read_obj(source)
    mesh = skeletor.pre.fix_mesh(trimesh.Trimesh(vertices, triangles, process=False), remove_disconnected=0)
    found = skeletor.skeletonize.by_wavefront(mesh, waves=1, step_size=1, progress=False)
    points = {int(i): tuple(p) for i, p in zip(found.swc.node_id, found.swc[["x", "y", "z"]].values.tolist())}
    save(target, [(points[int(p)], points[int(i)]) for i, p in zip(found.swc.node_id, found.swc.parent_id) if p >= 0])


def save(target, segments):
    with open(target, "w") as out:
        json.dump(segments, out)


def segments_of(path):
    """Segments of a .cgr file or of a peer's list, as pairs of points."""
    if path.endswith(".json"):
        with open(path) as file:
            return [tuple(map(tuple, s)) for s in json.load(file)]
    points, segments = [], []
    with open(path) as file:
        for words in map(str.split, file):
            if words and words[0] == "v":
                points.append(tuple(map(float, words[1:4])))
            elif words and words[0] == "e":
                segments.append((points[int(words[1])], points[int(words[2])]))
    return segments


def judged(segments, mesh):
    """(nodes, cycles, genus, share of nodes inside): nodes at one place are one."""
    import numpy as np
    ids = {}
    edges = {tuple(sorted((ids.setdefault(a, len(ids)), ids.setdefault(b, len(ids))))) for a, b in segments}
    leader = list(range(len(ids)))

    def find(i):
        while leader[i] != i:
            leader[i] = leader[leader[i]]
            i = leader[i]
        return i
    for a, b in edges:
        leader[find(a)] = find(b)
    components = sum(find(i) == i for i in range(len(ids)))
    vertices, triangles = mesh
    used = np.unique(triangles)
    sides = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    euler = len(used) - len(np.unique(sides, axis=0)) + len(triangles)
    points = np.array(list(ids))
    corners = vertices[triangles]
    inside = 0
    for p in points:
        # Solid angle of all triangles (van Oosterom and Strackee, 1983), over 4 pi.
        a, b, c = (corners[:, k] - p for k in range(3))
        la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
        top = np.einsum("ij,ij->i", a, np.cross(b, c))
        bottom = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
        inside += abs(2 * np.arctan2(top, bottom).sum() / (4 * np.pi)) > 0.5
    return len(ids), len(edges) - len(ids) + components, 1 - euler / 2, inside / max(1, len(points))


def main():
    a = peer_parser(__doc__).parse_args()
    if a.peer:
        PEERS[a.peer[0]](*a.peer[1:])
        return
    rows = ["| surface | triangles | tool | CPU s | MiB | nodes | cycles / genus | inside |", "|---|---|---|---|---|---|---|---|"]
    for source in a.files:
        with tempfile.TemporaryDirectory() as folder:
            mesh = os.path.join(folder, "in.obj")
            subprocess.run([a.carreau, "repair", source, "-o", mesh, "-q"], check=True)
            runs = {}
            for _ in range(a.runs):
                out = os.path.join(folder, "carreau.cgr")
                runs.setdefault("carreau", []).append((measured([a.carreau, "skeleton", mesh, "-o", out, "-q", "--threads", "1"], a.timeout), out))
                for name in PEERS:
                    out = os.path.join(folder, name + ".json")
                    runs.setdefault(name, []).append((measured([sys.executable, __file__, "--peer", name, mesh, out], a.timeout), out))
            surface = read_obj(mesh)
            title = f"| {os.path.splitext(os.path.basename(source))[0]} | {len(surface[1])} |"
            for name, found in runs.items():
                done = [f for f, _ in found if f[0] == 0]
                if not done:
                    rows.append(f"{title} {name} | {'over time' if found[0][0][0] is None else 'failed'} | | | | |")
                    continue
                nodes, cycles, genus, inside = judged(segments_of(found[0][1]), surface)
                seconds, mib = (statistics.median(f[k] for f in done) for k in (1, 2))
                rows.append(f"{title} {name} | {seconds:.2f} | {mib:.0f} | {nodes} | {cycles} / {genus:g} | {100 * inside:.0f} % |")
            print("\n".join(rows[-len(runs):]), file=sys.stderr, flush=True)
    text = "\n".join(rows)
    if a.docs:
        write_between(a.docs, "hex", text)
    print(text)


if __name__ == "__main__":
    main()
