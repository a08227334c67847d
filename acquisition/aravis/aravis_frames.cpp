#include "acquisition/aravis/aravis_frames.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "acquisition/aravis/aravis_description.h"

namespace ulf::acquisition {

std::string BufferStatusText(ArvBufferStatus status) {
  switch (status) {
    case ARV_BUFFER_STATUS_SUCCESS:
      return "not the image that was configured";
    case ARV_BUFFER_STATUS_TIMEOUT:
      return "timed out";
    case ARV_BUFFER_STATUS_MISSING_PACKETS:
      return "packets lost";
    case ARV_BUFFER_STATUS_WRONG_PACKET_ID:
      return "wrong packet number";
    case ARV_BUFFER_STATUS_SIZE_MISMATCH:
      return "wrong size";
    default:
      return "never filled";
  }
}

AravisFrames::AravisFrames(const AravisSession& session, AravisConfigured configured)
    : configured_(std::move(configured)) {
  if (configured_.chunks.empty()) return;
  chunks_ = arv_camera_create_chunk_parser(session.Camera());
  // Chunks seldom tell a unit; then it is that of the setting.
  const NamedFeatures features = FeaturesOf(session.Camera());
  const FeatureNames names = FindFeatureNames(features);
  const std::string exposure_unit = features.unit_of("ChunkExposureTime");
  chunk_exposure_us_ = exposure_unit.empty() ? names.exposure_us : MicrosecondsIn(exposure_unit).value_or(0);
  const bool gain_in_decibels = IsDecibel(features.unit_of("ChunkGain"));
  chunk_gain_is_factor_ = names.gain_is_factor && !gain_in_decibels;
  chunk_gain_is_known_ = gain_in_decibels || !names.gain.empty();
  // Cameras of GigE Vision 1.x count ticks of their own.
  if (!ARV_IS_GV_DEVICE(session.Device())) return;
  const guint64 ticks_per_s =
      TryCall(arv_gv_device_get_timestamp_tick_frequency, ARV_GV_DEVICE(session.Device())).value_or(0);
  if (ticks_per_s > 0) tick_s_ = 1.0 / static_cast<double>(ticks_per_s);
}

AravisFrames::~AravisFrames() { g_clear_object(&chunks_); }

Frame AravisFrames::Read(ArvBuffer* buffer) {
  const double host_time_s = 1e-9 * static_cast<double>(arv_buffer_get_system_timestamp(buffer));
  Frame frame;
  frame.id = arv_buffer_get_frame_id(buffer);
  frame.device_time_s = 1e-9 * static_cast<double>(arv_buffer_get_timestamp(buffer));
  frame.host_time_s = host_time_s;
  if (frame.device_time_s == 0) frame.device_time_s = host_time_s;  // a camera without a clock
  frame.exposure_s = configured_.exposure_s;
  frame.gain = configured_.gain;
  frame.black_level = configured_.black_level;
  frame.on_shared_clock = on_shared_clock_;
  if (arv_buffer_get_status(buffer) == ARV_BUFFER_STATUS_SUCCESS && FillComplete(buffer, frame)) {
    frame.status = FrameStatus::kComplete;
    if (chunks_) ReadChunks(buffer, frame);
  } else {
    frame.status = FrameStatus::kIncomplete;
    FillIncomplete(buffer, frame);
  }
  return frame;
}

bool AravisFrames::FillComplete(ArvBuffer* buffer, Frame& frame) {
  const auto format = PixelFormatByCode(arv_buffer_get_image_pixel_format(buffer));
  const int width = arv_buffer_get_image_width(buffer), height = arv_buffer_get_image_height(buffer);
  std::size_t received = 0, size = 0;
  arv_buffer_get_data(buffer, &received);
  if (received > configured_.payload_bytes) return false;  // some packets were forged
  const void* data = arv_buffer_get_image_data(buffer, &size);
  gint x_padding = 0, y_padding = 0;
  arv_buffer_get_image_padding(buffer, &x_padding, &y_padding);
  BytesLayout layout;
  if (format && x_padding > 0)
    layout.row_bytes = ImageBytes(*format, width, 1) + static_cast<std::size_t>(x_padding);
  const std::size_t needed = !format                ? 0
                             : layout.row_bytes > 0 ? layout.row_bytes * static_cast<std::size_t>(height)
                                                    : ImageBytes(*format, width, height);
  if (!data || !format || width != configured_.width || height != configured_.height || size < needed) {
    if (!std::exchange(said_unexpected_, true))
      notes_.push_back(
          fmt::format("the camera sends {} bytes of {}x{} with format {:#010x}, but was set to {}x{} {}: its "
                      "frames count as incomplete",
                      size, width, height, arv_buffer_get_image_pixel_format(buffer), configured_.width,
                      configured_.height, configured_.format.name));
    return false;
  }
  frame.image = ImageFromBytes(*format, width, height, data, size, layout);
  return true;
}

// The picture is for display only. Uses the configured format, because the buffer's may be wrong.
void AravisFrames::FillIncomplete(ArvBuffer* buffer, Frame& frame) {
  std::size_t received = 0;
  const void* data = arv_buffer_get_data(buffer, &received);
  const std::size_t needed = ImageBytes(configured_.format, configured_.width, configured_.height);
  if (data && needed <= configured_.payload_bytes)
    frame.image = ImageFromBytes(configured_.format, configured_.width, configured_.height, data, needed);
}

void AravisFrames::ReadChunks(ArvBuffer* buffer, Frame& frame) {
  if (!arv_buffer_has_chunks(buffer)) {
    if (!std::exchange(said_no_chunks_, true))
      notes_.emplace_back(
          "chunk data are switched on, but the frames contain none: their exposure, gain and time are taken "
          "from the settings and the stream (chunks=off says so from the start)");
    return;
  }
  const auto real = [&](const char* name) {
    return TryCall(arv_chunk_parser_get_float_value, chunks_, buffer, name).value_or(std::nan(""));
  };
  const auto whole = [&](const char* name) {
    return TryCall(arv_chunk_parser_get_integer_value, chunks_, buffer, name).value_or(gint64{-1});
  };
  const auto has = [&](const char* chunk) {
    return std::find(configured_.chunks.begin(), configured_.chunks.end(), chunk) != configured_.chunks.end();
  };
  if (has("ExposureTime"))
    if (const double exposure = chunk_exposure_us_ * real("ChunkExposureTime"); exposure > 0)
      frame.exposure_s = 1e-6 * exposure;
  if (has("Gain") && chunk_gain_is_known_)
    if (const double gain = real("ChunkGain"); std::isfinite(gain) && (!chunk_gain_is_factor_ || gain > 0))
      frame.gain = chunk_gain_is_factor_ ? gain : std::pow(10, gain / 20);
  if (has("BlackLevel"))
    if (const double level = real("ChunkBlackLevel"); std::isfinite(level))
      frame.black_level = level / (std::pow(2.0, configured_.format.bits) - 1);
  for (const auto& [chunk, feature] :
       {std::pair("FrameID", "ChunkFrameID"), std::pair("FrameId", "ChunkFrameId"),
        std::pair("Framecounter", "ChunkFramecounter")})
    if (has(chunk))
      if (const gint64 id = whole(feature); id >= 0)
        frame.told_id = frame.id = static_cast<std::uint64_t>(id);
  if (has("LineStatusAll"))
    if (const gint64 lines = whole("ChunkLineStatusAll"); lines >= 0)
      frame.line_status = static_cast<std::uint64_t>(lines);
  if (has("Timestamp"))
    if (const gint64 ticks = whole("ChunkTimestamp"); ticks > 0)
      frame.device_time_s = tick_s_ * static_cast<double>(ticks);
}

}  // namespace ulf::acquisition
