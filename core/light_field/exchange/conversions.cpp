#include "core/light_field/exchange/conversions.h"

#include <fmt/format.h>

#include <set>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/image/files/picture_file.h"
#include "core/image/files/raw_file.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

// "its colours are of the profile 'P3' and converted to sRGB": what the file says, without what ulf does about it.
std::string MeaningOf(const std::string& note) {
  for (const char* done :
       {" and converted to", " and are converted to", ": its pixels stay", ", which is taken back"})
    if (const std::size_t at = note.find(done); at != std::string::npos) return note.substr(0, at);
  return note;
}

}  // namespace

std::vector<Conversion> ConversionsOf(const LightField& light_field) {
  std::vector<Conversion> conversions;
  std::set<std::pair<int, std::string>> seen;
  for (const View& view : light_field.views) {
    const fs::path photograph = light_field.root / view.image_path;
    const std::string ending = Lowercase(photograph.extension().string());
    if (IsRawFile(photograph) || !seen.emplace(view.camera, ending).second || !fs::exists(photograph))
      continue;
    try {
      for (const std::string& note : ReadPicture(photograph.string()).notes)
        conversions.push_back({photograph, note});
    } catch (const Error&) {
      continue;  // whoever needs its pixels says why
    }
  }
  return conversions;
}

void CopiedMeanings::Add(const StoredPicture& picture) {
  if (!picture.notes.empty()) ++photographs_;
  for (const std::string& note : picture.notes) ++counts_[MeaningOf(note)];
}

std::string CopiedMeanings::Doubt(std::size_t copied) const {
  if (photographs_ == 0) return {};
  std::string list;
  for (const auto& [meaning, count] : counts_)
    list += fmt::format("{}{}: {}", list.empty() ? "" : "; ", count, meaning);
  return fmt::format(
      "{} of {} are not upright sRGB but say what they are ({}): they are copied, and programs that pass "
      "over "
      "what they say see them otherwise than ulf does; convert them before they are posed, for instance with "
      "'magick IN -auto-orient -profile sRGB.icc OUT'",
      photographs_, Counted(copied, "photograph"), list);
}

}  // namespace ulf
