#include "core/image/files/picture_codecs.h"

#include <fmt/core.h>
#include <tiffio.h>

#include <algorithm>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/image/files/image_header.h"
#include "core/image/files/picture_colors.h"
#include "core/image/files/picture_projection.h"
#include "core/image/files/stored_picture.h"
#include "core/image/files/tiff_numbers.h"
#include "core/image/image.h"

namespace ulf {
namespace {

int KeepTiffError(TIFF*, void* kept, const char*, const char* format, std::va_list arguments) {
  auto& words = *static_cast<std::string*>(kept);
  std::string text(512, '\0');
  const int size = std::vsnprintf(text.data(), text.size(), format, arguments);
  text.resize(static_cast<std::size_t>(std::clamp(size, 0, static_cast<int>(text.size()) - 1)));
  if (words.empty()) words = text;
  return 1;
}

int IgnoreTiffWarning(TIFF*, void*, const char*, const char*, std::va_list) { return 1; }

// Decodes one page of a file step by step.
class TiffPage {
 public:
  explicit TiffPage(const std::string& path) : path_(path), options_(TIFFOpenOptionsAlloc()) {
    TIFFOpenOptionsSetErrorHandlerExtR(options_.get(), KeepTiffError, &words_);
    TIFFOpenOptionsSetWarningHandlerExtR(options_.get(), IgnoreTiffWarning, nullptr);
    file_.reset(TIFFOpenExt(path.c_str(), "rm", options_.get()));
    if (!file_) Refuse();
    ChoosePage();
    ReadTags();
  }
  StoredPicture Read();

 private:
  struct CloseTiff {
    void operator()(TIFF* file) const { TIFFClose(file); }
  };
  struct FreeOptions {
    void operator()(TIFFOpenOptions* options) const { TIFFOpenOptionsFree(options); }
  };

  [[noreturn]] void Refuse() const {
    throw Error(
        "{}: the image is truncated or damaged ({}); copy it again from its source (of a light field: ulf "
        "repair DIR)",
        path_, words_.empty() ? "no TIFF" : words_);
  }
  [[noreturn]] void RefuseKind(const std::string& what, const std::string& remedy) const {
    throw Error("{}: is a TIFF {}, which is not read; {}", path_, what, remedy);
  }
  std::uint16_t Short(std::uint32_t tag, std::uint16_t otherwise) {
    std::uint16_t value = otherwise;
    return TIFFGetFieldDefaulted(file_.get(), tag, &value) == 1 ? value : otherwise;
  }

  std::string_view Bytes(std::uint32_t tag) {
    std::uint32_t size = 0;
    void* bytes = nullptr;
    if (TIFFGetField(file_.get(), tag, &size, &bytes) != 1) return {};
    return {static_cast<const char*>(bytes), size};
  }

  void ChoosePage();
  void ChooseInside();
  void ReadTags();
  int StoredDepth() const;
  cv::Mat Samples();
  void CopyBlock(const std::vector<std::uint8_t>& block, std::size_t row_bytes, const cv::Rect& place,
                 int first_channel, int block_channels, cv::Mat& samples) const;
  cv::Mat DecodedByLibrary();
  void Colors(const cv::Mat& samples, StoredPicture& picture);
  void Alpha(const cv::Mat& samples, int colors, StoredPicture& picture);
  cv::Mat FromPalette(const cv::Mat& indices);
  ColorTags Claim();
  void TakeTransferFunction(StoredPicture& picture);
  std::optional<std::array<double, 2>> White();

