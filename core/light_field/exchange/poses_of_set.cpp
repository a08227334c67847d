#include "core/light_field/exchange/poses_of_set.h"

#include <algorithm>
#include <utility>

#include "core/base/name_order.h"
#include "core/light_field/exchange/read_posed_set.h"
#include "core/light_field/exchange/readers/set_readers.h"
#include "core/light_field/findings.h"
#include "core/light_field/folder/journal.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/formats/set_format.h"
#include "core/light_field/formats/transforms_json.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

void Append(const LightField& part, LightField& all) {
  for (View view : part.views) {
    view.camera = IndexOfCamera(part.CameraOf(view), all.cameras);
    all.views.push_back(std::move(view));
  }
  all.doubts.insert(all.doubts.end(), part.doubts.begin(), part.doubts.end());
}

LightField ReadPartsOf(const fs::path& folder) {
  LightField all;
  for (const char* part : {"transforms_train.json", "transforms_val.json", "transforms_test.json"})
    if (fs::is_regular_file(folder / part)) Append(ReadTransformsPoses(folder / part), all);
  return all;
}

// Many programs write photographs by their own numbers or by when they were aligned.
LightField InOrderOfNames(LightField set) {
  std::ranges::stable_sort(set.views, NameOrder, &View::image_path);
  return set;
}

LightField ReadWithoutPhotographs(const fs::path& source) {
  std::error_code unknown;
  const bool is_file = fs::is_regular_file(source, unknown);
  const std::vector<SetFormat> formats = FormatsIn(source);
  const bool has_frames = formats.empty() || formats.front() == SetFormat::kTransforms ||
                          formats.front() == SetFormat::kNerfSynthetic;
  if (is_file && has_frames && source.extension() == ".json") return ReadTransformsPoses(source);
  if (formats.empty()) return ReadLightField(source);  // says what is missing
  const fs::path place = PlaceOf(formats.front(), source);
  switch (formats.front()) {
    case SetFormat::kUlf:
      return ReadJournal(source / kJournalFile).light_field;
    case SetFormat::kTransforms:
      return ReadTransformsPoses(place);
    case SetFormat::kNerfSynthetic:
      return ReadPartsOf(place);
    case SetFormat::kColmap:
      return ReadColmapSetPoses(place);
    case SetFormat::kMetashape:
    case SetFormat::kMeshroom:
    case SetFormat::kOpenSfm:
    case SetFormat::kOpenMvg:
    case SetFormat::kGaussian:
      return InOrderOfNames(ReadPosedSet(source, formats.front(), kNoPhotographs).light_field);
    default:  // the readers of others open the photographs
      return InOrderOfNames(ReadPosedSet(source, formats.front(), {}).light_field);
  }
}

}  // namespace

SetPoses ReadPosesOfSet(const fs::path& source) {
  const LightField set = ReadWithoutPhotographs(source);
  WarnOnce(set.doubts);
  SetPoses poses;
  for (const View& view : set.views) {
    poses.cam_from_world.push_back(view.cam_from_world);
    poses.cameras.push_back(set.CameraOf(view));
  }
  if (std::ranges::any_of(poses.cameras, [](const CameraModel& camera) { return camera.width == 0; }))
    poses.cameras.clear();
  return poses;
}

}  // namespace ulf
