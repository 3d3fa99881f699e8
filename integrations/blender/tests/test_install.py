"""Blender installs the archive as it installs any extension, into a folder of its own."""

import os
import subprocess
import sys

from conftest import ADDON, CARREAU

SCRIPT = """
import sys, bpy
archive, program = sys.argv[1:]
name = "bl_ext.user_default.carreau"
bpy.ops.extensions.package_install_files(filepath=archive, repo="user_default", enable_on_install=True)
bpy.context.preferences.addons[name].preferences.path = program
bpy.ops.mesh.primitive_cube_add()
assert bpy.ops.carreau.quads(quads=100) == {"FINISHED"}
assert all(face.loop_total == 4 for face in bpy.context.active_object.data.polygons)
for _ in range(2):
    bpy.ops.preferences.addon_disable(module=name)
    assert not hasattr(bpy.types, "CARREAU_OT_quads") and not hasattr(bpy.types.Scene, "carreau")
    bpy.ops.preferences.addon_enable(module=name)
    assert hasattr(bpy.types, "CARREAU_OT_quads") and hasattr(bpy.types.Scene, "carreau")
print("installed")
"""


def test_the_archive_is_an_extension(tmp_path):
    environment = {**os.environ, "BLENDER_USER_RESOURCES": str(tmp_path)}
    command = [sys.executable, "-c", SCRIPT, f"{ADDON}.zip", CARREAU]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)
    assert "installed" in done.stdout, done.stderr
    assert not [line for line in done.stderr.splitlines() if "Traceback" in line], done.stderr
