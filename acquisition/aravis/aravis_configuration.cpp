#include "acquisition/aravis/aravis_configuration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "acquisition/aravis/aravis_automatics.h"
#include "acquisition/aravis/aravis_description.h"
#include "acquisition/aravis/aravis_link.h"
#include "acquisition/aravis/aravis_number.h"
#include "acquisition/aravis/aravis_region.h"
#include "acquisition/aravis/aravis_trigger.h"
#include "acquisition/aravis/aravis_white_balance.h"
#include "acquisition/aravis/gige_vision_probe.h"

namespace ulf::acquisition {
namespace {

// Units and back: a bound that is given exactly must not be out of range.
constexpr double kRounding = 1e-9;

double FactorOf(double decibels) { return std::pow(10.0, decibels / 20); }
double Decibels(double factor) { return 20 * std::log10(factor); }

class Configurator {
 public:
  Configurator(const AravisSession& session, std::string who)
      : session_(session), camera_(session.Camera()), who_(std::move(who)) {}

  AravisConfigured Write(const AravisOptions& options) {
    arv_camera_set_range_check_policy(camera_, ARV_RANGE_CHECK_POLICY_ENABLE);
    arv_camera_set_access_check_policy(camera_, ARV_ACCESS_CHECK_POLICY_ENABLE);
    // A killed program may have left the acquisition running.
    Try([&](GError** e) { arv_camera_stop_acquisition(camera_, e); });
    LoadUserSet(options.user_set);
    names_ = FindFeatureNames(FeaturesOf(camera_));
    if (Has("AcquisitionMode"))
      Must(who_, "continuous acquisition",
           [&](GError** e) { arv_camera_set_acquisition_mode(camera_, ARV_ACQUISITION_MODE_CONTINUOUS, e); });
    ClearAravisTriggers(session_, names_);
    StopSequencer();
    configured_.format = WriteFormat(options.format);
    WriteAravisBinning(session_, who_, options.binning);
    limits_ = WriteAravisRegion(session_, who_, options.region, configured_.format.mosaic != Mosaic::kNone);
    WriteAravisAutomatics(session_, who_, options);
    WriteExposure(options.exposure_us);
    WriteGain(options);
    WriteBlackLevel(options.black_level);
    WriteBalance(options.white_balance);
    WriteFrameRate(options.fps);
    WriteAravisTrigger(session_, who_, names_,
                       options);  // after the frame rate, because setting that switches the trigger off
    WriteChunks(options.chunks);
    WriteAravisLink(session_, who_, options, names_, configured_);
    ReadBack(options);
    return configured_;
  }

  void ReadLightInto(AravisConfigured& configured) {
    names_ = FindFeatureNames(FeaturesOf(camera_));
    configured_.format = configured.format;  // ReadBlackLevel() needs it
    ReadLight();
    // Changes nothing else, because other threads read the rest.
    configured.exposure_s = configured_.exposure_s;
    configured.gain = configured_.gain;
    configured.black_level = configured_.black_level;
  }

 private:
  // One that a killed program left running goes on to change the exposure, whatever is set.
  void StopSequencer() {
    for (const char* mode : {"SequencerConfigurationMode", "SequencerMode"})
      if (Has(mode)) SetText(mode, "Off");
  }

  bool Has(const char* feature) {
    return Maybe([&](GError** e) { return arv_camera_is_feature_available(camera_, feature, e); }, false);
  }

  template <typename Call>
  bool Can(Call&& call) {
    return Maybe([&](GError** e) { return call(camera_, e); }, false);
  }

  std::vector<std::string> Choices(const char* enumeration) {
    return MaybeNames([&](guint* count, GError** e) {
      return arv_camera_dup_available_enumerations_as_strings(camera_, enumeration, count, e);
    });
  }

