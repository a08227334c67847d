// The kinds of picture files, told by their first bytes.
#pragma once

#include <filesystem>
#include <string>

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

}  // namespace ulf
