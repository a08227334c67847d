#include "core/light_field/exchange/readers/timed_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/light_field/formats/frame_files.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

constexpr double kMostGapS = 0.1;
constexpr double kMostOffS = 0.02;   // the default of associate.py
constexpr double kRoundingS = 1e-6;  // for times since 1970 with six digits

std::optional<Rigid3> PoseAtTime(std::span<const TimedPose> poses, double time_s) {
  const auto after = std::ranges::lower_bound(poses, time_s, {}, &TimedPose::time_s);
  const auto off_s = [&](auto pose) { return std::abs(pose->time_s - time_s); };
  if (after == poses.begin())
    return off_s(after) <= kMostOffS ? std::optional(after->cam_from_world) : std::nullopt;
  const auto before = std::prev(after);
  if (after != poses.end())
    if (const double gap_s = after->time_s - before->time_s; gap_s <= kMostGapS + kRoundingS)
      return Interpolated(before->cam_from_world, after->cam_from_world, off_s(before) / gap_s);
  const auto nearest = after == poses.end() || off_s(before) <= off_s(after) ? before : after;
  return off_s(nearest) <= kMostOffS ? std::optional(nearest->cam_from_world) : std::nullopt;
}

}  // namespace

void AddTimedViews(std::vector<TimedPhotograph> photographs, std::vector<TimedPose> poses,
                   const fs::path& list, const fs::path& trajectory, const SetImages& images,
                   const CameraModel& camera, PosedSet& set) {
  std::ranges::stable_sort(photographs, {}, &TimedPhotograph::time_s);
  std::ranges::stable_sort(poses, {}, &TimedPose::time_s);
  LightField& light_field = set.light_field;
  light_field.root = images.folder();
  std::map<std::string, int> lines;  // by the photograph
  std::vector<std::string> unposed, missing;
  for (const TimedPhotograph& each : photographs) {
    const std::string where = fmt::format("{}, line {}", list.string(), each.line);
    const std::string name = PathInside(images.folder(), each.name, where);
    const std::optional<Rigid3> cam_from_world = PoseAtTime(poses, each.time_s);
    if (!cam_from_world) {
      unposed.push_back(each.name);
      continue;
    }
    if (!cam_from_world->translation.allFinite())
      throw Error("{}: its pose by {} is not finite; export the trajectory again", where,
                  trajectory.string());
    const std::string found = images.Find(name);
    if (found.empty()) {
      missing.push_back(each.name);
      continue;
    }
    const std::string path = PathInside(images.folder(), found, where);
    if (const auto [other, is_new] = lines.try_emplace(path, each.line); !is_new)
      throw Error("{}, lines {} and {}: both lead to {}; a photograph has one time: take out the wrong line",
                  list.string(), other->second, each.line, (images.folder() / path).string());
    const CameraModel own = AtSizeOf(images.folder() / path, camera, where, light_field.doubts);
    AddView(path, own, *cam_from_world, images, light_field).device_time_s = each.time_s;
  }
  if (unposed.size() == photographs.size())
    throw Error(
        "{}: its {} of {:.6f} to {:.6f} s, the poses of {} of {:.6f} to {:.6f} s: none of the times "
        "fit; take the two files of one recording, with times by one clock",
        list.string(), Counted(photographs.size(), "photograph"), photographs.front().time_s,
        photographs.back().time_s, trajectory.string(), poses.front().time_s, poses.back().time_s);
  if (missing.size() > light_field.views.size())
    throw Error("{}: {} of its {} are not in {} ({} is the first); {}", list.string(), missing.size(),
                Counted(missing.size() + light_field.views.size(), "photograph"), images.folder().string(),
                missing.front(), ImagesRemedy());
  set.counts_unposed = !unposed.empty();
  if (set.counts_unposed)
    light_field.doubts.push_back(fmt::format(
        "{} without a pose at its time (none within {} s, no two around it at most {} s apart): left out, {} "
        "the first",
        Counted(unposed.size(), "photograph"), kMostOffS, kMostGapS, unposed.front()));
  if (!missing.empty())
    light_field.doubts.push_back(fmt::format("{} of {} not in {}: left out, {} the first",
                                             Counted(missing.size(), "photograph"), list.filename().string(),
                                             images.folder().string(), missing.front()));
}

}  // namespace ulf
