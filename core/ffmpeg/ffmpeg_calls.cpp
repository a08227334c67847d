#include "core/ffmpeg/ffmpeg_calls.h"

#include <dlfcn.h>
#include <fmt/core.h>

#include <string>

#include "core/base/error.h"

namespace ulf {
namespace {

void* OpenLibrary(const char* name, int version) {
  const std::string file = fmt::format("lib{}.so.{}", name, version);
  void* library = dlopen(file.c_str(), RTLD_LAZY | RTLD_LOCAL);
  if (!library)
    throw Error(
        "FFmpeg's library {} is not installed, which reads and writes videos and reads BMP and Netpbm "
        "pictures; "
        "install libavformat{}, libavcodec{} and libswscale{}",
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

}  // namespace

const FfmpegCalls& Ffmpeg() {
  static const FfmpegCalls calls = OpenFfmpeg();
  return calls;
}

}  // namespace ulf
