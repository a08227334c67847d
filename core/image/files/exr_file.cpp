#include "core/image/files/exr_file.h"

#include <Iex.h>
#include <ImathBox.h>
#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfFloatAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfOutputFile.h>
#include <ImfPartType.h>
#include <ImfRgbaFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <opencv2/core.hpp>
#include <set>
#include <string>
#include <system_error>

#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/image/files/exif.h"
#include "core/image/files/exr_header.h"
#include "core/image/files/image_header.h"
#include "core/image/files/picture_colors.h"
#include "core/image/files/picture_projection.h"
#include "core/image/files/stored_picture.h"

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

// Checks memory for as many floats a pixel.
void RequireRoom(const std::string& path, const cv::Size2d& size, int channels) {
  constexpr double kMostPx = 1 << 20;
  std::error_code unknown;
  const std::uintmax_t bytes = std::filesystem::file_size(path, unknown);
  if (!(size.width >= 1 && size.height >= 1 && size.width <= kMostPx && size.height <= kMostPx))
    throw Error("{}: is {:.0f}x{:.0f}, which is no picture's size; write it again", path, size.width,
                size.height);
  RequirePixelsOfFile(path, unknown ? 0 : bytes, size.area(), channels * sizeof(float));
}

// The names of a picture's channels in one part of a file.
struct ColorChannels {
  std::string layer;  // with its point: "beauty."; empty: none
  bool has_colors = false, has_luminance = false, has_chroma = false, has_alpha = false;
  bool any() const { return has_colors || has_luminance; }
};

// A Y beside an X is a coordinate (normals, motion, CIE XYZ), and so is one beside a Z in a layer; a Z alone
// is depth.
ColorChannels ChannelsOf(const Imf::Header& header, const std::string& layer) {
  const auto has = [&](const char* name) { return header.channels().findChannel(layer + name) != nullptr; };
  const bool is_coordinate = has("X") || (!layer.empty() && has("Z"));
  return {layer, has("R") && has("G") && has("B"), has("Y") && !is_coordinate, has("RY") && has("BY"),
          has("A")};
}

struct ExrPicturePlace {
  int part = 0;
  ColorChannels channels;
};

[[noreturn]] void RefuseWithoutColors(const std::string& path, const std::set<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  throw Error("{}: holds no picture: neither R, G and B nor Y among its channels ({}); write those channels",
              path, list);
}

// A candidate picture: plain channels of a part, or a layer.
struct ExrCandidate {
  ExrPicturePlace place;
  std::string words;  // "part 2 of 3 (beauty)", "the layer 'beauty'"
  int rank = 0;       // the default names first, then colour, then luminance
};

int RankOf(const ColorChannels& channels, std::string name) {
  if (!channels.has_colors && !channels.has_chroma) return 2;
  static const std::set<std::string> kPictures = {"combined", "beauty", "rgba",  "rgb",
                                                  "color",    "colour", "final", "main"};
  name = Lowercase(name);
  return kPictures.contains(name.substr(name.rfind('.') + 1)) ? 0 : 1;
}

