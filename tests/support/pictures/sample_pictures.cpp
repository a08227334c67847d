#include "tests/support/pictures/sample_pictures.h"

#include <lcms2.h>
#include <png.h>
#include <tiffio.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace ulf::test {
namespace {

double LightOf(double srgb) { return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4); }
double SrgbOf(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

// The bits of a sample: `value` from 0 to 1.
class SampleBits {
 public:
  explicit SampleBits(int bits, int format) : bits_(bits), format_(format) {}
  void Put(double value) {
    if (format_ == 3) return PutFloat(value);
    const auto most = static_cast<double>((std::uint64_t{1} << bits_) - 1);
    const auto number = static_cast<std::uint64_t>(std::llround(value * most));
    if (bits_ >= 8 && bits_ % 8 == 0) return PutBytes(&number, bits_ / 8);
    for (int b = bits_ - 1; b >= 0; --b) PutBit(number >> b & 1);
  }
  void EndRow() { used_ = 0; }
  std::vector<std::uint8_t>& bytes() { return bytes_; }

 private:
  void PutBytes(const void* from, int count) {
    const auto* begin = static_cast<const std::uint8_t*>(from);
    bytes_.insert(bytes_.end(), begin, begin + count);
  }
  void PutBit(std::uint64_t bit) {
    if (used_ == 0) bytes_.push_back(0);
    bytes_.back() = static_cast<std::uint8_t>(bytes_.back() | bit << (7 - used_));
    used_ = (used_ + 1) % 8;
  }
  void PutFloat(double value) {
    if (bits_ == 64) return PutBytes(&value, 8);
    const auto single = static_cast<float>(value);
    if (bits_ == 32) return PutBytes(&single, 4);
    if (bits_ == 16) {
      const cv::float16_t half(single);
      return PutBytes(&half, 2);
    }
    // 24 bits: a sign, 7 of the exponent with a bias of 63, 16 of the fraction.
    int exponent = 0;
    const double fraction = std::frexp(value, &exponent);  // 0.5 to 1
    const std::uint32_t number =
        value == 0 ? 0
                   : static_cast<std::uint32_t>(exponent - 1 + 63) << 16 |
                         static_cast<std::uint32_t>(std::lround((2 * fraction - 1) * 65536.0)) % 65536;
    PutBytes(&number, 3);
  }
  int bits_, format_, used_ = 0;
  std::vector<std::uint8_t> bytes_;
};

// Numbers of one pixel, 0 to 1, as the layout stores them.
std::vector<double> StoredPixel(const TiffLayout& layout, int patch) {
  const auto& rgb = kPatches[static_cast<std::size_t>(patch)];
  std::vector<double> values;
  if (layout.photometric <= 1) {
    values = {rgb[1] / 255.0};
    if (layout.bits == 1) values = {rgb[1] >= 128 ? 1.0 : 0.0};
  } else if (layout.photometric == 3) {
    values = {patch / static_cast<double>((1 << layout.bits) - 1)};
  } else if (layout.photometric == 5) {
    values = {1 - rgb[0] / 255.0, 1 - rgb[1] / 255.0, 1 - rgb[2] / 255.0, 0.0};
  } else {
    values = {rgb[0] / 255.0, rgb[1] / 255.0, rgb[2] / 255.0};
  }
  if (layout.format == 3)
    for (double& value : values) value = LightOf(value);
  if (layout.alpha == 1)
    for (double& value : values) value *= 128 / 255.0;
  if (layout.photometric == 0)
    for (double& value : values) value = 1 - value;
  if (layout.photometric == 8) {
    cv::Mat lab, pixel(1, 1, CV_8UC3, cv::Scalar(rgb[2], rgb[1], rgb[0]));
    const cmsHPROFILE srgb = cmsCreate_sRGBProfile(), to = cmsCreateLab4Profile(nullptr);
    const cmsHTRANSFORM transform =
        cmsCreateTransform(srgb, TYPE_BGR_8, to, TYPE_Lab_DBL, INTENT_RELATIVE_COLORIMETRIC, 0);
    double values_lab[3];
    cmsDoTransform(transform, pixel.data, values_lab, 1);
    cmsDeleteTransform(transform);
    cmsCloseProfile(srgb);
    cmsCloseProfile(to);
    const double most = std::pow(2, layout.bits) - 1, unit = layout.bits == 16 ? 256 : 1;
    values = {values_lab[0] / 100};
    for (int c = 1; c < 3; ++c) {
      const double number = std::round(values_lab[c] * unit);
      values.push_back((number < 0 ? number + most + 1 : number) / most);
    }
  }
  if (layout.alpha >= 0) values.push_back(128 / 255.0);
  return values;
}

int PatchAt(int x, int y) { return x / kPatchPx + 3 * (y / kPatchPx); }

void WritePage(TIFF* file, const TiffLayout& layout, int width, int height, bool is_thumbnail) {
  const int channels = static_cast<int>(StoredPixel(layout, 0).size());
  if (is_thumbnail) TIFFSetField(file, TIFFTAG_SUBFILETYPE, FILETYPE_REDUCEDIMAGE);
  TIFFSetField(file, TIFFTAG_IMAGEWIDTH, width);
  TIFFSetField(file, TIFFTAG_IMAGELENGTH, height);
  TIFFSetField(file, TIFFTAG_BITSPERSAMPLE, layout.bits);
  TIFFSetField(file, TIFFTAG_SAMPLESPERPIXEL, channels);
  TIFFSetField(file, TIFFTAG_SAMPLEFORMAT, layout.format);
  TIFFSetField(file, TIFFTAG_PHOTOMETRIC, layout.photometric);
  TIFFSetField(file, TIFFTAG_COMPRESSION, layout.compression);
  TIFFSetField(file, TIFFTAG_PLANARCONFIG, layout.planes ? PLANARCONFIG_SEPARATE : PLANARCONFIG_CONTIG);
  TIFFSetField(file, TIFFTAG_ORIENTATION, layout.orientation);
  if (layout.predictor > 1) TIFFSetField(file, TIFFTAG_PREDICTOR, layout.predictor);
  if (layout.photometric == 5) TIFFSetField(file, TIFFTAG_INKSET, INKSET_CMYK);
  if (layout.alpha >= 0) {
    const auto kind = static_cast<std::uint16_t>(layout.alpha);
    TIFFSetField(file, TIFFTAG_EXTRASAMPLES, 1, &kind);
  }
  if (!layout.icc.empty())
    TIFFSetField(file, TIFFTAG_ICCPROFILE, static_cast<std::uint32_t>(layout.icc.size()), layout.icc.data());
  if (layout.across > 0) {
    TIFFSetField(file, TIFFTAG_XRESOLUTION, layout.across);
    TIFFSetField(file, TIFFTAG_YRESOLUTION, layout.down);
  }
  if (!layout.xmp.empty())
    TIFFSetField(file, TIFFTAG_XMLPACKET, static_cast<std::uint32_t>(layout.xmp.size()), layout.xmp.data());
  if (layout.photometric == 3) {
    std::vector<std::uint16_t> map[3];
    for (int c = 0; c < 3; ++c) {
      map[c].resize(std::size_t{1} << layout.bits);
      for (std::size_t i = 0; i < kPatches.size(); ++i)
        map[c][i] = static_cast<std::uint16_t>(257 * kPatches[i][static_cast<std::size_t>(c)]);
    }
    TIFFSetField(file, TIFFTAG_COLORMAP, map[0].data(), map[1].data(), map[2].data());
  }
  constexpr int kTile = 32, kRows = 16;
  const int block_width = layout.tiles ? kTile : width, block_height = layout.tiles ? kTile : kRows;
  if (layout.tiles) {
    TIFFSetField(file, TIFFTAG_TILEWIDTH, kTile);
    TIFFSetField(file, TIFFTAG_TILELENGTH, kTile);
  } else {
    TIFFSetField(file, TIFFTAG_ROWSPERSTRIP, kRows);
  }
  for (int plane = 0; plane < (layout.planes ? channels : 1); ++plane)
    for (int y0 = 0; y0 < height; y0 += block_height)
      for (int x0 = 0; x0 < width; x0 += block_width) {
        SampleBits samples(layout.bits, layout.format);
        const int rows = layout.tiles ? kTile : std::min(kRows, height - y0);
        for (int y = y0; y < y0 + rows; ++y) {
          for (int x = x0; x < x0 + block_width; ++x) {
            const int scale = 3 * kPatchPx / width;  // of a thumbnail
            const auto pixel =
                StoredPixel(layout, PatchAt(scale * std::min(x, width - 1), scale * std::min(y, height - 1)));
            if (layout.planes)
              samples.Put(pixel[static_cast<std::size_t>(plane)]);
            else
              for (const double value : pixel) samples.Put(value);
          }
          samples.EndRow();
        }
        auto& bytes = samples.bytes();
        const auto size = static_cast<tmsize_t>(bytes.size());
        const auto sample = static_cast<std::uint16_t>(plane);
        const auto x = static_cast<std::uint32_t>(x0), y = static_cast<std::uint32_t>(y0);
        const tmsize_t written =
            layout.tiles
                ? TIFFWriteEncodedTile(file, TIFFComputeTile(file, x, y, 0, sample), bytes.data(), size)
                : TIFFWriteEncodedStrip(file, TIFFComputeStrip(file, y, sample), bytes.data(), size);
        if (written < 0) throw std::runtime_error("a sample TIFF cannot be written");
      }
  TIFFWriteDirectory(file);
}

cmsHPROFILE ProfileOf(const std::string& kind) {
  const cmsCIExyY d65{0.3127, 0.3290, 1};
  const cmsCIExyYTRIPLE p3{{0.680, 0.320, 1}, {0.265, 0.690, 1}, {0.150, 0.060, 1}},
      rec709{{0.64, 0.33, 1}, {0.30, 0.60, 1}, {0.15, 0.06, 1}};
  const double srgb_curve[5] = {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};
  cmsToneCurve* const curve = kind == "linear" ? cmsBuildGamma(nullptr, 1.0)
                              : kind == "grey" ? cmsBuildGamma(nullptr, 1.8)
                                               : cmsBuildParametricToneCurve(nullptr, 4, srgb_curve);
  cmsToneCurve* curves[3] = {curve, curve, curve};
  cmsHPROFILE profile = nullptr;
  if (kind == "sRGB")
    profile = cmsCreate_sRGBProfile();
  else if (kind == "grey")
    profile = cmsCreateGrayProfile(&d65, curve);
  else if (kind == "Lab")
    profile = cmsCreateLab4Profile(nullptr);
  else if (kind == "CMYK")
    profile = cmsCreateInkLimitingDeviceLink(cmsSigCmykData, 300);
  else
    profile = cmsCreateRGBProfile(&d65, kind == "P3" ? &p3 : &rec709, curves);
  cmsFreeToneCurve(curve);
  return profile;
}

void PutBigEndian(std::string& bytes, std::uint32_t number, int count) {
  for (int i = count - 1; i >= 0; --i) bytes += static_cast<char>(number >> (8 * i));
}

}  // namespace

