// Predicted against true error of tracked frames, as CSV:
// run,frame,predicted_mm,actual_mm,quality,points,distance_mm.
//
// tracking_quality RUN... > tracking_quality.csv; a RUN is `room` (the textured room under noise and with few
// features), `simulator` (its studio), or a recording's folder: pictures, intrinsics.txt, and
// colmap_reference.txt or groundtruth.txt.
#include <fmt/core.h>

#include <filesystem>
#include <string>

#include "tests/tracking/predicted_error.h"

namespace {

using namespace ulf;

void Print(const std::string& run, const std::vector<test::PredictedError>& errors) {
  for (const auto& error : errors)
    fmt::print("{},{},{:.6f},{:.6f},{:.4f},{},{:.6f}\n", run, error.frame, 1000 * error.predicted,
               1000 * error.actual, error.quality, error.points, 1000 * error.distance);
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
  fmt::print("run,frame,predicted_mm,actual_mm,quality,points,distance_mm\n");
  for (int i = 1; i < argc; ++i) {
    const std::string run = argv[i];
    if (run == "room")
      Room();
    else if (run == "simulator")
      for (const unsigned seed : {1u, 2u}) Print(run, test::SimulatorErrors(seed, 10));
    else
      Print(std::filesystem::path(run).filename().string(), test::RecordingErrors(run));
  }
  return 0;
}
