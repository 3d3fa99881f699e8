"""Makes solids of files inside FreeCAD, and has FreeCAD fillet, cut, store and open them; one line of JSON a file.

CARREAU=… CARREAU_ADDON=… PARTS="a.stl b.stl" freecadcmd parts.py
"""

import json
import os
import sys
import tempfile
import time

sys.path.insert(0, os.environ["CARREAU_ADDON"])

import FreeCAD as App
import Mesh
import Part


def fillet(shape):
    """A round on the longest straight edge that takes one, of a hundredth of its length."""
    straight = [edge for edge in shape.Edges if edge.Length > 0 and isinstance(edge.Curve, Part.Line)]
    for edge in sorted(straight, key=lambda edge: -edge.Length)[:20]:
        try:
            made = shape.makeFillet(edge.Length / 100, [edge])
        except Exception:  # FreeCAD's kernel says no to this edge
            continue
        if made.isValid() and not made.isNull() and abs(made.Volume - shape.Volume) > 1e-9 * shape.Volume:
            return made
    return None


def cut(shape):
    """What a ball at one of its corners leaves."""
    return shape.cut(Part.makeSphere(shape.BoundBox.DiagonalLength / 20, shape.Vertexes[0].Point))


def stored(document):
    """Whether the shapes are the same after the document was stored and opened again."""
    before = [(len(f.Shape.Faces), f.Shape.Volume) for f in document.Objects if f.TypeId == "Part::Feature"]
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "part.FCStd")
        document.saveAs(path)
        App.closeDocument(document.Name)
        again = App.openDocument(path)
        after = [f.Shape for f in again.Objects if f.TypeId == "Part::Feature"]
        # FreeCAD stores shapes as text, which rounds the last digits.
        same = len(after) == len(before) and all(
            s.isValid() and len(s.Faces) == faces and abs(s.Volume - volume) <= 1e-6 * abs(volume)
            for s, (faces, volume) in zip(after, before, strict=True)
        )
        App.closeDocument(again.Name)
    return same


def run(path):
    import carreau_freecad as cf

    document = App.newDocument("Part")
    mesh = document.addObject("Mesh::Feature", "Mesh")
    mesh.Mesh = Mesh.Mesh(path)
    row = {"file": os.path.basename(path), "triangles": mesh.Mesh.CountFacets}
    start = time.monotonic()
    try:
        parts = cf.cad(mesh)
    except cf.Failure as failure:
        App.closeDocument(document.Name)
        return {**row, "failure": failure.lines()}
    row["seconds"] = round(time.monotonic() - start, 1)
    shapes = [part.Shape for part in parts]
    row["solids"] = sum(len(shape.Solids) for shape in shapes)
    row["faces"] = sum(len(shape.Faces) for shape in shapes)
    row["valid"] = all(shape.isValid() for shape in shapes)
    row["volume_ratio"] = round(sum(shape.Volume for shape in shapes) / mesh.Mesh.Volume, 6)
    largest = max(shapes, key=lambda shape: shape.Volume)
    rounded = fillet(largest)
    row["filleted"] = rounded is not None
    row["cut"] = bool((left := cut(largest)).isValid() and left.Volume < largest.Volume)
    row["stored"] = stored(document)
    return row


for file in os.environ["PARTS"].split():
    print(json.dumps(run(file)), flush=True)
os._exit(0)