ExrPicturePlace PlaceOfPicture(const Imf::MultiPartInputFile& file, const std::string& path,
                               StoredPicture& picture) {
  std::set<std::string> names, layers;
  std::vector<ExrCandidate> candidates;
  for (int part = 0; part < file.parts(); ++part) {
    const Imf::Header& header = file.header(part);
    if (header.hasType() && Imf::isDeepData(header.type())) {
      names.insert("deep samples");
      continue;
    }
    const std::string part_name = header.hasName() ? ExifText(header.name()) : "";
    if (const ColorChannels plain = ChannelsOf(header, ""); plain.any())
      candidates.push_back({{part, plain},
                            fmt::format("part {} of {}{}", part + 1, file.parts(),
                                        part_name.empty() ? "" : " (" + part_name + ")"),
                            file.parts() == 1 && plain.has_colors ? -1 : RankOf(plain, part_name)});
    for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel) {
      const std::string name = channel.name();
      names.insert(ExifText(name));
      const std::size_t point = name.rfind('.');
      if (point == std::string::npos ||
          !layers.insert(fmt::format("{} {}", part, name.substr(0, point))).second)
        continue;
      if (const ColorChannels of_layer = ChannelsOf(header, name.substr(0, point + 1)); of_layer.any())
        candidates.push_back({{part, of_layer},
                              fmt::format("the layer '{}'", ExifText(name.substr(0, point))),
                              RankOf(of_layer, name.substr(0, point))});
    }
  }
  if (candidates.empty()) RefuseWithoutColors(path, names);
  const auto chosen = std::ranges::min_element(candidates, {}, &ExrCandidate::rank);
  const auto equals = std::ranges::count(candidates, chosen->rank, &ExrCandidate::rank);
  const bool is_plain_file = file.parts() == 1 && chosen->place.channels.layer.empty();
  if (equals > 1)
    picture.warnings.push_back(
        fmt::format("its picture is taken from {}, the first of {} that may be meant: write "
                    "the one that is meant as a file of its own",
                    chosen->words, equals));
  else if (!is_plain_file)
    picture.remarks.push_back(fmt::format("its picture is taken from {}", chosen->words));
  return chosen->place;
}

// Returns the library's origin of a buffer, place 0, 0 of the file's own coordinates, which may lie far
// outside of the buffer, so that it is computed as a number.
template <typename T>
T* OriginOf(T* first, const Imath::Box2i& data, std::int64_t x_stride_bytes, std::int64_t y_stride_bytes) {
  const std::int64_t offset = data.min.x * x_stride_bytes + data.min.y * y_stride_bytes;
  return reinterpret_cast<T*>(reinterpret_cast<std::uintptr_t>(first) - static_cast<std::uintptr_t>(offset));
}

// Chroma has half the size; the library's reader of RGBA upsamples it, in half floats.
cv::Mat ReadLuminanceAndChroma(const std::string& path, const cv::Size& size, const std::string& layer) {
  Imf::RgbaInputFile file(path.c_str(), layer);
  const Imath::Box2i data = file.dataWindow();
  std::vector<Imf::Rgba> line(static_cast<std::size_t>(size.width));
  cv::Mat stored(size, CV_32FC3);
  for (int y = 0; y < size.height; ++y) {
    file.setFrameBuffer(OriginOf(line.data(), data, sizeof(Imf::Rgba), 0), 1, 0);
    file.readPixels(data.min.y + y);
    for (int x = 0; x < size.width; ++x) {
      const Imf::Rgba& pixel = line[static_cast<std::size_t>(x)];
      stored.at<cv::Vec3f>(y, x) = {pixel.b, pixel.g, pixel.r};
    }
  }
  return stored;
}

// Reads channels of a part's data window, each into its place in the pixels.
void ReadSlices(Imf::MultiPartInputFile& file, int number,
                const std::vector<std::pair<std::string, int>>& channels, cv::Mat& pixels) {
  const Imath::Box2i data = file.header(number).dataWindow();
  const std::size_t step = pixels.elemSize();
  Imf::FrameBuffer buffer;
  for (const auto& [name, at] : channels) {
    char* base = OriginOf(reinterpret_cast<char*>(pixels.ptr<float>() + at), data,
                          static_cast<std::int64_t>(step), static_cast<std::int64_t>(pixels.step));
    buffer.insert(name, Imf::Slice(Imf::FLOAT, base, step, pixels.step));
  }
  Imf::InputPart part(file, number);
  part.setFrameBuffer(buffer);
  part.readPixels(data.min.y, data.max.y);
}