cv::Mat PatchPicture() {
  cv::Mat picture(2 * kPatchPx, 3 * kPatchPx, CV_8UC3);
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x) {
      const auto& rgb = kPatches[static_cast<std::size_t>(PatchAt(x, y))];
      picture.at<cv::Vec3b>(y, x) =
          cv::Vec3b(static_cast<std::uint8_t>(rgb[2]), static_cast<std::uint8_t>(rgb[1]),
                    static_cast<std::uint8_t>(rgb[0]));
    }
  return picture;
}

cv::Mat PatchGrey() {
  cv::Mat grey;
  cv::extractChannel(PatchPicture(), grey, 1);
  return grey;
}

double LargestPatchError(const cv::Mat& read) {
  if (read.cols != 3 * kPatchPx || read.rows != 2 * kPatchPx) return 1e9;
  cv::Mat levels;
  read.convertTo(levels, CV_64F, read.depth() == CV_16U ? 255 / 65535.0 : 1);
  if (read.depth() == CV_32F)
    for (int y = 0; y < levels.rows; ++y)
      for (int i = 0; i < levels.cols * levels.channels(); ++i) {
        double& value = levels.ptr<double>(y)[i];
        value = 255 * SrgbOf(value);
      }
  double worst = 0;
  for (int patch = 0; patch < 6; ++patch) {
    const int x = patch % 3 * kPatchPx + kPatchPx / 2, y = patch / 3 * kPatchPx + kPatchPx / 2;
    for (int c = 0; c < levels.channels(); ++c) {
      const double truth = kPatches[static_cast<std::size_t>(patch)]
                                   [levels.channels() == 1 ? 1 : 2U - static_cast<unsigned>(c)];
      worst = std::max(worst, std::abs(levels.ptr<double>(y)[x * levels.channels() + c] - truth));
    }
  }
  return worst;
}

