// The functions of FFmpeg's libraries that ulf calls, found when the first is called: these libraries bring a hundred others,
// and most commands read no video.
#pragma once

#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/dict.h>
#include <libavutil/display.h>
#include <libavutil/dovi_meta.h>
#include <libavutil/log.h>
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
#include <libavutil/spherical.h>
#include <libavutil/stereo3d.h>
#include <libswscale/swscale.h>
#include <string>

namespace ulf {

struct FfmpegCalls {
#define ULF_MEMBER(library, function) decltype(&::function) function;
  ULF_FFMPEG_FUNCTIONS(ULF_MEMBER)
#undef ULF_MEMBER
};

// Throws Error, which names the packages, where the libraries of the version that ulf was built with are not installed.
const FfmpegCalls& Ffmpeg();

// Reading and writing videos share this use of FFmpeg's libraries.

// The meaning of an error number of FFmpeg.
std::string FfmpegWords(int status);

// FFmpeg's own messages go to our log as details (--verbose), once and for all.
void RouteFfmpegLog();

}  // namespace ulf
