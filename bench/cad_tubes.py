#!/usr/bin/env python3
"""Tubes of CAD: carreau skeleton and hex on forty that Open CASCADE builds; see README.md.

Pipes, elbows, reducers, tees, crosses, Ys, manifolds of 3 to 8 branches and S-bends, of round tubes about known axes; each with flat caps
and without, each at a coarse and at a fine tessellation. The axes and radii that a tube was built of are what its skeleton is measured
by, its triangles what its hexes are. Exit code 1 where a bound is missed. --build FOLDER only writes the parts.
"""
import argparse
import json
import math
import os
import sys
import tempfile

from common import measured

# Greatest distance of the triangles from the part, in radii of the main tube, and angle between neighbours in radians: round tubes of about 9
# and of 21 sides.
TESSELLATIONS = {"coarse": (0.3, 0.7), "fine": (0.05, 0.3)}
# Radii of the skeleton may be off by this share of the tube's, its nodes off the axis by this share of the radius; within so many radii of a
# branching or a bend between straight tubes the shape has no axis.
RADIUS, AXIS, BLEND = 0.03, 0.02, 2.5
# Distances of the hexes as a share of the diagonal, their volume against that of the triangles, seconds on one thread.
FAR, VOLUME, SECONDS = 0.01, 0.01, 20


def straight(a, b, radius, to=None):
    """A cylinder from one point to another, or a cone where the second radius differs."""
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCone, BRepPrimAPI_MakeCylinder
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
    axis = gp_Ax2(gp_Pnt(*a), gp_Dir(*(q - p for p, q in zip(a, b))))
    if to is None or to == radius:
        return BRepPrimAPI_MakeCylinder(axis, radius, math.dist(a, b)).Shape()
    return BRepPrimAPI_MakeCone(axis, radius, to, math.dist(a, b)).Shape()


