// Makes the files of a recorded frame: the photograph, which every program reads, and its master if the frame
// has more than 8-bit sRGB. Encoding may run in any thread; LightFieldWriter writes the files.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "core/base/atomic_file.h"
#include "core/frames/frame.h"
#include "core/image/files/raw_file.h"
#include "core/light_field/light_field.h"

namespace ulf {

struct ViewFile {
  std::string extension;  // ".png", ".tif", ...: lower case
  FileContent content;
};

struct ViewFiles {
  std::optional<ViewFile> image;  // the photograph; none: it will be made from the master on disk
  std::string image_extension;    // the photograph's, also if it will be made later
  std::optional<ViewFile> master;
  std::optional<Transfer> master_transfer;  // none: no master, or a camera's raw file
  Mosaic master_mosaic = Mosaic::kNone;
  std::optional<RawFacts> raw = {};  // if the master is a readable raw file
};

// kNow makes photograph and master; kLater makes only the master if the photograph can be made from it,
// because the master alone is on disk ten times sooner.
enum class MakePictures { kNow, kLater };

// Encodes a frame's files. The master of a mosaic is the mosaic itself with `keep_mosaics`, else demosaicked
// 16-bit linear colours. A camera's own JPEG is kept byte for byte; without one the photograph is made from
// the raw file, by `white_balance` (null: the file's own). Throws Error for a frame without pixels or a file.
ViewFiles MakeViewFiles(const Frame& frame, bool keep_mosaics, MakePictures pictures,
                        LockedWhiteBalance* white_balance = nullptr);

// Returns whether the photograph can be made from the master.
bool PictureFollowsFromMaster(const View& view);
// Returns the photograph made from the master, 8-bit sRGB. `size` is the camera model's, to which a raw file
// is cropped; by default as the camera crops it. Throws Error if the master is missing or truncated.
Image PictureFromMaster(const std::filesystem::path& root, const View& view,
                        std::optional<cv::Size> size = std::nullopt);
// Writes that photograph if it is missing. Throws DiskFullError, Error.
void WritePictureFromMaster(const std::filesystem::path& root, const View& view,
                            std::optional<cv::Size> size = std::nullopt);

}  // namespace ulf
