// Reading and writing videos share this use of FFmpeg's libraries.
#pragma once

#include <string>

namespace ulf {

// The meaning of an error number of FFmpeg.
std::string FfmpegWords(int status);

// FFmpeg's own messages go to our log as details (--verbose), once and for all.
void RouteFfmpegLog();

}  // namespace ulf
