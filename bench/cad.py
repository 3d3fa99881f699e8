#!/usr/bin/env python3
"""CAD models of parts with known faces: carreau cad on labelled meshes, as they are and with noise; see README.md.

For every PART.ply with PART.json (format labelled-cad-1): is there a model, has it the faces of the part, what is its volume. With
--noise the part is turned at random and its vertices are moved by so many per cent of the mean edge; then also the angles between axes
and normals and the true ones, and the differences of radii. With --after Open CASCADE (package cadquery-ocp) goes on with the model:
halves by a plane, one fillet, a mesh of its faces. Exit code 1 where a part has no model.
"""
import argparse
import json
import os
import sys
import tempfile
import zlib
from pathlib import Path

from common import measured

# Radii within this share of the true one count as right.
RIGHT = 1e-3
# Of the diagonal: radius of the fillet, chord of the mesh; angle of the mesh in radians.
FILLET, CHORD, ANGLE = 0.01, 0.005, 0.5
TYPES = {"char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2", "int": "i4",
         "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4", "double": "f8", "float64": "f8"}


def read_ply(path):
    """Vertices and triangles of a binary PLY file."""
    import numpy as np
    head, body = Path(path).read_bytes().split(b"end_header\n", 1)
    elements = []
    for words in (line.split() for line in head.decode().splitlines()):
        if words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        elif words[:1] == ["property"]:
            fields = [(words[4] + "_n", "<" + TYPES[words[2]]), (words[4], "<" + TYPES[words[3]], 3)] if words[1] == "list" else [(words[2], "<" + TYPES[words[1]])]
            elements[-1][2].extend(fields)
    found, at = {}, 0
    for name, count, fields in elements:
        found[name] = np.frombuffer(body, np.dtype(fields), count, at)
        at += found[name].nbytes
    triangles = next(found["face"][n] for n in found["face"].dtype.names if n in ("vertex_indices", "vertex_index"))
    return np.stack([found["vertex"][c].astype(float) for c in "xyz"], 1), triangles.astype(np.int64)


def write_off(path, points, triangles):
    with open(path, "w") as out:
        out.write(f"OFF\n{len(points)} {len(triangles)} 0\n")
        out.writelines("%.17g %.17g %.17g\n" % tuple(p) for p in points)
        out.writelines("3 %d %d %d\n" % tuple(t) for t in triangles)


def disturbed(name, points, triangles, percent):
    """The part turned at random with noise, and the rotation; the same for the same name and noise."""
    import numpy as np
    random = np.random.default_rng(zlib.crc32(f"{name} {percent}".encode()))
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    sides = points[triangles] - points[np.roll(triangles, 1, 1)]
    edge = np.linalg.norm(sides, axis=2).mean()
    return points @ turn.T + random.normal(size=points.shape) * edge * percent / 100, turn


def distance(face, points):
    """Mean distance of points from the surface of a face of the record; infinite where it is not of a simple kind."""
    import numpy as np
    if "direction" not in face or "origin" not in face:
        return np.inf
    off = points - np.array(face["origin"])
    along = off @ np.array(face["direction"])
    across = np.linalg.norm(off - along[:, None] * np.array(face["direction"]), axis=1)
    kind = face["kind"]
    if kind == "plane":
        far = along
    elif kind == "cylinder":
        far = across - face["radius"]
    elif kind == "sphere":
        far = np.hypot(along, across) - face["radius"]
    elif kind == "torus":
        far = np.hypot(along, across - face["major_radius"]) - face["minor_radius"]
    else:
        return np.inf
    return float(np.abs(far).mean())


def figures(truth, table, points, triangles, turn):
    """Angles in degrees between directions and the true ones, and shares by which radii are off, of all true faces that have one."""
    import numpy as np
    labels = np.array(truth["tri_face"])
    angles, radii = [], []
    for f, face in enumerate(truth["faces"]):
        own = points[np.unique(triangles[labels == f])]
        alike = [g for g in table if g["kind"] == face["type"]]
        if not len(own) or not alike or face["type"] not in ("plane", "cylinder", "sphere", "torus"):
            continue
        best = min(alike, key=lambda g: distance(g, own))
        true = face.get("normal") or face.get("axis")
        if true and face["type"] != "sphere":
            angles.append(np.degrees(np.arcsin(min(1, np.linalg.norm(np.cross(turn @ np.array(true), best["direction"]))))))
        for key in ("radius", "minor_radius"):
            if key in face and key in best:
                radii.append(abs(best[key] / face[key] - 1))
    return angles, radii


