#include "render/output/video.h"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <cstdint>

#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/image/files/picture_file.h"
#include "core/video/video_writer.h"
#include "render/output/picture_files.h"

namespace ulf::render {
namespace {

namespace fs = std::filesystem;

class Pictures : public PictureSink {
 public:
  explicit Pictures(fs::path out) : out_(std::move(out)) {
    MakeFolder(IsSinglePicture(out_) ? fs::absolute(out_).parent_path() : out_);
  }
  void Add(const cv::Mat& srgb8) override {
    WritePictureFile(IsSinglePicture(out_) ? out_ : out_ / fmt::format("frame_{:05}.png", count_++), srgb8);
  }
  void Close() override {}

 private:
  fs::path out_;
  int count_ = 0;
};

class Video : public PictureSink {
 public:
  Video(fs::path path, double fps)
      : path_(std::move(path)), unfinished_(fs::path(path_).replace_extension(".part.mp4")), fps_(fps) {
    MakeFolder(fs::absolute(path_).parent_path());
  }
  ~Video() override {
    std::error_code ignored;
    writer_.reset();
    fs::remove(unfinished_, ignored);  // no player opens a video that was not closed
  }

  void Add(const cv::Mat& srgb8) override {
    const cv::Size even(srgb8.cols & ~1, srgb8.rows & ~1);  // chroma at half the resolution needs even sizes
    if (even.empty()) throw Error("{}: a video needs at least 2x2 pixels", path_.string());
    RequireRoom(even);
    if (!writer_) {
      if (even != srgb8.size())
        spdlog::warn(
            "{}: pictures of {}x{} are cropped to {}x{}: a video has even sizes; {} and {} give others",
            path_.string(), srgb8.cols, srgb8.rows, even.width, even.height, Parameter("width"),
            Parameter("height"));
      writer_ = std::make_unique<VideoWriter>(unfinished_, even, fps_);
      size_ = even;
    }
    if (even != size_)
      throw Refusal(path_.string(), "",
                    fmt::format("picture {} of the path is {}x{}, those before are {}x{}", count_, even.width,
                                even.height, size_.width, size_.height),
                    fmt::format("give {} and {}", Parameter("width"), Parameter("height")));
    writer_->Add(srgb8(cv::Rect({0, 0}, even)));
    ++count_;
  }

  void Close() override {
    if (!writer_) throw Error("{}: a video needs a picture", path_.string());
    writer_->Close();
    writer_.reset();
    fs::rename(unfinished_, path_);
  }

 private:
  // A video without its index cannot be played: the index must still find room.
  void RequireRoom(const cv::Size& size) {
    if (FreeBytes(FolderOf(unfinished_)) >= kReserve + BufferedBytes(size)) return;
    const int written = count_;
    if (written == 0)
      throw DiskFullError("{}: there is no room for a video; free some space", path_.string());
    Close();
    throw DiskFullError(
        "{}: the disk is nearly full: the video ends after {}; free some space and render the rest with {} "
        "{}:",
        path_.string(), Counted(written, "picture"), Parameter("frames"), written);
  }

  static constexpr std::uint64_t kReserve = 1 << 20;  // for the file's index
  // The encoder may buffer as much as four uncompressed pictures. Guessed.
  static std::uint64_t BufferedBytes(const cv::Size& size) {
    return 4ull * 3 * static_cast<std::uint64_t>(size.area());
  }

  fs::path path_, unfinished_;
  double fps_;
  cv::Size size_;
  int count_ = 0;
  std::unique_ptr<VideoWriter> writer_;
};

}  // namespace

std::unique_ptr<PictureSink> OpenPictureSink(const fs::path& out, double fps) {
  if (out.extension() == ".mp4") {
    // The codecs cannot store a rate outside these.
    constexpr double kLeast = 0.01, kMost = 1000;
    if (!(fps >= kLeast && fps <= kMost))
      throw Refusal(Parameter("fps"), fmt::format("{}", fps),
                    fmt::format("a video has {} to {} pictures a second", kLeast, kMost),
                    fmt::format("give {} a folder for pictures without a rate", Parameter("output")));
    return std::make_unique<Video>(out, fps);
  }
  if (out.has_extension() && out.extension() != ".png" && !fs::is_directory(out))
    throw Refusal(Parameter("output"), out.string(),
                  "pictures are written as OUT.mp4, OUT.png or into a folder", "");
  return std::make_unique<Pictures>(out);
}

}  // namespace ulf::render