def bent(a, ways, radius):
    """A pipe along straight pieces and arcs: ways are ("line", to) and ("arc", through, to)."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeWire
    from OCP.BRepOffsetAPI import BRepOffsetAPI_MakePipe
    from OCP.GC import GC_MakeArcOfCircle
    from OCP.gp import gp_Ax2, gp_Circ, gp_Dir, gp_Pnt
    spine, at = BRepBuilderAPI_MakeWire(), a
    for kind, *points in ways:
        to = points[-1]
        if kind == "line":
            spine.Add(BRepBuilderAPI_MakeEdge(gp_Pnt(*at), gp_Pnt(*to)).Edge())
        else:
            spine.Add(BRepBuilderAPI_MakeEdge(GC_MakeArcOfCircle(gp_Pnt(*at), gp_Pnt(*points[0]), gp_Pnt(*to)).Value()).Edge())
        at = to
    first = ways[0][1]
    circle = gp_Circ(gp_Ax2(gp_Pnt(*a), gp_Dir(*(q - p for p, q in zip(a, first)))), radius)
    profile = BRepBuilderAPI_MakeFace(BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(circle).Edge()).Wire()).Face()
    return BRepOffsetAPI_MakePipe(spine.Wire(), profile).Shape()


def fused(shapes):
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse
    whole = shapes[0]
    for shape in shapes[1:]:
        whole = BRepAlgoAPI_Fuse(whole, shape).Shape()
    return whole


class Tube:
    """A shape with the polylines (points, radii) of its axes; `sharp` are places about which it has none."""

    def __init__(self, shape, axes, ends, branchings, sharp=()):
        self.shape, self.axes, self.ends, self.branchings, self.sharp = shape, axes, ends, branchings, list(sharp)


def pipe(length, radius=1.0):
    a, b = (0, 0, 0), (0, 0, length)
    return Tube(straight(a, b, radius), [([a, b], [radius] * 2)], [a, b], 0)


def arc_points(a, through, b, count=24):
    """Points of the arc in the plane y = 0 through three points."""
    (ax, _, az), (bx, _, bz), (cx, _, cz) = a, through, b
    d = 2 * (ax * (bz - cz) + bx * (cz - az) + cx * (az - bz))
    squares = [ax * ax + az * az, bx * bx + bz * bz, cx * cx + cz * cz]
    ux = (squares[0] * (bz - cz) + squares[1] * (cz - az) + squares[2] * (az - bz)) / d
    uz = (squares[0] * (cx - bx) + squares[1] * (ax - cx) + squares[2] * (bx - ax)) / d
    radius = math.hypot(ax - ux, az - uz)
    angles = [math.atan2(z - uz, x - ux) for x, z in ((ax, az), (bx, bz), (cx, cz))]
    sweep = (angles[2] - angles[0]) % math.tau
    if (angles[1] - angles[0]) % math.tau > sweep:
        sweep -= math.tau
    return [(ux + radius * math.cos(angles[0] + sweep * k / count), 0, uz + radius * math.sin(angles[0] + sweep * k / count)) for k in range(count + 1)]


def elbow(degrees, bend=2.5, leg=4.0, radius=1.0):
    """Two legs and an arc between them, in the plane y = 0."""
    turn = math.radians(degrees)
    at = lambda t: (bend * (1 - math.cos(t)), 0, leg + bend * math.sin(t))
    end = tuple(p + leg * d for p, d in zip(at(turn), (math.sin(turn), 0, math.cos(turn))))
    a, b, c = (0, 0, 0), at(0), at(turn)
    shape = bent(a, [("line", b), ("arc", at(turn / 2), c), ("line", end)], radius)
    points = [a, *arc_points(b, at(turn / 2), c), end]
    return Tube(shape, [(points, [radius] * len(points))], [a, end], 0)


def s_bend(degrees, bend=3.0, leg=3.0, radius=1.0):
    turn = math.radians(degrees)
    first = lambda t: (bend * (1 - math.cos(t)), 0, leg + bend * math.sin(t))
    middle = first(turn)
    # Turned by half about the middle the one half is the other.
    other = lambda p: tuple(2 * m - q for m, q in zip(middle, p))
    a, b = (0, 0, 0), first(0)
    shape = bent(a, [("line", b), ("arc", first(turn / 2), middle), ("arc", other(first(turn / 2)), other(b)), ("line", other(a))], radius)
    points = [a, *arc_points(b, first(turn / 2), middle), *arc_points(middle, other(first(turn / 2)), other(b))[1:], other(a)]
    return Tube(shape, [(points, [radius] * len(points))], [a, other(a)], 0)


def reducer(radii, length):
    """Two pipes and a cone between them."""
    (r, s), z = radii, [0, 4, 4 + length, 8 + length]
    at = [(0, 0, h) for h in z]
    shape = fused([straight(at[0], at[1], r), straight(at[1], at[2], r, s), straight(at[2], at[3], s)])
    return Tube(shape, [(at, [r, r, s, s])], [at[0], at[3]], 0, [at[1], at[2]])


def star(directions, radii, length=6.0):
    """Straight tubes from one point."""
    ends = [tuple(length * c / math.hypot(*d) for c in d) for d in directions]
    tubes = [straight((0, 0, 0), e, r) for e, r in zip(ends, radii)]
    # A ball where they meet closes what is left between flat ends at one point.
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeSphere
    return Tube(fused([*tubes, BRepPrimAPI_MakeSphere(max(radii)).Shape()]), [([(0, 0, 0), e], [r] * 2) for e, r in zip(ends, radii)], ends, 1, [(0, 0, 0)])


def tee(radius=1.0, side=1.0, lean=90):
    c, s = math.cos(math.radians(lean)), math.sin(math.radians(lean))
    return star([(0, 0, -1), (0, 0, 1), (s, 0, c)], [radius, radius, side])


def cross(radius=1.0, side=1.0):
    return star([(0, 0, -1), (0, 0, 1), (1, 0, 0), (-1, 0, 0)], [radius, radius, side, side])


def wye(half, radius=1.0, arm=1.0):
    c, s = math.cos(math.radians(half)), math.sin(math.radians(half))
    return star([(0, 0, -1), (s, 0, c), (-s, 0, c)], [radius, arm, arm], 7.0)


def manifold(count, pitch=4.0, radius=1.0, side=0.7):
    """A header with so many outlets in a row."""
    length = pitch * (count + 1)
    a, b = (0, 0, 0), (0, 0, length)
    feet = [(0, 0, pitch * (k + 1)) for k in range(count)]
    ends = [(5.0, 0, z) for _, _, z in feet]
    shape = fused([straight(a, b, radius), *(straight(f, e, side) for f, e in zip(feet, ends))])
    axes = [([a, b], [radius] * 2), *(([f, e], [side] * 2) for f, e in zip(feet, ends))]
    return Tube(shape, axes, [a, b, *ends], count, feet)


PARTS = {
    "pipe 3": lambda: pipe(3), "pipe 12": lambda: pipe(12), "pipe 60": lambda: pipe(60),
    "elbow 45": lambda: elbow(45), "elbow 90": lambda: elbow(90), "elbow 135": lambda: elbow(135),
    "reducer .7": lambda: reducer((1, 0.7), 1), "reducer .5": lambda: reducer((1, 0.5), 3),
    "tee": lambda: tee(), "tee .6": lambda: tee(side=0.6), "tee 60": lambda: tee(lean=60),
    "cross": lambda: cross(), "cross .7": lambda: cross(side=0.7),
    "wye 30": lambda: wye(30), "wye 60": lambda: wye(60), "wye 30 .7": lambda: wye(30, arm=0.7),
    "s-bend 45": lambda: s_bend(45), "s-bend 90": lambda: s_bend(90),
    "manifold 3": lambda: manifold(3), "manifold 4": lambda: manifold(4), "manifold 6": lambda: manifold(6), "manifold 8": lambda: manifold(8),
}
# Forty: every part once capped and once open, the tessellation by turns, but for four that are made at one only.
FORTY = [(name, capped, level) for k, name in enumerate(PARTS) for capped, level in
         [(True, "coarse" if k % 2 else "fine"), (False, "fine" if k % 2 else "coarse")] if not (name in ("pipe 60", "elbow 45", "cross .7", "manifold 4") and not capped)]


def triangles_of(tube, linear, angular, capped):
    """The points and triangles of a shape, outward; without the plane faces at its ends if it is open."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.TopAbs import TopAbs_FACE, TopAbs_REVERSED
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS
    BRepMesh_IncrementalMesh(tube.shape, linear, False, angular)
    points, number, triangles = [], {}, []
    explorer = TopExp_Explorer(tube.shape, TopAbs_FACE)
    cast = getattr(TopoDS, "Face_s", None) or TopoDS.Face
    while explorer.More():
        face = cast(explorer.Current())
        where = TopLoc_Location()
        mesh = BRep_Tool.Triangulation_s(face, where)
        at = []
        for k in range(1, mesh.NbNodes() + 1):
            p = mesh.Node(k).Transformed(where.Transformation())
            at.append((p.X(), p.Y(), p.Z()))
        middle = tuple(sum(c) / len(at) for c in zip(*at))
        is_cap = any(math.dist(middle, e) < 0.2 and max(math.dist(p, e) for p in at) < 1.3 for e in tube.ends)
        if capped or not is_cap:
            ids = [number.setdefault(tuple(round(c, 7) for c in p), len(number)) for p in at]
            for p, i in zip(at, ids):
                if i == len(points):
                    points.append(p)
            for k in range(1, mesh.NbTriangles() + 1):
                a, b, c = (ids[i - 1] for i in mesh.Triangle(k).Get())
                if len({a, b, c}) == 3:
                    triangles.append((a, c, b) if face.Orientation() == TopAbs_REVERSED else (a, b, c))
        explorer.Next()
    return points, triangles


