#include "core/light_field/exchange/conversions.h"

#include <fmt/format.h>

#include <set>
#include <tuple>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/image/files/picture_file.h"
#include "core/image/files/picture_kind.h"

namespace ulf {
namespace fs = std::filesystem;

std::vector<Conversion> ConversionsOf(const LightField& light_field) {
  std::vector<Conversion> conversions;
  std::set<std::tuple<int, int, std::string>> seen;
  for (const View& view : light_field.views) {
    const fs::path photograph = light_field.root / view.image_path;
    const std::string ending = Lowercase(photograph.extension().string());
    const CameraModel& camera = light_field.CameraOf(view);
    if (IsRawFile(photograph) || !seen.emplace(camera.width, camera.height, ending).second ||
        !fs::exists(photograph))
      continue;
    try {
      const StoredPicture picture = ReadPicture(photograph.string());
      for (const PictureNote& note : picture.notes) conversions.push_back({photograph, note.Words()});
      for (const std::string& remark : picture.remarks) conversions.push_back({photograph, remark});
    } catch (const Error&) {
      continue;  // its reader reports it
    }
  }
  return conversions;
}

void CopiedColorEncodings::Add(const StoredPicture& picture) {
  if (!picture.notes.empty()) ++photographs_;
  for (const PictureNote& note : picture.notes) {
    ++counts_[note.meaning];
    are_all_tagged_ = are_all_tagged_ && note.kind == PictureNote::Kind::kTagged;
  }
}

std::string CopiedColorEncodings::Doubt(std::size_t copied) const {
  if (photographs_ == 0) return {};
  std::string list;
  for (const auto& [meaning, count] : counts_)
    list += fmt::format("{}{}: {}", list.empty() ? "" : "; ", count, meaning);
  // The suggested command understands only profiles: it would attach sRGB's to other colours.
  return fmt::format(
      "{} of {} are not upright sRGB but say what they are ({}): they are copied, and programs that pass "
      "over what they say see them otherwise than ulf does; convert them before they are posed{}",
      photographs_, Counted(copied, "photograph"), list,
      are_all_tagged_ ? ", for instance with 'magick IN -auto-orient -profile sRGB.icc OUT' (ImageMagick "
                        "6: 'convert')"
                      : "");
}

}  // namespace ulf