  void RequireChoice(const char* option, const char* enumeration, const std::string& value) {
    const std::vector<std::string> choices = Choices(enumeration);
    if (std::find(choices.begin(), choices.end(), value) == choices.end())
      throw UsageError("{}: {}={}: the camera has {}", who_, option, value,
                       choices.empty() ? "none" : fmt::format("{}", fmt::join(choices, ", ")));
  }

  void SetText(const char* feature, const std::string& value) {
    Must(who_, fmt::format("{}={}", feature, value),
         [&](GError** e) { arv_camera_set_string(camera_, feature, value.c_str(), e); });
  }

  void LoadUserSet(const std::optional<std::string>& user_set) {
    if (!user_set) return;
    if (!Has("UserSetSelector") || !Has("UserSetLoad"))
      throw UsageError("{}: the camera keeps no user sets; leave user_set out", who_);
    RequireChoice("user_set", "UserSetSelector", *user_set);
    SetText("UserSetSelector", *user_set);
    Must(who_, "user set " + *user_set,
         [&](GError** e) { arv_camera_execute_command(camera_, "UserSetLoad", e); });
  }

  void CheckRange(const char* option, double value, double low, double high) {
    const double rounding = kRounding * std::abs(value);
    if (value < low - rounding || value > high + rounding)
      throw UsageError("{}: {}={} is out of the camera's range, {} to {}", who_, option, value, low, high);
  }
  template <typename Bound>
  void CheckRange(const char* option, double value, const char* what,
                  void (*get_bounds)(ArvCamera*, Bound*, Bound*, GError**)) {
    Bound low = 0, high = 0;
    Must(who_, what, [&](GError** e) { get_bounds(camera_, &low, &high, e); });
    CheckRange(option, value, static_cast<double>(low), static_cast<double>(high));
  }
  PixelFormat WriteFormat(const std::optional<std::string>& asked) {
    guint count = 0;
    const char** names = Must(who_, "pixel formats", [&](GError** e) {
      return arv_camera_dup_available_pixel_formats_as_strings(camera_, &count, e);
    });
    const std::vector<std::string> offered(names, names + count);
    g_free(names);
    const std::string list = fmt::format("{}", fmt::join(offered, ", "));
    const auto format = asked ? PixelFormatByName(*asked) : PreferredPixelFormat(offered);
    if (!format)
      throw Error("{}: none of the camera's pixel formats ({}) is supported; supported are {}", who_, list,
                  SupportedPixelFormats());
    const auto name = std::find_if(offered.begin(), offered.end(), [&](const std::string& candidate) {
      const auto known = PixelFormatByName(candidate);
      return known && known->code == format->code;
    });
    if (name == offered.end())
      throw UsageError("{}: the camera has no pixel format {}; it has {}", who_, format->name, list);
    Must(who_, "pixel format " + *name,
         [&](GError** e) { arv_camera_set_pixel_format_from_string(camera_, name->c_str(), e); });
    return *format;
  }

  void WriteNumber(const char* option, const AravisNumber& number, double value) {
    const auto [low, high] = number.Bounds(who_);
    CheckRange(option, value, low, high);
    number.Write(who_, value);
  }
  AravisNumber Exposure() { return {session_, names_.exposure, names_.exposure_us}; }

  void WriteExposure(std::optional<double> exposure_us) {
    if (!exposure_us) return;
    if (names_.exposure.empty())
      throw UsageError(
          "{}: the camera has no exposure in a unit of time; leave exposure_us out ('ulf features' shows "
          "what "
          "it has)",
          who_);
    if (!names_.exposure_auto.empty()) SetText(names_.exposure_auto.c_str(), "Off");
    WriteNumber("exposure_us", Exposure(), *exposure_us);
  }

