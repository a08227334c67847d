// What of a frame comes to the disk when it is recorded in a light field: the photograph for every tool and,
// where the camera gave more, its master. Making them is a matter of the processor and may happen in any
// thread; writing them is light_field_io's.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/base/atomic_file.h"
#include "core/image/frame.h"
#include "core/light_field/light_field.h"

namespace ulf {

struct ViewFile {
  std::string extension;  // ".png", ".tif", ...: lower case
  FileContent content;
};

struct ViewFiles {
  // None: to be made from the master once that is on disk.
  std::optional<ViewFile> image;
  std::string image_extension;
  std::optional<ViewFile> master;
  std::optional<Transfer> master_transfer;  // none: no master, or one that only a raw converter reads
  Mosaic master_mosaic = Mosaic::kNone;
};

// kNow: files for both; kLater: the photograph is left out where it can be made from the master, which is
// on disk ten times sooner alone.
enum class MakePictures { kNow, kLater };

// A mosaic's master is the mosaic itself with `keep_mosaics`, else the 16-bit linear colours made from it. A
// camera's own JPEG is kept byte for byte. Throws Error for a frame without pixels or a file.
ViewFiles MakeViewFiles(const Frame& frame, bool keep_mosaics, MakePictures pictures);

// Whether the photograph can be made from the master.
bool PictureFollowsFromMaster(const View& view);
// The photograph as it is (or would be) stored in images/, from the master's file. Throws Error when that is
// missing or truncated.
Image PictureFromMaster(const std::filesystem::path& root, const View& view);
// Writes it where it is missing. Throws DiskFullError, Error.
void WritePictureFromMaster(const std::filesystem::path& root, const View& view);

}  // namespace ulf