def write_stl(path, points, triangles):
    with open(path, "w") as out:
        out.write("solid tube\n")
        for t in triangles:
            out.write("facet normal 0 0 0\nouter loop\n")
            out.writelines("vertex {:.17g} {:.17g} {:.17g}\n".format(*points[v]) for v in t)
            out.write("endloop\nendfacet\n")
        out.write("endsolid tube\n")


def on_axis(tube, p):
    """(distance, radius) of the nearest place of the axes."""
    best = (math.inf, 0.0)
    for points, radii in tube.axes:
        for (a, b), (r, s) in zip(zip(points, points[1:]), zip(radii, radii[1:])):
            along = [q - o for o, q in zip(a, b)]
            t = sum(d * (x - o) for d, x, o in zip(along, p, a)) / sum(d * d for d in along)
            t = min(max(t, 0), 1)
            best = min(best, (math.dist(p, [o + t * d for o, d in zip(a, along)]), r + t * (s - r)))
    return best


def skeleton_misses(tube, record, graph, inner):
    """What a skeleton misses of its bounds. `inner` is the share of its radius at which a tube's triangles may lie."""
    misses = []
    if record["extremities"] != len(tube.ends) or record["branchings"] != tube.branchings:
        misses.append(f"{record['extremities']} ends, {record['branchings']} branchings")
    off, thin, thick = 0.0, 0.0, 0.0
    for line in open(graph):
        words = line.split()
        if not words or words[0] != "v":
            continue
        *p, radius = map(float, words[1:5])
        distance, wanted = on_axis(tube, p)
        if all(math.dist(p, s) > BLEND * wanted for s in tube.sharp):
            off, thin, thick = max(off, distance / wanted), max(thin, inner - radius / wanted), max(thick, radius / wanted - 1)
    if off > AXIS:
        misses.append(f"{off:.3f} r off the axis")
    if max(thin, thick) > RADIUS:
        misses.append(f"radius {-thin:+.3f} {thick:+.3f}")
    return misses