  void WriteGain(const AravisOptions& options) {
    if (!options.gain_db && !options.gain_raw) return;
    if (!names_.gain_auto.empty()) SetText(names_.gain_auto.c_str(), "Off");
    if (!names_.gain_of_all.empty()) SetText(names_.gain_selector.c_str(), names_.gain_of_all);
    if (options.gain_raw) {
      if (names_.gain_raw.empty()) throw UsageError("{}: the camera has no raw gain; give gain_db", who_);
      return WriteNumber("gain_raw", {session_, names_.gain_raw}, *options.gain_raw);
    }
    if (names_.gain.empty())
      throw UsageError("{}: the camera has no gain in dB{}", who_,
                       names_.gain_raw.empty()
                           ? "; leave gain_db out"
                           : "; it has units of its own: give gain_raw ('ulf features' shows its range)");
    const AravisNumber gain(session_, names_.gain);
    if (!names_.gain_is_factor) return WriteNumber("gain_db", gain, *options.gain_db);
    const auto [low, high] = gain.Bounds(who_);
    CheckRange("gain_db", *options.gain_db, Decibels(low), Decibels(high));
    gain.Write(who_, std::clamp(FactorOf(*options.gain_db), low, high));
  }

  void WriteBlackLevel(std::optional<double> black_level) {
    if (!black_level) return;
    if (!Can(arv_camera_is_black_level_available))
      throw UsageError("{}: the camera's black level cannot be set; leave black_level out", who_);
    if (Can(arv_camera_is_black_level_auto_available))
      Must(who_, "auto black level off",
           [&](GError** e) { arv_camera_set_black_level_auto(camera_, ARV_AUTO_OFF, e); });
    CheckRange("black_level", *black_level, "black level", arv_camera_get_black_level_bounds);
    Must(who_, "black level", [&](GError** e) { arv_camera_set_black_level(camera_, *black_level, e); });
  }

  void WriteBalance(const std::optional<AravisWhiteBalance>& balance) {
    if (!balance) return;
    if (balance->by_camera) {
      if (names_.white_balance_auto.empty())
        throw UsageError("{}: the camera has no automatic white balance; give white_balance=RED,BLUE", who_);
      RequireChoice("white_balance", names_.white_balance_auto.c_str(), "Once");
      return;
    }
    if (names_.balance_ratio.empty())
      throw UsageError("{}: the camera has no ratios for red and blue; leave white_balance out", who_);
    if (!names_.white_balance_auto.empty()) SetText(names_.white_balance_auto.c_str(), "Off");
    WriteWhiteBalance(session_, who_, names_, *balance);
  }

  // Enables the chunk data that the camera offers.
  void WriteChunks(bool wanted) {
    if (!Can(arv_camera_are_chunks_available)) {
      if (wanted) throw UsageError("{}: the camera adds no data to its frames; leave chunks out", who_);
      return;
    }
    Must(who_, "chunk data", [&](GError** e) { arv_camera_set_chunk_mode(camera_, wanted, e); });
    if (!wanted) return;
    for (const std::string& offered : Choices("ChunkSelector"))
      for (const char* useful : {"ExposureTime", "Gain", "BlackLevel", "FrameID", "FrameId", "Framecounter",
                                 "Timestamp", "LineStatusAll"})
        if (offered == useful &&
            Maybe([&](GError** e) { return arv_camera_set_chunk_state(camera_, useful, TRUE, e), true; },
                  false))
          configured_.chunks.push_back(offered);
    if (configured_.chunks.empty())
      configured_.notes.emplace_back("offers no useful chunk data (exposure, gain, number, time)");
  }

  void WriteFrameRate(std::optional<double> fps) {
    if (!fps) return;
    if (!Can(arv_camera_is_frame_rate_available))
      throw UsageError("{}: the camera's frame rate cannot be set; leave fps out", who_);
    CheckRange("fps", *fps, "frame rate", arv_camera_get_frame_rate_bounds);
    Must(who_, "frame rate", [&](GError** e) { arv_camera_set_frame_rate(camera_, *fps, e); });
  }

