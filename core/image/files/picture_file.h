// Reads and writes picture files of any kind. The file's first bytes tell its kind, not its name, except for
// raw files, which the ending of the name tells, since many are TIFF inside.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "core/image/files/stored_picture.h"
#include "core/image/image.h"

namespace ulf {

// Reads any kind but raw files. Throws Error naming the file, what is wrong with it, and the remedy.
StoredPicture ReadPicture(const std::string& path);

// Logs the warnings of a picture, each kind of them once in this process.
void LogWarnings(const std::string& path, const StoredPicture& picture);

// Returns the pixels of ReadPicture(), and calls LogWarnings(); for a camera's raw file what ReadRawFile()
// returns. Transparent pixels keep their colours. Throws Error as ReadPicture() does.
cv::Mat ReadImageFile(const std::string& path);
// Says how the numbers that ReadImageFile() returns relate to light: linear for raw files and floating point.
Transfer TransferOfFile(const std::filesystem::path& path);

// Returns whether the header claims an alpha channel or transparent colours; false for an unreadable file.
bool HasAlphaChannel(const std::filesystem::path& path);
// Returns the alpha channel of an image file, CV_8UC1: 255 where a pixel is at least half opaque, else 0;
// empty if the file has none. Throws as ReadImageFile() does.
cv::Mat ReadAlpha(const std::string& path);

// Returns width and height of any readable picture, for a raw file as the camera crops it (raw_file.h).
// Decodes kinds that ReadImageHeader() does not know. Throws Error as ReadImageFile() does.
cv::Size ReadImageSize(const std::string& path);

// Returns whether the name has an ending that ReadImageFile() reads, in lower or upper case.
bool HasImageEnding(const std::filesystem::path& path);
// Tells, by the name's ending, the kind of a picture that is not read, and what converts it ("HEIC, ... ;
// heif-convert ..."); none for others.
std::optional<std::string> UnreadPicture(const std::filesystem::path& path);

// Encodes by the ending of `path`: .png, .jpg, .jpeg or .webp. Throws DiskFullError or Error; an existing
// file at `path` is then unchanged.
void WritePictureFile(const std::string& path, const cv::Mat& srgb8);

// Blends the picture's colours (straight, not premultiplied) over `background` (B, G, R, encoded as the
// picture, 0 to 1) in stored numbers, as synthetic sets for view synthesis define it. Returns three channels
// of the picture's depth; empty if the file has no alpha channel, or one that is opaque everywhere. Throws
// Error as ReadPicture() does.
cv::Mat ReadOverBackground(const std::string& path, const cv::Vec3d& background);

}  // namespace ulf