def hex_misses(tube, record, seconds):
    """What a hex mesh misses."""
    checks = [(not record["certified"], "not certified"), (record["distance_max"] > FAR, f"{100 * record['distance_max']:.2f} % off"),
              (abs(record["volume_ratio"] - 1) > VOLUME, f"volume {100 * record['volume_ratio']:.1f} %"),
              (record["overlap"] > 0, f"overlap {record['overlap']:.4f}"),
              (len(record["tags"]) != 1 + len(tube.ends), f"{len(record['tags']) - 1} tags of ends"), (seconds > SECONDS, f"{seconds:.0f} s")]
    return [said for bad, said in checks if bad]


def main():
    p = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    p.add_argument("--carreau", default="target/release/carreau")
    p.add_argument("--build", metavar="FOLDER", help="write the parts as STL and end")
    p.add_argument("--only", default="", metavar="TEXT", help="parts whose name has this text")
    p.add_argument("--kind", choices=("skeleton", "hex", "both"), default="both")
    o = p.parse_args()
    folder = o.build or tempfile.mkdtemp()
    os.makedirs(folder, exist_ok=True)
    missed = 0
    print("| tube | triangles | skeleton | hex | far | volume | least, mean Jacobian | seconds |\n|---|--:|---|---|--:|--:|--:|--:|")
    for name, capped, level in FORTY:
        label = f"{name}, {'capped' if capped else 'open'}, {level}"
        if o.only not in label:
            continue
        tube = PARTS[name]()
        linear, angular = TESSELLATIONS[level]
        points, triangles = triangles_of(tube, linear, angular, capped)
        source = os.path.join(folder, label.replace(", ", "_").replace(" ", "_") + ".stl")
        write_stl(source, points, triangles)
        if o.build:
            continue
        skeleton, cells, row = "-", "-", ["", "", "", ""]
        stem = source[:-4]
        if o.kind != "hex":
            code, _, _, said = measured([o.carreau, "skeleton", source, "-o", stem + ".cgr", "--json", stem + ".s.json", "--threads", "1"], 100)
            # What its triangles leave of the smallest tube.
            inner = min(math.sqrt(1 - min(1, 2 * linear)), math.cos(angular / 2))
            skeleton = "; ".join(skeleton_misses(tube, json.load(open(stem + ".s.json")), stem + ".cgr", inner)) if code == 0 else f"exit {code}: {said[-120:]}"
        if o.kind != "skeleton":
            code, seconds, _, said = measured([o.carreau, "hex", source, "-o", stem + ".vtu", "--json", stem + ".h.json", "--threads", "1"], 300)
            if code == 0:
                r = json.load(open(stem + ".h.json"))
                cells = "; ".join(hex_misses(tube, r, seconds))
                row = [f"{100 * r['distance_max']:.2f} %", f"{100 * r['volume_ratio']:.1f} %", f"{r['scaled_jacobian_min']:.2f}, {r['scaled_jacobian_mean']:.2f}", f"{seconds:.1f}"]
            else:
                cells = f"exit {code}: {said[said.find('carreau:') + 9:][-160:].strip()}"
        missed += bool(skeleton.strip("-")) + bool(cells.strip("-"))
        print(f"| {label} | {len(triangles)} | {skeleton or 'right'} | {cells or 'right'} | {' | '.join(row)} |", flush=True)
    print(f"\n{missed} missed")
    return missed > 0


if __name__ == "__main__":
    sys.exit(main())