  void ReadWindow() {
    SensorWindow& window = configured_.window;
    window.binning_x =
        ReductionOf(session_, "BinningHorizontal") * ReductionOf(session_, "DecimationHorizontal");
    window.binning_y = ReductionOf(session_, "BinningVertical") * ReductionOf(session_, "DecimationVertical");
    gint x = 0, y = 0;
    Must(who_, "region", [&](GError** e) {
      arv_camera_get_region(camera_, &x, &y, &configured_.width, &configured_.height, e);
    });
    // A camera that does not report its sensor's size reports the largest image.
    const auto full_size = [&](const char* of_sensor, const char* of_image, int binning, int largest) {
      const auto read = [&](const char* feature) {
        return Has(feature)
                   ? Maybe([&](GError** e) { return arv_camera_get_integer(camera_, feature, e); }, gint64{0})
                   : 0;
      };
      const auto sensor = static_cast<int>(read(of_sensor)), image = static_cast<int>(read(of_image));
      return sensor > 0 ? sensor : binning * (image > 0 ? image : largest);
    };
    window.x = x * window.binning_x;
    window.y = y * window.binning_y;
    window.width = configured_.width * window.binning_x;
    window.height = configured_.height * window.binning_y;
    window.sensor_width = full_size("SensorWidth", "WidthMax", window.binning_x, limits_.width);
    window.sensor_height = full_size("SensorHeight", "HeightMax", window.binning_y, limits_.height);
  }

  // A share of the pixel format's full scale, or a percentage where the camera gives that unit.
  void ReadBlackLevel() {
    if (!Can(arv_camera_is_black_level_available)) return;
    const double value = Maybe([&](GError** e) { return arv_camera_get_black_level(camera_, e); }, 0.0);
    ArvGcNode* node = arv_device_get_feature(session_.Device(), "BlackLevel");
    const bool percent = ARV_IS_GC_FLOAT(node) &&
                         Text(arv_gc_float_get_unit(ARV_GC_FLOAT(node))).find('%') != std::string::npos;
    configured_.black_level = value / (percent ? 100 : std::pow(2.0, configured_.format.bits) - 1);
  }

  double ReadExposureSeconds() { return 1e-6 * Exposure().Read().value_or(0); }
  // 1: unknown.
  double ReadGain() {
    const std::optional<double> value = AravisNumber(session_, names_.gain).Read();
    if (!value || (names_.gain_is_factor && *value <= 0)) return 1;
    return names_.gain_is_factor ? *value : FactorOf(*value);
  }

  // Exposure and gain of every frame; 0 and 1 (unknown) while an automatic controls them.
  void ReadLight() {
    ReadBlackLevel();
    const bool auto_exposure =
        Can(arv_camera_is_exposure_auto_available) &&
        Maybe([&](GError** e) { return arv_camera_get_exposure_time_auto(camera_, e); }, ARV_AUTO_OFF) !=
            ARV_AUTO_OFF;
    configured_.exposure_s = auto_exposure ? 0 : ReadExposureSeconds();
    const bool auto_gain =
        Can(arv_camera_is_gain_auto_available) &&
        Maybe([&](GError** e) { return arv_camera_get_gain_auto(camera_, e); }, ARV_AUTO_OFF) != ARV_AUTO_OFF;
    configured_.gain = auto_gain ? 1 : ReadGain();
  }

  // Notes a setting that the camera changed by more than its own step, and by more than this share. Guessed:
  // cameras round exposure times and frame rates.
  static constexpr double kSameShare = 0.02;
  void Compare(const char* option, double asked, double reads, double own_step) {
    if (std::abs(reads - asked) > std::max(1.001 * own_step, kSameShare * std::abs(asked)))
      configured_.notes.push_back(fmt::format("changed {}={:g} to {:g}", option, asked, reads));
  }

  void CompareGain(double asked_db) {
    const AravisNumber gain(session_, names_.gain);
    const double reads = gain.Read().value_or(0);
    if (!names_.gain_is_factor) return Compare("gain_db", asked_db, reads, gain.Step());
    Compare("gain_db", asked_db, Decibels(reads), Decibels(reads + gain.Step()) - Decibels(reads));
  }

