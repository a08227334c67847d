#include "tests/support/pictures/sample_exr.h"

#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfRgbaFile.h>
#include <ImfStandardAttributes.h>
#include <ImfTiledOutputFile.h>
#include <ImfTiledOutputPart.h>

#include <algorithm>
#include <cstdint>
#include <opencv2/core.hpp>

#include "core/image/image.h"
#include "tests/support/pictures/sample_pictures.h"

namespace ulf::test {
namespace {

cv::Vec3f LightRgb(int x, int y) {
  const int column = std::clamp(x / kPatchPx, 0, 2), row = std::clamp(y / kPatchPx, 0, 1);
  const auto& rgb = kPatches[static_cast<std::size_t>(column + 3 * row)];
  return {LinearFromSrgb(rgb[0] / 255.0F), LinearFromSrgb(rgb[1] / 255.0F), LinearFromSrgb(rgb[2] / 255.0F)};
}

// By the definition: each primary scaled so that all together are the white.
cv::Matx33d XyzFromRgb(const std::array<float, 8>& xy) {
  const auto xyz = [&](std::size_t i) {
    return cv::Vec3d(xy[i] / xy[i + 1], 1, (1.0 - xy[i] - xy[i + 1]) / xy[i + 1]);
  };
  cv::Matx33d primaries;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) primaries(r, c) = xyz(2U * static_cast<unsigned>(c))[r];
  const cv::Vec3d scale = primaries.inv() * xyz(6);
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) primaries(r, c) *= scale[c];
  return primaries;
}

void AddPrimaries(const std::array<float, 8>& xy, Imf::Header& header) {
  Imf::addChromaticities(header,
                         Imf::Chromaticities({xy[0], xy[1]}, {xy[2], xy[3]}, {xy[4], xy[5]}, {xy[6], xy[7]}));
}

Imf::Header HeaderOf(const ExrPartLayout& part) {
  const int width = 3 * kPatchPx, height = 2 * kPatchPx, margin = part.margin;
  const Imath::V2i origin(part.origin, part.origin);
  Imf::Header header(Imath::Box2i(origin, origin + Imath::V2i(width - 1, height - 1)),
                     Imath::Box2i(origin - Imath::V2i(margin),
                                  origin + Imath::V2i(width - 1 + margin, height - 1 + margin)));
  header.setName(part.name);
  if (!part.views.empty()) Imf::addMultiView(header, part.views);
  header.pixelAspectRatio() = part.pixel_aspect;
  if (part.panorama >= 0) Imf::addEnvmap(header, static_cast<Imf::Envmap>(part.panorama));
  header.setType(part.tiles ? Imf::TILEDIMAGE : Imf::SCANLINEIMAGE);
  if (part.tiles) header.setTileDescription(Imf::TileDescription(16, 16));
  for (const std::string& name : part.channels)
    header.channels().insert(name, Imf::Channel(part.type == "half"   ? Imf::HALF
                                                : part.type == "uint" ? Imf::UINT
                                                                      : Imf::FLOAT));
  return header;
}

// The numbers of each channel over the data window.
struct Samples {
  explicit Samples(const ExrPartLayout& part) {
    const int width = 3 * kPatchPx + 2 * part.margin, height = 2 * kPatchPx + 2 * part.margin;
    cv::Matx33d to = cv::Matx33d::eye();
    constexpr std::array<float, 8> kBt709{0.64F, 0.33F, 0.30F, 0.60F, 0.15F, 0.06F, 0.3127F, 0.3290F};
    if (part.primaries) to = XyzFromRgb(*part.primaries).inv() * XyzFromRgb(kBt709);
    for (const std::string& name : part.channels) {
      cv::Mat values(height, width, part.type == "half" ? CV_16F : part.type == "uint" ? CV_32S : CV_32F);
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          const cv::Vec3d rgb = to * cv::Vec3d(LightRgb(x - part.margin, y - part.margin));
          const char kind = name.back();
          const bool is_color = kind == 'R' || kind == 'G' || kind == 'B' || kind == 'Y';
          const double value = kind == 'R'                  ? rgb[0]
                               : kind == 'G' || kind == 'Y' ? rgb[1]
                               : kind == 'B'                ? rgb[2]
                               : kind == 'A'                ? 1
                                                            : 0.5;
          const double number = is_color || kind == 'A' ? part.alpha * value : value;
          if (part.type == "half")
            values.at<cv::float16_t>(y, x) = cv::float16_t(static_cast<float>(number));
          else if (part.type == "uint")
            values.at<int>(y, x) = static_cast<int>(1000 * number);
          else
            values.at<float>(y, x) = static_cast<float>(number);
        }
      const Imf::PixelType type = part.type == "half"   ? Imf::HALF
                                  : part.type == "uint" ? Imf::UINT
                                                        : Imf::FLOAT;
      // A number: the place of pixel 0, 0 may lie far outside.
      auto* const base = reinterpret_cast<char*>(
          reinterpret_cast<std::uintptr_t>(values.data) -
          static_cast<std::uintptr_t>((std::int64_t{part.origin} - part.margin) *
                                      static_cast<std::int64_t>(values.elemSize() + values.step)));
      buffer.insert(name, Imf::Slice(type, base, values.elemSize(), values.step));
      channels.push_back(values);
    }
  }
  std::vector<cv::Mat> channels;
  Imf::FrameBuffer buffer;
};

}  // namespace

void WriteExrSample(const std::filesystem::path& path, const std::vector<ExrPartLayout>& parts) {
  std::vector<Imf::Header> headers;
  std::optional<std::array<float, 8>> primaries;  // all parts must claim the same
  for (const ExrPartLayout& part : parts)
    if (part.primaries) primaries = part.primaries;
  for (const ExrPartLayout& part : parts) {
    headers.push_back(HeaderOf(part));
    if (primaries) AddPrimaries(*primaries, headers.back());
  }
  Imf::MultiPartOutputFile file(path.c_str(), headers.data(), static_cast<int>(headers.size()));
  for (int i = 0; i < static_cast<int>(parts.size()); ++i) {
    const ExrPartLayout& layout = parts[static_cast<std::size_t>(i)];
    const Samples samples(layout);
    if (layout.tiles) {
      Imf::TiledOutputPart part(file, i);
      part.setFrameBuffer(samples.buffer);
      part.writeTiles(0, part.numXTiles() - 1, 0, part.numYTiles() - 1);
    } else {
      Imf::OutputPart part(file, i);
      part.setFrameBuffer(samples.buffer);
      part.writePixels(2 * kPatchPx + 2 * layout.margin);
    }
  }
}

void WriteLuminanceChromaExr(const std::filesystem::path& path) {
  const int width = 3 * kPatchPx * kLuminanceChromaScale, height = 2 * kPatchPx * kLuminanceChromaScale;
  std::vector<Imf::Rgba> pixels;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const cv::Vec3f rgb = LightRgb(x / kLuminanceChromaScale, y / kLuminanceChromaScale);
      pixels.emplace_back(rgb[0], rgb[1], rgb[2]);
    }
  Imf::RgbaOutputFile file(path.c_str(), width, height, Imf::WRITE_YC);
  file.setFrameBuffer(pixels.data(), 1, static_cast<std::size_t>(width));
  file.writePixels(height);
}

}  // namespace ulf::test