void WriteTiffSample(const std::filesystem::path& path, const TiffLayout& layout) {
  TIFF* const file = TIFFOpen(path.c_str(), layout.mode);
  if (!file) throw std::runtime_error("a sample TIFF cannot be opened");
  if (layout.is_inside_thumbnail) {
    std::uint64_t places[1] = {};
    TIFFSetField(file, TIFFTAG_SUBIFD, 1, places);  // the next directory is written into it
    WritePage(file, layout, 3 * kPatchPx / 2, kPatchPx, true);
  }
  for (int i = 0; i < layout.thumbnail_first; ++i) WritePage(file, layout, 3 * kPatchPx / 2, kPatchPx, true);
  for (int i = 0; i <= layout.further_pages; ++i) WritePage(file, layout, 3 * kPatchPx, 2 * kPatchPx, false);
  TIFFClose(file);
}

void WritePngSample(const std::filesystem::path& path, const PngLayout& layout) {
  std::FILE* const file = std::fopen(path.c_str(), "wb");
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  const cv::Mat bgr = PatchPicture();
  png_set_IHDR(png, info, static_cast<png_uint_32>(bgr.cols), static_cast<png_uint_32>(bgr.rows), layout.bits,
               layout.palette ? PNG_COLOR_TYPE_PALETTE
               : layout.grey  ? PNG_COLOR_TYPE_GRAY
                              : PNG_COLOR_TYPE_RGB,
               layout.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  if (layout.palette) {
    std::vector<png_color> palette;
    for (const auto& rgb : kPatches)
      palette.push_back(
          {static_cast<png_byte>(rgb[0]), static_cast<png_byte>(rgb[1]), static_cast<png_byte>(rgb[2])});
    png_set_PLTE(png, info, palette.data(), static_cast<int>(palette.size()));
  }
  if (layout.gamma > 0) png_set_gAMA(png, info, layout.gamma);
  if (const auto& xy = layout.primaries; xy.size() == 8)
    png_set_cHRM(png, info, xy[0], xy[1], xy[2], xy[3], xy[4], xy[5], xy[6], xy[7]);
  if (!layout.icc.empty())
    png_set_iCCP(png, info, "profile", PNG_COMPRESSION_TYPE_BASE,
                 reinterpret_cast<png_const_bytep>(layout.icc.data()),
                 static_cast<png_uint_32>(layout.icc.size()));
  if (!layout.code.empty()) {
    png_unknown_chunk chunk{};
    std::memcpy(chunk.name, "cICP", 5);
    std::string code = layout.code;
    chunk.data = reinterpret_cast<png_byte*>(code.data());
    chunk.size = code.size();
    chunk.location = PNG_HAVE_IHDR;
    png_set_unknown_chunks(png, info, &chunk, 1);
  }
  png_write_info(png, info);
  const int passes = png_set_interlace_handling(png);
  for (int pass = 0; pass < passes; ++pass)
    for (int y = 0; y < bgr.rows; ++y) {
      SampleBits samples(layout.bits, 1);
      for (int x = 0; x < bgr.cols; ++x) {
        const auto& rgb = kPatches[static_cast<std::size_t>(PatchAt(x, y))];
        const auto value = [&](int c) {
          const double srgb = rgb[static_cast<std::size_t>(c)] / 255.0;
          return layout.gamma > 0 ? std::pow(LightOf(srgb), layout.gamma) : srgb;
        };
        if (layout.palette)
          samples.Put(PatchAt(x, y) / static_cast<double>((1 << layout.bits) - 1));
        else if (layout.grey)
          samples.Put(value(1));
        else
          for (int c = 0; c < 3; ++c) samples.Put(value(c));
      }
      auto& bytes = samples.bytes();
      if (layout.bits == 16)
        for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) std::swap(bytes[i], bytes[i + 1]);
      png_write_row(png, bytes.data());
    }
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  std::fclose(file);
}

