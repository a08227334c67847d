"""What a loader gave of an export, in one form for all, and how far that is from the truth."""
import os
from dataclasses import dataclass, field

import cv2
import numpy as np


@dataclass
class View:
    """A photograph and its camera in the loader's world; the camera's axes: x right, y down, z forwards."""
    photograph: str
    cam_from_world: np.ndarray
    misses: callable  # of points in the camera's frame and their pixels in the photograph: distances in pixels
    mask: str = ""

    @property
    def stem(self):
        return os.path.splitext(os.path.basename(self.photograph))[0]


@dataclass
class Given:
    views: list
    points: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))


def lens(fx, fy, cx, cy, distortion=(), fisheye=False):
    """Distances to pixels whose centres are at halves, by OpenCV's lenses."""
    matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]], float)
    given = np.zeros(4 if fisheye else 8)
    given[: len(distortion)] = distortion

    def misses(in_cam, pixels):
        project = cv2.fisheye.projectPoints if fisheye else cv2.projectPoints
        shaped = np.asarray(in_cam, float).reshape(-1, 1, 3)
        projected, _ = (project(shaped, np.zeros((3, 1)), np.zeros((3, 1)), matrix, given))
        return np.linalg.norm(projected.reshape(-1, 2) - pixels, axis=1)

    return misses


def undistorted(in_photograph, fx, fy, cx, cy, size, equidistant=False):
    """Distances where the loader resamples the photograph itself, of what its picture of this size shows;
    in_photograph leads from its pixels to those of the photograph."""
    def misses(in_cam, pixels):
        in_cam = np.asarray(in_cam, float)
        x, y = in_cam[:, 0] / in_cam[:, 2], in_cam[:, 1] / in_cam[:, 2]
        if equidistant:
            r = np.hypot(x, y) + 1e-12
            x, y = x * np.arctan(r) / r, y * np.arctan(r) / r
        u, v = fx * x + cx, fy * y + cy
        shown = (u > 0.5) & (u < size[0] - 0.5) & (v > 0.5) & (v < size[1] - 0.5)
        return np.where(shown, np.linalg.norm(in_photograph(np.stack([u, v], 1)) - pixels, axis=1), 0)

    return misses


def rays(origin_and_directions, focal):
    """Distances by the rays through pixels (in the camera's frame), as angles times the focal length."""
    def misses(in_cam, pixels):
        given = origin_and_directions(pixels)
        given = given / np.linalg.norm(given, axis=1, keepdims=True)
        wanted = in_cam / np.linalg.norm(in_cam, axis=1, keepdims=True)
        return focal * np.linalg.norm(given - wanted, axis=1)

    return misses


def similarity(given, truth):
    """Scale, rotation and translation that lead from the truth's world to the loader's."""
    rotation = np.zeros((3, 3))
    for view in given.views:
        rotation += view.cam_from_world[:3, :3].T @ np.array(truth[view.stem]["cam_from_world"])[:3, :3]
    u, _, v = np.linalg.svd(rotation)
    rotation = u @ v
    here = np.array([-view.cam_from_world[:3, :3].T @ view.cam_from_world[:3, 3] for view in given.views])
    there = []
    for view in given.views:
        pose = np.array(truth[view.stem]["cam_from_world"])
        there.append(-pose[:3, :3].T @ pose[:3, 3])
    turned = np.array(there) @ rotation.T
    middle, turned_middle = here.mean(0), turned.mean(0)
    scale = np.sum((here - middle) * (turned - turned_middle)) / np.sum((turned - turned_middle) ** 2)
    return scale, rotation, middle - scale * turned_middle


def compare(given, truth):
    """A row of the table: numbers of photographs, masks and points, and the largest distance in pixels."""
    views = {view["stem"]: view for view in truth["views"]}
    row = {"images": len(given.views), "of": len(views), "masks": 0, "points": len(given.points)}
    row["photographs"] = sum(os.path.isfile(view.photograph) for view in given.views)
    scale, rotation, translation = similarity(given, views)
    in_loaders_world = lambda places: scale * np.asarray(places, float) @ rotation.T + translation
    worst = 0.0
    for view in given.views:
        expected = np.array(views[view.stem]["points"])
        pose = view.cam_from_world
        in_cam = in_loaders_world(expected[:, :3]) @ pose[:3, :3].T + pose[:3, 3]
        worst = max(worst, float(np.max(view.misses(in_cam, expected[:, 3:]))))
        if view.mask and os.path.isfile(view.mask):
            row["masks"] += 1
    row["px"] = worst
    row["points_off"] = None
    if len(given.points) and truth["points"]:
        wanted = in_loaders_world(truth["points"])
        distance = np.linalg.norm(np.asarray(given.points, float)[:, None] - wanted[None], axis=2).min(1)
        row["points_off"] = float(distance.max() / scale)
    return row