  void CompareWhiteBalance(const AravisWhiteBalance& asked) {
    const auto reads = ReadWhiteBalance(session_, names_);
    const double step = WhiteBalanceStep(session_, names_);
    Compare("white_balance (red)", asked.red, reads ? reads->red : 0, step);
    Compare("white_balance (blue)", asked.blue, reads ? reads->blue : 0, step);
  }

  // A camera that mirrors or crops its image may shift the mosaic and then change the format's name.
  void ReadFormat() {
    const auto now = PixelFormatByName(
        Text(Maybe([&](GError** e) { return arv_camera_get_pixel_format_as_string(camera_, e); },
                   static_cast<const char*>(nullptr))));
    if (!now || now->code == configured_.format.code) return;
    configured_.notes.push_back(fmt::format("sends {} in place of {}", now->name, configured_.format.name));
    configured_.format = *now;
  }

  void ReadBack(const AravisOptions& options) {
    ReadFormat();
    ReadWindow();
    ReadLight();
    configured_.payload_bytes =
        Must(who_, "payload", [&](GError** e) { return arv_camera_get_payload(camera_, e); });
    const double exposure_s = ReadExposureSeconds();
    const double fps = Maybe([&](GError** e) { return arv_camera_get_frame_rate(camera_, e); }, 0.0);
    configured_.period_s = std::max(fps > 0 ? 1 / fps : 0, exposure_s);
    if (options.fps) Compare("fps", *options.fps, fps, 0);
    if (options.exposure_us)
      Compare("exposure_us", *options.exposure_us, 1e6 * exposure_s, Exposure().Step());
    if (options.gain_db) CompareGain(*options.gain_db);
    if (options.gain_raw)
      Compare("gain_raw", *options.gain_raw, AravisNumber(session_, names_.gain_raw).Read().value_or(0), 0);
    if (options.black_level)
      Compare("black_level", *options.black_level,
              Maybe([&](GError** e) { return arv_camera_get_black_level(camera_, e); }, 0.0),
              AravisNumber(session_, Has("BlackLevel") ? "BlackLevel" : "").Step());
    if (options.white_balance && !options.white_balance->by_camera)
      CompareWhiteBalance(*options.white_balance);
    const SensorWindow& window = configured_.window;
    if (const auto& asked = options.region;
        asked && (configured_.width != asked->width || configured_.height != asked->height ||
                  window.x != asked->x * window.binning_x || window.y != asked->y * window.binning_y))
      configured_.notes.push_back(fmt::format(
          "changed roi={}x{}+{}+{} to {}x{}+{}+{}", asked->width, asked->height, asked->x, asked->y,
          configured_.width, configured_.height, window.x / window.binning_x, window.y / window.binning_y));
  }

  const AravisSession& session_;
  ArvCamera* camera_;
  std::string who_;
  FeatureNames names_;
  AravisImageLimits limits_;
  AravisConfigured configured_;
};

}  // namespace

AravisConfigured ConfigureAravis(const AravisSession& session, const std::string& who,
                                 const AravisOptions& options) {
  return Configurator(session, who).Write(options);
}

void ReadLight(const AravisSession& session, const std::string& who, AravisConfigured& configured) {
  Configurator(session, who).ReadLightInto(configured);
}

void SwitchChunksOff(const AravisSession& session, const std::string& who, AravisConfigured& configured) {
  ArvCamera* camera = session.Camera();
  Must(who, "chunk data off", [&](GError** e) { arv_camera_set_chunk_mode(camera, FALSE, e); });
  configured.chunks.clear();
  configured.payload_bytes =
      Must(who, "payload", [&](GError** e) { return arv_camera_get_payload(camera, e); });
}

}  // namespace ulf::acquisition
