#include "core/light_field/folder/view_images.h"

#include <spdlog/spdlog.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/image/clipped.h"
#include "core/image/files/exr_file.h"
#include "core/image/files/image_header.h"
#include "core/image/files/picture_file.h"
#include "core/image/files/picture_kind.h"
#include "core/image/files/raw_file.h"
#include "core/light_field/folder/view_files.h"
#include "core/light_field/light_field.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

void RequireSizeOf(const CameraModel& camera, const Image& image, const fs::path& path) {
  if (image.width() != camera.width || image.height() != camera.height)
    throw Error("{}: the image is {}x{}, its camera says {}x{}; correct the intrinsics or restore the image",
                path.string(), image.width(), image.height(), camera.width, camera.height);
}

bool HasReadableMaster(const LightField& light_field, const View& view) {
  const fs::path master = view.master_path;
  const std::string ending = master.extension().string();
  return !master.empty() &&
         (view.master_transfer || IsRawFile(master) || ending == ".exr" || ending == ".png" ||
          ending == ".tif") &&
         fs::is_regular_file(light_field.root / master);
}

// Returns null if the camera has none for pictures of this kind.
const ColorProfile* ProfileFor(const LightField& light_field, const View& view, bool is_raw) {
  const auto found = light_field.color_profiles.find(view.camera);
  return found != light_field.color_profiles.end() && found->second.raw_white_balance.has_value() == is_raw
             ? &found->second
             : nullptr;
}

// The camera's picture with its metadata.
struct Recorded {
  Image image;
  cv::Mat clipped;
  bool is_raw = false;
};

Image Corrected(const LightField& light_field, const View& view, const Recorded& recorded) {
  Image image = recorded.image;
  if (const auto flat_field = light_field.flat_fields.find(view.camera);
      flat_field != light_field.flat_fields.end())
    image = flat_field->second.Corrected(image, view.black_level);
  if (const ColorProfile* profile = ProfileFor(light_field, view, recorded.is_raw))
    image = profile->Applied(image, view.black_level, recorded.clipped);
  return image;
}

}  // namespace

// Reads the view's photograph or its master at `path`; a raw file is cropped to the camera's size.
static Recorded ReadPixels(const LightField& light_field, const View& view, const fs::path& path,
                           bool finds_clipped) {
  const CameraModel& camera = light_field.CameraOf(view);
  Recorded recorded{.image = {}, .clipped = {}, .is_raw = IsRawFile(path)};
  if (recorded.is_raw) {
    const ColorProfile* profile = ProfileFor(light_field, view, true);
    recorded.image = {ReadRawFile(path.string(), SizeOf(camera),
                                  profile ? profile->raw_white_balance : view.raw_white_balance,
                                  finds_clipped ? &recorded.clipped : nullptr),
                      TransferOfFile(path)};
  } else {
    recorded.image = {ReadImageFile(path.string()), TransferOfFile(path)};
  }
  return recorded;
}

static Recorded ReadRecorded(const LightField& light_field, const View& view, bool finds_clipped) {
  const bool from_master = PictureFollowsFromMaster(view) && !fs::exists(light_field.root / view.image_path);
  const fs::path path = light_field.root / (from_master ? view.master_path : view.image_path);
  const CameraModel& camera = light_field.CameraOf(view);
  Recorded recorded;
  if (from_master)
    recorded.image = PictureFromMaster(light_field.root, view, SizeOf(camera));
  else
    recorded = ReadPixels(light_field, view, path, finds_clipped);
  RequireSizeOf(camera, recorded.image, path);
  if (finds_clipped && !recorded.is_raw) recorded.clipped = ClippedPixels(recorded.image);
  return recorded;
}

Image ReadRecordedImage(const LightField& light_field, const View& view) {
  return ReadRecorded(light_field, view, false).image;
}

static Recorded ReadMaster(const LightField& light_field, const View& view, bool finds_clipped) {
  if (view.master_path.empty()) return ReadRecorded(light_field, view, finds_clipped);
  const fs::path path = light_field.root / view.master_path;
  Recorded recorded = ReadPixels(light_field, view, path, finds_clipped);
  Image& image = recorded.image;
  image.transfer = view.master_transfer.value_or(image.transfer);
  image.mosaic = view.master_mosaic;
  if (image.mosaic != Mosaic::kNone && image.pixels.channels() != 1)
    throw Error("{}: the journal calls it a {} mosaic, but it has {} channels; restore it", path.string(),
                Name(image.mosaic), image.pixels.channels());
  RequireSizeOf(light_field.CameraOf(view), image, path);
  if (finds_clipped && !recorded.is_raw) recorded.clipped = ClippedPixels(image);
  return recorded;
}

