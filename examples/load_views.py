"""load_views.py LIGHT_FIELD: a capture as NumPy arrays: poses, intrinsics, pictures, masks, depth, coverage."""
import sys

import numpy as np
import ulf

field = ulf.open(sys.argv[1])
cam_from_world = np.stack([view.cam_from_world for view in field.views])  # n x 4 x 4, as OpenCV's cameras
intrinsics = np.stack([view.camera.K for view in field.views])  # n x 3 x 3, pixels
centers = np.stack([view.center for view in field.views])  # n x 3, in the world
pictures = [view.picture() for view in field.views]  # height x width x 3, 8-bit sRGB
masks = [view.mask() for view in field.views]  # height x width, or None where all pixels count
print(f"{len(field)} views, poses {cam_from_world.shape}, first picture {pictures[0].shape}, {field.units}")
print(f"{sum(mask is not None for mask in masks)} masks, {len(field.points)} points")
print("focal lengths", np.unique(intrinsics[:, 0, 0]), "viewpoints from", centers.min(0), "to", centers.max(0))

coverage = field.coverage(cap_deg=(60, 40))
print(f"{100 * coverage.share:.1f} % of 60 x 40 degrees covered within {coverage.threshold_px:g} px")
try:
    depth, camera = field.views[0].depth()
    print(f"depth {depth.shape}, median {np.nanmedian(depth):.3f}")
except ulf.Error as error:
    print(error)
