#include "core/light_field/points/point_io.h"

#include <fmt/format.h>

#include <fstream>
#include <string>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/geometry/digest.h"
#include "core/light_field/journal_stamp.h"
#include "core/light_field/points/point_file.h"
#include "core/light_field/points/point_ply.h"
#include "core/light_field/points/point_tracks.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPointFile = "points.ulf";
constexpr const char* kPointPly = "points.ply";

StoredPoints StoredIn(const fs::path& file, const LightField& light_field) {
  try {
    return PointsFromBytes(ReadWholeFile(file), light_field);
  } catch (const Error& error) {
    return {error.what(), {}, {}};
  }
}

// Tells light fields apart by how their journals begin: with the device, and the first view and its times.
std::string LightFieldMark(const fs::path& root) {
  std::ifstream journal(root / kJournalFile);
  std::string begin;
  for (std::string line; std::getline(journal, line);) {
    begin += line;
    if (line.find("\"event\":\"view\"") != std::string::npos) break;
  }
  return ChecksumText(FastChecksumOf(begin));
}

// Whether another program, a person, or ulf for another light field wrote the file. One of this light field that is only
// older, because a kill came between the two files, says nothing: the next writer makes it again.
bool IsOfAnother(const fs::path& ply, const std::vector<ScenePoint>& points) {
  std::error_code unknown;
  if (!fs::is_regular_file(ply, unknown)) return false;
  const std::string bytes = ReadWholeFile(ply);
  return !HoldsSamePoints(bytes, PointPlyBytes(points)) &&
         !IsOwnPointPly(bytes, LightFieldMark(FolderOf(ply)));
}

}  // namespace

bool ReadPointPositions(const fs::path& ply, LightField& light_field) {
  std::error_code unknown;
  if (!fs::is_regular_file(ply, unknown)) return false;
  try {
    light_field.points = ReadPointPly(ply);
  } catch (const Error& error) {
    light_field.doubts.push_back(fmt::format("{}; the light field is read without points", error.what()));
  }
  return true;
}

void ReadPoints(LightField& light_field) {
  const fs::path file = light_field.root / kPointFile, ply = light_field.root / kPointPly;
  std::error_code unknown;
  if (!fs::is_regular_file(file, unknown)) {
    ReadPointPositions(ply, light_field);
    return;
  }
  StoredPoints stored = StoredIn(file, light_field);
  if (!stored.problem.empty()) {
    light_field.doubts.push_back(fmt::format(
        "{}: {}; points.ply is read instead, which has no observations (ulf refine measures new ones)",
        file.string(), stored.problem));
    ReadPointPositions(ply, light_field);
    return;
  }
  if (IsOfAnother(ply, stored.points))
    light_field.doubts.push_back(fmt::format(
        "{}: holds other points than points.ulf, which is used; to use this file, remove points.ulf",
        ply.string()));
  light_field.points = std::move(stored.points);
  FitPointsOf(stored.moved, light_field);
  light_field.misplaced_observations = MeasurePoints(light_field);
}

void WritePoints(const LightField& light_field) {
  WriteFileAtomically(light_field.root / kPointFile, PointFileBytes(light_field));
  WriteFileAtomically(light_field.root / kPointPly,
                      PointPlyBytes(light_field.points, LightFieldMark(light_field.root)));
}

}  // namespace ulf
