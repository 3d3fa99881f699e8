"""Quads and graded meshes: what is made, where it is, and what it carries."""

import bpy
import numpy as np
import pytest
from mathutils import Matrix, Vector

BOX = (
    [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)],
    [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)],
)


def values(items, name, width=1):
    found = np.empty(len(items) * width, dtype=np.float32)
    items.foreach_get(name, found)
    return found.reshape(-1, width) if width > 1 else found


def world(obj):
    matrix = np.array(obj.matrix_world)
    return values(obj.data.vertices, "co", 3) @ matrix[:3, :3].T + matrix[:3, 3]


def volume(obj):
    """Of the closed mesh, as it is seen; negative where it is inside out."""
    mesh = obj.data
    mesh.calc_loop_triangles()
    points = world(obj)
    corners = np.array([t.vertices for t in mesh.loop_triangles])
    a, b, c = points[corners].transpose(1, 0, 2)
    total = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    return total if obj.matrix_world.determinant() > 0 else -total


def all_quads(obj):
    return len(obj.data.polygons) > 0 and all(face.loop_total == 4 for face in obj.data.polygons)


def closed(mesh):
    """Every edge has two faces."""
    uses = np.zeros(len(mesh.edges), dtype=int)
    for loop in mesh.loops:
        uses[loop.edge_index] += 1
    return bool((uses == 2).all())


def test_quads_are_a_new_object_beside_the_old_one(put):
    obj = put("cylinder", resolution=16)
    before = volume(obj)
    assert bpy.ops.carreau.quads(quads=400) == {"FINISHED"}
    made = bpy.context.view_layer.objects.active
    assert made is not obj and made.name == "Part quads" and made.select_get() and obj.hide_get()
    assert all_quads(made) and closed(made.data) and 350 < len(made.data.polygons) < 450
    assert abs(volume(made) - before) < 0.02 * before
    assert not made.data.validate()


def test_quads_are_symmetric_across_an_axis_of_the_object(put):
    obj = put("cylinder", resolution=16)
    obj.matrix_world = Matrix.Translation((3, 1, 2)) @ Matrix.Rotation(0.7, 4, "Z")
    assert bpy.ops.carreau.quads(quads=400, symmetry="X", adaptive=True) == {"FINISHED"}
    made = bpy.context.view_layer.objects.active
    points = values(made.data.vertices, "co", 3)
    middle = (points[:, 0].min() + points[:, 0].max()) / 2
    images = points * (-1, 1, 1) + (2 * middle, 0, 0)
    nearest = np.linalg.norm(points[:, None] - images[None], axis=2).min(axis=1)
    assert all_quads(made) and closed(made.data) and nearest.max() < 1e-4


def test_in_place_and_undo_restores_the_bytes(put):
    obj = put("cylinder", resolution=16)
    bpy.ops.ed.undo_push(message="before")
    points, corners = values(obj.data.vertices, "co", 3).tobytes(), values(obj.data.loops, "vertex_index").tobytes()
    assert bpy.ops.carreau.quads(quads=300, replace=True) == {"FINISHED"}
    bpy.ops.ed.undo_push(message="Quads")
    assert all_quads(bpy.data.objects["Part"]) and [o.name for o in bpy.data.objects if o.type == "MESH"] == ["Part"]
    bpy.ops.ed.undo()
    mesh = bpy.data.objects["Part"].data
    assert values(mesh.vertices, "co", 3).tobytes() == points
    assert values(mesh.loops, "vertex_index").tobytes() == corners


def test_materials_and_texture_coordinates_are_carried(put):
    obj = put(BOX)
    for name in ("red", "blue"):
        obj.data.materials.append(bpy.data.materials.new(name))
    for face in obj.data.polygons:
        face.material_index = face.index % 2
    layer = obj.data.uv_layers.new(name="Map")
    for loop in obj.data.loops:
        x, y, z = obj.data.vertices[loop.vertex_index].co
        layer.uv[loop.index].vector = (x + 0.1 * z, y - 0.2 * z)
    assert bpy.ops.carreau.quads(quads=200) == {"FINISHED"}
    mesh = bpy.context.active_object.data
    assert [m.name for m in mesh.materials] == ["red", "blue"] and mesh.uv_layers.active.name == "Map"
    # Each side of the box keeps its material, and the map is linear on it.
    sides = {tuple(round(x) for x in face.normal): face.material_index for face in obj.data.polygons}
    for face in mesh.polygons:
        assert face.material_index == sides[tuple(round(x) for x in face.normal)]
    for loop in mesh.loops:
        x, y, z = mesh.vertices[loop.vertex_index].co
        assert (mesh.uv_layers.active.uv[loop.index].vector - Vector((x + 0.1 * z, y - 0.2 * z))).length < 1e-4


