#include "render/video.h"

#include <fmt/core.h>

#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "acquisition/error.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

void MakeFolderFor(const fs::path& file) {
  if (file.has_parent_path()) fs::create_directories(file.parent_path());
}

void WritePicture(const fs::path& path, const cv::Mat& srgb8) {
  if (!cv::imwrite(path.string(), srgb8))
    throw Error("{}: the picture cannot be written (disk full, no permission, or an unknown ending)",
                path.string());
}

class SinglePicture : public PictureSink {
 public:
  explicit SinglePicture(fs::path path) : path_(std::move(path)) { MakeFolderFor(path_); }
  void Add(const cv::Mat& srgb8) override { WritePicture(path_, srgb8); }
  void Close() override {}

 private:
  fs::path path_;
};

class PictureFolder : public PictureSink {
 public:
  explicit PictureFolder(fs::path path) : path_(std::move(path)) {
    std::error_code error;
    fs::create_directories(path_, error);
    if (error || !fs::is_directory(path_)) throw Error("{}: the folder cannot be made", path_.string());
  }
  void Add(const cv::Mat& srgb8) override {
    WritePicture(path_ / fmt::format("frame_{:05}.png", count_++), srgb8);
  }
  void Close() override {}

 private:
  fs::path path_;
  int count_ = 0;
};

class Video : public PictureSink {
 public:
  Video(fs::path path, double fps) : path_(std::move(path)), fps_(fps) { MakeFolderFor(path_); }

  void Add(const cv::Mat& srgb8) override {
    const cv::Size even(srgb8.cols & ~1, srgb8.rows & ~1);  // half-resolution colour asks for it
    if (even.empty()) throw Error("{}: a video needs at least 2x2 pixels", path_.string());
    if (!writer_.isOpened()) Open(even);
    writer_.write(srgb8(cv::Rect({0, 0}, even)));
  }

  void Close() override {
    writer_.release();
    std::error_code error;
    if (fs::file_size(path_, error) == 0 || error)
      throw Error("{}: the video was not written (disk full or no permission)", path_.string());
  }

 private:
  void Open(const cv::Size& size) {
    // A codec that is not there is tried and passed over without OpenCV's own messages.
    const auto level = cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    for (const char* codec : {"avc1", "mp4v"}) {
      const int fourcc = cv::VideoWriter::fourcc(codec[0], codec[1], codec[2], codec[3]);
      if (writer_.open(path_.string(), cv::CAP_FFMPEG, fourcc, fps_, size)) break;
    }
    cv::utils::logging::setLogLevel(level);
    if (!writer_.isOpened())
      throw Error(
          "{}: no video can be written here (neither H.264 nor MPEG-4, or no permission); give a folder to "
          "get "
          "pictures",
          path_.string());
  }

  fs::path path_;
  double fps_;
  cv::VideoWriter writer_;
};

}  // namespace

bool IsSinglePicture(const fs::path& out) { return out.extension() == ".png"; }

std::unique_ptr<PictureSink> OpenPictureSink(const fs::path& out, double fps) {
  if (IsSinglePicture(out)) return std::make_unique<SinglePicture>(out);
  if (out.extension() == ".mp4") return std::make_unique<Video>(out, fps);
  if (out.has_extension() && !fs::is_directory(out))
    throw UsageError("-o {}: pictures are written as OUT.mp4, OUT.png or into a folder", out.string());
  return std::make_unique<PictureFolder>(out);
}

}  // namespace ulf
