#!/usr/bin/env python3
"""Acute parts: carreau quad on the tessellation beside Gmsh's quasi-structured quads on the STEP file; see README.md.

The five kinds of part that the spec of the field names, built by Open CASCADE (cadquery-ocp) from their measures: a wedge, a
crescent, a gusset with a hole and a fillet, a block with a chamfer that runs out, a cone. Gmsh gets the exact shape as STEP and is
told the size at which it makes about --quads; carreau gets the triangles and the number that Gmsh came to. Both results are measured
by the independent checker (SHARED/verify/quad.py) against the same triangles. --build writes the parts and ends.
"""
import math
import os
import statistics
import sys
import tempfile

from common import measured, peer_parser, write_between
from quad import judged, write_obj

# Greatest distance of the triangles from the part as a share of its diagonal, and greatest angle between neighbours in radians.
LINEAR, ANGULAR = 5e-4, 0.1
# Gmsh is run again at another size until it is as near to the number as this, so many times at most.
NEAR, TRIES = 0.05, 4


def prism(wire, height):
    """A flat wire in the plane z = 0 and what it sweeps along z."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
    from OCP.gp import gp_Vec
    return BRepPrimAPI_MakePrism(BRepBuilderAPI_MakeFace(wire).Face(), gp_Vec(0, 0, height)).Shape()


def polygon(points):
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakePolygon
    from OCP.gp import gp_Pnt
    wire = BRepBuilderAPI_MakePolygon()
    for x, y in points:
        wire.Add(gp_Pnt(x, y, 0))
    wire.Close()
    return wire.Wire()


def wedge(angle=15, length=10, thickness=3):
    """A prism over a triangle with two long sides that meet at an angle."""
    half = length * math.tan(math.radians(angle / 2))
    return prism(polygon([(0, 0), (length, -half), (length, half)]), thickness)


def crescent(angle=32, outer=90, half_width=5, thickness=2):
    """A prism between two arcs over one chord; the outer leaves it at `outer` degrees, the inner at `angle` fewer."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeWire
    from OCP.GC import GC_MakeArcOfCircle
    from OCP.gp import gp_Pnt
    wire = BRepBuilderAPI_MakeWire()
    for degrees in (outer, outer - angle):
        # The angle between a chord and its arc is half of the arc's.
        top = half_width * math.tan(math.radians(degrees / 2))
        arc = GC_MakeArcOfCircle(gp_Pnt(-half_width, 0, 0), gp_Pnt(0, top, 0), gp_Pnt(half_width, 0, 0))
        wire.Add(BRepBuilderAPI_MakeEdge(arc.Value()).Edge())
    return prism(wire.Wire(), thickness)


def gusset(angle=20, length=10, thickness=1, hole=0.5, fillet=0.8):
    """A triangular plate with a hole through it, its far corner rounded."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
    from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
    height = length * math.tan(math.radians(angle))
    plate = prism(polygon([(0, 0), (length, 0), (length, height)]), thickness)
    rounded = BRepFilletAPI_MakeFillet(plate)
    corner = [e for e in explored(plate, "Edge") if all(math.dist(p[:2], (length, height)) < 1e-9 for p in ends(e))]
    rounded.Add(fillet, corner[0])
    at = gp_Ax2(gp_Pnt(0.75 * length, 0.4 * 0.75 * height, -1), gp_Dir(0, 0, 1))
    return BRepAlgoAPI_Cut(rounded.Shape(), BRepPrimAPI_MakeCylinder(at, hole, thickness + 2).Shape()).Shape()


def run_out(angle=8, size=(10, 6, 4), start=2):
    """A block with a chamfer that fades out along an edge: its face is a triangle that ends in a tip of this angle."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeHalfSpace
    from OCP.gp import gp_Dir, gp_Pln, gp_Pnt
    x, y, z = size
    # The sides of the tip lie in top and front, both at the angle s from the edge: cos angle = cos^2 s.
    s = math.acos(math.sqrt(math.cos(math.radians(angle))))
    normal = gp_Dir(-math.sin(s), -math.cos(s), math.cos(s))
    tip = gp_Pnt(start, 0, z)
    plane = BRepBuilderAPI_MakeFace(gp_Pln(tip, normal)).Face()
    cut = BRepPrimAPI_MakeHalfSpace(plane, gp_Pnt(x, -1, z + 1)).Solid()
    return BRepAlgoAPI_Cut(BRepPrimAPI_MakeBox(x, y, z).Shape(), cut).Shape()


