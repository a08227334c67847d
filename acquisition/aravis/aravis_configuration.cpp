#include "acquisition/aravis/aravis_configuration.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "acquisition/aravis/gige_vision_probe.h"

namespace ulf {
namespace {

// On this computer: with its headers just within 8 KiB, the block that the kernel gives it. A larger packet
// takes 16 KiB of the receive buffer, which then holds half as much (at 9000, one stream in ten began with a
// loss).
constexpr int kLocalPacketSize = 7800;

class Configurator {
 public:
  Configurator(const AravisSession& session, std::string who)
      : session_(session), camera_(session.Camera()), who_(std::move(who)) {}

  AravisConfigured Write(const AravisOptions& options) {
    arv_camera_set_range_check_policy(camera_, ARV_RANGE_CHECK_POLICY_ENABLE);
    arv_camera_set_access_check_policy(camera_, ARV_ACCESS_CHECK_POLICY_ENABLE);
    Try([&](GError** e) {
      arv_camera_stop_acquisition(camera_, e);
    });  // a killed program may have left it running
    Try([&](GError** e) { arv_camera_clear_triggers(camera_, e); });
    if (Has("AcquisitionMode"))
      Must(who_, "continuous acquisition",
           [&](GError** e) { arv_camera_set_acquisition_mode(camera_, ARV_ACQUISITION_MODE_CONTINUOUS, e); });
    AravisConfigured configured;
    configured.format = WriteFormat(options.format);
    WriteRegion(options.region);
    WriteExposure(options.exposure_us);
    WriteGain(options.gain_db);
    WriteFrameRate(options.fps);
    if (!session_.GigeAddress().empty()) WritePackets(session_.GigeAddress(), options.packet_size);
    ReadBack(configured);
    return configured;
  }

 private:
  bool Has(const char* feature) {
    return Maybe([&](GError** e) { return arv_camera_is_feature_available(camera_, feature, e); }, false);
  }

  void CheckRange(const char* option, double value, double low, double high) {
    if (value < low || value > high)
      throw Error("{}: {}={} is outside what the camera can do, {} to {}", who_, option, value, low, high);
  }

  PixelFormat WriteFormat(const std::optional<std::string>& asked) {
    guint count = 0;
    const char** names = Must(who_, "pixel formats", [&](GError** e) {
      return arv_camera_dup_available_pixel_formats_as_strings(camera_, &count, e);
    });
    const std::vector<std::string> offered(names, names + count);
    g_free(names);
    std::string list;
    for (const std::string& name : offered) list += (list.empty() ? "" : ", ") + name;

    const auto format = asked ? PixelFormatByName(*asked) : PreferredPixelFormat(offered);
    if (!format)
      throw Error("{}: none of the camera's pixel formats ({}) is supported; supported are {}", who_, list,
                  SupportedPixelFormats());
    const auto name = std::find_if(offered.begin(), offered.end(), [&](const std::string& candidate) {
      const auto known = PixelFormatByName(candidate);
      return known && known->code == format->code;
    });
    if (name == offered.end())
      throw Error("{}: the camera has no pixel format {}; it has {}", who_, format->name, list);
    Must(who_, "pixel format " + *name,
         [&](GError** e) { arv_camera_set_pixel_format_from_string(camera_, name->c_str(), e); });
    return *format;
  }

  void WriteRegion(const std::optional<AravisRegion>& asked) {
    if (Maybe([&](GError** e) { return arv_camera_is_binning_available(camera_, e); }, false))
      Try([&](GError** e) { arv_camera_set_binning(camera_, 1, 1, e); });
    // Offsets first to zero: they limit what the sizes may be.
    if (Maybe([&](GError** e) { return arv_camera_is_region_offset_available(camera_, e); }, false)) {
      Try([&](GError** e) { arv_camera_set_integer(camera_, "OffsetX", 0, e); });
      Try([&](GError** e) { arv_camera_set_integer(camera_, "OffsetY", 0, e); });
    }
    gint low = 0, max_width = 0, max_height = 0;
    Must(who_, "width", [&](GError** e) { arv_camera_get_width_bounds(camera_, &low, &max_width, e); });
    Must(who_, "height", [&](GError** e) { arv_camera_get_height_bounds(camera_, &low, &max_height, e); });
    if (!asked) {
      Must(who_, "whole sensor",
           [&](GError** e) { arv_camera_set_region(camera_, -1, -1, max_width, max_height, e); });
      return;
    }
    if (asked->x + asked->width > max_width || asked->y + asked->height > max_height)
      throw Error("{}: roi={}x{}+{}+{} reaches beyond the sensor of {}x{}", who_, asked->width, asked->height,
                  asked->x, asked->y, max_width, max_height);
    Must(who_, "roi", [&](GError** e) {
      arv_camera_set_region(camera_, asked->x, asked->y, asked->width, asked->height, e);
    });
  }