def test_groups_keys_colours_and_further_maps_are_carried(put):
    obj = put(BOX)
    group = obj.vertex_groups.new(name="Right")
    for vertex in obj.data.vertices:
        group.add([vertex.index], (vertex.co.x + 1) / 2, "REPLACE")
    obj.data.uv_layers.new(name="First")
    second = obj.data.uv_layers.new(name="Second")
    obj.data.uv_layers.active = obj.data.uv_layers["First"]
    for loop in obj.data.loops:
        second.uv[loop.index].vector = obj.data.vertices[loop.vertex_index].co.xy
    colours = obj.data.color_attributes.new(name="Paint", type="FLOAT_COLOR", domain="POINT")
    for vertex in obj.data.vertices:
        colours.data[vertex.index].color = (*((vertex.co + Vector((1, 1, 1))) / 2), 1)
    obj.shape_key_add(name="Basis")
    for point in obj.shape_key_add(name="Tall").data:
        point.co.z *= 3
    assert bpy.ops.carreau.quads(quads=200) == {"FINISHED"}
    made = bpy.context.active_object
    mesh = made.data
    assert [g.name for g in made.vertex_groups] == ["Right"]
    assert [k.name for k in mesh.shape_keys.key_blocks] == ["Basis", "Tall"]
    for vertex in mesh.vertices:
        weight = next((g.weight for g in vertex.groups), 0.0)
        assert abs(weight - (vertex.co.x + 1) / 2) < 1e-4
        assert (
            Vector(mesh.color_attributes["Paint"].data[vertex.index].color[:3]) * 2 - Vector((1, 1, 1)) - vertex.co
        ).length < 1e-4
        tall = mesh.shape_keys.key_blocks["Tall"].data[vertex.index].co
        assert (tall - Vector((vertex.co.x, vertex.co.y, 3 * vertex.co.z))).length < 1e-4
    for loop in mesh.loops:
        off = mesh.uv_layers["Second"].uv[loop.index].vector - mesh.vertices[loop.vertex_index].co.xy
        assert off.length < 0.02  # corners are sampled a little inside of their faces


@pytest.mark.parametrize("mirror", [1, -1])
def test_sizes_are_those_that_are_seen(put, mirror):
    """A box that is stretched by the object: quads are as long as wide in the scene."""
    obj = put(BOX)
    obj.matrix_world = (
        Matrix.Translation((1000, 0, 5)) @ Matrix.Rotation(0.5, 4, "X") @ Matrix.Diagonal((5 * mirror, 1, 1, 1))
    )
    bpy.context.view_layer.update()
    before = volume(obj)
    assert bpy.ops.carreau.quads(quads=600) == {"FINISHED"}
    made = bpy.context.active_object
    bpy.context.view_layer.update()
    assert made.matrix_world == obj.matrix_world
    assert before > 0 and abs(volume(made) - before) < 0.01 * before
    points = world(made)
    lengths = np.array([np.linalg.norm(points[a] - points[b]) for a, b in (e.vertices for e in made.data.edges)])
    assert lengths.max() < 2.5 * lengths.min()


def test_a_child_of_a_scaled_parent_stays_in_its_place(put):
    parent = bpy.data.objects.new("Parent", None)
    bpy.context.collection.objects.link(parent)
    parent.scale, parent.location = (2, 2, 2), (3, 4, 5)
    obj = put(BOX)
    obj.parent = parent
    obj.location = (1, 0, 0)
    bpy.context.view_layer.update()
    assert bpy.ops.carreau.quads(quads=200) == {"FINISHED"}
    made = bpy.context.active_object
    bpy.context.view_layer.update()
    assert made.parent is parent and made.matrix_world == obj.matrix_world
    assert np.allclose(world(made).min(axis=0), world(obj).min(axis=0), atol=1e-5)
    assert np.allclose(world(made).max(axis=0), world(obj).max(axis=0), atol=1e-5)


@pytest.mark.parametrize("apply", [True, False])
def test_modifiers_are_applied_or_kept(put, apply):
    obj = put(BOX)
    modifier = obj.modifiers.new("Array", "ARRAY")
    modifier.use_relative_offset, modifier.use_constant_offset = False, True
    modifier.constant_offset_displace = (10, 0, 0)
    assert bpy.ops.carreau.quads(quads=300, apply_modifiers=apply) == {"FINISHED"}
    made = bpy.context.active_object
    assert len(made.modifiers) == (0 if apply else 1) and len(obj.modifiers) == 1
    assert made.data.vertices[:] and abs(values(made.data.vertices, "co", 3)[:, 0].max() - (11 if apply else 1)) < 1e-5


def test_marked_edges_stay_paths_of_edges(put):
    """A line across a flat side, which no angle tells."""
    n = 8
    points = [(x, y, 0) for y in range(n + 1) for x in range(n + 1)]
    faces = [(k, k + 1, k + n + 2, k + n + 1) for y in range(n) for k in range(y * (n + 1), y * (n + 1) + n)]
    obj = put((points, faces))
    for edge in obj.data.edges:
        a, b = (obj.data.vertices[v].co for v in edge.vertices)
        edge.use_edge_sharp = a.y == b.y == 3
    assert bpy.ops.carreau.quads(quads=100) == {"FINISHED"}
    mesh = bpy.context.active_object.data
    on = [e for e in mesh.edges if all(abs(mesh.vertices[v].co.y - 3) < 1e-5 for v in e.vertices)]
    length = sum((mesh.vertices[a].co - mesh.vertices[b].co).length for a, b in (e.vertices for e in on))
    assert abs(length - n) < 1e-4 and all(e.use_edge_sharp for e in on)


def test_remesh_meets_its_number(put):
    obj = put("torus", resolution=40)
    assert bpy.ops.carreau.remesh(triangles=800) == {"FINISHED"}
    made = bpy.context.active_object
    assert made.name == "Part remeshed" and 700 < len(made.data.polygons) < 900 and closed(made.data)
    assert abs(volume(made) - volume(obj)) < 0.02 * volume(obj)
