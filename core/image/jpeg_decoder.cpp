#include "core/image/jpeg_decoder.h"

#include <csetjmp>
#include <cstddef>
#include <cstdio>

extern "C" {
#include <jpeglib.h>
//
#include <jerror.h>
}

namespace ulf {
namespace {

constexpr int kMostFillBytes = 16;  // before a marker; webcams are known to send up to nine

// libjpeg has a pointer to `manager` only, which must therefore be the first member.
struct Report {
  jpeg_error_mgr manager{};
  std::jmp_buf on_error{};
  char damage[JMSG_LENGTH_MAX] = "";
};

Report& ReportOf(j_common_ptr decoder) { return *reinterpret_cast<Report*>(decoder->err); }

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
      return false;  // oddities of the headers, which cost no pixels
  }
}

void OnMessage(j_common_ptr decoder, int level) {
  Report& report = ReportOf(decoder);
  constexpr int kWarning = -1;
  if (level == kWarning && report.damage[0] == '\0' && IsDamage(report.manager))
    report.manager.format_message(decoder, report.damage);
}

void OnError(j_common_ptr decoder) {
  Report& report = ReportOf(decoder);
  report.manager.format_message(decoder, report.damage);
  std::longjmp(report.on_error, 1);
}

// libjpeg reports an error by a longjmp out of this function: nothing here may have a destructor.
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
  while (decoder.output_scanline < decoder.output_height) {
    JSAMPROW row = decoded.bgr.ptr(static_cast<int>(decoder.output_scanline));
    jpeg_read_scanlines(&decoder, &row, 1);
  }
  jpeg_finish_decompress(&decoder);
}

}  // namespace

DecodedJpeg DecodeWebcamJpeg(std::span<const std::uint8_t> bytes, cv::Size expected) {
  Report report;
  jpeg_decompress_struct decoder{};
  decoder.err = jpeg_std_error(&report.manager);
  report.manager.emit_message = OnMessage;
  report.manager.error_exit = OnError;
  jpeg_create_decompress(&decoder);
  DecodedJpeg decoded;
  Decode(decoder, report, bytes, expected, decoded);
  jpeg_destroy_decompress(&decoder);
  decoded.damage = report.damage;
  return decoded;
}

}  // namespace ulf