def cone(angle=11, height=10):
    """A cone with its tip; the angle is from the axis."""
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCone
    return BRepPrimAPI_MakeCone(height * math.tan(math.radians(angle)), 0, height).Shape()


PARTS = {"wedge 15°": wedge, "crescent": crescent, "gusset": gusset, "run-out 8°": run_out, "cone 11°": cone}


def explored(shape, kind):
    """The sub-shapes of a kind ("Edge", "Face", "Vertex"), once for every use."""
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS
    cast = getattr(TopoDS, kind + "_s", None) or getattr(TopoDS, kind)
    explorer = TopExp_Explorer(shape, getattr(TopAbs_ShapeEnum, "TopAbs_" + kind.upper()))
    while explorer.More():
        yield cast(explorer.Current())
        explorer.Next()


def ends(edge):
    from OCP.BRep import BRep_Tool
    points = (BRep_Tool.Pnt_s(v) for v in explored(edge, "Vertex"))
    return [(p.X(), p.Y(), p.Z()) for p in points]


def write_step(shape, path):
    from OCP.Message import Message, Message_Printer
    # What it tells of its transfer would come between the lines of the table.
    Message.DefaultMessenger_s().RemovePrinters(Message_Printer.get_type_descriptor_s())
    from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer
    writer = STEPControl_Writer()
    writer.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
    writer.Write(path)


def triangles(shape):
    """Vertices and triangles of Open CASCADE's mesh, those of neighbouring faces joined where they are equal."""
    import numpy as np
    from OCP.BRep import BRep_Tool
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.TopAbs import TopAbs_Orientation
    from OCP.TopLoc import TopLoc_Location
    corners = np.array([p for edge in explored(shape, "Edge") for p in ends(edge)])
    diagonal = float(np.linalg.norm(np.ptp(corners, axis=0)))
    BRepMesh_IncrementalMesh(shape, LINEAR * diagonal, False, ANGULAR, False)
    points, faces = [], []
    for face in explored(shape, "Face"):
        # The far end of a prism is its base at another place.
        place = TopLoc_Location()
        mesh = BRep_Tool.Triangulation_s(face, place)
        nodes = [mesh.Node(k + 1).Transformed(place.Transformation()) for k in range(mesh.NbNodes())]
        first = len(points)
        points += [(p.X(), p.Y(), p.Z()) for p in nodes]
        for k in range(mesh.NbTriangles()):
            a, b, c = (mesh.Triangle(k + 1).Value(i) + first - 1 for i in (1, 2, 3))
            faces.append((a, c, b) if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED else (a, b, c))
    points = np.array(points)
    _, kept, of = np.unique(np.round(points / (1e-9 * diagonal)), axis=0, return_index=True, return_inverse=True)
    faces = of.ravel()[np.array(faces)]
    # At the tip of a cone triangles of the parameter plane have two equal corners.
    a, b, c = faces.T
    return points[kept], faces[(a != b) & (b != c) & (c != a)]


def gmsh_quads(source, target, quads):
    """Quasi-structured quads of a STEP file, at the size that gives about this many."""
    import gmsh
    import numpy as np
    # It halves what it makes: the size is that of two quads.
    size, best = None, None
    for _ in range(TRIES):
        # A second mesh of the same model would not be the same as a first.
        gmsh.initialize()
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.merge(source)
        if size is None:
            area = sum(gmsh.model.occ.getMass(2, tag) for _, tag in gmsh.model.getEntities(2))
            size = 2 * (area / quads) ** 0.5
        for option, value in (("Algorithm", 11), ("MeshSizeMin", size), ("MeshSizeMax", size)):
            gmsh.option.setNumber("Mesh." + option, value)
        gmsh.model.mesh.generate(2)
        tags, points, _ = gmsh.model.mesh.getNodes()
        index = np.zeros(int(tags.max()) + 1, int)
        index[tags.astype(int)] = np.arange(len(tags))
        # Triangles that are left are written, too: the checker tells them.
        faces = [list(f) for k, kind in ((4, 3), (3, 2)) for f in index[gmsh.model.mesh.getElementsByType(kind)[1].astype(int)].reshape(-1, k)]
        gmsh.finalize()
        off = abs(math.log(max(len(faces), 1) / quads))
        if best is None or off < best[0]:
            best = off, points.reshape(-1, 3), faces
        if off < NEAR or not faces:
            break
        size *= (len(faces) / quads) ** 0.5
    _, points, faces = best
    used = np.unique(np.concatenate(faces))
    place = np.zeros(len(points), int)
    place[used] = np.arange(len(used))
    write_obj(target, points[used], [place[f] for f in faces])