std::string IccProfile(const std::string& kind) {
  const cmsHPROFILE profile = ProfileOf(kind);
  cmsUInt32Number size = 0;
  cmsSaveProfileToMem(profile, nullptr, &size);
  std::string bytes(size, '\0');
  cmsSaveProfileToMem(profile, bytes.data(), &size);
  cmsCloseProfile(profile);
  return bytes;
}

cv::Mat EncodedIn(const std::string& kind, const cv::Mat& srgb8) {
  // By the primaries' own matrices (Display P3 from BT.709, both D65), not by the library that reads.
  const cv::Matx33d p3_from_srgb(0.8224620, 0.1775380, 0, 0.0331942, 0.9668058, 0, 0.0170826, 0.0723974,
                                 0.9105199);
  cv::Mat encoded(srgb8.size(), CV_8UC3);
  for (int y = 0; y < srgb8.rows; ++y)
    for (int x = 0; x < srgb8.cols; ++x) {
      const auto& bgr = srgb8.at<cv::Vec3b>(y, x);
      cv::Vec3d light(LightOf(bgr[2] / 255.0), LightOf(bgr[1] / 255.0), LightOf(bgr[0] / 255.0));
      if (kind == "P3") light = p3_from_srgb * light;
      for (int c = 0; c < 3; ++c)
        encoded.at<cv::Vec3b>(y, x)[2 - c] =
            cv::saturate_cast<std::uint8_t>(255 * (kind == "linear" ? light[c] : SrgbOf(light[c])));
    }
  return encoded;
}

