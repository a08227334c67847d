#include "core/light_field/exchange/readers/set_readers.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/geometry/trajectory.h"
#include "core/light_field/exchange/readers/timed_views.h"
#include "core/light_field/formats/set_format.h"
#include "core/light_field/formats/text_file.h"
#include "core/light_field/points/ply_reader.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBlanks = " \t\r";

std::vector<TimedPhotograph> ReadTumList(const fs::path& file) {
  std::ifstream stream = OpenTextFile(file);
  std::vector<TimedPhotograph> photographs;
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
  return photographs;
}

std::vector<TimedPose> ReadTumPoses(const fs::path& file) {
  std::vector<TimedPose> poses = ReadTum(file);
  if (poses.empty()) throw Error("{}: holds no pose; take the file that belongs to the set", file.string());
  return poses;
}

}  // namespace

PosedSet ReadTumSet(const fs::path& rgb_txt, const fs::path& chosen, const CameraModel& camera) {
  const fs::path folder = rgb_txt.parent_path(), poses_file = folder / kTumPosesFile;
  const SetImages images(folder, chosen, {"."});
  PosedSet set;
  set.format = "TUM RGB-D";
  set.light_field.units = "metres";
  AddTimedViews(ReadTumList(rgb_txt), ReadTumPoses(poses_file), rgb_txt, poses_file, images, camera, set);
  if (std::error_code unknown; fs::exists(folder / "depth.txt", unknown))
    set.light_field.doubts.push_back("depth.txt: depth images are not used");
  return set;
}

}  // namespace ulf
