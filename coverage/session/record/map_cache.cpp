#include "coverage/session/record/map_cache.h"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/geometry/digest.h"
#include "core/light_field/folder/opened_folder.h"
#include "core/light_field/folder/view_images.h"
#include "coverage/session/record/still_capture.h"

namespace ulf::coverage {
namespace {

std::filesystem::path MapCacheOf(const LightField& light_field) {
  return light_field.root / "cache" / "map.ulf";
}

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

// Logs why the map is made again and, once the first views show how long each takes, the expected time.
class MakingAgain {
 public:
  MakingAgain(std::string why, std::size_t views) : why_(std::move(why)), views_(views) {}

  void Read() { read_s_ = SecondsSince(start_); }
  void After(std::size_t views) {
    if (views < kTelling || said_) return;
    const double view_s = (SecondsSince(start_) - read_s_) / static_cast<double>(views);
    Say(read_s_ + kWithAdjustment * view_s * static_cast<double>(views_));
  }
  void Done() {
    if (!said_) Say(0);
    spdlog::info("the map is made again from {}, in {:.1f} s", Counted(views_, "recorded view"),
                 SecondsSince(start_));
  }

 private:
  // The first views are adjusted little and the whole map once at the end: measured on captures of the
  // studio, 640x480.
  static constexpr double kWithAdjustment = 2;
  static constexpr std::size_t kTelling = 16;  // seeds are adjusted every eighth
  static constexpr double kWorthSaying_s = 3;  // guessed: a shorter wait needs no word

  void Say(double seconds) {
    said_ = true;
    spdlog::info("{}: the map is made again{}", why_,
                 seconds < kWorthSaying_s ? "" : fmt::format(", about {:.0f} s", seconds));
  }

  const std::string why_;
  const std::size_t views_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double read_s_ = 0;
  bool said_ = false;
};

// Seeds the map from views spread evenly over the capture.
void SeedFrom(const LightField& light_field, const CameraModel& tracked, const std::string& why,
              tracking::PoseSource& poses) {
  constexpr std::size_t kMostViews =
      80;  // guessed; the tracker adds the rest of the map from its first frames
  const std::size_t count = light_field.views.size();
  const std::size_t used = std::min(count, kMostViews);
  MakingAgain making(why, used);
  std::vector<tracking::SeedView> seeds;
  for (std::size_t i = 0; i < used; ++i) {
    const View& view = light_field.views[i * count / used];
    Image image = ReadRecordedImage(light_field, view);
    const CameraModel& camera = light_field.CameraOf(view);
    if (camera != tracked) image = AsSeenBy(tracked, image, camera);
    seeds.push_back({std::move(image), view.cam_from_world});
  }
  making.Read();
  if (!poses.SeedMap(seeds, [&making](std::size_t views) { making.After(views); }))
    throw Error(
        "{}: its {} views show too little in common to find the camera's position among them; begin a new "
        "light field",
        light_field.root.string(), count);
  making.Done();
}

}  // namespace

void RestoreOrSeedMap(const LightField& light_field, const CameraModel& tracked,
                      tracking::PoseSource& poses) {
  const auto start = std::chrono::steady_clock::now();
  const std::filesystem::path file = MapCacheOf(light_field);
  std::string why = "the last session left no map";
  if (std::filesystem::exists(file)) {
    const auto refusal = poses.RestoreMap(file, KeyOf(light_field, tracked));
    if (!refusal) {
      spdlog::info("the map of the last session was loaded in {:.2f} s", SecondsSince(start));
      return;
    }
    const bool are_taken_back =
        refusal->problem == tracking::MapProblem::kOtherViews && !light_field.taken_back.empty();
    why = are_taken_back ? "views were taken back, or poses changed" : refusal->words;
  }
  SeedFrom(light_field, tracked, why, poses);
}

void SaveMapCache(const LightField& light_field, const CameraModel& tracked,
                  const tracking::PoseSource& poses) {
  const std::filesystem::path file = MapCacheOf(light_field);
  try {
    MakeFolderIn(light_field.root, "cache");
    poses.SaveMap(file, KeyOf(light_field, tracked));
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}; {} will take longer to start, nothing else changes\n", error.what(),
               Parameter("resume"));
  }
}

}  // namespace ulf::coverage