std::string ExifSegment(const std::string& taken, int orientation, const std::string& thumbnail_jpeg,
                        bool is_adobe_rgb) {
  // TIFF, big-endian: IFD 0 with the orientation and the place of the Exif IFD, that with the time and the
  // place of the interoperability IFD, IFD 1 with the thumbnail.
  std::string tiff("MM\0*\0\0\0\x08", 8);
  const auto entry = [&](std::uint32_t tag, std::uint32_t type, std::uint32_t count, std::uint32_t value,
                         bool is_short = false) {
    PutBigEndian(tiff, tag, 2);
    PutBigEndian(tiff, type, 2);
    PutBigEndian(tiff, count, 4);
    PutBigEndian(tiff, is_short ? value << 16 : value, 4);
  };
  const std::uint32_t entries = is_adobe_rgb ? 2 : 1, time_bytes = 20;
  const std::uint32_t exif_at = 8 + 2 + 2 * 12 + 4, time_at = exif_at + 2 + entries * 12 + 4,
                      interoperability_at = time_at + time_bytes,
                      thumbnail_ifd = interoperability_at + (is_adobe_rgb ? 2 + 12 + 4 : 0),
                      thumbnail_at = thumbnail_ifd + 2 + 3 * 12 + 4;
  PutBigEndian(tiff, 2, 2);
  entry(0x0112, 3, 1, static_cast<std::uint32_t>(orientation), true);
  entry(0x8769, 4, 1, exif_at);
  PutBigEndian(tiff, thumbnail_jpeg.empty() ? 0 : thumbnail_ifd, 4);
  PutBigEndian(tiff, entries, 2);
  entry(0x9003, 2, time_bytes, time_at);
  if (is_adobe_rgb) entry(0xA005, 4, 1, interoperability_at);
  PutBigEndian(tiff, 0, 4);
  std::string time = taken;
  time.resize(time_bytes, '\0');
  tiff += time;
  if (is_adobe_rgb) {
    PutBigEndian(tiff, 1, 2);
    entry(0x0001, 2, 4, 0x52303300);  // "R03"
    PutBigEndian(tiff, 0, 4);
  }
  if (!thumbnail_jpeg.empty()) {
    PutBigEndian(tiff, 3, 2);
    entry(0x0103, 3, 1, 6, true);
    entry(0x0201, 4, 1, thumbnail_at);
    entry(0x0202, 4, 1, static_cast<std::uint32_t>(thumbnail_jpeg.size()));
    PutBigEndian(tiff, 0, 4);
    tiff += thumbnail_jpeg;
  }
  std::string segment("\xFF\xE1");
  PutBigEndian(segment, static_cast<std::uint32_t>(2 + 6 + tiff.size()), 2);
  return segment + std::string("Exif\0\0", 6) + tiff;
}

