// Loads FFmpeg's libraries at the first call of Ffmpeg(), not at the program's start: they load a hundred
// others, and most commands read no video. Call FFmpeg only through Ffmpeg().
#pragma once

#include <memory>
#include <string>

extern "C" {
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
}

// Lists the functions that are loaded, as F(library, function). Add a function here before you call it.
#define ULF_FFMPEG_FUNCTIONS(F)               \
  F(avutil, av_color_primaries_name)          \
  F(avutil, av_color_space_name)              \
  F(avutil, av_color_transfer_name)           \
  F(avutil, av_d2q)                           \
  F(avutil, av_dict_free)                     \
  F(avutil, av_dict_set)                      \
  F(avutil, av_frame_alloc)                   \
  F(avutil, av_frame_free)                    \
  F(avutil, av_frame_get_buffer)              \
  F(avutil, av_frame_get_side_data)           \
  F(avutil, av_frame_make_writable)           \
  F(avutil, av_get_pix_fmt_name)              \
  F(avutil, av_log_format_line)               \
  F(avutil, av_log_set_callback)              \
  F(avutil, av_opt_set)                       \
  F(avutil, av_pix_fmt_desc_get)              \
  F(avutil, av_strerror)                      \
  F(avcodec, av_new_packet)                   \
  F(avcodec, av_packet_alloc)                 \
  F(avcodec, av_packet_free)                  \
  F(avcodec, av_packet_rescale_ts)            \
  F(avcodec, av_packet_unref)                 \
  F(avcodec, avcodec_alloc_context3)          \
  F(avcodec, avcodec_find_decoder)            \
  F(avcodec, avcodec_find_encoder_by_name)    \
  F(avcodec, avcodec_free_context)            \
  F(avcodec, avcodec_get_name)                \
  F(avcodec, avcodec_open2)                   \
  F(avcodec, avcodec_parameters_from_context) \
  F(avcodec, avcodec_parameters_to_context)   \
  F(avcodec, avcodec_receive_frame)           \
  F(avcodec, avcodec_receive_packet)          \
  F(avcodec, avcodec_send_frame)              \
  F(avcodec, avcodec_send_packet)             \
  F(avformat, av_find_best_stream)            \
  F(avformat, av_guess_frame_rate)            \
  F(avformat, av_guess_sample_aspect_ratio)   \
  F(avformat, av_interleaved_write_frame)     \
  F(avformat, av_read_frame)                  \
  F(avformat, av_stream_get_side_data)        \
  F(avformat, av_write_trailer)               \
  F(avformat, avformat_alloc_output_context2) \
  F(avformat, avformat_close_input)           \
  F(avformat, avformat_find_stream_info)      \
  F(avformat, avformat_free_context)          \
  F(avformat, avformat_new_stream)            \
  F(avformat, avformat_open_input)            \
  F(avformat, avformat_write_header)          \
  F(avformat, avio_closep)                    \
  F(avformat, avio_open)                      \
  F(swscale, sws_freeContext)                 \
  F(swscale, sws_getCoefficients)             \
  F(swscale, sws_getContext)                  \
  F(swscale, sws_scale)                       \
  F(swscale, sws_setColorspaceDetails)

namespace ulf {

struct FfmpegCalls {
#define ULF_MEMBER(library, function) decltype(&::function) function;
  ULF_FFMPEG_FUNCTIONS(ULF_MEMBER)
#undef ULF_MEMBER
};

// Returns the loaded functions. Throws an Error that names the packages if the libraries of the version that
// ulf was built with are not installed; so do the functions below. May be called from any thread.
const FfmpegCalls& Ffmpeg();

// Frees what FFmpeg has allocated, and closes files.
struct FfmpegFree {
  void operator()(AVCodecContext* codec) const { Ffmpeg().avcodec_free_context(&codec); }
  void operator()(AVFrame* frame) const { Ffmpeg().av_frame_free(&frame); }
  void operator()(AVPacket* packet) const { Ffmpeg().av_packet_free(&packet); }
  void operator()(SwsContext* scaler) const { Ffmpeg().sws_freeContext(scaler); }
  void operator()(AVFormatContext* file) const {
    if (file->iformat) return Ffmpeg().avformat_close_input(&file);
    Ffmpeg().avio_closep(&file->pb);
    Ffmpeg().avformat_free_context(file);
  }
};
template <typename Thing>
using FfmpegOwned = std::unique_ptr<Thing, FfmpegFree>;

// Returns the text of an error code (AVERROR, negative) that FFmpeg returned.
std::string FfmpegErrorText(int status);

// Sends FFmpeg's warnings and errors to our log at the level debug from now on. Further calls do nothing.
void RouteFfmpegLog();

}  // namespace ulf
