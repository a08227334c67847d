"""Inria's gaussian-splatting: scene/dataset_readers.py, then the cameras that its trainer makes."""
import os
import sys
import types

import numpy as np
import torch

from given import Given, View
from stand_ins import module, package_without_init

FORMS = ["colmap", "nerf-synthetic"]

stored = {}  # what would be points3D.ply in the export's folder


class PlyElement:
    @staticmethod
    def describe(elements, _):
        return elements


class PlyData:
    def __init__(self, elements):
        self.elements = elements[0]

    def write(self, path):
        stored[path] = self.elements

    @staticmethod
    def read(path):
        return {"vertex": stored[path]}


def prepare(root):
    sys.path.insert(0, os.path.join(root, "gaussian-splatting"))
    module("plyfile", PlyData=PlyData, PlyElement=PlyElement)
    package_without_init("scene", os.path.join(root, "gaussian-splatting", "scene"))
    from utils.graphics_utils import BasicPointCloud
    module("scene.gaussian_model", BasicPointCloud=BasicPointCloud)  # asks for CUDA's simple_knn
    torch.Tensor.cuda = lambda self: self


def view_of(info, number):
    from utils.camera_utils import loadCam
    arguments = types.SimpleNamespace(resolution=-1, data_device="cpu", train_test_exp=False)
    camera = loadCam(arguments, number, info, 1.0, False, False)
    projection = camera.projection_matrix.numpy().astype(float)
    size = np.array([camera.image_width, camera.image_height])

    def misses(in_cam, pixels):
        clip = np.hstack([in_cam, np.ones((len(in_cam), 1))]) @ projection
        return np.linalg.norm((clip[:, :2] / clip[:, 3:] + 1) * size / 2 - pixels, axis=1)

    pose = camera.world_view_transform.numpy().T.astype(float)
    mask = info.image_path if float(camera.alpha_mask.min()) == 0 else ""
    return View(info.image_path, pose, misses, mask)


def load(folder, form):
    from scene.dataset_readers import sceneLoadTypeCallbacks
    if form == "colmap":
        scene = sceneLoadTypeCallbacks["Colmap"](folder, "images", "", False, False)
    else:
        scene = sceneLoadTypeCallbacks["Blender"](folder, False, "", False)
    points = scene.point_cloud.points if form == "colmap" else np.empty((0, 3))
    return Given([view_of(info, i) for i, info in enumerate(scene.train_cameras)], points)
