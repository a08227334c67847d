"""3dgrut: threedgrut/datasets. NVIDIA's ncore, which makes its rays through OpenCV's lenses, is stood in for: what it
is given is taken by OpenCV's formulas."""
import os
import sys
import types
from dataclasses import asdict, dataclass

import numpy as np
import torch

from given import Given, View, lens, rays
from stand_ins import module, package_without_init, stand_in

FORMS = ["colmap", "nerf-synthetic"]


@dataclass
class Parameters:
    resolution: object = None
    shutter_type: object = None
    principal_point: object = None
    focal_length: object = None
    radial_coeffs: object = None
    tangential_coeffs: object = None
    thin_prism_coeffs: object = None
    max_angle: object = None

    def to_dict(self):
        return asdict(self)


class OpenCVPinholeCameraModelParameters(Parameters):
    pass


class OpenCVFisheyeCameraModelParameters(Parameters):
    pass


class CameraModel:
    @staticmethod
    def from_parameters(*_, **__):
        return CameraModel()

    def pixels_to_image_points(self, pixels):
        return pixels

    def image_points_to_camera_rays(self, points):
        return torch.zeros(len(points), 3)


def prepare(root):
    sys.path.insert(0, os.path.join(root, "3dgrut"))
    shutter = types.SimpleNamespace(GLOBAL=0)
    ncore = module("ncore")
    ncore.sensors = module("ncore.sensors", CameraModel=CameraModel)
    ncore.data = module("ncore.data", ShutterType=shutter,
                        OpenCVFisheyeCameraModelParameters=OpenCVFisheyeCameraModelParameters,
                        OpenCVPinholeCameraModelParameters=OpenCVPinholeCameraModelParameters)
    stand_in("einops", "kornia", "imageio", "polyscope", "omegaconf", "hydra", "wandb")
    package_without_init("threedgrut.datasets", os.path.join(root, "3dgrut/threedgrut/datasets"))
    torch.cuda.nvtx.range = lambda _: lambda function: function


def colmap_views(data):
    views = []
    for i in range(len(data)):
        item = data[i]
        parameters, _, directions, kind, centres = data.intrinsics[item["intr"]]
        fisheye = "Fisheye" in kind
        radial = parameters["radial_coeffs"]
        terms = radial if fisheye else [*radial[:2], *parameters["tangential_coeffs"], *radial[2:]]
        misses = lens(*parameters["focal_length"], *parameters["principal_point"], terms, fisheye)
        if not fisheye and not np.any(terms):  # then the rays are its own
            to_pixels = misses
            shown = directions.reshape(-1, 3).numpy()
            middles = centres.reshape(-1, 2).numpy()
            assert np.max(to_pixels(shown, middles)) < 1e-3, "its rays are not through the middles of pixels"
        mask = data.mask_paths[i] if "mask" in item else ""
        pose = np.linalg.inv(data.poses[i].astype(float))
        views.append(View(str(data.image_paths[i]), pose, misses, str(mask)))
    return views


def synthetic_views(data):
    fx, fy, cx, cy = data.intrinsics
    return [View(str(path), np.linalg.inv(pose.astype(float)), lens(fx, fy, cx, cy), str(path))
            for path, pose in zip(data.image_paths, data.poses)]


def load(folder, form):
    if form == "colmap":
        from threedgrut.datasets.dataset_colmap import ColmapDataset
        parts = [ColmapDataset(folder, device="cpu", split=split) for split in ("train", "val")]
        from threedgrut.datasets.utils import read_colmap_points3D_binary, read_colmap_points3D_text
        points = os.path.join(folder, "sparse/0/points3D.")
        read = (read_colmap_points3D_binary(points + "bin") if os.path.exists(points + "bin")
                else read_colmap_points3D_text(points + "txt"))
        return Given([view for part in parts for view in colmap_views(part)], read[0])
    from threedgrut.datasets.dataset_nerf import NeRFDataset
    parts = [NeRFDataset(folder, device="cpu", split=split, bg_color="black") for split in ("train", "val")]
    return Given([view for part in parts for view in synthetic_views(part)])
