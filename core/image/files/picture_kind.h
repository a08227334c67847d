// The kinds of picture files, told by their first bytes.
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
  // What follows is not read.
  kHeif,
  kJpegXl,
  kJpeg2000,
  kGif,
  kPsd,
  // By the ending of the name: inside they are JPEG or PNG.
  kStereo,
  kTwoFisheyes
};

PictureKind KindOfPicture(const std::filesystem::path& path);
inline bool IsRead(PictureKind kind) { return kind != PictureKind::kUnknown && kind < PictureKind::kHeif; }
// Of what is not read: what it is and the way out ("HEIC, which is not read; convert it ...").
std::string WordsOf(PictureKind kind);
// Of kinds that are not read, by the ending of the name, in any case; kUnknown: of all others.
PictureKind UnreadKindByEnding(const std::filesystem::path& path);

// Whether the file is a camera's raw file (raw_file.h), by the ending of its name in lower or upper case.
bool IsRawFile(const std::filesystem::path& path);

// Of photographs that are there as pictures and as raw files of the same name, the raw files go.
template <typename Path>
void LeaveOutRawTwins(std::vector<Path>& files) {
  const auto stem = [](const Path& file) { return std::filesystem::path(file).replace_extension(); };
  std::set<std::filesystem::path> pictures;
  for (const Path& file : files)
    if (!IsRawFile(file)) pictures.insert(stem(file));
  std::erase_if(files, [&](const Path& file) { return IsRawFile(file) && pictures.contains(stem(file)); });
}

}  // namespace ulf
