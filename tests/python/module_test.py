"""Tests: python/opened_field, python/ulf_module, examples/load_views, examples/compare_captures.

The module on drawn photographs of a plane, whose poses, colours and depths are known by formulas of this file.
"""
import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import threading
import unittest
import zlib

import numpy as np
import ulf

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples"
WIDTH, HEIGHT, FOCAL = 96, 72, 90.0
K = np.array([[FOCAL, 0, 47.0], [0, FOCAL, 37.0], [0, 0, 1]])
SUBJECT = ([0.0, 0.0, 0.0], 0.3)


def write_png(path, pixels):
    """8 bits, grey or RGB."""
    color = {2: 0, 3: 2}[pixels.ndim]
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", pixels.shape[1], pixels.shape[0], 8, color, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) +
                     chunk(b"IEND", b""))


def looking_at_origin(center):
    """cam_from_world of a camera that looks at the origin, its x axis along the world's xy plane."""
    forward = -np.array(center) / np.linalg.norm(center)
    right = np.cross(forward, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(forward, right), forward])
    pose = np.eye(4)
    pose[:3, :3] = rotation
    pose[:3, 3] = -rotation @ center
    return pose


def turned(pose, degrees, axis):
    """The camera turned in its place, about its own x or y axis."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turn = np.eye(4)
    turn[:3, :3] = [[1, 0, 0], [0, c, -s], [0, s, c]] if axis == 0 else [[c, 0, s], [0, 1, 0], [-s, 0, c]]
    return turn @ pose


def plane_seen_by(pose, k=K):
    """The picture of the plane z = 0, 8-bit sRGB, and its depths along the optical axis."""
    y, x = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    rays = np.stack([(x - k[0, 2]) / k[0, 0], (y - k[1, 2]) / k[1, 1], np.ones_like(x)], axis=-1)
    center = -pose[:3, :3].T @ pose[:3, 3]
    directions = rays @ pose[:3, :3]
    depth = -center[2] / directions[..., 2]
    u, v = (center[i] + depth * directions[..., i] for i in (0, 1))
    waves = [np.sin(9 * u + 1), np.sin(8 * v - 0.5 + 2 * u), np.sin(7 * u - 6 * v)]
    return np.round(255 * (0.5 + 0.4 * np.stack(waves, axis=-1))).astype(np.uint8), depth


POSES = [looking_at_origin([0.18 * i, 0.18 * j, 1.6]) for j in (-1, 0, 1) for i in (-2, -1, 0, 1, 2)]
PICTURES = [plane_seen_by(pose)[0] for pose in POSES]
MASK = np.full((HEIGHT, WIDTH), 255, np.uint8)
MASK[:10, :20] = 0


def write_set(folder, poses, mask=False):
    (folder / "images").mkdir(parents=True)
    frames = []
    for i, (pose, picture) in enumerate(zip(poses, PICTURES)):
        name = f"images/{i:03}.png"
        write_png(folder / name, picture)
        frames.append({"file_path": name,
                       "transform_matrix": (np.linalg.inv(pose) @ np.diag([1, -1, -1, 1])).tolist()})
        if mask:
            write_png(folder / f"mask{i}.png", MASK)
            frames[-1]["mask_path"] = f"mask{i}.png"
    center, radius = SUBJECT
    (folder / "points.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n"
        "0.25 0.5 0 10 20 30\n-0.25 0.5 0 40 50 60\n")
    (folder / "proxy.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
        "-9 -9 0\n9 -9 0\n9 9 0\n-9 9 0\n3 0 1 2\n3 0 2 3\n")
    (folder / "transforms.json").write_text(json.dumps({
        "w": WIDTH, "h": HEIGHT, "fl_x": FOCAL, "fl_y": FOCAL, "cx": K[0, 2], "cy": K[1, 2], "frames": frames,
        "ply_file_path": "points.ply",
        "ulf": {"format_version": 1, "subject": {"center": center, "radius": radius}}}))
    return folder


def srgb(light):
    """IEC 61966-2-1."""
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 0) ** (1 / 2.4) - 0.055)


def psnr_db(a, b):
    return 10 * np.log10(255**2 / np.mean((a.astype(float) - b) ** 2))


class Module(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = write_set(pathlib.Path(cls.scratch.name) / "set", POSES)
        cls.field = ulf.open(cls.folder)

    @classmethod
    def tearDownClass(cls):
        del cls.field
        cls.scratch.cleanup()

    def test_gives_what_the_files_hold(self):
        field = self.field
        self.assertEqual(len(field), len(POSES))
        self.assertEqual(field.root, self.folder)
        np.testing.assert_array_equal(field.subject[0], SUBJECT[0])
        self.assertEqual(field.subject[1], SUBJECT[1])
        for view, pose, picture in zip(field.views, POSES, PICTURES):
            np.testing.assert_allclose(view.cam_from_world, pose, atol=1e-9)
            np.testing.assert_allclose(pose[:3, :3] @ view.center + pose[:3, 3], 0, atol=1e-9)
            np.testing.assert_array_equal(view.camera.K, K)
            self.assertEqual((view.camera.width, view.camera.height), (WIDTH, HEIGHT))
            self.assertEqual(view.camera.distortion, "none")
            np.testing.assert_array_equal(view.picture(), picture)
            self.assertTrue(view.path.is_file())
        self.assertIsNone(field.views[0].mask())
        np.testing.assert_array_equal(field.points, [[0.25, 0.5, 0], [-0.25, 0.5, 0]])
        np.testing.assert_array_equal(field.point_colors, [[10, 20, 30], [40, 50, 60]])
        light = field.views[3].light()
        np.testing.assert_array_equal(np.round(255 * srgb(light)).astype(np.uint8), PICTURES[3])

    def test_gives_masks(self):
        masked = ulf.open(write_set(pathlib.Path(self.scratch.name) / "masked", POSES[:3], mask=True))
        np.testing.assert_array_equal(masked.views[1].mask(), MASK > 0)
        self.assertEqual(masked.views[1].mask().dtype, bool)

    def test_gives_depth_along_the_axis(self):
        depth, camera = self.field.views[4].depth()
        self.assertEqual(depth.shape, (camera.height, camera.width))
        np.testing.assert_allclose(depth, plane_seen_by(POSES[4])[1], rtol=1e-3)

    def test_renders_what_a_new_camera_sees(self):
        pose = looking_at_origin([0.09, -0.05, 1.55])
        expected = plane_seen_by(pose)[0]
        picture = self.field.render(pose)
        self.assertEqual(picture.dtype, np.uint8)
        self.assertGreater(psnr_db(picture[6:-6, 6:-6], expected[6:-6, 6:-6]), 35)
        self.assertEqual(self.field.render(pose, width=48).shape, (36, 48, 3))
        self.assertEqual(self.field.render(pose, width=48, height=20).shape, (20, 48, 3))
        linear = self.field.render(pose, linear=True)
        encoded = srgb(linear)
        self.assertLessEqual(np.abs(255 * encoded - picture).max(), 0.51)
        near = np.array([[1.5 * FOCAL, 0, 40], [0, 1.5 * FOCAL, 30], [0, 0, 1]])
        picture = self.field.render(pose, camera=ulf.Camera(WIDTH, HEIGHT, near))
        self.assertGreater(psnr_db(picture, plane_seen_by(pose, near)[0]), 30)

    def test_renders_in_several_threads(self):
        pictures = {}
        threads = [threading.Thread(target=lambda i=i: pictures.update({i: self.field.render(POSES[i])}))
                   for i in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for i in range(3):
            np.testing.assert_array_equal(pictures[i], self.field.render(POSES[i]))

    def test_tells_what_a_cap_is_covered_by(self):
        coverage = self.field.coverage(cap_deg=(60, 40))
        area_sr = np.radians(60) * 2 * np.sin(np.radians(20))
        self.assertAlmostEqual(coverage.solid_angle_sr.sum(), area_sr, delta=0.01)
        np.testing.assert_allclose(np.linalg.norm(coverage.directions, axis=1), 1, atol=1e-9)
        covered = np.isfinite(coverage.bound_px)
        share = coverage.solid_angle_sr[covered].sum() / coverage.solid_angle_sr.sum()
        self.assertAlmostEqual(coverage.share, share, delta=1e-6)
        self.assertTrue(0 < coverage.share < 1)
        self.assertTrue((coverage.bound_px[covered] <= coverage.threshold_px).all())
        np.testing.assert_array_equal(coverage.view_id >= 0, covered)
        self.assertLessEqual(set(coverage.view_id[covered]), {view.id for view in self.field.views})
        self.assertEqual(self.field.coverage((0.5, 0.5)).share, 1)
        self.assertGreater(self.field.coverage((60, 40), threshold_px=20).share, coverage.share)

    def test_renders_left_out_views_from_the_others(self):
        ids = [self.field.views[i].id for i in (6, 8)]
        pictures = self.field.left_out(ids)
        self.assertEqual([picture.id for picture in pictures], ids)
        for picture, index in zip(pictures, (6, 8)):
            np.testing.assert_array_equal(picture.photograph, PICTURES[index])
            self.assertTrue(picture.valid.all())
            self.assertAlmostEqual(picture.psnr_db, psnr_db(picture.rendered, picture.photograph), places=6)
            self.assertGreater(picture.psnr_db, 30)

    def test_says_what_cannot_be_done(self):
        with self.assertRaisesRegex(ulf.Error, "nowhere"):
            ulf.open(self.folder / "nowhere")
        self.assertTrue(issubclass(ulf.Refusal, ulf.Error) and issubclass(ulf.Error, RuntimeError))
        with self.assertRaisesRegex(ulf.Refusal, "rigid"):
            self.field.render(2 * np.eye(4))
        with self.assertRaisesRegex(ulf.Refusal, "width"):
            self.field.render(POSES[0], width=-1)
        with self.assertRaises(ulf.Refusal):
            self.field.coverage((0, 40))
        with self.assertRaisesRegex(ulf.Refusal, "no view"):
            self.field.left_out([12345])
        with self.assertRaises(ulf.Refusal):
            ulf.open(self.folder, subject=([0, 0, 0], -1))
        self.assertEqual(ulf.open(self.folder, subject=([0, 0, 1], 2)).subject[1], 2)
        bare = write_set(pathlib.Path(self.scratch.name) / "bare", POSES)
        (bare / "proxy.ply").unlink()
        with self.assertRaisesRegex(ulf.Error, "ulf proxy"):
            ulf.open(bare).views[0].depth()
        (bare / "images/002.png").write_bytes(b"no picture")
        with self.assertRaisesRegex(ulf.Error, "002.png"):
            ulf.open(bare).views[2].picture()

    def run_example(self, name, *arguments):
        run = subprocess.run([sys.executable, EXAMPLES / name, *arguments], capture_output=True, text=True,
                             check=False)
        self.assertEqual(run.returncode, 0, run.stderr)
        return run.stdout

    def test_example_loads_a_capture(self):
        self.assertRegex(self.run_example("load_views.py", self.folder),
                         rf"^{len(POSES)} views, poses \({len(POSES)}, 4, 4\), first picture \({HEIGHT}, {WIDTH}, 3\)")

    # The same photographs with poses that are off: the worse by far.
    def test_example_compares_captures(self):
        off = [turned(pose, 1.5 * (-1) ** i, i % 2) for i, pose in enumerate(POSES)]
        other = write_set(pathlib.Path(self.scratch.name) / "off", off)
        mean = self.run_example("compare_captures.py", self.folder, other).splitlines()[-1].split()
        self.assertGreater(float(mean[1]), float(mean[4]) + 3)
        self.assertEqual(mean[7:], ["2", "photographs"])


if __name__ == "__main__":
    unittest.main()
