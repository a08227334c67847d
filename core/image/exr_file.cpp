#include "core/image/exr_file.h"

#include <Iex.h>
#include <ImathBox.h>
#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <system_error>

#include "core/base/error.h"
#include "core/image/exr_header.h"
#include "core/image/image_header.h"

namespace ulf {
namespace {

constexpr float kLargestHalf = 65504.0f;

class BytesStream : public Imf::OStream {
 public:
  BytesStream() : Imf::OStream("picture.exr") {}
  void write(const char from[], int count) override {
    const auto size = static_cast<std::size_t>(count);
    if (position_ + size > bytes_.size()) bytes_.resize(position_ + size);
    std::memcpy(bytes_.data() + position_, from, size);
    position_ += size;
  }
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override { position_ = position; }
  std::string Take() { return std::move(bytes_); }

 private:
  std::string bytes_;
  std::size_t position_ = 0;
};

cv::Size2d SizeOf(const Imath::Box2i& window) {
  return {static_cast<double>(window.max.x) - window.min.x + 1,
          static_cast<double>(window.max.y) - window.min.y + 1};
}

// For as many numbers a pixel as floats.
void RequireRoom(const std::string& path, const cv::Size2d& size, int channels) {
  constexpr double kMostPx = 1 << 20;
  std::error_code unknown;
  const std::uintmax_t bytes = std::filesystem::file_size(path, unknown);
  if (!(size.width >= 1 && size.height >= 1 && size.width <= kMostPx && size.height <= kMostPx))
    throw Error("{}: is {:.0f}x{:.0f}, which is no picture's size; write it again", path, size.width,
                size.height);
  RequirePixelsOfFile(path, unknown ? 0 : bytes, size.area(), channels * sizeof(float));
}

cv::Mat ReadColours(Imf::InputFile& file, const std::string& path) {
  const Imf::Header& header = file.header();
  const Imath::Box2i shown = header.displayWindow(), data = header.dataWindow();
  const cv::Size2d size = SizeOf(data), shown_size = SizeOf(shown);
  RequireRoom(path, size, 3);
  RequireRoom(path, shown_size, 3);
  // Indexed from the data window's corner.
  cv::Mat stored(static_cast<int>(size.height), static_cast<int>(size.width), CV_32FC3, cv::Scalar::all(0));
  Imf::FrameBuffer buffer;
  const auto has = [&](const char* name) { return header.channels().findChannel(name) != nullptr; };
  const bool color = has("R") && has("G") && has("B");
  if (!color && (!has("Y") || has("RY")))
    throw Error("{}: holds neither R, G and B nor Y alone; write those channels without a layer's name",
                path);
  for (const auto& [name, at] : {std::pair{"B", 0}, {"G", 1}, {"R", 2}, {"Y", 0}}) {
    if ((name[0] != 'Y') != color) continue;
    const auto x_stride = static_cast<std::ptrdiff_t>(3 * sizeof(float)),
               y_stride = static_cast<std::ptrdiff_t>(stored.step);
    char* base = reinterpret_cast<char*>(stored.data) + at * static_cast<std::ptrdiff_t>(sizeof(float)) -
                 data.min.x * x_stride - data.min.y * y_stride;
    buffer.insert(name, Imf::Slice(Imf::FLOAT, base, 3 * sizeof(float), stored.step));
  }
  file.setFrameBuffer(buffer);
  file.readPixels(data.min.y, data.max.y);
  if (!color)
    for (int y = 0; y < stored.rows; ++y)
      for (int x = 0; x < stored.cols; ++x)
        stored.at<cv::Vec3f>(y, x) = cv::Vec3f::all(stored.at<cv::Vec3f>(y, x)[0]);
  if (shown == data) return stored;
  cv::Mat picture(static_cast<int>(shown_size.height), static_cast<int>(shown_size.width), CV_32FC3,
                  cv::Scalar::all(0));
  const cv::Rect data_in_shown(data.min.x - shown.min.x, data.min.y - shown.min.y, stored.cols, stored.rows);
  const cv::Rect both = data_in_shown & cv::Rect(0, 0, picture.cols, picture.rows);
  if (!both.empty()) stored(both - data_in_shown.tl()).copyTo(picture(both));
  return picture;
}

}  // namespace

cv::Mat HalfFromFloat(const cv::Mat& pixels) {
  const cv::Mat clipped = cv::max(cv::min(pixels.reshape(1), kLargestHalf), -kLargestHalf);
  cv::Mat half;
  clipped.convertTo(half, CV_16F);
  return half.reshape(pixels.channels());
}

std::string ExrBytes(const std::vector<ExrChannel>& channels, ExrCompression compression,
                     const ExrColors& colors, const std::map<std::string, std::string>& attributes) {
  const cv::Size size = channels.front().pixels.size();
  Imf::Header header(size.width, size.height);
  header.compression() = compression == ExrCompression::kPiz ? Imf::PIZ_COMPRESSION : Imf::ZIP_COMPRESSION;
  if (colors) {
    const std::array<float, 8>& xy = *colors;
    Imf::addChromaticities(
        header, Imf::Chromaticities({xy[0], xy[1]}, {xy[2], xy[3]}, {xy[4], xy[5]}, {xy[6], xy[7]}));
    if (xy == kRec709) header.insert("colorInteropID", Imf::StringAttribute("lin_rec709_scene"));
  }
  for (const auto& [name, text] : attributes) header.insert(name, Imf::StringAttribute(text));
  Imf::FrameBuffer buffer;
  for (const ExrChannel& channel : channels) {
    const Imf::PixelType type = channel.pixels.depth() == CV_16F ? Imf::HALF : Imf::FLOAT;
    header.channels().insert(channel.name, Imf::Channel(type));
    char* base = const_cast<char*>(reinterpret_cast<const char*>(channel.pixels.data)) +
                 static_cast<std::size_t>(channel.channel) * channel.pixels.elemSize1();
    buffer.insert(channel.name, Imf::Slice(type, base, channel.pixels.elemSize(), channel.pixels.step));
  }
  BytesStream stream;
  try {
    Imf::OutputFile file(stream, header);
    file.setFrameBuffer(buffer);
    file.writePixels(size.height);
  } catch (const Iex::BaseExc& error) {
    throw Error("a picture of {}x{} with {} channels cannot be written as EXR: {}", size.width, size.height,
                channels.size(), error.what());
  }
  return stream.Take();
}

cv::Mat ReadExr(const std::string& path) {
  try {
    RequireExrHeader(path);
    Imf::InputFile file(path.c_str());
    return ReadColours(file, path);
  } catch (const Iex::BaseExc& error) {
    RefuseExr(path, error.what());
  }
}

cv::Mat ReadExrChannel(const std::string& path, const std::string& name) {
  try {
    RequireExrHeader(path);
    Imf::InputFile file(path.c_str());
    if (!file.header().channels().findChannel(name)) return {};
    const Imath::Box2i data = file.header().dataWindow();
    const cv::Size2d size = SizeOf(data);
    RequireRoom(path, size, 1);
    cv::Mat stored(static_cast<int>(size.height), static_cast<int>(size.width), CV_32FC1);
    char* base = reinterpret_cast<char*>(stored.data) -
                 data.min.x * static_cast<std::ptrdiff_t>(sizeof(float)) -
                 data.min.y * static_cast<std::ptrdiff_t>(stored.step);
    Imf::FrameBuffer buffer;
    buffer.insert(name, Imf::Slice(Imf::FLOAT, base, sizeof(float), stored.step));
    file.setFrameBuffer(buffer);
    file.readPixels(data.min.y, data.max.y);
    return stored;
  } catch (const Iex::BaseExc& error) {
    RefuseExr(path, error.what());
  }
}

ExrColors ExrColorsOf(const std::string& path) {
  try {
    RequireExrHeader(path);
    const Imf::InputFile file(path.c_str());
    if (!Imf::hasChromaticities(file.header())) return std::nullopt;
    const Imf::Chromaticities& told = Imf::chromaticities(file.header());
    return std::array{told.red.x,  told.red.y,  told.green.x, told.green.y,
                      told.blue.x, told.blue.y, told.white.x, told.white.y};
  } catch (const Iex::BaseExc& error) {
    RefuseExr(path, error.what());
  }
}

std::string ExrAttribute(const std::string& path, const std::string& name) {
  try {
    RequireExrHeader(path);
    const Imf::InputFile file(path.c_str());
    const auto* text = file.header().findTypedAttribute<Imf::StringAttribute>(name);
    return text ? text->value() : "";
  } catch (const Iex::BaseExc& error) {
    RefuseExr(path, error.what());
  }
}

}  // namespace ulf
