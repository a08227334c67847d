#include "core/light_field/folder/view_files.h"

#include <utility>

#include "core/base/error.h"
#include "core/image/files/picture_file.h"
#include "core/image/files/picture_kind.h"
#include "core/image/files/png_picture.h"
#include "core/image/files/raw_file.h"
#include "core/image/files/tiff_file.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTiff = ".tif";
constexpr const char* kPng = ".png";

// Makes content that owns its bytes.
FileContent Owning(std::shared_ptr<const std::string> bytes) {
  FileContent content = ContentOf(*bytes);
  content.copy = [bytes, copy = std::move(content.copy)](std::uint64_t offset, std::span<char> out) {
    copy(offset, out);
  };
  return content;
}

ViewFile FileOf(const EncodedImage& image) { return {image.extension, Owning(image.bytes)}; }

ViewFile Png(const cv::Mat& pixels) {
  return {kPng, Owning(std::make_shared<const std::string>(PngBytes(pixels)))};
}

bool IsPlain8BitSrgb(const Image& image) {
  return image.transfer == Transfer::kSrgb && image.mosaic == Mosaic::kNone && image.pixels.depth() == CV_8U;
}

// Returns the camera's own file, if it can serve as the photograph.
std::optional<EncodedImage> CameraFile(const Frame& frame) {
  if (frame.encoded && frame.encoded->extension == ".jpg" && IsPlain8BitSrgb(frame.image))
    return frame.encoded;
  if (!frame.image.empty()) return std::nullopt;
  if (const auto& file = frame.encoded ? frame.encoded : frame.raw) return file;  // could not be decoded
  throw Error("a frame without pixels or a file cannot be kept");
}

std::string NameOf(const EncodedImage& raw) { return "the photograph's raw file (" + raw.extension + ")"; }

// Reads its header only; none if it cannot be read.
std::optional<RawFacts> FactsOf(const EncodedImage& raw) {
  try {
    return RawFactsOf(*raw.bytes, NameOf(raw));
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace

ViewFiles MakeViewFiles(const Frame& frame, bool keep_mosaics, MakePictures pictures,
                        LockedWhiteBalance* white_balance) {
  ViewFiles files;
  const std::optional<EncodedImage> own = CameraFile(frame);
  if (frame.raw) {
    files.master = FileOf(*frame.raw);
    files.raw = FactsOf(*frame.raw);
  } else if (!IsPlain8BitSrgb(frame.image)) {
    const Image master = keep_mosaics ? frame.image : Demosaiced(frame.image);
    files.master = {kTiff, TiffContent(master.pixels)};
    files.master_transfer = master.transfer;
    files.master_mosaic = master.mosaic;
  }
  files.image_extension = own ? own->extension : kPng;
  if (own) {
    files.image = FileOf(*own);
  } else if (files.raw) {
    // Its pixels were developed for tracking only: the photograph is made from the file.
    if (pictures == MakePictures::kNow)
      files.image = Png(Srgb8(
          {.pixels = DecodeRaw(*frame.raw->bytes, NameOf(*frame.raw), RawQuality::kBest, {},
                               white_balance ? white_balance->WhiteBalanceFor(*files.raw) : std::nullopt)
                         .light,
           .transfer = Transfer::kLinear}));
  } else if (pictures == MakePictures::kNow || !files.master_transfer) {
    files.image = Png(Srgb8(frame.image));
  }
  return files;
}

bool PictureFollowsFromMaster(const View& view) {
  const fs::path master = view.master_path;
  return (IsRawFile(master) || (view.master_transfer && master.extension() == kTiff)) &&
         fs::path(view.image_path).extension() == kPng;
}

Image PictureFromMaster(const fs::path& root, const View& view, std::optional<cv::Size> size) {
  const std::string path = (root / view.master_path).string();
  if (IsRawFile(path))
    return {.pixels = Srgb8(
                {.pixels = ReadRawFile(path, size, view.raw_white_balance), .transfer = Transfer::kLinear}),
            .transfer = Transfer::kSrgb};
  const Image master{ReadImageFile(path), *view.master_transfer, view.master_mosaic};
  return {.pixels = Srgb8(master), .transfer = Transfer::kSrgb};
}

void WritePictureFromMaster(const fs::path& root, const View& view, std::optional<cv::Size> size) {
  const fs::path path = root / view.image_path;
  if (fs::exists(path)) return;
  FileBatch batch;
  batch.Write(path, Png(PictureFromMaster(root, view, size).pixels).content);
  batch.Commit();
}

}  // namespace ulf
