"""The add-on in a fresh scene.

From the environment: CARREAU, the executable; CARREAU_ADDON, the folder of the add-on as it is packed.
"""

import importlib.util
import os
import subprocess
import sys

import bpy
import pytest

CARREAU = os.environ["CARREAU"]
ADDON = os.environ["CARREAU_ADDON"]
NAME = "carreau_blender"


def _load():
    spec = importlib.util.spec_from_file_location(
        NAME, os.path.join(ADDON, "__init__.py"), submodule_search_locations=[ADDON]
    )
    module = importlib.util.module_from_spec(spec)
    sys.modules[NAME] = module
    spec.loader.exec_module(module)
    return module


_load()


@pytest.fixture(autouse=True)
def scene():
    """The factory's scene, without its cube; the add-on is on, with the program in its preferences."""
    bpy.ops.wm.read_factory_settings()
    addon = bpy.context.preferences.addons.new()
    addon.module = NAME
    sys.modules[NAME].register()
    addon.preferences.path = CARREAU
    bpy.data.objects.remove(bpy.data.objects["Cube"])
    yield bpy.context.scene
    sys.modules[NAME].unregister()
    bpy.context.preferences.addons.remove(addon)


@pytest.fixture(scope="session")
def sample(tmp_path_factory):
    """The file of a built-in model, as OBJ."""
    folder = tmp_path_factory.mktemp("samples")

    def make(name, resolution=None):
        path = folder / f"{name}-{resolution}.obj"
        if not path.exists():
            more = ["--resolution", str(resolution)] if resolution else []
            subprocess.run([CARREAU, "sample", name, "-q", *more, "-o", path], check=True)
        return str(path)

    return make


@pytest.fixture
def put(sample):
    """Puts a built-in model, or points and faces, into the scene as the active object."""

    def make(what, name="Part", resolution=None):
        if isinstance(what, str):
            bpy.ops.wm.obj_import(
                filepath=sample(what, resolution), forward_axis="Y", up_axis="Z", use_split_groups=False
            )
            obj = bpy.context.selected_objects[0]
            obj.name = name
        else:
            mesh = bpy.data.meshes.new(name)
            mesh.from_pydata(what[0], [], what[1])
            obj = bpy.data.objects.new(name, mesh)
            bpy.context.collection.objects.link(obj)
        for other in bpy.context.selected_objects:
            other.select_set(False)
        obj.select_set(True)
        bpy.context.view_layer.objects.active = obj
        return obj

    return make
