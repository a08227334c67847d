// A light field as a capture of the simulated turntable leaves it, with true poses and true masks.
#pragma once

#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "acquisition/simulator/simulated_camera.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "tests/support/floors.h"

namespace ulf::test {

struct TurntableField {
  LightField light_field;
  std::map<int, cv::Mat> truth;  // by View::id
};

// `views` of one turn from each of the heights of sim:turntable with these options; the world is the
// board's frame.
inline TurntableField MakeTurntableField(const std::filesystem::path& dir, const std::string& options,
                                         int views, int heights) {
  const acquisition::SimulatedCamera camera(
      acquisition::SimulationOptions::FromUri(DeviceUri::Parse("sim:turntable?" + options)));
  CaptureHeader header;
  header.camera = camera.camera();
  header.units = "metres";
  LightFieldWriter writer = LightFieldWriter::Create(dir, header);
  const acquisition::StandingBoard& board = *camera.scene().board();
  Subject subject = camera.scene().subject();
  subject.center_in_world = board.board_from_world * subject.center_in_world;
  writer.SetSubject(subject);
  writer.SetTurntable({board.board.Text()});
  TurntableField field;
  const double turn_s = 2 * M_PI / camera.options().turn_speed;
  for (int height = 0; height < heights; ++height)
    for (int i = 0; i < views; ++i) {
      // A turn takes as long as the camera stands; then it is raised.
      const double open_s = height * (turn_s + 0.925) + turn_s * (i + 0.5) / views;
      const Frame frame =
          camera.Capture({.open_s = open_s, .id = static_cast<std::uint64_t>(100 * height + i)});
      View view;
      view.cam_from_world = *frame.known_cam_from_world * board.board_from_world.Inverse();
      view = writer.AddView(frame, view);
      field.truth[view.id] = camera.MovingPixels(frame.device_time_s);
    }
  writer.Close(1);
  field.light_field = ReadLightField(dir);
  return field;
}

// The share of the pixels of either that belong to both.
inline double OverlapOf(const cv::Mat& a, const cv::Mat& b) {
  return static_cast<double>(cv::countNonZero(a & b)) / std::max(1, cv::countNonZero(a | b));
}

}  // namespace ulf::test
