#include "core/image/files/picture_kind.h"

#include <array>
#include <fstream>
#include <map>
#include <set>
#include <string_view>

#include "core/base/lowercase.h"

namespace ulf {

PictureKind KindOfPicture(const std::filesystem::path& path) {
  if (const PictureKind kind = UnreadKindByEnding(path); kind >= PictureKind::kStereo) return kind;
  std::array<char, 16> bytes{};
  std::ifstream(path, std::ios::binary).read(bytes.data(), bytes.size());
  const std::string_view head(bytes.data(), bytes.size());
  if (head.starts_with("\x89PNG")) return PictureKind::kPng;
  if (head.starts_with("\xFF\xD8")) return PictureKind::kJpeg;
  for (const std::string_view tiff : {std::string_view("II*\0", 4), std::string_view("MM\0*", 4),
                                      std::string_view("II+\0", 4), std::string_view("MM\0+", 4)})
    if (head.starts_with(tiff)) return PictureKind::kTiff;
  if (head.starts_with("v/1\x01")) return PictureKind::kExr;
  if (head.starts_with("RIFF") && head.substr(8, 4) == "WEBP") return PictureKind::kWebp;
  if (head.starts_with("#?")) return PictureKind::kRadiance;
  if (head.starts_with("BM")) return PictureKind::kBmp;
  constexpr std::string_view kNetpbmKinds = "123456Ff";
  if (head[0] == 'P' && kNetpbmKinds.find(head[1]) != std::string_view::npos) return PictureKind::kNetpbm;
  if (head.starts_with("GIF8")) return PictureKind::kGif;
  if (head.starts_with("8BPS")) return PictureKind::kPsd;
  if (head.starts_with("\xFF\x0A") || head.substr(4, 4) == "JXL ") return PictureKind::kJpegXl;
  if (head.substr(4, 4) == "jP  ") return PictureKind::kJpeg2000;
  static const std::set<std::string_view> kBrands = {"heic", "heix", "hevc", "mif1",
                                                     "msf1", "heif", "avif", "avis"};
  if (head.substr(4, 4) == "ftyp" && kBrands.contains(head.substr(8, 4))) return PictureKind::kHeif;
  return PictureKind::kUnknown;
}

std::string WordsOf(PictureKind kind) {
  switch (kind) {
    case PictureKind::kHeif:
      return "HEIC or AVIF, as telephones write it, which is not read; convert it to JPEG or PNG with "
             "heif-convert (Linux) or sips (macOS), or let the telephone write JPEG (iPhone: Camera, "
             "Formats, Most Compatible)";
    case PictureKind::kJpegXl:
      return "JPEG XL, which is not read; convert it to PNG with djxl";
    case PictureKind::kJpeg2000:
      return "JPEG 2000, which is not read; convert it to TIFF or PNG with opj_decompress";
    case PictureKind::kGif:
      return "GIF, which is not read; convert it to PNG";
    case PictureKind::kPsd:
      return "a document of Photoshop, which is not read; export it as TIFF or PNG";
    case PictureKind::kStereo:
      return "a stereo pair in one picture (JPS, PNS), which no single lens made; cut one half out (ffmpeg "
             "-i IN -vf crop=iw/2:ih:0:0 OUT.png)";
    case PictureKind::kTwoFisheyes:
      return "two fisheye pictures in one (Insta360), which no single lens made; cut one half out (ffmpeg "
             "-i IN -vf crop=iw/2:ih:0:0 OUT.png) and calibrate it as a fisheye";
    default:
      return "damaged, or of another kind than PNG, JPEG, TIFF, EXR, WebP, BMP, PBM, PGM, PPM, PFM, HDR and "
             "raw; copy it again from its source, or convert it (of a light field: ulf repair DIR)";
  }
}

bool IsRawFile(const std::filesystem::path& path) {
  static const std::set<std::string> kEndings = {
      ".3fr", ".arw", ".cr2", ".cr3", ".crw", ".dcr", ".dng", ".erf", ".fff", ".iiq", ".kdc", ".mef", ".mos",
      ".mrw", ".nef", ".nrw", ".orf", ".pef", ".raf", ".rw2", ".rwl", ".sr2", ".srf", ".srw", ".x3f"};
  return kEndings.contains(Lowercase(path.extension().string()));
}

PictureKind UnreadKindByEnding(const std::filesystem::path& path) {
  static const std::map<std::string, PictureKind> kEndings = {
      {".heic", PictureKind::kHeif},    {".heif", PictureKind::kHeif},       {".hif", PictureKind::kHeif},
      {".avif", PictureKind::kHeif},    {".jxl", PictureKind::kJpegXl},      {".jp2", PictureKind::kJpeg2000},
      {".j2k", PictureKind::kJpeg2000}, {".jpx", PictureKind::kJpeg2000},    {".gif", PictureKind::kGif},
      {".psd", PictureKind::kPsd},      {".psb", PictureKind::kPsd},         {".jps", PictureKind::kStereo},
      {".pns", PictureKind::kStereo},   {".insp", PictureKind::kTwoFisheyes}};
  const auto kind = kEndings.find(Lowercase(path.extension().string()));
  return kind == kEndings.end() ? PictureKind::kUnknown : kind->second;
}

}  // namespace ulf
