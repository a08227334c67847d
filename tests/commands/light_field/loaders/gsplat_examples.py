"""gsplat's examples: examples/datasets/colmap.py. `gsplat-1.5.3` reads by rmbrualla's pycolmap; for the newer one a
stand-in holds what COLMAP's own pycolmap would, read by nerfstudio's reader of the same files."""
import importlib.util
import os
import sys

import cv2
import numpy as np
from PIL import Image

from given import Given, View, lens, undistorted
from stand_ins import module, stand_in

FORMS = ["colmap"]
version = None


def older_pycolmap(root):
    """A package of this name, whatever the folder is called."""
    folder = os.path.join(root, "pycolmap", "pycolmap")
    spec = importlib.util.spec_from_file_location("pycolmap", os.path.join(folder, "__init__.py"),
                                                  submodule_search_locations=[folder])
    made = importlib.util.module_from_spec(spec)
    sys.modules["pycolmap"] = made
    spec.loader.exec_module(made)
    return made


NAMES = ["SIMPLE_PINHOLE", "PINHOLE", "SIMPLE_RADIAL", "RADIAL", "OPENCV", "OPENCV_FISHEYE", "FULL_OPENCV"]


def reconstruction_of(nerfstudio_utils):
    """COLMAP's own reader is in C++; what it would hold, by another's reader of the same files."""
    class Camera:
        def __init__(self, camera):
            self.model_name, self.width, self.height = camera.model, camera.width, camera.height
            self.params = np.array(camera.params, float)

        def calibration_matrix(self):
            fx, fy, cx, cy = self.params[:4]
            return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])

    class Pose:
        def __init__(self, matrix):
            self.matrix = lambda: matrix

    class ImageOf:
        def __init__(self, image):
            self.name, self.camera_id = image.name, image.camera_id
            rotation = nerfstudio_utils.qvec2rotmat(image.qvec)
            self.cam_from_world = Pose(np.hstack([rotation, np.reshape(image.tvec, (3, 1))]))

    class Element:
        def __init__(self, image_id):
            self.image_id = image_id

    class Track:
        def __init__(self, ids):
            self.elements = [Element(i) for i in ids]

    class Point:
        def __init__(self, point):
            self.xyz, self.color, self.error = point.xyz, point.rgb, point.error
            self.track = Track(point.image_ids)

    class Reconstruction:
        def __init__(self, folder):
            form, ending = ("text", "txt")
            if os.path.exists(os.path.join(folder, "cameras.bin")):
                form, ending = ("binary", "bin")
            read = lambda what: getattr(nerfstudio_utils, f"read_{what}_{form}")(
                os.path.join(folder, f"{what}.{ending}"))
            self.cameras = {i: Camera(camera) for i, camera in read("cameras").items()}
            self.images = {i: ImageOf(image) for i, image in read("images").items()}
            self.points3D = {i: Point(point) for i, point in read("points3D").items()}

        def reg_image_ids(self):
            return list(self.images)

    return Reconstruction


def prepare(root):
    stand_in("piexif")
    module("imageio")
    module("imageio.v2", imread=lambda path: np.array(Image.open(path)), imwrite=None)
    sys.modules["imageio"].v2 = sys.modules["imageio.v2"]
    sys.path.insert(0, os.path.join(root, version, "examples"))
    if version == "gsplat-1.5.3":
        older_pycolmap(root)
        return
    file = os.path.join(root, "nerfstudio/nerfstudio/data/utils/colmap_parsing_utils.py")
    spec = importlib.util.spec_from_file_location("colmap_parsing_utils", file)
    utils = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(utils)
    module("pycolmap", Reconstruction=reconstruction_of(utils))


def load(folder, form):
    from datasets.colmap import Dataset, Parser
    parser = Parser(folder, factor=1, normalize=False)
    Dataset(parser)[0]
    views = []
    for name, pose, camera in zip(parser.image_paths, parser.camtoworlds, parser.camera_ids):
        matrix = parser.Ks_dict[camera]
        fx, fy, cx, cy = matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]
        misses = lens(fx, fy, cx, cy)
        if len(parser.params_dict[camera]):
            x, y = parser.roi_undist_dict[camera][:2]
            maps = parser.mapx_dict[camera], parser.mapy_dict[camera]

            # Its pixel (i, j) shows what lies at its maps (i, j); centres are at halves in both.
            def in_photograph(pixels, maps=maps, corner=(x, y)):
                at = (pixels + np.array(corner) - 0.5).astype(np.float32).reshape(-1, 1, 2)
                return np.stack([cv2.remap(one, at, None, cv2.INTER_LINEAR, cv2.BORDER_REPLICATE).ravel()
                                 for one in maps], 1) + 0.5

            # Fisheyes alone get a mask; they stay equidistant (the trainer's camera_model fisheye).
            misses = undistorted(in_photograph, fx, fy, cx, cy, parser.imsize_dict[camera],
                                 parser.mask_dict[camera] is not None)
        views.append(View(name, np.linalg.inv(pose), misses))
    return Given(views, parser.points)