cv::Mat ReadStored(Imf::MultiPartInputFile& file, const ExrPicturePlace& place, const cv::Size& size) {
  const std::string& layer = place.channels.layer;
  const bool color = place.channels.has_colors;
  cv::Mat stored(size, color ? CV_32FC3 : CV_32FC1, cv::Scalar::all(0));
  if (color)
    ReadSlices(file, place.part, {{layer + "B", 0}, {layer + "G", 1}, {layer + "R", 2}}, stored);
  else
    ReadSlices(file, place.part, {{layer + "Y", 0}}, stored);
  if (!color) cv::merge(std::vector<cv::Mat>(3, stored), stored);
  return stored;
}

// Crops or pads the pixels of the data window to the display window.
cv::Mat InDisplay(const cv::Mat& stored, const Imath::Box2i& data, const Imath::Box2i& shown) {
  if (shown == data) return stored;
  cv::Mat picture(shown.max.y - shown.min.y + 1, shown.max.x - shown.min.x + 1, stored.type(),
                  cv::Scalar::all(0));
  const cv::Rect data_in_shown(data.min.x - shown.min.x, data.min.y - shown.min.y, stored.cols, stored.rows);
  const cv::Rect both = data_in_shown & cv::Rect(0, 0, picture.cols, picture.rows);
  if (!both.empty()) stored(both - data_in_shown.tl()).copyTo(picture(both));
  return picture;
}

// Colours are premultiplied in these files.
void TakeOpacity(const cv::Mat& opacity, StoredPicture& picture) {
  double least = 1;
  cv::minMaxLoc(opacity, &least);
  if (!(least < 1)) return;
  picture.alpha = opacity;
  for (int y = 0; y < opacity.rows; ++y)
    for (int x = 0; x < opacity.cols; ++x)
      if (const float opaque = opacity.at<float>(y, x); opaque > 0 && opaque < 1)
        picture.pixels.at<cv::Vec3f>(y, x) /= opaque;
  picture.notes.push_back({"its colours are multiplied by its alpha", ", which is taken back"});
}

void RequireLight(const Imf::Header& header, const ColorChannels& channels, const std::string& path) {
  const std::string name = channels.layer + (channels.has_colors ? "G" : "Y");
  if (header.channels().findChannel(name)->type == Imf::UINT)
    throw Error("{}: its colours are whole numbers (UINT), which say no light; write them as half or float",
                path);
}

StoredPicture ReadColours(Imf::MultiPartInputFile& file, const std::string& path) {
  StoredPicture picture;
  const ExrPicturePlace place = PlaceOfPicture(file, path, picture);
  const Imf::Header& header = file.header(place.part);
  RequireLight(header, place.channels, path);
  if (Imf::hasEnvmap(header))
    throw Error("{}: is a panorama (its attribute envmap), which no lens made; {}", path,
                PanoramaRemedy(Imf::envmap(header) == Imf::ENVMAP_LATLONG));
  if (Imf::hasMultiView(header) && Imf::multiView(header).size() > 1)
    picture.remarks.push_back(
        fmt::format("it holds {} views ({}), of which the first is taken", Imf::multiView(header).size(),
                    ExifText(fmt::format("{}", fmt::join(Imf::multiView(header), ", ")))));
  WarnOfPixelAspect(1, header.pixelAspectRatio(), picture);
  const Imath::Box2i shown = header.displayWindow(), data = header.dataWindow();
  const cv::Size2d claimed = SizeOf(data), shown_size = SizeOf(shown);
  RequireRoom(path, claimed, 3);
  RequireRoom(path, shown_size, 3);
  const cv::Size size(static_cast<int>(claimed.width), static_cast<int>(claimed.height));
  cv::Mat stored;
  if (!place.channels.has_colors && place.channels.has_chroma) {
    if (place.part > 0)
      throw Error("{}: its picture is luminance and chroma in part {}; write it as R, G and B", path,
                  place.part + 1);
    const std::string& layer = place.channels.layer;
    stored = ReadLuminanceAndChroma(path, size, layer.substr(0, layer.empty() ? 0 : layer.size() - 1));
    picture.notes.push_back(
        {"its colours are luminance and chroma (Y, RY, BY)", " and converted to R, G and B"});
  } else {
    stored = ReadStored(file, place, size);
  }
  picture.pixels = InDisplay(stored, data, shown);
  CheckFloatNumbers(picture);
  if (place.channels.has_alpha) {
    RequireRoom(path, claimed, 1);
    cv::Mat opacity(size, CV_32FC1, cv::Scalar::all(1));
    ReadSlices(file, place.part, {{place.channels.layer + "A", 0}}, opacity);
    TakeOpacity(InDisplay(opacity, data, shown), picture);
  }
  if (Imf::hasChromaticities(header) && (place.channels.has_colors || place.channels.has_chroma)) {
    const Imf::Chromaticities& told = Imf::chromaticities(header);
    ConvertToSrgb({.primaries = Primaries{told.red.x, told.red.y, told.green.x, told.green.y, told.blue.x,
                                          told.blue.y, told.white.x, told.white.y},
                   .exponent = 1.0},
                  picture);
  }
  return picture;
}

