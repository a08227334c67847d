"""What Blender's importer of glTF makes of a file:

    blender --background --factory-startup --python cameras_in_blender.py -- FILE.glb OUT.json

OUT: of each camera the 4x4 matrix that takes it to Blender's world (rows; along -z, y up) and its angle from top to bottom;
and how many triangles there are.
"""
import json
import sys

import bpy
import numpy

numpy.bool = bool  # Debian 12's Blender asks for a name that Debian 12's NumPy no longer has

file, out = sys.argv[sys.argv.index("--") + 1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=file)
read = {"cameras": {}, "triangles": 0}
for thing in bpy.data.objects:
    if thing.type == "CAMERA":
        read["cameras"][thing.name] = {
            "world_from_camera": [list(row) for row in thing.matrix_world],
            "angle_y": thing.data.angle_y,
        }
    elif thing.type == "MESH":
        thing.data.calc_loop_triangles()
        read["triangles"] += len(thing.data.loop_triangles)
with open(out, "w") as file:
    json.dump(read, file)
