#include "core/video/video_writer.h"

#include <cerrno>
#include <string>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/ffmpeg/ffmpeg_calls.h"

namespace ulf {

namespace fs = std::filesystem;

struct VideoWriter::State {
  State(const fs::path& mp4, const cv::Size& wanted, double frame_rate)
      : name(mp4.string()),
        size(wanted),
        packet(Ffmpeg().av_packet_alloc()),
        frame(Ffmpeg().av_frame_alloc()) {
    OpenCodec(frame_rate);
    OpenFile();
    frame->format = codec->pix_fmt;
    frame->width = size.width;
    frame->height = size.height;
    Require(Ffmpeg().av_frame_get_buffer(frame.get(), 0), "no memory for a picture");
    scaler.reset(Ffmpeg().sws_getContext(size.width, size.height, AV_PIX_FMT_BGR24, size.width, size.height,
                                         codec->pix_fmt, SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INP,
                                         nullptr, nullptr, nullptr));
    if (!scaler) throw Error("{}: pictures of {}x{} cannot be converted", name, size.width, size.height);
    constexpr int kAsIs = 1 << 16;
    Ffmpeg().sws_setColorspaceDetails(scaler.get(), Ffmpeg().sws_getCoefficients(SWS_CS_DEFAULT), 1,
                                      Ffmpeg().sws_getCoefficients(SWS_CS_ITU709), 0, 0, kAsIs, kAsIs);
  }

  void Require(int status, const char* what) const {
    if (status >= 0) return;
    if (status == AVERROR(ENOSPC) || status == AVERROR(EDQUOT)) ThrowDiskError(-status, name + ": " + what);
    throw Error("{}: {}: {}", name, what, FfmpegErrorText(status));
  }

  void OpenCodec(double frame_rate) {
    constexpr int kMostTerm = 1'000'000;
    const AVRational rate = Ffmpeg().av_d2q(frame_rate, kMostTerm);
    for (const char* encoder_name : {"libx264", "libopenh264", "mpeg4"}) {
      const AVCodec* encoder = Ffmpeg().avcodec_find_encoder_by_name(encoder_name);
      if (!encoder) continue;
      codec.reset(Ffmpeg().avcodec_alloc_context3(encoder));
      codec->width = size.width;
      codec->height = size.height;
      codec->time_base = av_inv_q(rate);
      codec->framerate = rate;
      codec->pix_fmt = AV_PIX_FMT_YUV420P;
      codec->color_range = AVCOL_RANGE_MPEG;
      codec->colorspace = AVCOL_SPC_BT709;
      codec->color_primaries = AVCOL_PRI_BT709;
      codec->color_trc = AVCOL_TRC_BT709;
      codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
      if (encoder->id == AV_CODEC_ID_H264) {
        Ffmpeg().av_opt_set(codec->priv_data, "crf", "17", 0);  // visually almost lossless
        Ffmpeg().av_opt_set(codec->priv_data, "preset", "medium", 0);
      } else {
        codec->flags |= AV_CODEC_FLAG_QSCALE;
        codec->global_quality = 2 * FF_QP2LAMBDA;
      }
      status = Ffmpeg().avcodec_open2(codec.get(), encoder, nullptr);
      if (status >= 0) return;
    }
    if (!codec)
      throw Error(
          "{}: no video can be written here (neither H.264 nor MPEG-4); give a folder to get pictures", name);
    throw Refusal(
        Parameter("fps"), fmt::format("{}", frame_rate),
        fmt::format("{} cannot have this rate or size ({})", codec->codec->name, FfmpegErrorText(status)),
        "give a rounder rate");
  }

  void OpenFile() {
    AVFormatContext* made = nullptr;
    Require(Ffmpeg().avformat_alloc_output_context2(&made, nullptr, "mp4", ("file:" + name).c_str()),
            "cannot be written");
    file.reset(made);
    AVStream* stream = Ffmpeg().avformat_new_stream(made, nullptr);
    Require(
        stream ? Ffmpeg().avcodec_parameters_from_context(stream->codecpar, codec.get()) : AVERROR(ENOMEM),
        "cannot be written");
    stream->time_base = codec->time_base;
    stream->avg_frame_rate = codec->framerate;
    Require(Ffmpeg().avio_open(&file->pb, file->url, AVIO_FLAG_WRITE), "cannot be written");
    AVDictionary* options = nullptr;
    Ffmpeg().av_dict_set(&options, "movflags", "+faststart+write_colr", 0);
    const int written = Ffmpeg().avformat_write_header(made, &options);
    Ffmpeg().av_dict_free(&options);
    Require(written, "cannot be written");
  }

  // Gives the encoder a picture, or the end of stream; writes its output.
  void Encode(AVFrame* picture) {
    Require(Ffmpeg().avcodec_send_frame(codec.get(), picture), "a picture cannot be encoded");
    while (true) {
      const int received = Ffmpeg().avcodec_receive_packet(codec.get(), packet.get());
      if (received == AVERROR(EAGAIN) || received == AVERROR_EOF) return;
      Require(received, "a picture cannot be encoded");
      packet->stream_index = 0;
      packet->duration = 1;
      Ffmpeg().av_packet_rescale_ts(packet.get(), codec->time_base, file->streams[0]->time_base);
      Require(Ffmpeg().av_interleaved_write_frame(file.get(), packet.get()), "a picture cannot be written");
      Require(file->pb->error, "a picture cannot be written");
    }
  }

  std::string name;
  cv::Size size;
  int status = 0;
  std::int64_t count = 0;
  FfmpegOwned<AVCodecContext> codec;
  FfmpegOwned<AVFormatContext> file;
  FfmpegOwned<SwsContext> scaler;
  FfmpegOwned<AVPacket> packet;
  FfmpegOwned<AVFrame> frame;
};

VideoWriter::VideoWriter(const fs::path& mp4, const cv::Size& size, double frame_rate) {
  RouteFfmpegLog();
  state_ = std::make_unique<State>(mp4, size, frame_rate);
}

VideoWriter::~VideoWriter() = default;

void VideoWriter::Add(const cv::Mat& srgb8) {
  State& state = *state_;
  if (srgb8.size() != state.size || srgb8.type() != CV_8UC3)
    throw Error("{}: a picture is {}x{}, the video {}x{}", state.name, srgb8.cols, srgb8.rows,
                state.size.width, state.size.height);
  state.Require(Ffmpeg().av_frame_make_writable(state.frame.get()), "no memory for a picture");
  const std::uint8_t* const data[]{srgb8.data};
  const int line_bytes[]{static_cast<int>(srgb8.step)};
  Ffmpeg().sws_scale(state.scaler.get(), data, line_bytes, 0, srgb8.rows, state.frame->data,
                     state.frame->linesize);
  state.frame->pts = state.count++;
  state.Encode(state.frame.get());
}

void VideoWriter::Close() {
  State& state = *state_;
  state.Encode(nullptr);
  state.Require(Ffmpeg().av_write_trailer(state.file.get()), "the end cannot be written");
  const int failed = state.file->pb->error;
  const int closed = Ffmpeg().avio_closep(&state.file->pb);
  state.Require(failed < 0 ? failed : closed, "the end cannot be written");
}

}  // namespace ulf
