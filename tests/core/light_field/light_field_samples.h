// A small light field to write and read back: cameras in a row, pictures of noise.
#pragma once

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "core/light_field/folder/light_field_writer.h"

namespace ulf {

namespace fs = std::filesystem;

inline constexpr int kWidth = 64, kHeight = 48;

inline CaptureHeader Header() {
  CaptureHeader header;
  header.camera = CameraModel::FromOpenCv(kWidth, kHeight, 60, 61, 31, 23, Distortion::kRadialTangential,
                                          {0.01, -0.002, 0.0003, -0.0004, 0});
  header.device_uri = "sim:test";
  header.device_serial = "S1";
  header.threshold_px = 7;
  return header;
}

inline Frame NoiseFrame(int seed, Transfer transfer = Transfer::kSrgb, int type = CV_8UC3) {
  Frame frame;
  frame.image.pixels.create(kHeight, kWidth, type);
  cv::RNG random(static_cast<std::uint64_t>(seed) + 1);
  random.fill(frame.image.pixels, cv::RNG::UNIFORM, 0, 256);
  frame.image.transfer = transfer;
  frame.device_time_s = 0.1 * seed;
  frame.host_time_s = 1000 + 0.1 * seed;
  frame.exposure_s = 0.004;
  frame.gain = 2;
  return frame;
}

// Cameras on a row, looking at (0, 0, 3).
inline View ViewNumber(int i) {
  View view;
  view.cam_from_world = LookAt({0.3 * i, -0.2, 0.01 * i}, {0, 0, 3}, {0, -1, 0});
  view.tracking_quality = 0.9;
  if (i > 0) view.bound_px = 7.5 + i;
  return view;
}

inline void ExpectSame(const LightField& a, const LightField& b) {
  ASSERT_EQ(a.cameras.size(), b.cameras.size());
  for (std::size_t i = 0; i < a.cameras.size(); ++i) EXPECT_EQ(a.cameras[i], b.cameras[i]);
  ASSERT_EQ(a.views.size(), b.views.size());
  for (std::size_t i = 0; i < a.views.size(); ++i) {
    const View &v = a.views[i], &w = b.views[i];
    EXPECT_EQ(v.id, w.id);
    EXPECT_EQ(v.image_path, w.image_path);
    EXPECT_EQ(v.master_path, w.master_path);
    EXPECT_EQ(v.camera, w.camera);
    EXPECT_LT((v.cam_from_world.Matrix() - w.cam_from_world.Matrix()).norm(), 1e-12);
    EXPECT_EQ(v.device_time_s, w.device_time_s);
    EXPECT_EQ(v.exposure_s, w.exposure_s);
    EXPECT_EQ(v.gain, w.gain);
    EXPECT_EQ(v.bound_px, w.bound_px);
    EXPECT_EQ(v.twist, w.twist);
  }
  EXPECT_EQ(a.subject, b.subject);
  EXPECT_EQ(a.threshold_px, b.threshold_px);
  EXPECT_EQ(a.goal, b.goal);
  EXPECT_EQ(a.readout, b.readout);
  EXPECT_EQ(a.device_serial, b.device_serial);
  EXPECT_EQ(a.capture_s, b.capture_s);
  EXPECT_EQ(a.reasons, b.reasons);
  EXPECT_EQ(a.points.size(), b.points.size());
}

inline LightField WriteSample(const fs::path& dir, int views) {
  LightFieldWriter writer = LightFieldWriter::Create(dir, Header());
  writer.SetSubject({{0, 0, 3}, 0.4});
  writer.SetGoal({{60, 40}, 0.95});
  for (int i = 0; i < views; ++i) writer.AddView(NoiseFrame(i), ViewNumber(i));
  writer.SetPoints({{{1, 2, 3}, {10, 20, 30}}, {{-1, 0.5, 2}, {200, 100, 0}}});
  writer.SetReadout({0.0281, 0.0004});
  writer.Close(12.5, {{"recorded", 5}, {"covered", 7}});
  return writer.Contents();
}
// Views that are recorded while their photographs are still in the masters.
inline LightFieldWriter WriterAheadOfItsPhotographs(const std::filesystem::path& dir, int views) {
  LightFieldWriter writer = LightFieldWriter::Create(dir, Header());
  for (int i = 0; i < views; ++i) {
    LightFieldWriter::NewView added{NoiseFrame(i), {}, {}};
    added.frame.image.pixels.convertTo(added.frame.image.pixels, CV_16U, 257);
    added.frame.image.transfer = Transfer::kLinear;
    added.files = writer.Files(added.frame, MakePictures::kLater);
    writer.AddViews({&added, 1});
  }
  return writer;
}

}  // namespace ulf
