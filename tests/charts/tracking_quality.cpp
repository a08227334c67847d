// Predicted against true error of tracked frames, as CSV: run,frame,predicted_mm,actual_mm,quality,points.
//
// tracking_quality RUN... > tracking_quality.csv; a RUN is `room` (the textured room under noise and with few
// features), `simulator` (its studio), or a recording's folder: pictures, intrinsics.txt, and groundtruth.txt
// or colmap_reference.txt.
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
    fmt::print("{},{},{:.6f},{:.6f},{:.4f},{}\n", run, error.frame, 1000 * error.predicted,
               1000 * error.actual, error.quality, error.points);
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
  const bool measured = std::filesystem::exists(folder / "groundtruth.txt");
  const auto truth = ReadTum(folder / (measured ? "groundtruth.txt" : "colmap_reference.txt"));
  const auto device = OpenDevice("replay:" + folder.string() + "?glob=*.jpg");
  device->Start();
  const auto next = [&]() -> std::optional<Frame> {
    auto frame = device->Next(std::chrono::milliseconds(1000));
    if (!frame) return std::nullopt;
    for (const TimedPose& pose : truth)
      if (std::abs(pose.time_s - frame->device_time_s) < 1.0 / 60)
        frame->known_cam_from_world = pose.cam_from_world;
    return frame;
  };
  Print(folder.filename().string(),
        test::RunForErrors(ReadCalibration(folder / "intrinsics.txt"), {.deterministic = true}, next));
}

void Room() {
  for (const unsigned seed : {1u, 2u})
    for (const double noise : {1.0, 4.0, 12.0})
      for (const int features : {300, 1000})
        Print(fmt::format("room noise {} features {}", noise, features),
              test::RoomErrors(noise, features, seed, 150));
}

}  // namespace

int main(int argc, char** argv) {
  fmt::print("run,frame,predicted_mm,actual_mm,quality,points\n");
  for (int i = 1; i < argc; ++i) {
    const std::string run = argv[i];
    if (run == "room")
      Room();
    else if (run == "simulator")
      for (const unsigned seed : {1u, 2u}) Simulator(seed, 10);
    else
      Recorded(run);
  }
  return 0;
}
