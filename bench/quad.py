#!/usr/bin/env python3
"""Quads: carreau quad beside QuadriFlow, Instant Meshes and Gmsh at the same number of quads; see README.md.

The measures are those of the independent checker (SHARED/verify/quad.py), the same for all: features kept (recall within
0.2 % of the diagonal and 15 degrees), irregular vertices, scaled Jacobian, two-sided distance.
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


@peer("QuadriFlow")
def quadriflow(source, target, quads):
    from pyQuadriFlow.pyQuadriFlow import pyquadriflow
    vertices, triangles = read_obj(source)
    # Sharp edges and borders preserved; sizes not adaptive, its default solvers.
    done = pyquadriflow(quads, 0, vertices.tolist(), triangles.tolist(), True, True, False, False, False)
    write_obj(target, done["vertices"], done["faces"])


@peer("Instant Meshes")
def instant_meshes(source, target, quads):
    import numpy as np
    import pynanoinstantmeshes as pynim
    vertices, triangles = read_obj(source)
    # Pure quads: every polygon of the mesh that is counted becomes four. Two rounds of smoothing, as in its window.
    v, q = pynim.remesh(vertices.astype(np.float32), triangles.astype(np.uint32), -1, face_count=quads // 4, align_to_boundaries=True,
                        creaseAngle=35, smooth_iter=2, deterministic=True)
    write_obj(target, v, np.asarray(q))


@peer("Gmsh")
def gmsh_quads(source, target, quads):
    """Classified by the same feature angle, meshed anew by the frontal method for quads, recombined and halved."""
    import gmsh
    import numpy as np
    vertices, triangles = read_obj(source)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    stl = target + ".stl"
    write_stl(stl, vertices[triangles])
    gmsh.merge(stl)
    gmsh.model.mesh.classifySurfaces(np.radians(35), True, True, np.pi)
    gmsh.model.mesh.createGeometry()
    size = 2 * (area / quads) ** 0.5
    for option, value in (("MeshSizeMin", size), ("MeshSizeMax", size), ("Algorithm", 8), ("RecombineAll", 1), ("SubdivisionAlgorithm", 1)):
        gmsh.option.setNumber("Mesh." + option, value)
    gmsh.model.mesh.generate(2)
    tags, points, _ = gmsh.model.mesh.getNodes()
    index = np.zeros(int(tags.max()) + 1, int)
    index[tags.astype(int)] = np.arange(len(tags))
    nodes = gmsh.model.mesh.getElementsByType(3)[1]
    faces = index[nodes.astype(int)].reshape(-1, 4)
    used, faces = np.unique(faces, return_inverse=True)
    write_obj(target, points.reshape(-1, 3)[used], faces.reshape(-1, 4))
    gmsh.finalize()


def write_obj(path, vertices, faces):
    with open(path, "w") as out:
        out.writelines(f"v {x:.17g} {y:.17g} {z:.17g}\n" for x, y, z in vertices)
        out.writelines("f " + " ".join(str(int(i) + 1) for i in face) + "\n" for face in faces)


def write_stl(path, corners):
    with open(path, "w") as out:
        out.write("solid part\n")
        for triangle in corners:
            lines = "".join(f"vertex {x:.17g} {y:.17g} {z:.17g}\n" for x, y, z in triangle)
            out.write(f"facet normal 0 0 0\nouter loop\n{lines}endloop\nendfacet\n")
        out.write("endsolid part\n")


def judged(shared, source, result, folder):
    """The checker's figures and how many of its checks failed; None where it cannot read the mesh."""
    values = os.path.join(folder, "values.json")
    if os.path.exists(values):
        os.remove(values)
    done = subprocess.run([sys.executable, "-B", "quad.py", source, result, "--values", values], cwd=os.path.join(shared, "verify"),
                          capture_output=True, text=True)
    if not os.path.exists(values):
        return None
    with open(values) as file:
        figures = json.load(file)
    # A mesh with a wrong feature here and there is still a mesh; what is no all-quad manifold is told.
    broken = [line for line in done.stdout.splitlines() if line.startswith("FAIL") and "feature" not in line and "inverted" not in line]
    return figures | {"broken": len(broken)}


def run(name, arguments, source, target):
    if name == "carreau":
        return measured([arguments.carreau, "quad", source, "-o", target, "--quads", str(arguments.quads), "-q", "--threads", "1"],
                        arguments.timeout)
    return measured([sys.executable, __file__, "--peer", name, source, target, "--quads", str(arguments.quads)], arguments.timeout)


def table(arguments):
    """One row per file and tool: medians of time and memory over the runs, figures of the last."""
    rows = ["| part | tool | quads | features kept | irregular | SJ min | SJ mean | inverted | distance % | CPU s | MiB | |",
            "|---|---|---|---|---|---|---|---|---|---|---|---|"]
    for source in arguments.files:
        part = os.path.splitext(os.path.basename(source))[0]
        source = os.path.abspath(source)
        with tempfile.TemporaryDirectory() as folder:
            mesh = os.path.join(folder, "in.obj")
            subprocess.run([arguments.carreau, "convert", source, "-o", mesh, "-q"], check=True)
            runs = {}
            for _ in range(arguments.runs):
                for name in ("carreau", *PEERS):
                    runs.setdefault(name, []).append(run(name, arguments, mesh, os.path.join(folder, name.replace(" ", "") + ".obj")))
            for name, found in runs.items():
                target = os.path.join(folder, name.replace(" ", "") + ".obj")
                done = [f for f in found if f[0] == 0]
                figures = judged(arguments.shared, mesh, target, folder) if done and os.path.exists(target) else None
                if figures is None or figures.get("sj_mean") is None:
                    why = "over time" if any(f[0] is None for f in found) else "failed" if not done else "no quads"
                    rows.append(f"| {part} | {name} | {why} | | | | | | | | | |")
                    continue
                f = {key: figures.get(key) for key in ("quads", "feature_recall", "irregular", "sj_min", "sj_mean", "inverted", "distance_max")}
                seconds, mib = (statistics.median(x[k] for x in done) for k in (1, 2))
                recall = "–" if f["feature_recall"] is None else f"{100 * f['feature_recall']:.1f} %"
                rows.append(f"| {part} | {name} | {f['quads']} | {recall} | {f['irregular']} | {f['sj_min']:.2f} | {f['sj_mean']:.3f} | "
                            f"{f['inverted']} | {100 * (f['distance_max'] or 0):.2f} | {seconds:.1f} | {mib:.0f} | "
                            f"{'not an all-quad manifold' if figures['broken'] else ''} |")
            print("\n".join(rows[-len(runs):]), file=sys.stderr, flush=True)
    return "\n".join(rows)


def main():
    p = peer_parser(__doc__)
    p.add_argument("--shared", default=os.environ.get("CARREAU_SHARED", "../shared"), help="folder of verify/")
    p.add_argument("--quads", type=int, default=3000)
    a = p.parse_args()
    if a.peer:
        PEERS[a.peer[0]](a.peer[1], a.peer[2], a.quads)
        return
    a.carreau, a.shared = os.path.abspath(a.carreau), os.path.abspath(a.shared)
    text = table(a)
    if a.docs:
        write_between(a.docs, "quad", text)
    print(text)


if __name__ == "__main__":
    main()