  void WriteExposure(std::optional<double> exposure_us) {
    if (!exposure_us) return;
    if (!Maybe([&](GError** e) { return arv_camera_is_exposure_time_available(camera_, e); }, false))
      throw Error("{}: the camera's exposure cannot be set; leave exposure_us out", who_);
    if (Maybe([&](GError** e) { return arv_camera_is_exposure_auto_available(camera_, e); }, false))
      Must(who_, "auto exposure off",
           [&](GError** e) { arv_camera_set_exposure_time_auto(camera_, ARV_AUTO_OFF, e); });
    double low = 0, high = 0;
    Must(who_, "exposure", [&](GError** e) { arv_camera_get_exposure_time_bounds(camera_, &low, &high, e); });
    CheckRange("exposure_us", *exposure_us, low, high);
    Must(who_, "exposure", [&](GError** e) { arv_camera_set_exposure_time(camera_, *exposure_us, e); });
  }

  void WriteGain(std::optional<double> gain_db) {
    if (!gain_db) return;
    if (!Has("Gain"))
      throw Error("{}: the camera has no gain in dB (at most a raw number of its own); leave gain_db out",
                  who_);
    if (Maybe([&](GError** e) { return arv_camera_is_gain_auto_available(camera_, e); }, false))
      Must(who_, "auto gain off", [&](GError** e) { arv_camera_set_gain_auto(camera_, ARV_AUTO_OFF, e); });
    double low = 0, high = 0;
    Must(who_, "gain", [&](GError** e) { arv_camera_get_gain_bounds(camera_, &low, &high, e); });
    CheckRange("gain_db", *gain_db, low, high);
    Must(who_, "gain", [&](GError** e) { arv_camera_set_gain(camera_, *gain_db, e); });
  }

  void WriteFrameRate(std::optional<double> fps) {
    if (!fps) return;
    if (!Maybe([&](GError** e) { return arv_camera_is_frame_rate_available(camera_, e); }, false))
      throw Error("{}: the camera's frame rate cannot be set; leave fps out", who_);
    double low = 0, high = 0;
    Must(who_, "frame rate", [&](GError** e) { arv_camera_get_frame_rate_bounds(camera_, &low, &high, e); });
    CheckRange("fps", *fps, low, high);
    Must(who_, "frame rate", [&](GError** e) { arv_camera_set_frame_rate(camera_, *fps, e); });
  }

  void WritePackets(const std::string& address, std::optional<int> packet_size) {
    if (PacketSocketWouldMishear(address))
      arv_camera_gv_set_stream_options(camera_, ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED);
    if (!packet_size && address.starts_with("127.")) packet_size = kLocalPacketSize;
    if (packet_size) {
      arv_camera_gv_set_packet_size_adjustment(camera_, ARV_GV_PACKET_SIZE_ADJUSTMENT_NEVER);
      Must(who_, "packet size", [&](GError** e) { arv_camera_gv_set_packet_size(camera_, *packet_size, e); });
    } else {
      Try([&](GError** e) {
        arv_camera_gv_auto_packet_size(camera_, e);
      });  // not every camera sends test packets
    }
  }

  void ReadBack(AravisConfigured& configured) {
    gint x = 0, y = 0;
    Must(who_, "region", [&](GError** e) {
      arv_camera_get_region(camera_, &x, &y, &configured.width, &configured.height, e);
    });
    configured.payload_bytes =
        Must(who_, "payload", [&](GError** e) { return arv_camera_get_payload(camera_, e); });
    const bool auto_exposure =
        Maybe([&](GError** e) { return arv_camera_is_exposure_auto_available(camera_, e); }, false) &&
        Maybe([&](GError** e) { return arv_camera_get_exposure_time_auto(camera_, e); }, ARV_AUTO_OFF) !=
            ARV_AUTO_OFF;
    const double exposure_s =
        1e-6 * Maybe([&](GError** e) { return arv_camera_get_exposure_time(camera_, e); }, 0.0);
    if (!auto_exposure) configured.exposure_s = exposure_s;
    const bool auto_gain =
        Maybe([&](GError** e) { return arv_camera_is_gain_auto_available(camera_, e); }, false) &&
        Maybe([&](GError** e) { return arv_camera_get_gain_auto(camera_, e); }, ARV_AUTO_OFF) != ARV_AUTO_OFF;
    if (Has("Gain") && !auto_gain)
      configured.gain =
          std::pow(10.0, Maybe([&](GError** e) { return arv_camera_get_gain(camera_, e); }, 0.0) / 20.0);
    const double fps = Maybe([&](GError** e) { return arv_camera_get_frame_rate(camera_, e); }, 0.0);
    configured.period_s = std::max(fps > 0 ? 1 / fps : 0, exposure_s);
  }

  const AravisSession& session_;
  ArvCamera* camera_;
  std::string who_;
};

}  // namespace

AravisConfigured ConfigureAravis(const AravisSession& session, const std::string& who,
                                 const AravisOptions& options) {
  return Configurator(session, who).Write(options);
}

}  // namespace ulf
