"""What loaders of other programs read of `ulf export`:

    python3 loaders_of_others.py LOADERS COLMAP_TEXT COLMAP_BINARY NERF_SYNTHETIC

LOADERS: a folder with files of theirs (docs/exchange.md); those that are missing are left out. The others are exports, the
first two with --undistort. Prints one JSON object: of each loader that is there what it read.
"""
import importlib.util
import json
import math
import os
import sys
import types

import numpy as np

loaders, colmap_text, colmap_binary, nerf_synthetic = sys.argv[1:]


def stand_in(name, **members):
    """For a module that a loader asks for beside reading (paths of a video, smaller pictures)."""
    if importlib.util.find_spec(name) is None:
        sys.modules[name] = types.ModuleType(name)
        vars(sys.modules[name]).update(members)


def load(name):
    file = os.path.join(loaders, name)
    if not os.path.isfile(file):
        return None
    spec = importlib.util.spec_from_file_location(name.removesuffix(".py"), file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def model(images, cameras, points):
    """Of COLMAP's terms, as all readers of them name these."""
    return {
        "cameras": {
            str(camera.id): {"model": camera.model, "width": camera.width, "height": camera.height,
                             "params": list(map(float, camera.params))}
            for camera in cameras.values()
        },
        "images": {
            image.name: {"qvec": list(map(float, image.qvec)), "tvec": list(map(float, image.tvec)),
                         "camera": str(image.camera_id), "observations": int(np.sum(np.array(image.point3D_ids) != -1))}
            for image in images.values()
        },
        "points": points,
    }


read = {}
for form, folder in (("text", colmap_text), ("binary", colmap_binary)):
    file = lambda name: os.path.join(folder, "sparse/0", name + (".txt" if form == "text" else ".bin"))
    if inria := load("colmap_loader.py"):
        images = getattr(inria, "read_extrinsics_" + form)(file("images"))
        cameras = getattr(inria, "read_intrinsics_" + form)(file("cameras"))
        positions, _, _ = getattr(inria, "read_points3D_" + form)(file("points3D"))
        read["colmap_loader.py, " + form] = model(images, cameras, len(positions))
    if nerfstudio := load("colmap_parsing_utils.py"):
        images = getattr(nerfstudio, "read_images_" + form)(file("images"))
        cameras = getattr(nerfstudio, "read_cameras_" + form)(file("cameras"))
        points = getattr(nerfstudio, "read_points3D_" + form)(file("points3D"))
        read["colmap_parsing_utils.py, " + form] = model(images, cameras, len(points))

stand_in("tensorflow", float32=np.float32, cos=math.cos, sin=math.sin, stack=np.stack,
         convert_to_tensor=lambda rows, dtype=None: np.array(rows, dtype))
stand_in("torch", stack=lambda rows, _: np.stack(rows), Tensor=np.array, from_numpy=lambda array: array)
stand_in("cv2")
if nerf := load("load_blender.py"):
    pictures, poses, _, (height, width, focal), splits = nerf.load_blender_data(nerf_synthetic)
    read["load_blender.py"] = {
        "size": list(pictures.shape), "height": int(height), "width": int(width), "focal": float(focal),
        "splits": [len(split) for split in splits], "poses": poses.tolist(),
        "least": float(pictures.min()), "most": float(pictures.max()),
    }
print(json.dumps(read))
