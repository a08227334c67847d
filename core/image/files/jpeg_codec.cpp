#include "core/image/files/jpeg_codec.h"

#include <cmath>
#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "core/base/error.h"
#include "core/image/files/exif.h"
#include "core/image/files/image_header.h"
#include "core/image/files/picture_colors.h"
#include "core/image/files/picture_end.h"
#include "core/image/files/picture_projection.h"

extern "C" {
#include <jpeglib.h>
//
#include <jerror.h>
}

namespace ulf {
namespace {

constexpr std::size_t kExifBytes = 1 << 17;  // a segment has at most half of it
constexpr int kMostFillBytes = 16;           // before a marker; webcams send up to nine

// libjpeg has a pointer to `manager` only, which must therefore be the first member.
struct Report {
  jpeg_error_mgr manager{};
  std::jmp_buf on_error{};
  char damage[JMSG_LENGTH_MAX] = "";
  bool is_error = false;
};

Report& ReportOf(j_common_ptr codec) { return *reinterpret_cast<Report*>(codec->err); }

bool IsDamage(const jpeg_error_mgr& manager) {
  switch (manager.msg_code) {
    case JWRN_HIT_MARKER:  // the data of a segment end too early
    case JWRN_HUFF_BAD_CODE:
    case JWRN_MUST_RESYNC:
    case JWRN_JPEG_EOF:
      return true;
    case JWRN_EXTRANEOUS_DATA:
      return manager.msg_parm.i[0] > kMostFillBytes;
    default:
      return false;  // header faults cost no pixels
  }
}

void OnMessage(j_common_ptr codec, int level) {
  Report& report = ReportOf(codec);
  constexpr int kWarning = -1;
  if (level == kWarning && report.damage[0] == '\0' && IsDamage(report.manager))
    report.manager.format_message(codec, report.damage);
}

void OnError(j_common_ptr codec) {
  Report& report = ReportOf(codec);
  report.is_error = true;
  report.manager.format_message(codec, report.damage);
  std::longjmp(report.on_error, 1);
}

void Prepare(Report& report) {
  jpeg_std_error(&report.manager);
  report.manager.emit_message = OnMessage;
  report.manager.error_exit = OnError;
}

void ReadRows(jpeg_decompress_struct& decoder, cv::Mat& pixels) {
  while (decoder.output_scanline < decoder.output_height) {
    JSAMPROW row = pixels.ptr(static_cast<int>(decoder.output_scanline));
    jpeg_read_scanlines(&decoder, &row, 1);
  }
  jpeg_finish_decompress(&decoder);
}

// libjpeg reports an error by a longjmp out of this function: nothing here may have a destructor. The same
// holds for DecodePhotograph() and Encode().
void Decode(jpeg_decompress_struct& decoder, Report& report, std::span<const std::uint8_t> bytes,
            const cv::Size& expected, DecodedJpeg& decoded) {
  if (setjmp(report.on_error)) return;
  jpeg_mem_src(&decoder, bytes.data(), bytes.size());
  jpeg_read_header(&decoder, TRUE);
  decoded.size.width = static_cast<int>(decoder.image_width);
  decoded.size.height = static_cast<int>(decoder.image_height);
  if (decoded.size != expected) return;
  decoder.out_color_space = JCS_EXT_BGR;
  jpeg_start_decompress(&decoder);
  decoded.bgr.create(expected, CV_8UC3);
  ReadRows(decoder, decoded.bgr);
}

struct Photograph {
  cv::Mat pixels;  // one channel, B G R, or four inks
  JOCTET* icc = nullptr;
  unsigned icc_bytes = 0;
  bool is_by_adobe = false;
  int density[2] = {};  // JFIF: across, down
};

void DecodePhotograph(jpeg_decompress_struct& decoder, Report& report, std::string_view bytes,
                      Photograph& photograph) {
  if (setjmp(report.on_error)) return;
  jpeg_mem_src(&decoder, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  constexpr int kIccMarker = JPEG_APP0 + 2;
  constexpr unsigned kWholeMarker = 0xFFFF;
  jpeg_save_markers(&decoder, kIccMarker, kWholeMarker);
  jpeg_read_header(&decoder, TRUE);
  jpeg_read_icc_profile(&decoder, &photograph.icc, &photograph.icc_bytes);
  photograph.is_by_adobe = decoder.saw_Adobe_marker != FALSE;
  if (decoder.saw_JFIF_marker != FALSE) {
    photograph.density[0] = decoder.X_density;
    photograph.density[1] = decoder.Y_density;
  }
  int type = CV_8UC3;
  switch (decoder.jpeg_color_space) {
    case JCS_GRAYSCALE:
      decoder.out_color_space = JCS_GRAYSCALE;
      type = CV_8UC1;
      break;
    case JCS_CMYK:
    case JCS_YCCK:
      decoder.out_color_space = JCS_CMYK;
      type = CV_8UC4;
      break;
    default:
      decoder.out_color_space = JCS_EXT_BGR;
  }
  jpeg_start_decompress(&decoder);
  photograph.pixels.create(static_cast<int>(decoder.output_height), static_cast<int>(decoder.output_width),
                           type);
  ReadRows(decoder, photograph.pixels);
}

void Encode(jpeg_compress_struct& encoder, Report& report, const cv::Mat& pixels, int quality,
            unsigned char** bytes, unsigned long* size) {
  if (setjmp(report.on_error)) return;
  jpeg_mem_dest(&encoder, bytes, size);
  encoder.image_width = static_cast<JDIMENSION>(pixels.cols);
  encoder.image_height = static_cast<JDIMENSION>(pixels.rows);
  encoder.input_components = pixels.channels();
  encoder.in_color_space = pixels.channels() == 1 ? JCS_GRAYSCALE : JCS_EXT_BGR;
  jpeg_set_defaults(&encoder);
  jpeg_set_quality(&encoder, quality, TRUE);
  jpeg_start_compress(&encoder, TRUE);
  while (encoder.next_scanline < encoder.image_height) {
    JSAMPROW row = const_cast<JSAMPROW>(pixels.ptr(static_cast<int>(encoder.next_scanline)));
    jpeg_write_scanlines(&encoder, &row, 1);
  }
  jpeg_finish_compress(&encoder);
}

}  // namespace

DecodedJpeg DecodeWebcamJpeg(std::span<const std::uint8_t> bytes, cv::Size expected) {
  Report report;
  jpeg_decompress_struct decoder{};
  Prepare(report);
  decoder.err = &report.manager;
  jpeg_create_decompress(&decoder);
  DecodedJpeg decoded;
  Decode(decoder, report, bytes, expected, decoded);
  jpeg_destroy_decompress(&decoder);
  decoded.damage = report.damage;
  return decoded;
}

StoredPicture ReadJpeg(std::string_view bytes, const std::string& name) {
  Report report;
  jpeg_decompress_struct decoder{};
  Prepare(report);
  decoder.err = &report.manager;
  jpeg_create_decompress(&decoder);
  Photograph photograph;
  DecodePhotograph(decoder, report, bytes, photograph);
  jpeg_destroy_decompress(&decoder);
  std::string icc;
  if (photograph.icc) icc.assign(reinterpret_cast<const char*>(photograph.icc), photograph.icc_bytes);
  std::free(photograph.icc);
  if (report.is_error)
    throw Error("{}: cannot be decoded as JPEG ({}); copy it again from its source, or convert it to PNG",
                name, report.damage);
  StoredPicture picture;
  if (report.damage[0] != '\0')
    picture.warnings.push_back(
        fmt::format("its data are damaged inside ({}): part of it is wrong", report.damage));
  RequireOneLensOfJpeg(bytes, name, picture);
  const auto [across, down] = photograph.density;
  const cv::Size size = photograph.pixels.size();
  constexpr double kSame = 0.02;
  if (std::abs(across * size.height - down * size.width) >
      kSame * down * size.width)  // the size, in some programs
    WarnOfPixelAspect(across, down, picture);
  const ExifFacts exif = ReadExif(std::string(bytes.substr(0, kExifBytes)));
  NoteOrientation(exif.orientation, picture);
  if (photograph.pixels.channels() == 4) {
    picture.pixels = SrgbOfInks(photograph.pixels, photograph.is_by_adobe, icc, picture);
    return picture;
  }
  picture.pixels = photograph.pixels;
  ColorTags claim{.icc = icc};
  constexpr Primaries kAdobeRgb{0.64, 0.33, 0.21, 0.71, 0.15, 0.06, 0.3127, 0.3290};
  constexpr double kAdobeExponent = 2.19921875;
  if (exif.is_adobe_rgb)
    claim = {.icc = icc, .primaries = kAdobeRgb, .exponent = kAdobeExponent, .name = "Adobe RGB (Exif)"};
  if (exif.is_other_space && icc.empty())
    picture.warnings.emplace_back(
        "its Exif data say that its colours are not sRGB, and no profile says which: they are taken for "
        "sRGB");
  ConvertToSrgb(claim, picture);
  return picture;
}

cv::Mat DecodeJpeg(const std::string& bytes) {
  if (!JpegIsWhole(bytes)) return {};
  try {
    std::istringstream stream(bytes);
    if (const auto header = ReadImageHeader(stream))
      RequirePixelsOfFile("JPEG", bytes.size(),
                          static_cast<double>(header->width) * static_cast<double>(header->height), 3);
    cv::Mat pixels = ReadJpeg(bytes, "JPEG").pixels;
    if (pixels.channels() == 1) cv::cvtColor(pixels, pixels, cv::COLOR_GRAY2BGR);
    return pixels;
  } catch (const Error&) {
    return {};
  }
}

std::string JpegBytes(const cv::Mat& pixels, int quality) {
  cv::Mat shown = pixels;
  if (pixels.channels() == 4) cv::cvtColor(pixels, shown, cv::COLOR_BGRA2BGR);
  if (shown.empty() || shown.depth() != CV_8U || (shown.channels() != 1 && shown.channels() != 3))
    throw Error(
        "a picture of {} channels of OpenCV's depth {} cannot be written as JPEG; convert it to 8 bits",
        pixels.channels(), pixels.depth());
  Report report;
  jpeg_compress_struct encoder{};
  Prepare(report);
  encoder.err = &report.manager;
  jpeg_create_compress(&encoder);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  Encode(encoder, report, shown, quality, &bytes, &size);
  jpeg_destroy_compress(&encoder);
  std::string jpeg;
  if (!report.is_error) jpeg.assign(reinterpret_cast<const char*>(bytes), size);
  std::free(bytes);
  if (report.is_error)
    throw Error("a picture of {}x{} cannot be written as JPEG: {}", pixels.cols, pixels.rows, report.damage);
  return jpeg;
}

}  // namespace ulf
