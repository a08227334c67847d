#include "core/ffmpeg/ffmpeg.h"

#include <spdlog/spdlog.h>

#include <array>
#include <mutex>

#include "core/ffmpeg/ffmpeg_calls.h"

namespace ulf {
namespace {

void ToOurLog(void* context, int level, const char* format, va_list arguments) {
  if (level > AV_LOG_WARNING) return;
  std::array<char, 1024> line{};
  int print_prefix = 1;
  Ffmpeg().av_log_format_line(context, level, format, arguments, line.data(), static_cast<int>(line.size()),
                              &print_prefix);
  std::string text = line.data();
  while (text.ends_with('\n')) text.pop_back();
  spdlog::debug("FFmpeg: {}", text);
}

}  // namespace

std::string FfmpegWords(int status) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> words{};
  if (Ffmpeg().av_strerror(status, words.data(), words.size()) < 0) return std::to_string(status);
  return words.data();
}

void RouteFfmpegLog() {
  static std::once_flag once;
  std::call_once(once, [] { Ffmpeg().av_log_set_callback(ToOurLog); });
}

}  // namespace ulf
