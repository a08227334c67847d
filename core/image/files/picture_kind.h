// Tells the kinds of picture files by their first bytes.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace ulf {

enum class PictureKind {
  kUnknown,
  kPng,
  kJpeg,
  kTiff,
  kExr,
  kWebp,
  kBmp,
  kNetpbm,
  kRadiance,
  // The kinds from here on are not read.
  kHeif,
  kJpegXl,
  kJpeg2000,
  kGif,
  kPsd,
  // The ending of the name tells these: inside they are JPEG or PNG.
  kStereo,
  kTwoFisheyes
};

// Returns kUnknown for other files, and for one that cannot be read.
PictureKind KindOfPicture(const std::filesystem::path& path);
inline bool IsRead(PictureKind kind) { return kind != PictureKind::kUnknown && kind < PictureKind::kHeif; }
// Describes an unread or unknown kind and the remedy ("HEIC or AVIF, ... which is not read; convert it ...").
std::string WordsOf(PictureKind kind);
// Tells an unread kind by the ending of the name, in any case; kUnknown for all others.
PictureKind UnreadKindByEnding(const std::filesystem::path& path);

// Returns whether the file is a camera's raw file (raw_file.h), by its ending in lower or upper case.
bool IsRawFile(const std::filesystem::path& path);

// Removes raw files beside which the list has a picture of the same name but for the extension.
template <typename Path>
void LeaveOutRawTwins(std::vector<Path>& files) {
  const auto stem = [](const Path& file) { return std::filesystem::path(file).replace_extension(); };
  std::set<std::filesystem::path> pictures;
  for (const Path& file : files)
    if (!IsRawFile(file)) pictures.insert(stem(file));
  std::erase_if(files, [&](const Path& file) { return IsRawFile(file) && pictures.contains(stem(file)); });
}

}  // namespace ulf
