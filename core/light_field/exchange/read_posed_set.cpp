#include "core/light_field/exchange/read_posed_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <set>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/shell_word.h"
#include "core/geometry/rigid3.h"
#include "core/image/files/picture_file.h"
#include "core/image/files/picture_folder.h"
#include "core/image/image.h"
#include "core/light_field/exchange/readers/set_readers.h"
#include "core/light_field/exchange/unread_sets.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/formats/set_format.h"
#include "core/light_field/formats/transforms_json.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void RefuseUnposed(const fs::path& source) {
  std::error_code unknown;
  const std::string path = source.string(), word = ShellWord(path);
  if (!fs::exists(source, unknown)) throw Error("{}: there is no such file or folder; check the path", path);
  if (const std::string unread = UnreadSet(source); !unread.empty()) throw Error("{}", unread);
  if (fs::is_regular_file(source, unknown))
    throw Error(
        "{}: is no set of posed photographs (docs/exchange.md lists the formats); a video is posed and "
        "recorded by 'ulf capture replay:{} -o DIR {}'",
        path, word, Parameter("no_subject"));
  for (const auto& entry : fs::directory_iterator(source, unknown))
    if (HasImageEnding(entry.path()))
      throw Error(
          "{0}: photographs without poses (docs/exchange.md lists the formats); 'ulf import {1} {2} -o DIR' "
          "poses them through COLMAP, and frames that follow each other 'ulf capture replay:{1} -o DIR {3}'",
          path, word, Parameter("pose"), Parameter("no_subject"));
  if (fs::is_empty(source, unknown)) RefuseWithoutPictures(path, {});
  throw Error("{}: holds no set of posed photographs; docs/exchange.md lists the formats and their files",
              path);
}

// Returns whether the set's files hold the intrinsics.
bool HasIntrinsics(SetFormat format) { return format != SetFormat::kTum; }

void RequireOneSourceOfIntrinsics(SetFormat format, const fs::path& source, bool is_camera_given) {
  if (HasIntrinsics(format) && is_camera_given)
    throw Refusal(
        Parameter("calibration"), "",
        fmt::format("{} is read as {}, whose files hold the intrinsics", source.string(), Name(format)),
        "leave the option out");
  if (!HasIntrinsics(format) && !is_camera_given)
    throw Refusal(source.string(), "",
                  fmt::format("a set in the format {} holds no intrinsics", Name(format)),
                  fmt::format("give those of its camera with {} FILE: a file of 'ulf calibrate' or of "
                              "another program, or a line `fx fy cx cy k1 k2 p1 p2 width height` with the "
                              "numbers of whoever published the set (docs/calibration.md)",
                              Parameter("calibration")));
}

PosedSet ReadAs(SetFormat format, const fs::path& place, const fs::path& images,
                const std::optional<CameraModel>& camera) {
  switch (format) {
    case SetFormat::kUlf: {
      if (!images.empty())
        throw Refusal(Parameter("images"), "",
                      fmt::format("{} is a light field, which holds its photographs", place.string()),
                      "leave the option out");
      PosedSet set{ReadLightField(place), "ulf", {}, {}};
      set.light_field.doubts.clear();  // they have been logged
      return set;
    }
    case SetFormat::kTransforms:
      return {ReadTransformsSet(place, images), "nerfstudio", {}, {}};
    case SetFormat::kNerfSynthetic:
      return ReadNerfSyntheticSet(place, images);
    case SetFormat::kColmap:
      return ReadColmapSet(place, images);
    case SetFormat::kLlff:
      return ReadLlffSet(place, images);
    case SetFormat::kBundler:
      return ReadBundlerSet(place, images);
    case SetFormat::kMetashape:
      return ReadMetashapeSet(place, images);
    case SetFormat::kRealityScan:
      return fs::is_directory(place) ? ReadRealityScanSet(place, images) : ReadRealityScanCsv(place, images);
    case SetFormat::kMeshroom:
      return ReadMeshroomSet(place, images);
    case SetFormat::kOpenSfm:
      return ReadOpenSfmSet(place, images);
    case SetFormat::kOpenMvg:
      return ReadOpenMvgSet(place, images);
    case SetFormat::kVisualSfm:
      return ReadVisualSfmSet(place, images);
    case SetFormat::kGaussian:
      return ReadGaussianSplattingSet(place, images);
    case SetFormat::kPolycam:
      return ReadPolycamSet(place, images);
    case SetFormat::kTum:
      return ReadTumSet(place, images, camera.value());
    case SetFormat::kEuroc:
      return ReadEurocSet(place, images);
    case SetFormat::kKitti:
      return ReadKittiSet(place, images);
  }
  return {};
}

// Returns the greatest distance of a camera centre from the first.
double SpreadOf(const std::vector<View>& views) {
  double spread = 0;
  for (const View& view : views)
    spread = std::max(
        spread,
        (view.cam_from_world.OriginInSource() - views.front().cam_from_world.OriginInSource()).norm());
  return spread;
}

// Compares except for rounding: of the rotations, of the centres in a set of this spread, and of coordinates
// that are far from zero.
bool IsSamePose(const Rigid3& a, const Rigid3& b, double spread) {
  constexpr double kRounding = 1e-6, kRoundingOfCoordinates = 1e-12;
  const Eigen::Vector3d center = a.OriginInSource();
  return RotationAngle(a.rotation * b.rotation.conjugate()) <= kRounding &&
         (center - b.OriginInSource()).norm() <= kRounding * spread + kRoundingOfCoordinates * center.norm();
}