def afterwards(path):
    """Whether halves of a solid are valid, whether one of its edges takes a fillet, whether all faces have a mesh."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Common
    from OCP.BRepBndLib import BRepBndLib
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
    from OCP.Bnd import Bnd_Box
    from OCP.STEPControl import STEPControl_Reader
    from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS
    from OCP.gp import gp_Pnt
    reader = STEPControl_Reader()
    reader.ReadFile(path)
    reader.TransferRoots()
    shape, box = reader.OneShape(), Bnd_Box()
    BRepBndLib.Add_s(shape, box)
    low, high = box.CornerMin(), box.CornerMax()
    size = low.Distance(high)
    # Not through the middle: planes of symmetry hold edges.
    cut = gp_Pnt(low.X() + 0.47 * (high.X() - low.X()), high.Y() + size, high.Z() + size)
    half = BRepAlgoAPI_Common(shape, BRepPrimAPI_MakeBox(gp_Pnt(low.X() - size, low.Y() - size, low.Z() - size), cut).Shape())
    # Static functions ended in _s up to Open CASCADE 7.
    face_of, edge_of = (getattr(TopoDS, name + "_s", None) or getattr(TopoDS, name) for name in ("Face", "Edge"))
    halved = half.IsDone() and not half.Shape().IsNull() and BRepCheck_Analyzer(half.Shape()).IsValid()

    def all_of(kind):
        found, explorer = [], TopExp_Explorer(shape, kind)
        while explorer.More():
            found.append(explorer.Current())
            explorer.Next()
        return found

    def takes(edge):
        try:
            fillet = BRepFilletAPI_MakeFillet(shape)
            fillet.Add(FILLET * size, edge_of(edge))
            fillet.Build()
            return fillet.IsDone() and BRepCheck_Analyzer(fillet.Shape()).IsValid()
        except Exception:  # noqa: BLE001 (Open CASCADE's errors are of many kinds)
            return False

    filleted = any(takes(e) for e in all_of(TopAbs_EDGE)[:40])
    BRepMesh_IncrementalMesh(shape, CHORD * size, False, ANGLE)
    meshed = all(BRep_Tool.Triangulation_s(face_of(f), TopLoc_Location()) is not None for f in all_of(TopAbs_FACE))
    return halved, filleted, meshed


def quantile(values, share):
    values = sorted(values)
    return values[min(len(values) - 1, int(share * len(values)))] if values else float("nan")


def main():
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    p.add_argument("--carreau", default="target/release/carreau")
    p.add_argument("--parts", required=True, metavar="FOLDER", help="labelled meshes")
    p.add_argument("--pattern", default="iso", help="parts whose name ends so, default iso")
    p.add_argument("--sample", type=int, default=1, metavar="N", help="every N-th part, default all")
    p.add_argument("--noise", type=float, nargs="*", default=[], metavar="P", help="per cent of the mean edge; 0 only turns")
    p.add_argument("--after", action="store_true", help="go on with the models in Open CASCADE")
    p.add_argument("--timeout", type=float, default=60, metavar="S", help="CPU seconds for each part, default 60")
    p.add_argument("--verbose", action="store_true", help="a line for every part")
    o = p.parse_args()
    parts = sorted(Path(o.parts).glob(f"*_{o.pattern}.ply"))[:: o.sample]
    folder, missing = tempfile.mkdtemp(), 0
    print("| noise | parts | models | = truth | <= truth | volume < 1e-4 | directions, median | radii, median | radii right | halves | fillet | mesh |")
    print("|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|")
    for percent in o.noise or [None]:
        models = equal = fewer = near = 0
        angles, radii, after = [], [], [0, 0, 0]
        for part in parts:
            truth = json.loads(part.with_suffix(".json").read_text())
            source, stem = str(part), os.path.join(folder, part.stem)
            if percent is not None:
                points, triangles = read_ply(part)
                points, turn = disturbed(part.stem, points, triangles, percent)
                source = stem + ".off"
                write_off(source, points, triangles)
            command = [o.carreau, "cad", source, "-o", stem + ".step", "--json", stem + ".json", "--threads", "1"]
            code, seconds, _, said = measured(command, o.timeout)
            if code != 0:
                print(f"{part.stem}: exit {code}: {said[-160:].strip()}", file=sys.stderr)
                continue
            record = json.loads(Path(stem + ".json").read_text())
            off = abs(record["volume"] / truth["cad_volume"] - 1) if truth.get("cad_volume") else 0
            models, equal, fewer = models + 1, equal + (record["faces"] == truth["n_faces"]), fewer + (record["faces"] <= truth["n_faces"])
            near += off < 1e-4
            if percent is not None:
                found = figures(truth, record["face_table"], points, triangles, turn)
                angles, radii = angles + found[0], radii + found[1]
            if o.after:
                after = [n + bool(x) for n, x in zip(after, afterwards(stem + ".step"))]
            if o.verbose:
                print(f"{part.stem}: {record['faces']} faces for {truth['n_faces']}, volume {off:.1e} off, {seconds:.1f} s", file=sys.stderr, flush=True)
        missing += len(parts) - models
        right = sum(r <= RIGHT for r in radii) / len(radii) if radii else float("nan")
        counts = " | ".join(str(n) for n in after) if o.after else " | | "
        label = "as they are" if percent is None else f"{percent:g} %, turned"
        print(f"| {label} | {len(parts)} | {models} | {equal} | {fewer} | {near} | {quantile(angles, 0.5):.4f} deg | {quantile(radii, 0.5):.1e} | {right:.2f} | {counts} |", flush=True)
    return missing > 0


if __name__ == "__main__":
    sys.exit(main())
