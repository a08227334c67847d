#include "core/ffmpeg/ffmpeg_calls.h"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <dlfcn.h>
#include <array>
#include <mutex>

#include "core/base/error.h"

namespace ulf {

namespace {

void* OpenLibrary(const char* name, int version) {
  const std::string file = fmt::format("lib{}.so.{}", name, version);
  void* library = dlopen(file.c_str(), RTLD_LAZY | RTLD_LOCAL);
  if (!library)
    throw Error(
        "FFmpeg's library {} is not installed, which reads and writes videos and reads BMP and Netpbm "
        "pictures; install libavformat{}, libavcodec{} and libswscale{}",
        file, LIBAVFORMAT_VERSION_MAJOR, LIBAVCODEC_VERSION_MAJOR, LIBSWSCALE_VERSION_MAJOR);
  return library;
}

template <typename Function>
void Find(void* library, const char* name, Function& function) {
  function = reinterpret_cast<Function>(dlsym(library, name));
  if (!function)
    throw Error("FFmpeg's library has no function {}; install the version that ulf was built with", name);
}

FfmpegCalls OpenFfmpeg() {
  void* const avutil = OpenLibrary("avutil", LIBAVUTIL_VERSION_MAJOR);
  void* const avcodec = OpenLibrary("avcodec", LIBAVCODEC_VERSION_MAJOR);
  void* const avformat = OpenLibrary("avformat", LIBAVFORMAT_VERSION_MAJOR);
  void* const swscale = OpenLibrary("swscale", LIBSWSCALE_VERSION_MAJOR);
  FfmpegCalls calls{};
#define ULF_FIND(library, function) Find(library, #function, calls.function);
  ULF_FFMPEG_FUNCTIONS(ULF_FIND)
#undef ULF_FIND
  return calls;
}

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

const FfmpegCalls& Ffmpeg() {
  static const FfmpegCalls calls = OpenFfmpeg();
  return calls;
}

std::string FfmpegErrorText(int status) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> words{};
  if (Ffmpeg().av_strerror(status, words.data(), words.size()) < 0) return std::to_string(status);
  return words.data();
}

void RouteFfmpegLog() {
  static std::once_flag once;
  std::call_once(once, [] { Ffmpeg().av_log_set_callback(ToOurLog); });
}

}  // namespace ulf