  const std::string path_;
  std::string words_;
  std::unique_ptr<TIFFOpenOptions, FreeOptions> options_;
  std::unique_ptr<TIFF, CloseTiff> file_;
  int width_ = 0, height_ = 0, channels_ = 1, bits_ = 1, format_ = SAMPLEFORMAT_UINT,
      light_ = PHOTOMETRIC_MINISBLACK;
  bool has_planes_ = false;
  std::vector<int> extras_;  // EXTRASAMPLE_* of the channels after the colours
  std::vector<std::string> warnings_;
};

void TiffPage::ChoosePage() {
  int pages = 0, chosen = -1, others = 0;
  constexpr int kMostPages = 64;
  do {
    std::uint32_t kind = 0;
    TIFFGetField(file_.get(), TIFFTAG_SUBFILETYPE, &kind);
    const bool is_picture = (kind & (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK)) == 0;
    if (is_picture && chosen < 0)
      chosen = pages;
    else if (is_picture)
      ++others;
    ++pages;
  } while (pages < kMostPages && TIFFReadDirectory(file_.get()) == 1);
  words_.clear();  // belongs to a directory after the last
  if (TIFFSetDirectory(file_.get(), static_cast<tdir_t>(std::max(chosen, 0))) != 1) Refuse();
  if (chosen < 0) ChooseInside();
  if (others > 0)
    warnings_.push_back(fmt::format(
        "it holds {} pages: the first is taken, export the others as files of their own", others + 1));
}

// Some files have a thumbnail first, and the picture in a directory inside.
void TiffPage::ChooseInside() {
  std::uint16_t count = 0;
  std::uint64_t* places = nullptr;
  if (TIFFGetField(file_.get(), TIFFTAG_SUBIFD, &count, &places) != 1) return;
  const std::vector<std::uint64_t> inside(places, places + count);
  for (const std::uint64_t place : inside) {
    std::uint32_t kind = 0;
    if (TIFFSetSubDirectory(file_.get(), place) != 1) continue;
    TIFFGetField(file_.get(), TIFFTAG_SUBFILETYPE, &kind);
    if ((kind & (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK)) == 0) return;
  }
  words_.clear();
  if (TIFFSetDirectory(file_.get(), 0) != 1) Refuse();
  warnings_.emplace_back("it holds a thumbnail alone");
}

void TiffPage::ReadTags() {
  std::uint32_t width = 0, height = 0;
  TIFFGetField(file_.get(), TIFFTAG_IMAGEWIDTH, &width);
  TIFFGetField(file_.get(), TIFFTAG_IMAGELENGTH, &height);
  constexpr std::uint32_t kMostPx = 1 << 20;
  if (width == 0 || height == 0 || width > kMostPx || height > kMostPx)
    throw Error(
        "{}: says that it is {}x{}, which is no picture's size; it is damaged: copy it again from its source",
        path_, width, height);
  width_ = static_cast<int>(width);
  height_ = static_cast<int>(height);
  if (std::uint16_t light = 0; TIFFGetField(file_.get(), TIFFTAG_PHOTOMETRIC, &light) == 1 &&
                               (light == PHOTOMETRIC_LOGL || light == PHOTOMETRIC_LOGLUV))
    TIFFSetField(file_.get(), TIFFTAG_SGILOGDATAFMT, SGILOGDATAFMT_FLOAT);  // sets the following tags
  channels_ = Short(TIFFTAG_SAMPLESPERPIXEL, 1);
  bits_ = Short(TIFFTAG_BITSPERSAMPLE, 1);
  format_ = Short(TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT);
  has_planes_ = channels_ > 1 && Short(TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG) == PLANARCONFIG_SEPARATE;
  std::uint16_t light = 0;
  if (TIFFGetField(file_.get(), TIFFTAG_PHOTOMETRIC, &light) == 1)
    light_ = light;
  else
    light_ = channels_ >= 3 ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK;
  std::uint16_t extras = 0;
  std::uint16_t* kinds = nullptr;
  if (TIFFGetField(file_.get(), TIFFTAG_EXTRASAMPLES, &extras, &kinds) == 1)
    extras_.assign(kinds, kinds + extras);
  constexpr int kMostChannels = 32;
  if (channels_ < 1 || channels_ > kMostChannels)
    RefuseKind(fmt::format("of {} channels", channels_), "export its colours as RGB");
  constexpr double kDecoded = 4;
  RequirePixelsOfFile(path_, std::filesystem::file_size(path_), 1.0 * width_ * height_,
                      channels_ * std::max(kDecoded, bits_ / 8.0));
}

int TiffPage::StoredDepth() const {
  const char* const as_whole = "write it as unsigned whole numbers of 8 or 16 bits, or as floating point";
  switch (format_) {
    case SAMPLEFORMAT_IEEEFP:
      if (bits_ == 16 || bits_ == 24 || bits_ == 32 || bits_ == 64) return CV_32F;
      RefuseKind(fmt::format("of floating point of {} bits", bits_), as_whole);
    case SAMPLEFORMAT_UINT:
    case SAMPLEFORMAT_VOID:
      if (bits_ <= 8) return CV_8U;
      if (bits_ <= 16 || bits_ == 32) return CV_16U;
      RefuseKind(fmt::format("of whole numbers of {} bits", bits_), as_whole);
    case SAMPLEFORMAT_INT:
      if (light_ == PHOTOMETRIC_CIELAB && bits_ <= 16) return bits_ <= 8 ? CV_8U : CV_16U;
      RefuseKind("of signed numbers, as measurements and heights are stored", as_whole);
    default:
      RefuseKind("of complex numbers", as_whole);
  }
}

void TiffPage::CopyBlock(const std::vector<std::uint8_t>& block, std::size_t row_bytes, const cv::Rect& place,
                         int first_channel, int block_channels, cv::Mat& samples) const {
  const TiffNumbers numbers{bits_, format_ == SAMPLEFORMAT_IEEEFP, light_ == PHOTOMETRIC_PALETTE};
  for (int y = 0; y < place.height; ++y)
    CopyTiffRow(numbers, block.data() + static_cast<std::size_t>(y) * row_bytes, place.width, block_channels,
                place.x, place.y + y, first_channel, samples);
}

cv::Mat TiffPage::Samples() {
  cv::Mat samples(height_, width_, CV_MAKETYPE(StoredDepth(), channels_));
  TIFF* file = file_.get();
  const bool has_tiles = TIFFIsTiled(file) != 0;
  std::uint32_t block_width = static_cast<std::uint32_t>(width_), block_height = 0;
  TIFFGetFieldDefaulted(file, has_tiles ? TIFFTAG_TILELENGTH : TIFFTAG_ROWSPERSTRIP, &block_height);
  if (has_tiles) TIFFGetField(file, TIFFTAG_TILEWIDTH, &block_width);
  if (!has_tiles) block_height = std::min(block_height, static_cast<std::uint32_t>(height_));
  constexpr std::uint32_t kMostTilePx = 1 << 16;
  if (block_width == 0 || block_height == 0 ||
      (has_tiles && std::max(block_width, block_height) > kMostTilePx))
    Refuse();
  const auto size = static_cast<std::uint64_t>(has_tiles ? TIFFTileSize64(file) : TIFFStripSize64(file));
  const auto row_bytes =
      static_cast<std::size_t>(has_tiles ? TIFFTileRowSize64(file) : TIFFScanlineSize64(file));
  const int block_channels = has_planes_ ? 1 : channels_;
  const std::size_t needed =
      (static_cast<std::size_t>(block_width) * static_cast<std::size_t>(block_channels * bits_) + 7) / 8;
  if (row_bytes < needed || size < row_bytes * block_height) Refuse();
  RequirePixelsOfFile(path_, std::filesystem::file_size(path_), static_cast<double>(size), 1);
  std::vector<std::uint8_t> block(size);
  const int wide = static_cast<int>(block_width), high = static_cast<int>(block_height);
  for (int plane = 0; plane < (has_planes_ ? channels_ : 1); ++plane)
    for (int y = 0; y < height_; y += high)
      for (int x = 0; x < width_; x += wide) {
        const auto sample = static_cast<std::uint16_t>(plane);
        const auto ux = static_cast<std::uint32_t>(x), uy = static_cast<std::uint32_t>(y);
        const cv::Rect place(x, y, std::min(wide, width_ - x), std::min(high, height_ - y));
        const tmsize_t read =
            has_tiles ? TIFFReadEncodedTile(file, TIFFComputeTile(file, ux, uy, 0, sample), block.data(),
                                            static_cast<tmsize_t>(size))
                      : TIFFReadEncodedStrip(file, TIFFComputeStrip(file, uy, sample), block.data(),
                                             static_cast<tmsize_t>(row_bytes) * place.height);
        if (read < static_cast<tmsize_t>(row_bytes) * place.height) Refuse();
        CopyBlock(block, row_bytes, place, plane, block_channels, samples);
      }
  return samples;
}

// Decodes layouts that only the library supports (subsampled YCbCr without JPEG) to 8 bits, B G R.
cv::Mat TiffPage::DecodedByLibrary() {
  std::vector<std::uint32_t> pixels(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  const auto own_order = static_cast<int>(Short(TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT));
  if (TIFFReadRGBAImageOriented(file_.get(), static_cast<std::uint32_t>(width_),
                                static_cast<std::uint32_t>(height_), pixels.data(), own_order, 1) != 1)
    Refuse();
  const cv::Mat rgba(height_, width_, CV_8UC4, pixels.data());
  cv::Mat bgr;
  cv::cvtColor(rgba, bgr, cv::COLOR_RGBA2BGR);
  return bgr;
}

cv::Mat TiffPage::FromPalette(const cv::Mat& indices) {
  std::uint16_t *red = nullptr, *green = nullptr, *blue = nullptr;
  if (bits_ > 8 || TIFFGetField(file_.get(), TIFFTAG_COLORMAP, &red, &green, &blue) != 1)
    RefuseKind("with a palette of another kind than 8 bits", "write it as RGB");
  return ThroughPalette(indices, {red, green, blue}, 1 << bits_);
}

std::optional<std::array<double, 2>> TiffPage::White() {
  float* white = nullptr;
  if (TIFFGetField(file_.get(), TIFFTAG_WHITEPOINT, &white) != 1 || !(white[1] > 0)) return std::nullopt;
  return std::array<double, 2>{white[0], white[1]};
}

ColorTags TiffPage::Claim() {
  ColorTags claim{.icc = std::string(Bytes(TIFFTAG_ICCPROFILE))};
  if (!claim.icc.empty()) return claim;
  float* colors = nullptr;
  if (const auto white = White();
      white && TIFFGetField(file_.get(), TIFFTAG_PRIMARYCHROMATICITIES, &colors) == 1)
    claim.primaries =
        Primaries{colors[0], colors[1], colors[2], colors[3], colors[4], colors[5], (*white)[0], (*white)[1]};
  return claim;
}

void TiffPage::Alpha(const cv::Mat& samples, int colors, StoredPicture& picture) {
  if (channels_ == colors) return;
  const int kind = extras_.empty() ? EXTRASAMPLE_UNSPECIFIED : extras_.front();
  if (kind == EXTRASAMPLE_UNSPECIFIED || channels_ > colors + 1)
    picture.warnings.push_back(fmt::format(
        "it has {} channels: the first {} taken, and {}", channels_, colors == 1 ? "is" : "three are",
        kind == EXTRASAMPLE_UNSPECIFIED ? "the others are not said to be alpha" : "the next as alpha"));
  if (kind == EXTRASAMPLE_UNSPECIFIED) return;
  cv::extractChannel(samples, picture.alpha, colors);
  if (kind != EXTRASAMPLE_ASSOCALPHA) return;
  picture.notes.push_back({"its colours are multiplied by its alpha", ", which is taken back"});
  DivideByAlpha(picture.alpha, picture.pixels);
}

void TiffPage::Colors(const cv::Mat& samples, StoredPicture& picture) {
  const char* const as_rgb = "write it as RGB or grey";
  const auto require = [&](int channels) {
    if (channels_ < channels)
      RefuseKind(fmt::format("of {} channels where its colours need {}", channels_, channels), as_rgb);
  };
  switch (light_) {
    case PHOTOMETRIC_MINISWHITE:
    case PHOTOMETRIC_MINISBLACK:
      if (channels_ - static_cast<int>(extras_.size()) > 2)
        RefuseKind(fmt::format("of {} grey channels", channels_),
                   "write each as a file, or its colours as RGB");
      cv::extractChannel(samples, picture.pixels, 0);
      if (light_ == PHOTOMETRIC_MINISWHITE)
        picture.pixels = cv::Scalar::all(FullScale(samples.depth())) - picture.pixels;
      Alpha(samples, 1, picture);
      break;
    case PHOTOMETRIC_RGB:
    case PHOTOMETRIC_YCBCR:  // the JPEG decoder returns RGB
      require(3);
      cv::cvtColor(FirstChannels(samples, 3), picture.pixels, cv::COLOR_RGB2BGR);
      Alpha(samples, 3, picture);
      break;
    case PHOTOMETRIC_PALETTE:
      cv::extractChannel(samples, picture.pixels, 0);
      picture.pixels = FromPalette(picture.pixels);
      break;
    case PHOTOMETRIC_SEPARATED:
      require(4);
      if (samples.depth() == CV_32F) RefuseKind("of inks in floating point", as_rgb);
      picture.pixels = SrgbOfInks(FirstChannels(samples, 4), false, Claim().icc, picture);
      return;
    case PHOTOMETRIC_CIELAB:
    case PHOTOMETRIC_ICCLAB:
      require(3);
      if (samples.depth() == CV_32F) RefuseKind("of CIE L*a*b* in floating point", as_rgb);
      picture.pixels = SrgbOfLab(FirstChannels(samples, 3), light_ == PHOTOMETRIC_CIELAB, White());
      picture.notes.push_back({"its colours are CIE L*a*b*", " and converted to sRGB"});
      return;
    case PHOTOMETRIC_CFA:
      RefuseKind("of a sensor's mosaic", "name it .dng, if it is one, or develop it with a raw converter");
    case PHOTOMETRIC_LOGL:
      cv::extractChannel(samples, picture.pixels, 0);
      return;
    case PHOTOMETRIC_LOGLUV:
      require(3);
      // These are X, Y, Z of the light itself, as programs write it that assume sRGB's white (OpenCV among
      // them).
      cv::cvtColor(FirstChannels(samples, 3), picture.pixels, cv::COLOR_XYZ2BGR);
      return;
    default:
      RefuseKind(fmt::format("of another kind of colours (photometric interpretation {})", light_), as_rgb);
  }
  CheckFloatNumbers(picture);
  const ColorTags claim = Claim();
  if (claim.icc.empty() && light_ != PHOTOMETRIC_PALETTE) TakeTransferFunction(picture);
  ConvertToSrgb(claim, picture);
}

void TiffPage::TakeTransferFunction(StoredPicture& picture) {
  std::uint16_t* curves[3] = {};
  if (picture.pixels.depth() == CV_32F || (bits_ != 8 && bits_ != 16) ||
      TIFFGetField(file_.get(), TIFFTAG_TRANSFERFUNCTION, &curves[0], &curves[1], &curves[2]) != 1 ||
      !ApplyTransferFunction({curves[0], curves[1], curves[2]}, picture.pixels))
    return;
  picture.notes.push_back(
      {"its numbers have a transfer function of their own", " and are converted to sRGB"});
}

StoredPicture TiffPage::Read() {
  RequireOneLens(Bytes(TIFFTAG_XMLPACKET), path_);
  StoredPicture picture;
  NoteOrientation(Short(TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT), picture);
  float across = 0, down = 0;
  if (TIFFGetField(file_.get(), TIFFTAG_XRESOLUTION, &across) == 1 &&
      TIFFGetField(file_.get(), TIFFTAG_YRESOLUTION, &down) == 1)
    WarnOfPixelAspect(across, down, picture);
  if (light_ == PHOTOMETRIC_YCBCR) {
    if (Short(TIFFTAG_COMPRESSION, COMPRESSION_NONE) == COMPRESSION_JPEG) {
      TIFFSetField(file_.get(), TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
    } else {
      picture.pixels = DecodedByLibrary();
      ConvertToSrgb(Claim(), picture);
    }
  }
  if (picture.pixels.empty()) {
    const cv::Mat samples = Samples();
    Colors(samples, picture);
    if (std::uint16_t most = 0;
        format_ == SAMPLEFORMAT_UINT && TIFFGetField(file_.get(), TIFFTAG_MAXSAMPLEVALUE, &most) == 1)
      WarnOfUnusedBits(most, bits_, samples, picture);
  }
  picture.warnings.insert(picture.warnings.begin(), warnings_.begin(), warnings_.end());
  return picture;
}

}  // namespace

StoredPicture ReadTiff(const std::string& path) { return TiffPage(path).Read(); }

}  // namespace ulf
