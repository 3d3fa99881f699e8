"""The operators: each starts carreau on the active object and takes its result into the scene.

Called from the panel they run beside Blender: a timer looks after the child, Esc ends it. Called from a script, or
without a window, they wait for its end.
"""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np

from . import obj_file, ply, preferences, transfer
from .child import POLL, Cancelled, Child, Failure, attend, find
from .surface import Source, new_mesh

__all__ = ["CLASSES", "SYMMETRIES", "Run"]

#: The face property `primitive` of `carreau segment`, with colours that colour-blind people tell apart (Okabe and Ito).
PRIMITIVES = {
    "plane": (0.60, 0.60, 0.60),
    "sphere": (0.90, 0.62, 0.00),
    "cylinder": (0.00, 0.45, 0.70),
    "cone": (0.00, 0.62, 0.45),
    "torus": (0.80, 0.47, 0.65),
    "freeform": (0.84, 0.37, 0.00),
}


class Run:
    """What the operators have in common. A subclass says how a run begins (`begin`) and what becomes of it (`end`)."""

    bl_options = {"UNDO"}  # noqa: RUF012 -- Blender's way
    #: The run that goes on: one at a time.
    current: Any = None

    @classmethod
    def poll(cls, context: Any) -> bool:
        obj = context.active_object
        if obj is None or obj.type != "MESH":
            cls.poll_message_set("Select a mesh")
        elif obj.mode != "OBJECT":
            cls.poll_message_set("Leave the mode of the object first: object mode is needed")
        elif Run.current is not None:
            cls.poll_message_set("A run of carreau goes on: Esc ends it")
        else:
            return True
        return False

    def begin(self, context: Any, child_of: Any) -> tuple[Child, str, str]:
        """Prepares a run: `child_of(verb, options)` makes the child; returns it with the names of input and output."""
        raise NotImplementedError

    def end(self, context: Any, record: dict[str, Any], path: str) -> None:
        """Takes the result into the scene."""
        raise NotImplementedError

    def _prepare(self, context: Any) -> tuple[Child, str, str]:
        label = context.active_object.name
        command = find(preferences.path())

        def child_of(verb: str, options: dict[str, Any]) -> Child:
            return Child(command, verb, {**preferences.common(), **options}, label)

        return self.begin(context, child_of)

    def execute(self, context: Any) -> set[str]:
        """Waits for the end of the run."""
        try:
            child, source, output = self._prepare(context)
            with child:
                attend(child, source, output)
                self._finish(context, child, output)
        except (Failure, OSError) as error:
            return self._fail(error)
        return {"FINISHED"}

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Starts the run; Blender goes on."""
        if bpy.app.background or context.window is None:
            return self.execute(context)
        try:
            self._child, source, self._output = self._prepare(context)
            self._child.start(source, self._output)
        except (Failure, OSError) as error:
            return self._fail(error)
        Run.current = self
        manager = context.window_manager
        self._timer = manager.event_timer_add(2 * POLL, window=context.window)
        manager.progress_begin(0, 100)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: Any, event: Any) -> set[str]:
        """Looks after the child at every tick."""
        child = self._child
        if event.type == "ESC" and event.value == "PRESS":
            child.cancel()
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if not child.done():
            share = f" {round(100 * child.share)} %" if child.share > 0 else ""
            context.workspace.status_text_set(f"carreau: {child.stage or self.bl_label}{share}    Esc: cancel")
            context.window_manager.progress_update(max(round(100 * child.share), 0))
            return {"PASS_THROUGH"}
        try:
            self._finish(context, child, self._output)
        except Exception as error:
            return self._fail(error)
        finally:
            self._leave(context)
        return {"FINISHED"}

    def cancel(self, context: Any) -> None:
        """Called by Blender where it ends the operator itself, as with a file that is opened."""
        self._leave(context)

    def _leave(self, context: Any) -> None:
        Run.current = None
        self._child.close()
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)

    def _finish(self, context: Any, child: Child, output: str) -> None:
        record = child.finish()
        self.end(context, record, child.path(output))
        for text in record["warnings"]:
            self.report({"WARNING"}, text)
        if record["summary"]:
            self.report({"INFO"}, record["summary"][0])

    def _fail(self, error: Exception) -> set[str]:
        if isinstance(error, Cancelled):
            self.report({"INFO"}, "carreau: cancelled")
        elif isinstance(error, Failure):
            self.report({"ERROR"}, "\n".join(error.lines()))
        else:
            self.report({"ERROR"}, f"{type(error).__name__}: {error}")
        return {"CANCELLED"}


class _NewMesh(Run):
    """Operators that make a new mesh of the object."""

    replace: bpy.props.BoolProperty(
        name="In place", description="The object gets the new mesh; else a new object beside it"
    )
    apply_modifiers: bpy.props.BoolProperty(
        name="Apply modifiers",
        default=True,
        description="The object as it is seen; else its own mesh, and modifiers stay",
    )
    keep_sharp: bpy.props.BoolProperty(name="Edges marked sharp", default=True, description="Stay as paths of edges")
    keep_seams: bpy.props.BoolProperty(name="Seams", default=True, description="Stay as paths of edges")
    keep_materials: bpy.props.BoolProperty(
        name="Borders of materials", default=True, description="Stay as paths of edges"
    )
    mark_sharp: bpy.props.BoolProperty(
        name="Mark sharp edges", default=True, description="Sharp edges that were kept are marked sharp in the result"
    )
    feature_angle: bpy.props.FloatProperty(
        name="Sharp edges above",
        min=0.0,
        max=180.0,
        description="Angle in degrees; 0: creases at the size of the result; 180: none but marked ones",
    )

    def _source(self, context: Any) -> Source:
        obj = context.active_object
        if self.apply_modifiers and obj.modifiers:
            depsgraph = context.evaluated_depsgraph_get()
            evaluated = obj.evaluated_get(depsgraph)
            source = Source.of(obj, depsgraph)
            mesh = evaluated.to_mesh()
            source.mark(mesh, **self._marks())
            evaluated.to_mesh_clear()
            if obj.data.shape_keys is not None:
                self.report(
                    {"WARNING"}, "shape keys went into the result with the modifiers; without these they are kept"
                )
        else:
            source = Source.of(obj)
            source.mark(obj.data, **self._marks())
        if not len(source.materials):
            raise Failure(f"{obj.name} has no faces", remedy="select a mesh that has some", code=3)
        return source

    def _marks(self) -> dict[str, bool]:
        return {"sharp": self.keep_sharp, "seams": self.keep_seams, "materials": self.keep_materials}

    def _begin(self, context: Any, child_of: Any, verb: str, options: dict[str, Any]) -> tuple[Child, str, str]:
        self._from = source = self._source(context)
        options = {**options, "feature-angle": self.feature_angle or None}
        child = child_of(verb, options)
        obj_file.write(child.path("source.obj"), source)
        if len(source.marked):
            obj_file.write_edges(child.path("marked.txt"), source.marked)
            child.option("features", child.path("marked.txt"))
        return child, "source.obj", "result.obj"

    def end(self, context: Any, record: dict[str, Any], path: str) -> None:
        source = self._from
        obj = bpy.data.objects.get(source.name)
        if obj is None or obj.type != "MESH":
            raise Failure(f"{source.name} is gone", remedy="undo what removed it, and run again", code=3)
        result = obj_file.read(path)
        mesh = new_mesh(
            f"{obj.data.name} {self.suffix}", source.frame.back(result.points), result.corners, result.starts
        )
        transfer.materials(source, mesh, result.materials)
        if source.uv is not None and result.uv is not None:
            mesh.uv_layers.new(name=source.uv_name, do_init=False).uv.foreach_set(
                "vector", result.uv.astype(np.float32).ravel()
            )
        mesh.polygons.foreach_set("use_smooth", np.full(len(mesh.polygons), source.smooth))
        if self.mark_sharp and len(result.edges):
            _mark(mesh, result.edges)
        made = self._put(context, obj, mesh)
        transfer.carry(source, made)
        mesh.update()
        # What cannot be is set right rather than taken into the scene.
        mesh.validate(verbose=False)

    def _put(self, context: Any, obj: Any, mesh: Any) -> Any:
        """The object that has the mesh: the old one, or a new one in its place."""
        if self.replace:
            made = obj
            if obj.data.shape_keys is not None:
                obj.shape_key_clear()
            obj.data = mesh
        else:
            made = obj.copy()
            made.name = f"{obj.name} {self.suffix}"
            made.data = mesh
            for collection in obj.users_collection:
                collection.objects.link(made)
            obj.select_set(False)
            obj.hide_set(True)
            made.select_set(True)
            context.view_layer.objects.active = made
        if self.apply_modifiers:
            made.modifiers.clear()
        return made


def _mark(mesh: Any, pairs: np.ndarray) -> None:
    ends = np.empty(len(mesh.edges) * 2, dtype=np.int32)
    mesh.edges.foreach_get("vertices", ends)
    ends = np.sort(ends.reshape(-1, 2), axis=1).astype(np.int64)
    size = len(mesh.vertices)
    pairs = np.sort(pairs, axis=1)
    marked = np.isin(ends[:, 0] * size + ends[:, 1], pairs[:, 0] * size + pairs[:, 1])
    mesh.edges.foreach_set("use_edge_sharp", marked)


SYMMETRIES = [
    ("OFF", "None", "Quads without symmetry"),
    ("X", "X", "Across the object's x axis"),
    ("Y", "Y", "Across the object's y axis"),
    ("Z", "Z", "Across the object's z axis"),
    ("AUTO", "Of the object", "Across all planes of symmetry that the object has"),
]


class CarreauQuads(_NewMesh, bpy.types.Operator):
    """Makes a mesh of quads that keeps every sharp edge"""

    bl_idname, bl_label, suffix = "carreau.quads", "Quads", "quads"

    quads: bpy.props.IntProperty(
        name="Quads", default=3000, min=1, max=100_000_000, description="Met within 10 % where sharp edges allow"
    )
    symmetry: bpy.props.EnumProperty(name="Symmetry", items=SYMMETRIES, description="One half is made and mirrored")
    adaptive: bpy.props.BoolProperty(name="Adaptive", description="Smaller quads where the surface bends")

    def begin(self, context: Any, child_of: Any) -> tuple[Child, str, str]:
        options: dict[str, Any] = {"quads": self.quads}
        if self.symmetry != "OFF":
            options["symmetry"] = self.symmetry.lower()
        if self.adaptive:
            options["adaptive"] = True
        return self._begin(context, child_of, "quad", options)


class CarreauRemesh(_NewMesh, bpy.types.Operator):
    """Makes a graded mesh of fewer triangles that keeps every sharp edge"""

    bl_idname, bl_label, suffix = "carreau.remesh", "Remesh", "remeshed"

    triangles: bpy.props.IntProperty(
        name="Triangles", min=0, max=100_000_000, description="0: as many as the angle takes"
    )
    deviation: bpy.props.FloatProperty(
        name="Angle",
        default=14.0,
        min=0.1,
        max=90.0,
        description="Degrees between edges and the surface, where no number is given",
    )

    def begin(self, context: Any, child_of: Any) -> tuple[Child, str, str]:
        options = {"triangles": self.triangles} if self.triangles else {"deviation": self.deviation}
        return self._begin(context, child_of, "simplify", options)


class CarreauSegment(Run, bpy.types.Operator):
    """Finds the faces of a part: face sets, and materials by face or by kind of surface"""

    bl_idname, bl_label = "carreau.segment", "Segment"

    regions: bpy.props.IntProperty(
        name="Faces", min=0, max=100_000, description="Merged down to this number; 0: from the data"
    )
    materials: bpy.props.EnumProperty(
        name="Materials",
        items=[
            ("KIND", "By kind", "One for each kind of surface"),
            ("FACE", "By face", "One for each face"),
            ("NONE", "Left", "Materials are left as they are"),
        ],
    )
    mark_sharp: bpy.props.BoolProperty(name="Mark borders", description="Edges between faces are marked sharp")

    def begin(self, context: Any, child_of: Any) -> tuple[Child, str, str]:
        # Its own mesh: that is what gets the faces.
        self._from = source = Source.of(context.active_object)
        if not len(source.triangles):
            raise Failure(f"{source.name} has no faces", remedy="select a mesh that has some", code=3)
        triangles = source.corners[source.triangles]
        child = child_of("segment", {"regions": self.regions or None})
        ply.write(child.path("source.ply"), source.frame.out(source.points).tolist(), triangles.tolist())
        return child, "source.ply", "result.ply"

    def end(self, context: Any, record: dict[str, Any], path: str) -> None:
        source = self._from
        obj = bpy.data.objects.get(source.name)
        same = obj is not None and obj.type == "MESH" and len(obj.data.polygons) == len(source.materials)
        if not same or len(obj.data.loops) != len(source.corners):
            raise Failure(f"{source.name} was changed meanwhile", remedy="run again", code=3)
        found = ply.read(path).of_faces
        # A polygon is what its first triangle is.
        first = np.unique(source.triangle_faces, return_index=True)
        regions, kinds = (
            np.zeros(len(source.materials), np.int32),
            np.full(len(source.materials), len(PRIMITIVES) - 1, np.int32),
        )
        regions[first[0]] = np.array(found["region"], np.int32)[first[1]]
        kinds[first[0]] = np.array(found["primitive"], np.int32)[first[1]]
        mesh = obj.data
        _face_values(mesh, ".sculpt_face_set", regions + 1)
        _face_values(mesh, "region", regions)
        _face_values(mesh, "primitive", kinds)
        self._paint(mesh, regions, kinds)
        if self.mark_sharp:
            source.materials = regions
            source.mark(mesh, sharp=True, seams=False, materials=True)
            _mark(mesh, source.marked.astype(np.int64))
        mesh.update()

    def _paint(self, mesh: Any, regions: np.ndarray, kinds: np.ndarray) -> None:
        names = list(PRIMITIVES)
        if self.materials == "NONE":
            return
        mesh.materials.clear()
        if self.materials == "KIND":
            used, numbers = np.unique(kinds, return_inverse=True)
            wanted = [(f"carreau {names[kind]}", PRIMITIVES[names[kind]]) for kind in used]
        else:
            used, at, numbers = np.unique(regions, return_index=True, return_inverse=True)
            wanted = [
                (f"{names[kinds[a]]}_{region}", PRIMITIVES[names[kinds[a]]]) for region, a in zip(used, at, strict=True)
            ]
        for name, colour in wanted:
            mesh.materials.append(_material(name, colour))
        mesh.polygons.foreach_set("material_index", numbers.astype(np.int32))


def _face_values(mesh: Any, name: str, values: np.ndarray) -> None:
    attribute = mesh.attributes.get(name)
    if attribute is not None and (attribute.domain, attribute.data_type) != ("FACE", "INT"):
        mesh.attributes.remove(attribute)
        attribute = None
    attribute = attribute or mesh.attributes.new(name, "INT", "FACE")
    attribute.data.foreach_set("value", values.astype(np.int32))


def _material(name: str, colour: tuple[float, float, float]) -> Any:
    found = bpy.data.materials.get(name)
    if found is None:
        found = bpy.data.materials.new(name)
        found.diffuse_color = (*colour, 1.0)
    return found


CLASSES = (CarreauQuads, CarreauRemesh, CarreauSegment)
