// Predicted against true error of tracked frames, as CSV: run,predicted_mm,actual_mm,quality,points. Runs:
// the textured room under noise and with few features, the simulator, and a recorded sequence where it is
// given.
//
// tracking_quality [FOLDER] > tracking_quality.csv; FOLDER has *.jpg, intrinsics.txt and groundtruth.txt.
#include <fmt/core.h>

#include <filesystem>
#include <string>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/calibration/intrinsics.h"
#include "acquisition/device.h"
#include "tests/tracking/predicted_error.h"

namespace {

using namespace ulf;

void Print(const std::string& run, const std::vector<test::PredictedError>& errors) {
  for (const auto& error : errors)
    fmt::print("{},{:.6f},{:.6f},{:.4f},{}\n", run, 1000 * error.predicted, 1000 * error.actual,
               error.quality, error.points);
}

void Simulator(unsigned seed, double duration_s) {
  const auto device = OpenDevice(fmt::format("sim:studio?duration_s={}&seed={}", duration_s, seed));
  device->Start();
  const auto next = [&]() -> std::optional<Frame> {
    while (!IsOver(device->State()))
      if (auto frame = device->Next(std::chrono::milliseconds(200))) return frame;
    return std::nullopt;
  };
  const auto first = next();
  if (!first) return;
  const CameraModel camera = ResolveIntrinsics(*device, {}, first->image.width(), first->image.height());
  Print("simulator", test::RunForErrors(camera, {.deterministic = true, .seed = seed}, next));
}

void Recorded(const std::filesystem::path& folder) {
  const auto device = OpenDevice("replay:" + folder.string() + "?glob=*.jpg");
  const auto truth = ReadTum(folder / "groundtruth.txt");
  device->Start();
  const auto next = [&]() -> std::optional<Frame> {
    auto frame = device->Next(std::chrono::milliseconds(1000));
    if (!frame) return std::nullopt;
    for (const TimedPose& pose : truth)
      if (std::abs(pose.time_s - frame->device_time_s) < 1.0 / 60)
        frame->known_cam_from_world = pose.cam_from_world;
    return frame;
  };
  Print("recorded",
        test::RunForErrors(ReadCalibration(folder / "intrinsics.txt"), {.deterministic = true}, next));
}

}  // namespace

int main(int argc, char** argv) {
  fmt::print("run,predicted_mm,actual_mm,quality,points\n");
  for (const unsigned seed : {1u, 2u})
    for (const double noise : {1.0, 4.0, 12.0})
      for (const int features : {300, 1000})
        Print(fmt::format("room noise {} features {}", noise, features),
              test::RoomErrors(noise, features, seed, 150));
  Simulator(1, 10);
  if (argc > 1) Recorded(argv[1]);
  return 0;
}