def build(name, folder):
    """The STEP file of a part and its triangles."""
    shape = PARTS[name]()
    stem = os.path.join(folder, name.split()[0])
    write_step(shape, stem + ".step")
    write_obj(stem + ".obj", *triangles(shape))
    return stem + ".step", stem + ".obj"


def faces_in(path):
    with open(path) as lines:
        return sum(line.startswith("f ") for line in lines)


def row(part, tool, figures, runs):
    seconds, mib = (statistics.median(run[k] for run in runs) for k in (1, 2))
    if figures is None or figures.get("sj_mean") is None:
        return f"| {part} | {tool} | {'over time' if runs[-1][0] is None else 'failed'} | | | | | | | | | |"
    recall = "–" if figures["feature_recall"] is None else f"{100 * figures['feature_recall']:.1f} %"
    return (f"| {part} | {tool} | {figures['quads']} | {recall} | {figures['irregular']} | {figures['sj_min']:.3f} | "
            f"{figures['sj_mean']:.3f} | {figures['inverted']} | {100 * (figures['distance_max'] or 0):.2f} | {seconds:.1f} | {mib:.0f} | "
            f"{'not an all-quad manifold' if figures['broken'] else ''} |")


def table(arguments):
    rows = ["| part | tool | quads | features kept | irregular | SJ min | SJ mean | inverted | distance % | CPU s | MiB | |",
            "|---|---|---|---|---|---|---|---|---|---|---|---|"]
    for part in PARTS:
        with tempfile.TemporaryDirectory() as folder:
            step, mesh = build(part, folder)
            of_gmsh, of_carreau = (os.path.join(folder, tool + ".obj") for tool in ("gmsh", "carreau"))
            runs = {"Gmsh": [], "carreau": []}
            for _ in range(arguments.runs):
                peer = [sys.executable, __file__, "--peer", "Gmsh", step, of_gmsh, "--quads", str(arguments.quads)]
                runs["Gmsh"].append(measured(peer, arguments.timeout))
                quads = faces_in(of_gmsh) if os.path.exists(of_gmsh) else arguments.quads
                ours = [arguments.carreau, "quad", mesh, "-o", of_carreau, "--quads", str(quads), "-q", "--threads", "1"]
                runs["carreau"].append(measured(ours, arguments.timeout))
            for tool, result in (("carreau", of_carreau), ("Gmsh", of_gmsh)):
                figures = judged(arguments.shared, mesh, result, folder) if os.path.exists(result) else None
                rows.append(row(part, tool, figures, runs[tool]))
            print("\n".join(rows[-2:]), file=sys.stderr, flush=True)
    return "\n".join(rows)


def main():
    p = peer_parser(__doc__)
    p.add_argument("--shared", default=os.environ.get("CARREAU_SHARED", "../shared"), help="folder of verify/")
    p.add_argument("--quads", type=int, default=2000)
    p.add_argument("--build", metavar="FOLDER", help="write the parts as STEP and OBJ, and end")
    a = p.parse_args()
    if a.build:
        os.makedirs(a.build, exist_ok=True)
        print("\n".join(path for part in PARTS for path in build(part, a.build)))
        return
    if a.peer:
        gmsh_quads(a.peer[1], a.peer[2], a.quads)
        return
    a.carreau, a.shared = os.path.abspath(a.carreau), os.path.abspath(a.shared)
    text = table(a)
    if a.docs:
        write_between(a.docs, "acute", text)
    print(text)


if __name__ == "__main__":
    main()
