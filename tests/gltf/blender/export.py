"""Opens a glTF file in Blender and writes it by the ordinary export: blender -b --python export.py -- FROM TO."""

import sys

import bpy

source, target = sys.argv[-2:]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=source)
bpy.ops.export_scene.gltf(filepath=target)