// A photograph has one pose: sets whose validation is their test give it twice, and it is taken once. Two
// poses belong to two photographs of the same name.
void RequireOnePoseEach(const fs::path& source, LightField& light_field) {
  const double spread = SpreadOf(light_field.views);
  std::map<std::string, const View*> taken;
  std::vector<View> views;
  std::set<std::string> wrong, repeated;
  std::string first;
  for (const View& view : light_field.views) {
    const auto [before, is_new] = taken.try_emplace(view.image_path, &view);
    if (is_new) {
      views.push_back(view);
    } else if (IsSamePose(before->second->cam_from_world, view.cam_from_world, spread)) {
      repeated.insert(view.image_path);
    } else {
      if (wrong.empty())
        first = fmt::format("two poses, number {} and {}, lead to the photograph '{}'", before->second->id,
                            view.id, view.image_path);
      wrong.insert(view.image_path);
    }
  }
  if (!wrong.empty())
    throw Error(
        "{}: {}{}; where photographs of several folders have the same name, give the folder from which their "
        "names count with {}, or else take one of the poses out",
        source.string(), first,
        wrong.size() == 1 ? "" : fmt::format(", and so it is with {} more", wrong.size() - 1),
        Parameter("images"));
  if (repeated.empty()) return;
  light_field.doubts.push_back(
      fmt::format("{} named more than once: taken once", Counted(repeated.size(), "photograph")));
  light_field.views = std::move(views);
  std::set<int> ids;
  for (const View& view : light_field.views) ids.insert(view.id);
  for (ScenePoint& point : light_field.points)
    std::erase_if(point.track, [&](const ViewObservation& seen) { return !ids.contains(seen.view_id); });
}

// Returns the folders with a set, of the nearest level below `source` that has some, in the order of their
// names.
std::vector<fs::path> FoldersOfSetsBelow(const fs::path& source) {
  constexpr int kMostLevels = 3;
  constexpr std::size_t kMostFolders = 1000;  // looked at: a set may lie in somebody's whole disk
  std::vector<fs::path> level{source};
  for (int i = 0; i < kMostLevels; ++i) {
    std::vector<fs::path> below, found;
    std::error_code unknown;
    for (const fs::path& folder : level)
      for (const auto& entry : fs::directory_iterator(folder, unknown))
        if (entry.is_directory(unknown) && !entry.path().filename().string().starts_with('.') &&
            below.size() < kMostFolders)
          below.push_back(entry.path());
    std::ranges::sort(below);
    std::ranges::copy_if(below, std::back_inserter(found),
                         [](const fs::path& folder) { return !FormatsIn(folder).empty(); });
    if (!found.empty()) return found;
    level = std::move(below);
  }
  return {};
}

// Returns the only folder below with a set, or `source` itself.
fs::path FolderOfSet(const fs::path& source) {
  std::error_code unknown;
  if (!fs::is_directory(source, unknown) || !FormatsIn(source).empty()) return source;
  const std::vector<fs::path> below = FoldersOfSetsBelow(source);
  if (below.size() < 2) return below.empty() ? source : below.front();
  std::vector<std::string> sets;
  for (const fs::path& folder : below)
    sets.push_back(fmt::format("{} ({})", folder.string(), Name(FormatsIn(folder).front())));
  constexpr std::size_t kMostNamed = 5;
  const std::size_t unnamed = sets.size() - std::min(kMostNamed, sets.size());
  sets.resize(sets.size() - unnamed);
  throw Error("{}: holds no set itself, and several lie below it: {}{}; give the folder of one",
              source.string(), fmt::join(sets, ", "),
              unnamed > 0 ? fmt::format(" and {} more", unnamed) : "");
}

// Says which of several files of the kind is read.
std::string RivalsInWords(const fs::path& place) {
  std::vector<std::string> names;
  for (const fs::path& file : RivalsOf(place)) names.push_back(file.filename().string());
  return names.empty() ? ""
                       : fmt::format("{}: is read, and not {} beside it; give another one as the source",
                                     place.string(), AbbreviatedList(names));
}

}  // namespace

PosedSet ReadPosedSet(const fs::path& given, const std::optional<SetFormat>& asked, const fs::path& images,
                      const std::optional<CameraModel>& camera) {
  const fs::path source = FolderOfSet(given);
  const std::vector<SetFormat> formats = FormatsIn(source);
  if (asked && std::ranges::find(formats, *asked) == formats.end())
    throw Error("{}: holds no set in the format {}; {}", source.string(), Name(*asked),
                formats.empty() ? "docs/exchange.md lists the files of each"
                                : fmt::format("it holds one in the format {}", Name(formats.front())));
  if (formats.empty()) RefuseUnposed(source);
  const SetFormat format = asked.value_or(formats.front());
  RequireOneSourceOfIntrinsics(format, source, camera.has_value());
  const fs::path place = PlaceOf(format, source);
  PosedSet set = ReadAs(format, place, images, camera);
  RequireOnePoseEach(source, set.light_field);
  if (source != given)
    set.light_field.doubts.push_back(
        fmt::format("{}: holds no set itself: the one in {} is read", given.string(), source.string()));
  if (const std::string rivals = RivalsInWords(place); place != source && !rivals.empty())
    set.light_field.doubts.push_back(rivals);
  if (asked) return set;
  for (const SetFormat other : formats)
    if (other != format)
      set.light_field.doubts.push_back(
          fmt::format("{}: is read as {}; it is also a set in the format {} ({} {})", source.string(),
                      Name(format), Name(other), Parameter("format"), Name(other)));
  return set;
}

}  // namespace ulf
