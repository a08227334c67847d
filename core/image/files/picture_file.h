// Reads and writes picture files of any kind. The kind is told by the file's first bytes, not by its name; of
// raw files alone the ending of the name tells, since many are TIFF inside.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "core/image/files/stored_picture.h"
#include "core/image/image.h"

namespace ulf {

// Any kind but raw files. Throws Error naming the file, what is wrong with it, and the way out.
StoredPicture ReadPicture(const std::string& path);

// Logs the warnings of a picture, each kind of them once for all files.
void SayWarnings(const std::string& path, const StoredPicture& picture);

// The pixels of ReadPicture(), or of a camera's raw file as raw_file.h reads it; what is transparent keeps
// its colours. Warnings of the picture are logged, each once. Throws Error as ReadPicture() does.
cv::Mat ReadImageFile(const std::string& path);
// How the numbers of such a file relate to light: linear in raw files and wherever they are floating point.
Transfer TransferOfFile(const std::filesystem::path& path);

// Whether its header says that it has an alpha channel, or colours that are transparent. False for what
// cannot be read.
bool HasAlphaChannel(const std::filesystem::path& path);
// The alpha channel of an image file, CV_8UC1: 255 where a pixel is at least half opaque, else 0. Empty where
// the file has none. Throws as ReadImageFile() does.
cv::Mat ReadAlpha(const std::string& path);

// Width and height of any picture that ulf reads; of a raw file as the camera crops it (raw_file.h); other
// kinds are decoded for it. Throws Error as ReadImageFile().
cv::Size ReadImageSize(const std::string& path);

// Whether the file's name has the ending of a picture that ReadImageFile() reads, in lower or upper case.
bool HasImageEnding(const std::filesystem::path& path);
// Of a picture of a kind that is not read, by its ending: which kind, and what converts it ("HEIC, ... ;
// heif-convert ...").
std::optional<std::string> UnreadPicture(const std::filesystem::path& path);

// Encodes by the ending of `path`. Throws DiskFullError or Error; then the file at `path`, if there was one,
// is unchanged.
void WritePictureFile(const std::string& path, const cv::Mat& srgb8);

// The picture's colours (straight, not premultiplied) over `background` (B, G, R, display-encoded, 0 to 1),
// by the numbers as they are stored, which is how synthetic sets for view synthesis are meant: CV_8UC3 or
// CV_16UC3. Empty where the file has no alpha channel. Throws Error as ReadImageFile() does.
cv::Mat ReadOverBackground(const std::string& path, const cv::Vec3d& background);

}  // namespace ulf