std::string WithSegment(const std::string& jpeg, const std::string& segment) {
  return jpeg.substr(0, 2) + segment + jpeg.substr(2);
}

std::string WithPngChunk(const std::string& png, const std::string& name, const std::string& content,
                         bool at_end) {
  const auto number = [](std::uint32_t n) {
    return std::string{static_cast<char>(n >> 24), static_cast<char>(n >> 16), static_cast<char>(n >> 8),
                       static_cast<char>(n)};
  };
  std::uint32_t crc = 0xFFFFFFFF;
  for (const char byte : name + content) {
    crc ^= static_cast<std::uint8_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xEDB88320U : 0);
  }
  const std::size_t at = at_end ? png.size() - 12 : 8 + 12 + 13;
  return png.substr(0, at) + number(static_cast<std::uint32_t>(content.size())) + name + content +
         number(~crc) + png.substr(at);
}

std::string WithWebpChunk(const std::string& webp, char flag, const std::string& name,
                          const std::string& content) {
  const auto chunk = [](const std::string& kind, const std::string& inside) {
    const auto size = static_cast<std::uint32_t>(inside.size());
    return kind + std::string(reinterpret_cast<const char*>(&size), 4) + inside + std::string(size % 2, '\0');
  };
  // Width and height less one, of three bytes each.
  const std::string header = std::string{flag, 0, 0, 0} + std::string("\x3B\0\0\x27\0\0", 6);
  const bool is_before = name == "ICCP";  // metadata stand behind the picture
  const std::string extra = chunk(name, content), picture = webp.substr(12);
  return chunk("RIFF", "WEBP" + chunk("VP8X", header) + (is_before ? extra + picture : picture + extra));
}

void WriteTiffNumbers(const std::filesystem::path& path, const cv::Mat& samples, int photometric,
                      const std::optional<std::array<float, 2>>& white, int most) {
  TIFF* const file = TIFFOpen(path.c_str(), "w");
  if (!file) throw std::runtime_error("a sample TIFF cannot be opened");
  TIFFSetField(file, TIFFTAG_IMAGEWIDTH, samples.cols);
  TIFFSetField(file, TIFFTAG_IMAGELENGTH, samples.rows);
  TIFFSetField(file, TIFFTAG_BITSPERSAMPLE, samples.depth() == CV_8U ? 8 : 16);
  TIFFSetField(file, TIFFTAG_SAMPLESPERPIXEL, samples.channels());
  TIFFSetField(file, TIFFTAG_PHOTOMETRIC, photometric);
  TIFFSetField(file, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(file, TIFFTAG_ROWSPERSTRIP, samples.rows);
  if (white) TIFFSetField(file, TIFFTAG_WHITEPOINT, white->data());
  if (most > 0) TIFFSetField(file, TIFFTAG_MAXSAMPLEVALUE, most);
  cv::Mat rows = samples.clone();
  if (TIFFWriteEncodedStrip(file, 0, rows.data, static_cast<tmsize_t>(rows.total() * rows.elemSize())) < 0)
    throw std::runtime_error("a sample TIFF cannot be written");
  TIFFClose(file);
}

}  // namespace ulf::test
