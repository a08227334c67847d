#include "tests/support/video/sample_video.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/dovi_meta.h>
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
#include <libavutil/spherical.h>
#include <libavutil/stereo3d.h>
}

#include <cstring>
#include <stdexcept>

namespace ulf::test {
namespace {

void Require(int status, const char* what) {
  if (status < 0) throw std::runtime_error(std::string(what) + ": " + std::to_string(status));
}

void Fill(const VideoSample& sample, int number, AVFrame& frame) {
  const AVPixFmtDescriptor& layout = *av_pix_fmt_desc_get(sample.format);
  const bool is_wide = layout.comp[0].depth > 8;
  for (int plane = 0; plane < 4 && frame.data[plane]; ++plane) {
    const bool is_chroma = plane > 0 && (layout.flags & AV_PIX_FMT_FLAG_RGB) == 0;
    const int width = is_chroma ? AV_CEIL_RSHIFT(frame.width, layout.log2_chroma_w) : frame.width;
    const int height = is_chroma ? AV_CEIL_RSHIFT(frame.height, layout.log2_chroma_h) : frame.height;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        std::uint8_t* const line = frame.data[plane] + y * frame.linesize[plane];
        const int value = sample.value(number, plane, x, y);
        if (is_wide) {
          const auto wide = static_cast<std::uint16_t>(value);
          std::memcpy(line + 2 * x, &wide, sizeof(wide));
        } else {
          line[x] = static_cast<std::uint8_t>(value);
        }
      }
  }
}

}  // namespace

void WriteVideo(const std::filesystem::path& file, const VideoSample& sample) {
  AVFormatContext* output = nullptr;
  Require(avformat_alloc_output_context2(&output, nullptr, nullptr, file.c_str()), "container");
  const AVCodec* encoder = avcodec_find_encoder_by_name(sample.encoder.c_str());
  Require(encoder ? 0 : AVERROR_ENCODER_NOT_FOUND, sample.encoder.c_str());
  AVCodecContext* codec = avcodec_alloc_context3(encoder);
  codec->width = sample.width;
  codec->height = sample.height;
  codec->pix_fmt = sample.format;
  codec->time_base = {1, sample.rate};
  codec->framerate = {sample.rate, 1};
  codec->colorspace = sample.matrix;
  codec->color_range = sample.range;
  codec->color_primaries = sample.primaries;
  codec->color_trc = sample.curve;
  codec->max_b_frames = 0;
  if (sample.aspect_num > 0) codec->sample_aspect_ratio = {sample.aspect_num, sample.aspect_den};
  if (sample.is_interlaced) {
    codec->flags |= AV_CODEC_FLAG_INTERLACED_DCT;
    codec->field_order = AV_FIELD_TT;
  }
  if ((output->oformat->flags & AVFMT_GLOBALHEADER) != 0) codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  if (sample.encoder == "libx264") av_opt_set(codec->priv_data, "qp", "0", 0);
  if (sample.encoder == "mpeg2video" || sample.encoder == "mjpeg") {
    codec->flags |= AV_CODEC_FLAG_QSCALE;
    codec->global_quality = FF_QP2LAMBDA;
  }
  Require(avcodec_open2(codec, encoder, nullptr), "encoder");
  AVStream* stream = avformat_new_stream(output, nullptr);
  Require(avcodec_parameters_from_context(stream->codecpar, codec), "parameters");
  stream->time_base = codec->time_base;
  stream->avg_frame_rate = codec->framerate;
  stream->sample_aspect_ratio = codec->sample_aspect_ratio;
  if (sample.display_matrix) {
    const auto [a, b, c, d] = *sample.display_matrix;
    constexpr int kOne = 1 << 16;
    const std::array<std::int32_t, 9> matrix{a * kOne, b * kOne, 0, c * kOne, d * kOne, 0, 0, 0, 1 << 30};
    std::memcpy(av_stream_new_side_data(stream, AV_PKT_DATA_DISPLAYMATRIX, sizeof(matrix)), matrix.data(),
                sizeof(matrix));
  }
  if (sample.dolby_vision_profile > 0) {
    output->strict_std_compliance = FF_COMPLIANCE_UNOFFICIAL;
    std::size_t size = 0;
    AVDOVIDecoderConfigurationRecord* told = av_dovi_alloc(&size);
    told->dv_version_major = 1;
    told->dv_profile = static_cast<std::uint8_t>(sample.dolby_vision_profile);
    told->rpu_present_flag = told->bl_present_flag = 1;
    told->dv_bl_signal_compatibility_id = sample.dolby_vision_profile < 6 ? 0 : 4;
    av_stream_add_side_data(stream, AV_PKT_DATA_DOVI_CONF, reinterpret_cast<std::uint8_t*>(told), size);
  }
  if (sample.spherical >= 0) {
    std::size_t size = 0;
    AVSphericalMapping* mapping = av_spherical_alloc(&size);
    mapping->projection = static_cast<AVSphericalProjection>(sample.spherical);
    std::memcpy(av_stream_new_side_data(stream, AV_PKT_DATA_SPHERICAL, size), mapping, size);
    av_free(mapping);
  }
  if (sample.stereo >= 0) {
    AVStereo3D stereo{};
    stereo.type = static_cast<AVStereo3DType>(sample.stereo);
    std::memcpy(av_stream_new_side_data(stream, AV_PKT_DATA_STEREO3D, sizeof(stereo)), &stereo,
                sizeof(stereo));
  }
  Require(avio_open(&output->pb, file.c_str(), AVIO_FLAG_WRITE), "file");
  Require(avformat_write_header(output, nullptr), "header");
  AVPacket* packet = av_packet_alloc();
  const auto encode = [&](AVFrame* frame) {
    Require(avcodec_send_frame(codec, frame), "picture");
    while (avcodec_receive_packet(codec, packet) >= 0) {
      if (sample.drops_key_frames && (packet->flags & AV_PKT_FLAG_KEY) != 0) {
        av_packet_unref(packet);
        continue;
      }
      packet->stream_index = 0;
      av_packet_rescale_ts(packet, codec->time_base, stream->time_base);
      Require(av_interleaved_write_frame(output, packet), "packet");
    }
  };
  for (int number = 0; number < sample.pictures; ++number) {
    AVFrame* frame = av_frame_alloc();
    frame->format = sample.format;
    frame->width = sample.width;
    frame->height = sample.height;
    Require(av_frame_get_buffer(frame, 0), "memory");
    Fill(sample, number, *frame);
    frame->pts = sample.times.empty() ? number : sample.times[static_cast<std::size_t>(number)];
    frame->interlaced_frame = sample.is_interlaced;
    frame->top_field_first = sample.is_interlaced;
    encode(frame);
    av_frame_free(&frame);
  }
  encode(nullptr);
  Require(av_write_trailer(output), "end");
  av_packet_free(&packet);
  avcodec_free_context(&codec);
  avio_closep(&output->pb);
  avformat_free_context(output);
}

}  // namespace ulf::test