Image ReadViewMaster(const LightField& light_field, const View& view) {
  return ReadMaster(light_field, view, false).image;
}

static bool HasMerged(const LightField& light_field, const View& view) {
  return view.merged && fs::is_regular_file(light_field.root / view.merged->path);
}

// Converts to numbers of the view's master: above the black level, which the reader subtracts.
static Recorded ReadMerged(const LightField& light_field, const View& view) {
  const fs::path path = light_field.root / view.merged->path;
  Recorded recorded{.image = {ReadExr(path.string()), Transfer::kLinear}, .clipped = {}, .is_raw = false};
  RequireSizeOf(light_field.CameraOf(view), recorded.image, path);
  recorded.image.pixels += cv::Scalar::all(view.black_level);
  recorded.is_raw = IsRawFile(view.master_path);
  if (const cv::Mat clipped = ReadExrChannel(path.string(), kClippedChannel); !clipped.empty())
    recorded.clipped = clipped > 0;
  if (recorded.clipped.empty() || cv::countNonZero(recorded.clipped) == 0) recorded.clipped.release();
  return recorded;
}

bool HasMoreThanEightBits(const LightField& light_field, const View& view) {
  if (HasMerged(light_field, view)) return true;
  if (HasReadableMaster(light_field, view)) return true;
  const fs::path path = light_field.root / view.image_path;
  const auto header = ReadImageHeader(path.string());
  return TransferOfFile(path) == Transfer::kLinear || (header && header->bits > 8);
}

// A damaged file is replaced by its source, or by what was made of it.
static Recorded ReadMostLight(const LightField& light_field, const View& view) {
  if (HasMerged(light_field, view)) {
    try {
      return ReadMerged(light_field, view);
    } catch (const Error& error) {
      spdlog::warn("{}; its own exposure is used; ulf merge makes it again", error.what());
    }
  }
  if (!HasReadableMaster(light_field, view)) return ReadRecorded(light_field, view, true);
  try {
    return ReadMaster(light_field, view, true);
  } catch (const Error& error) {
    if (!fs::exists(light_field.root / view.image_path)) throw;
    spdlog::warn("{}; its photograph of 8 bits is used", error.what());
    return ReadRecorded(light_field, view, true);
  }
}

Image ReadViewLight(const LightField& light_field, const View& view, cv::Mat* clipped) {
  const Recorded recorded = ReadMostLight(light_field, view);
  if (clipped) *clipped = recorded.clipped;
  return Corrected(light_field, view, recorded);
}

Image ReadRecordedLight(const LightField& light_field, const View& view) {
  return ReadMostLight(light_field, view).image;
}

bool HasMask(const LightField& light_field, const View& view) {
  return !view.mask_path.empty() || HasAlphaChannel(light_field.root / view.image_path);
}

cv::Mat ReadViewMask(const LightField& light_field, const View& view) {
  cv::Mat mask;
  const auto use = [&](const cv::Mat& shown, const fs::path& path) {
    const CameraModel& camera = light_field.CameraOf(view);
    if (shown.empty()) return;
    if (!HasAspectOf(camera, shown.size()))
      throw Error("{}: the mask is {}x{}, its camera says {}x{}; make it as large as the image",
                  path.string(), shown.cols, shown.rows, camera.width, camera.height);
    cv::Mat fitting = shown;
    if (shown.size() != SizeOf(camera)) cv::resize(shown, fitting, SizeOf(camera), 0, 0, cv::INTER_NEAREST);
    mask = mask.empty() ? fitting : cv::Mat(mask & fitting);
  };
  if (!view.mask_path.empty()) {
    const fs::path path = light_field.root / view.mask_path;
    cv::Mat levels = ReadImageFile(path.string());
    if (view.mask_marks_unused) {
      cv::Mat unused = levels.reshape(1) > 0;  // in any channel
      cv::reduce(unused.reshape(1, static_cast<int>(levels.total())), unused, 1, cv::REDUCE_MAX);
      use(unused.reshape(1, levels.rows) == 0, path);
    } else {
      if (levels.channels() > 1) cv::extractChannel(levels.clone(), levels, 0);
      use(levels > 0, path);  // as in nerfstudio
    }
  }
  const fs::path image = light_field.root / view.image_path;
  if (HasAlphaChannel(image)) use(ReadAlpha(image.string()), image);
  return mask;
}

Image ReadViewImage(const LightField& light_field, const View& view, cv::Mat* clipped) {
  const Recorded recorded = ReadRecorded(light_field, view, true);
  if (clipped) *clipped = recorded.clipped;
  return Corrected(light_field, view, recorded);
}

}  // namespace ulf
