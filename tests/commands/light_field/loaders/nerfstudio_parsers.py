"""nerfstudio: its data parsers, and the rays of the cameras that they make."""
import os
import sys
from pathlib import Path

import numpy as np
import torch

from given import Given, View, rays
from stand_ins import Anything, module, stand_in

FORMS = ["colmap", "nerfstudio", "instant-ngp"]


def prepare(root):
    sys.path.insert(0, os.path.join(root, "nerfstudio"))
    stand_in("jaxtyping", "tyro", "viser", "nerfacc", "splines", "mediapy", "torchmetrics", "wandb", "appdirs",
             "packaging", "newrawpy", "rawpy", "matplotlib")
    module("torch.utils.tensorboard", SummaryWriter=Anything)


def configured(folder, form):
    data = Path(folder)
    if form == "colmap":
        from nerfstudio.data.dataparsers.colmap_dataparser import ColmapDataParserConfig as Config
        masks = Path("masks") if (data / "masks").is_dir() else None
        return Config(data=data, colmap_path=Path("sparse/0"), eval_mode="all", masks_path=masks)
    if form == "nerfstudio":
        from nerfstudio.data.dataparsers.nerfstudio_dataparser import NerfstudioDataParserConfig as Config
        return Config(data=data, eval_mode="all", load_3D_points=True)
    from nerfstudio.data.dataparsers.instant_ngp_dataparser import InstantNGPDataParserConfig as Config
    return Config(data=data, eval_mode="all")


def load(folder, form):
    config = configured(folder, form)
    outputs = config._target(config).get_dataparser_outputs(split="train")
    cameras = outputs.cameras
    views = []
    for i, name in enumerate(outputs.image_filenames):
        pose = np.eye(4)
        pose[:3] = cameras.camera_to_worlds[i].numpy()
        pose[:, 1:3] *= -1

        def directions(pixels, i=i, pose=pose):
            coords = torch.tensor(pixels[:, ::-1].copy(), dtype=torch.float32)
            index = torch.full((len(pixels), 1), i)
            bundle = cameras.generate_rays(camera_indices=index, coords=coords)
            return bundle.directions.numpy() @ pose[:3, :3]

        mask = str(outputs.mask_filenames[i]) if outputs.mask_filenames else ""
        views.append(View(str(name), np.linalg.inv(pose), rays(directions, float(cameras.fx[i])), mask))
    points = outputs.metadata.get("points3D_xyz") if outputs.metadata else None
    return Given(views, points.numpy() if points is not None else np.empty((0, 3)))
