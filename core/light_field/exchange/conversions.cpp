#include "core/light_field/exchange/conversions.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <tuple>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/image/files/picture_file.h"
#include "core/image/files/picture_kind.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

// Returns the file's part of a note, without ulf's conversion: "its colours are of the profile 'P3' and
// converted to sRGB".
std::string MeaningOf(const std::string& note) {
  for (const char* done :
       {" and converted to", " and are converted to", ": its pixels stay", ", which is taken back"})
    if (const std::size_t at = note.find(done); at != std::string::npos) return note.substr(0, at);
  return note;
}

}  // namespace

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
      for (const auto* lines : {&picture.notes, &picture.remarks})
        for (const std::string& line : *lines) conversions.push_back({photograph, line});
    } catch (const Error&) {
      continue;  // its reader reports it
    }
  }
  return conversions;
}

void CopiedColorEncodings::Add(const StoredPicture& picture) {
  if (!picture.notes.empty()) ++photographs_;
  for (const std::string& note : picture.notes) ++counts_[MeaningOf(note)];
}

std::string CopiedColorEncodings::Doubt(std::size_t copied) const {
  if (photographs_ == 0) return {};
  std::string list;
  for (const auto& [meaning, count] : counts_)
    list += fmt::format("{}{}: {}", list.empty() ? "" : "; ", count, meaning);
  // The suggested command understands only profiles: it would attach sRGB's to other colours.
  const bool is_told_by_profiles = std::ranges::all_of(counts_, [](const auto& each) {
    return each.first.find("of the profile") != std::string::npos || each.first.starts_with("its mark says");
  });
  return fmt::format(
      "{} of {} are not upright sRGB but say what they are ({}): they are copied, and programs that pass "
      "over what they say see them otherwise than ulf does; convert them before they are posed{}",
      photographs_, Counted(copied, "photograph"), list,
      is_told_by_profiles ? ", for instance with 'magick IN -auto-orient -profile sRGB.icc OUT' (ImageMagick "
                            "6: 'convert')"
                          : "");
}

}  // namespace ulf
