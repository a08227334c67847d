#include "core/light_field/exchange/readers/set_readers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <optional>
#include <span>

#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/geometry/trajectory.h"
#include "core/light_field/formats/frame_files.h"
#include "core/light_field/formats/set_format.h"
#include "core/light_field/points/ply_reader.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

constexpr double kMostGapS = 0.1;
constexpr double kMostOffS = 0.02;   // the default of associate.py
constexpr double kRoundingS = 1e-6;  // for times since 1970 with six digits
constexpr const char* kBlanks = " \t\r";

struct ListedPhotograph {
  double time_s = 0;
  std::string name;
  int line = 0;
};

// Returns them in order of time.
std::vector<ListedPhotograph> ReadTumList(const fs::path& file) {
  std::ifstream stream = OpenRegularFile(file);
  std::vector<ListedPhotograph> photographs;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    const std::size_t start = line.find_first_not_of(kBlanks);
    if (start == std::string::npos || line[start] == '#') continue;
    const std::string row = line.substr(start, line.find_last_not_of(kBlanks) + 1 - start);
    const std::size_t end_of_time = row.find_first_of(kBlanks);
    double time_s = 0;
    if (end_of_time == std::string::npos || !ParseNumber(row.substr(0, end_of_time), time_s) ||
        !std::isfinite(time_s))
      throw Error("{}, line {}: expected `time file`, seconds and the name of a photograph, found \"{}\"",
                  file.string(), number, row);
    photographs.push_back({time_s, row.substr(row.find_first_not_of(kBlanks, end_of_time)), number});
  }
  if (photographs.empty())
    throw Error("{}: names no photograph; take the file that belongs to the set", file.string());
  std::ranges::stable_sort(photographs, {}, &ListedPhotograph::time_s);
  return photographs;
}

// Returns them in order of time.
std::vector<TimedPose> ReadTumPoses(const fs::path& file) {
  std::vector<TimedPose> poses = ReadTum(file);
  if (poses.empty()) throw Error("{}: holds no pose; take the file that belongs to the set", file.string());
  std::ranges::stable_sort(poses, {}, &TimedPose::time_s);
  return poses;
}

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

PosedSet ReadTumSet(const fs::path& rgb_txt, const fs::path& chosen, const CameraModel& camera) {
  const fs::path folder = rgb_txt.parent_path(), poses_file = folder / kTumPosesFile;
  const std::vector<ListedPhotograph> listed = ReadTumList(rgb_txt);
  const std::vector<TimedPose> poses = ReadTumPoses(poses_file);
  const SetImages images(folder, chosen, {"."});
  PosedSet set;
  set.format = "TUM RGB-D";
  LightField& light_field = set.light_field;
  light_field.root = images.folder();
  light_field.units = "metres";
  std::map<std::string, int> lines;  // by the photograph
  std::vector<std::string> unposed, missing;
  for (const ListedPhotograph& each : listed) {
    const std::string where = fmt::format("{}, line {}", rgb_txt.string(), each.line);
    const std::string name = PathInside(images.folder(), each.name, where);
    const std::optional<Rigid3> cam_from_world = PoseAtTime(poses, each.time_s);
    if (!cam_from_world) {
      unposed.push_back(each.name);
      continue;
    }
    if (!cam_from_world->translation.allFinite())
      throw Error("{}: its pose by {} is not finite; export the trajectory again", where,
                  poses_file.string());
    const std::string found = images.Find(name);
    if (found.empty()) {
      missing.push_back(each.name);
      continue;
    }
    const std::string path = PathInside(images.folder(), found, where);
    if (const auto [other, is_new] = lines.try_emplace(path, each.line); !is_new)
      throw Error("{}, lines {} and {}: both lead to {}; a photograph has one time: take out the wrong line",
                  rgb_txt.string(), other->second, each.line, (images.folder() / path).string());
    const CameraModel own = AtSizeOf(images.folder() / path, camera, where, light_field.doubts);
    AddView(path, own, *cam_from_world, images, light_field).device_time_s = each.time_s;
  }
  if (unposed.size() == listed.size())
    throw Error(
        "{}: its {} of {:.6f} to {:.6f} s, the poses of {} of {:.6f} to {:.6f} s: none of the times "
        "fit; take the two files of one recording, with times by one clock",
        rgb_txt.string(), Counted(listed.size(), "photograph"), listed.front().time_s, listed.back().time_s,
        poses_file.string(), poses.front().time_s, poses.back().time_s);
  if (light_field.views.empty())
    throw Error("{}: none of its photographs is in {} ({} is the first); {}", rgb_txt.string(),
                images.folder().string(), missing.front(), ImagesRemedy());
  set.counts_unposed = !unposed.empty();
  if (set.counts_unposed)
    light_field.doubts.push_back(fmt::format(
        "{} without a pose at its time (none within {} s, no two around it at most {} s apart): left out, {} "
        "the first",
        Counted(unposed.size(), "photograph"), kMostOffS, kMostGapS, unposed.front()));
  if (!missing.empty())
    light_field.doubts.push_back(fmt::format("{} of {} not in {}: left out, {} the first",
                                             Counted(missing.size(), "photograph"), kTumListFile,
                                             images.folder().string(), missing.front()));
  if (std::error_code unknown; fs::exists(folder / "depth.txt", unknown))
    light_field.doubts.push_back("depth.txt: depth images are not used");
  return set;
}

}  // namespace ulf
