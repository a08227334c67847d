// Captures of a textured plane, and what is left of their views after a fault.
#pragma once

#include <gmock/gmock.h>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/view_images.h"
#include "core/light_field/light_field.h"
#include "tests/coverage/session/planar_capture.h"
#include "tracking/sources/pose_sources.h"

namespace ulf::test {

// A hand that goes round the subject: every frame is a view.
inline std::vector<PlanarShot> Arc(int count) {
  std::vector<PlanarShot> shots;
  for (int i = 0; i < count; ++i) shots.push_back({PoseAt(-60 + 2.0 * i, 0)});
  return shots;
}

inline CaptureOptions InThreads() {
  CaptureOptions options = Options();
  options.deterministic = false;
  return options;
}

// What the camera gave for each view: its master or, without one, its photograph, as the disk has it. Each
// photograph, or what it is made from, is whole, and so is every exposure beside it.
inline std::map<int, std::string> Photographs(const std::filesystem::path& dir) {
  const LightField light_field = ReadLightField(dir);
  std::map<int, std::string> photographs;
  for (const View& view : light_field.views) {
    EXPECT_NO_THROW(ReadViewImage(light_field, view)) << view.id;
    for (const ViewExposure& exposure : view.exposures) {
      EXPECT_NO_THROW(ReadViewLight(light_field, PhotographOf(view, exposure))) << view.id;
    }
    photographs[view.id] =
        ReadWholeFile(dir / (view.master_path.empty() ? view.image_path : view.master_path));
  }
  return photographs;
}

// How many of `kept` differ from what they were, or are gone.
inline int Lost(const std::map<int, std::string>& kept, const std::map<int, std::string>& now) {
  int lost = 0;
  for (const auto& [id, bytes] : kept) lost += !now.contains(id) || now.at(id) != bytes;
  return lost;
}

// Goes on with what is there, or begins where nothing is yet.
inline Captured GoOn(const std::filesystem::path& dir) {
  const bool is_there = [&] {
    try {
      ReadLightField(dir);
      return true;
    } catch (const Error&) {
      return false;
    }
  }();
  PlanarDevice device({{PoseAt(0, 8)}, {PoseAt(0, 16)}});
  const auto poses = MakeKnownPoseSource(kCamera, kSubject);
  device.Start();
  Captured captured;
  captured.summary = RunCapture(device, kCamera, *poses,
                                is_there ? LightFieldWriter::Resume(dir) : NewWriter(dir), Options());
  captured.light_field = ReadLightField(dir);
  return captured;
}

}  // namespace ulf::test
