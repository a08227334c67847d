#include "coverage/session/record/map_cache.h"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/base/waiting.h"
#include "core/geometry/digest.h"
#include "core/light_field/light_field_io.h"
#include "coverage/session/record/still_capture.h"

namespace ulf::coverage {
namespace {

std::uint64_t KeyOf(const LightField& light_field, const CameraModel& tracked) {
  Digest digest;
  digest.Add(tracked);
  for (const View& view : light_field.views) {
    digest.Add(static_cast<double>(view.id));
    digest.Add(view.cam_from_world);
    digest.Add(light_field.CameraOf(view));
  }
  return digest.Value();
}

// From views spread evenly over the capture.
void SeedFrom(const LightField& light_field, const CameraModel& tracked, tracking::PoseSource& poses) {
  constexpr std::size_t kMostViews =
      80;  // guessed; the tracker adds the rest of the map from its first frames
  const std::size_t count = light_field.views.size();
  const std::size_t used = std::min(count, kMostViews);
  const Waiting waiting("map", fmt::format("made again from {}", Counted(used, "recorded view")));
  std::vector<tracking::SeedView> seeds;
  for (std::size_t i = 0; i < used; ++i) {
    const View& view = light_field.views[i * count / used];
    Image image = ReadRecordedImage(light_field, view);
    const CameraModel& camera = light_field.CameraOf(view);
    if (camera != tracked) image = AsSeenBy(tracked, image, camera);
    seeds.push_back({std::move(image), view.cam_from_world});
  }
  if (!poses.SeedMap(seeds))
    throw Error(
        "{}: its {} views show too little in common to find the camera's position among them; begin a new "
        "light field",
        light_field.root.string(), count);
}

}  // namespace

std::filesystem::path MapCacheOf(const LightField& light_field) {
  return light_field.root / "cache" / "map.ulf";
}

void RestoreOrSeedMap(const LightField& light_field, const CameraModel& tracked,
                      tracking::PoseSource& poses) {
  const auto start = std::chrono::steady_clock::now();
  const std::filesystem::path file = MapCacheOf(light_field);
  std::string why = "the last session left none";
  const CameraModel& recorded = light_field.CameraOf(light_field.views.back());
  if (recorded.width == tracked.width && recorded.height == tracked.height && recorded != tracked) {
    why = "the lens is another one";
  } else if (std::filesystem::exists(file)) {
    const std::string problem = poses.RestoreMap(file, KeyOf(light_field, tracked));
    if (problem.empty()) {
      spdlog::info("the map of the last session was loaded in {:.2f} s", SecondsSince(start));
      return;
    }
    fmt::print(stderr, "{}: {}; the map is made anew from the recorded views\n", file.string(), problem);
    why = problem;
  }
  SeedFrom(light_field, tracked, poses);
  spdlog::info("the map is made anew from the recorded views in {:.2f} s ({})", SecondsSince(start), why);
}

void SaveMapCache(const LightField& light_field, const CameraModel& tracked,
                  const tracking::PoseSource& poses) {
  const std::filesystem::path file = MapCacheOf(light_field);
  try {
    MakeFolder(file.parent_path());
    poses.SaveMap(file, KeyOf(light_field, tracked));
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}; --resume will take longer to start, nothing else changes\n", error.what());
  }
}

}  // namespace ulf::coverage
