// A view's pixels, from whichever of its files holds them (declared in light_field_io.h).
#include <spdlog/spdlog.h>

#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/image/image_header.h"
#include "core/image/raw_file.h"
#include "core/light_field/light_field_io.h"
#include "core/light_field/view_files.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

void RequireSizeOf(const CameraModel& camera, const Image& image, const fs::path& path) {
  if (image.width() != camera.width || image.height() != camera.height)
    throw Error("{}: the image is {}x{}, its camera says {}x{}; correct the intrinsics or restore the image",
                path.string(), image.width(), image.height(), camera.width, camera.height);
}

// The view's photograph or its master; a raw file is cropped to the camera's size.
cv::Mat ReadPixels(const CameraModel& camera, const View& view, const fs::path& path) {
  return IsRawFile(path) ? ReadRawFile(path.string(), SizeOf(camera), view.raw_white_balance)
                         : ReadImageFile(path.string());
}

bool HasReadableMaster(const LightField& light_field, const View& view) {
  const fs::path master = view.master_path;
  const std::string ending = master.extension().string();
  return !master.empty() &&
         (view.master_transfer || IsRawFile(master) || ending == ".exr" || ending == ".png" ||
          ending == ".tif") &&
         fs::is_regular_file(light_field.root / master);
}

Image FlatFieldDivided(const LightField& light_field, const View& view, const Image& image) {
  const auto flat_field = light_field.flat_fields.find(view.camera);
  if (flat_field == light_field.flat_fields.end()) return image;
  return flat_field->second.Corrected(image, view.black_level);
}

bool HasAlpha(const fs::path& image) {
  const auto header = ReadImageHeader(image.string());
  return header && header->alpha;
}

}  // namespace

Image ReadRecordedImage(const LightField& light_field, const View& view) {
  const bool from_master = PictureFollowsFromMaster(view) && !fs::exists(light_field.root / view.image_path);
  const fs::path path = light_field.root / (from_master ? view.master_path : view.image_path);
  const CameraModel& camera = light_field.CameraOf(view);
  const Image image = from_master ? PictureFromMaster(light_field.root, view, SizeOf(camera))
                                  : Image{ReadPixels(camera, view, path), TransferOfFile(path)};
  RequireSizeOf(camera, image, path);
  return image;
}

Image ReadViewMaster(const LightField& light_field, const View& view) {
  if (view.master_path.empty()) return ReadRecordedImage(light_field, view);
  const fs::path path = light_field.root / view.master_path;
  const CameraModel& camera = light_field.CameraOf(view);
  Image image{ReadPixels(camera, view, path), view.master_transfer.value_or(TransferOfFile(path)),
              view.master_mosaic};
  if (image.mosaic != Mosaic::kNone && image.pixels.channels() != 1)
    throw Error("{}: the journal calls it a {} mosaic, but it has {} channels; restore it", path.string(),
                Name(image.mosaic), image.pixels.channels());
  RequireSizeOf(camera, image, path);
  return image;
}

bool HasMoreThanEightBits(const LightField& light_field, const View& view) {
  if (HasReadableMaster(light_field, view)) return true;
  const fs::path path = light_field.root / view.image_path;
  const auto header = ReadImageHeader(path.string());
  return TransferOfFile(path) == Transfer::kLinear || (header && header->bits > 8);
}

// The photograph stands in for a damaged master, as for a missing one.
static Image ReadMasterOrImage(const LightField& light_field, const View& view) {
  if (!HasReadableMaster(light_field, view)) return ReadRecordedImage(light_field, view);
  try {
    return ReadViewMaster(light_field, view);
  } catch (const Error& error) {
    if (!fs::exists(light_field.root / view.image_path)) throw;
    spdlog::warn("{}; its photograph of 8 bits is used", error.what());
    return ReadRecordedImage(light_field, view);
  }
}

Image ReadViewLight(const LightField& light_field, const View& view) {
  return FlatFieldDivided(light_field, view, ReadMasterOrImage(light_field, view));
}

bool HasMask(const LightField& light_field, const View& view) {
  return !view.mask_path.empty() || HasAlpha(light_field.root / view.image_path);
}

cv::Mat ReadViewMask(const LightField& light_field, const View& view) {
  cv::Mat mask;
  const auto use = [&](const cv::Mat& shown, const fs::path& path) {
    const CameraModel& camera = light_field.CameraOf(view);
    if (shown.empty()) return;
    if (shown.cols != camera.width || shown.rows != camera.height)
      throw Error("{}: the mask is {}x{}, its camera says {}x{}; make it as large as the image",
                  path.string(), shown.cols, shown.rows, camera.width, camera.height);
    mask = mask.empty() ? shown : cv::Mat(mask & shown);
  };
  if (!view.mask_path.empty()) {
    const fs::path path = light_field.root / view.mask_path;
    cv::Mat levels = ReadImageFile(path.string());
    if (levels.channels() > 1) cv::extractChannel(levels.clone(), levels, 0);
    use(levels > 0, path);  // as in nerfstudio
  }
  const fs::path image = light_field.root / view.image_path;
  if (HasAlpha(image)) use(ReadAlpha(image.string()), image);
  return mask;
}

Image ReadViewImage(const LightField& light_field, const View& view) {
  return FlatFieldDivided(light_field, view, ReadRecordedImage(light_field, view));
}

}  // namespace ulf