// Runs `read` on a file with a sound header; what the library throws becomes an Error.
template <typename Read>
auto WithExr(const std::string& path, const Read& read) {
  try {
    RequireExrHeader(path);
    return read();
  } catch (const Iex::BaseExc& error) {
    RefuseExr(path, error.what());
  }
}

}  // namespace

cv::Mat HalfFromFloat(const cv::Mat& pixels) {
  const cv::Mat clipped = cv::max(cv::min(pixels.reshape(1), kLargestHalf), -kLargestHalf);
  cv::Mat half;
  clipped.convertTo(half, CV_16F);
  return half.reshape(pixels.channels());
}

std::string ExrBytes(const std::vector<ExrChannel>& channels, ExrCompression compression,
                     const ExrColors& colors, const std::map<std::string, std::string>& attributes,
                     const std::map<std::string, float>& numbers) {
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
  for (const auto& [name, number] : numbers) header.insert(name, Imf::FloatAttribute(number));
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

StoredPicture ReadExrPicture(const std::string& path) {
  return WithExr(path, [&] {
    Imf::MultiPartInputFile file(path.c_str());
    return ReadColours(file, path);
  });
}

bool HasExrAlpha(const std::string& path) {
  return WithExr(path, [&] {
    Imf::MultiPartInputFile file(path.c_str());
    StoredPicture unused;
    return PlaceOfPicture(file, path, unused).channels.has_alpha;
  });
}

cv::Mat ReadExr(const std::string& path) { return ReadExrPicture(path).pixels; }

cv::Mat ReadExrChannel(const std::string& path, const std::string& name) {
  return WithExr(path, [&]() -> cv::Mat {
    Imf::MultiPartInputFile file(path.c_str());
    if (!file.header(0).channels().findChannel(name)) return {};
    const cv::Size2d size = SizeOf(file.header(0).dataWindow());
    RequireRoom(path, size, 1);
    cv::Mat stored(static_cast<int>(size.height), static_cast<int>(size.width), CV_32FC1);
    ReadSlices(file, 0, {{name, 0}}, stored);
    return stored;
  });
}

ExrColors ExrColorsOf(const std::string& path) {
  return WithExr(path, [&]() -> ExrColors {
    const Imf::InputFile file(path.c_str());
    if (!Imf::hasChromaticities(file.header())) return std::nullopt;
    const Imf::Chromaticities& told = Imf::chromaticities(file.header());
    return std::array{told.red.x,  told.red.y,  told.green.x, told.green.y,
                      told.blue.x, told.blue.y, told.white.x, told.white.y};
  });
}

std::string ExrAttribute(const std::string& path, const std::string& name) {
  return WithExr(path, [&]() -> std::string {
    const Imf::InputFile file(path.c_str());
    const auto* text = file.header().findTypedAttribute<Imf::StringAttribute>(name);
    return text ? text->value() : "";
  });
}

}  // namespace ulf
