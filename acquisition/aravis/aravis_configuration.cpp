#include "acquisition/aravis/aravis_configuration.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "acquisition/aravis/aravis_automatics.h"
#include "acquisition/aravis/aravis_description.h"
#include "acquisition/aravis/aravis_link.h"
#include "acquisition/aravis/aravis_region.h"
#include "acquisition/aravis/aravis_setting.h"
#include "acquisition/aravis/aravis_trigger.h"
#include "acquisition/aravis/aravis_white_balance.h"
#include "acquisition/gige_vision/gige_vision_probe.h"

namespace ulf::acquisition {
namespace {

// Units and back: a bound that is given exactly must not be out of range.
constexpr double kRounding = 1e-9;

// What lets a frame rate be set, and how. The last is Point Grey's.
constexpr std::array kRateSwitches{std::pair{"AcquisitionFrameRateEnable", AutomaticMode::kOn},
                                   std::pair{"AcquisitionFrameRateEnabled", AutomaticMode::kOn},
                                   std::pair{"AcquisitionFrameRateAuto", AutomaticMode::kOff}};

// Bytes that chunk data may take where the camera does not tell. Guessed: few chunks of some ten each.
constexpr std::size_t kChunkRoom = 4096;
constexpr double kMostPayload = 1 << 30;  // of what is told; guessed

double FactorOf(double decibels) { return std::pow(10.0, decibels / 20); }
double Decibels(double factor) { return 20 * std::log10(factor); }

// Makes room for a frame: what the camera tells, or the image where that is more. Returns what is wrong with
// the description; empty: nothing.
std::string ReadPayload(const AravisSession& session, AravisConfigured& configured) {
  const double told = AravisNumber(session, "PayloadSize").Read().value_or(0);
  const std::size_t image = ImageBytes(configured.format, configured.width, configured.height);
  const bool has_chunks = ReadSetting(session, "ChunkModeActive") == "true";
  const auto told_bytes = static_cast<std::size_t>(
      std::clamp(told, 0.0, std::max(kMostPayload, 2.0 * static_cast<double>(image))));
  configured.payload_bytes = told_bytes;
  if (told_bytes >= image + (has_chunks ? 1 : 0)) return "";
  configured.payload_bytes = image + (has_chunks ? kChunkRoom : 0);
  return fmt::format(
      "says that a frame has {} bytes (PayloadSize), but {}x{} of {} are {}{}: its description is wrong, "
      "and ulf makes room for {}",
      told_bytes, configured.width, configured.height, configured.format.name, image,
      has_chunks ? " without chunk data" : "", configured.payload_bytes);
}

class Configurator {
 public:
  Configurator(const AravisSession& session, std::string who)
      : session_(session), camera_(session.Camera()), who_(std::move(who)) {}

  AravisConfigured Write(const AravisOptions& options) {
    arv_camera_set_range_check_policy(camera_, ARV_RANGE_CHECK_POLICY_ENABLE);
    arv_camera_set_access_check_policy(camera_, ARV_ACCESS_CHECK_POLICY_ENABLE);
    // A killed program may have left the acquisition running.
    FailureOf(arv_camera_stop_acquisition, camera_);
    LoadUserSet(options.user_set);
    names_ = FindFeatureNames(FeaturesOf(camera_));
    if (session_.Has("AcquisitionMode")) Prefer("AcquisitionMode", "Continuous");
    ClearAravisTriggers(session_, names_);
    if (!options.Triggered() && ReadSetting(session_, names_.trigger_mode) == "On")
      Note("waits for triggers: TriggerMode stays On");
    // A sequencer that a killed program left running goes on to change the exposure, whatever is set.
    for (const char* mode : {"SequencerConfigurationMode", "SequencerMode"})
      if (session_.Has(mode)) Prefer(mode, "Off");
    configured_.format = WriteFormat(options.format);
    WriteAravisBinning(session_, who_, options.binning);
    limits_ = WriteAravisRegion(session_, who_, options.region, configured_.format.mosaic != Mosaic::kNone,
                                configured_.notes);
    for (std::string& note : WriteAravisAutomatics(session_, who_, options)) Note(std::move(note));
    WriteExposure(options.exposure_us);
    WriteGain(options);
    WriteBlackLevel(options.black_level);
    WriteBalance(options.white_balance);
    WriteFrameRate(options.fps);
    // After the frame rate, because setting that may switch the trigger off.
    for (std::string& note : WriteAravisTrigger(session_, who_, names_, options)) Note(std::move(note));
    WriteChunks(options.chunks);
    configured_.link = WriteAravisLink(session_, who_, options, names_, configured_.notes);
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
  template <typename Call>
  bool Can(Call&& call) {
    return TryCall(call, camera_).value_or(false);
  }

  void Note(std::string note) {
    auto& notes = configured_.notes;
    if (!note.empty() && std::find(notes.begin(), notes.end(), note) == notes.end())
      notes.push_back(std::move(note));
  }

  // What ulf would rather have, and nobody asked for by name: where it is fixed it is taken as it is.
  void Prefer(const std::string& feature, const std::string& value) {
    if (const std::string why = WriteSetting(session_, feature, value); !why.empty())
      Note(fmt::format("is taken as it is: {}", why));
  }
  void SwitchOff(const std::string& asked, const char* automatic) {
    const std::string said = SwitchOffFor(session_, who_, asked, automatic);
    if (ModeOf(session_, automatic) != AutomaticMode::kUnknown) Note(said);  // else it is said already
  }

  void LoadUserSet(const std::optional<std::string>& user_set) {
    if (!user_set) return;
    if (!session_.Has("UserSetSelector") || !session_.Has("UserSetLoad"))
      throw Refused(who_, "the camera keeps no user sets", "leave user_set out");
    const std::string asked = "user_set=" + *user_set;
    if (const auto choices = session_.Choices("UserSetSelector");
        std::ranges::find(choices, *user_set) == choices.end())
      throw NoSuchChoice(who_, asked, choices);
    RequireSetting(session_, who_, asked, "UserSetSelector", *user_set);
    CallOrThrow(who_, "user set " + *user_set, arv_camera_execute_command, camera_, "UserSetLoad");
  }

  void CheckRange(const char* option, double value, double low, double high) {
    const double rounding = kRounding * std::abs(value);
    if (value < low - rounding || value > high + rounding)
      throw Refused(who_,
                    fmt::format("{}={} is out of the camera's range, {} to {}", option, value, low, high));
  }
  PixelFormat WriteFormat(const std::optional<std::string>& asked) {
    guint count = 0;
    const char** names = CallOrThrow(who_, "pixel formats", arv_camera_dup_available_pixel_formats_as_strings,
                                     camera_, &count);
    const std::vector<std::string> offered(names, names + count);
    g_free(names);
    const std::string list = fmt::format("{}", fmt::join(offered, ", "));
    if (offered.empty() && !asked)
      if (const auto fixed = PixelFormatByCode(TryCall(arv_camera_get_pixel_format, camera_).value_or(0)))
        return *fixed;
    const auto format = asked ? PixelFormatByName(*asked) : PreferredPixelFormat(offered);
    if (!format)
      throw Error("{}: none of the camera's pixel formats ({}) is supported; supported are {}", who_, list,
                  SupportedPixelFormats());
    const auto name = std::find_if(offered.begin(), offered.end(), [&](const std::string& candidate) {
      const auto known = PixelFormatByName(candidate);
      return known && known->code == format->code;
    });
    if (name == offered.end())
      throw Refused(who_, fmt::format("the camera has no pixel format {}", format->name),
                    fmt::format("it has {}", list));
    const std::string why = WriteSetting(session_, "PixelFormat", *name);
    if (why.empty()) return *format;
    if (asked) throw Refused(who_, fmt::format("format={}: {}", *asked, why), "leave format out");
    const std::optional<std::string> reads = ReadSetting(session_, "PixelFormat");
    const auto fixed = reads ? PixelFormatByName(*reads) : std::nullopt;
    if (!fixed)
      throw Error("{}: {}, which is not supported; supported are {}", who_, why, SupportedPixelFormats());
    Note(fmt::format("sends {}: {}", fixed->name, why));
    return *fixed;
  }

  // `option_of`: the option's value for one of the number's.
  template <typename OptionOf>
  void WriteNumber(const char* option, const AravisNumber& number, double value, OptionOf&& option_of) {
    if (number.Reads(value)) return;
    if (const std::string why = number.WhyFixed(); !why.empty()) {
      const std::optional<double> reads = number.Read();
      throw Refused(who_,
                    fmt::format("{}={:g}: {} {}{}", option, option_of(value), number.Feature(), why,
                                reads ? fmt::format(" at {:g}", option_of(*reads)) : ""),
                    fmt::format("leave {} out", option));
    }
    const auto [low, high] = number.Bounds(who_);
    CheckRange(option, option_of(value), option_of(low), option_of(high));
    number.Write(who_, std::clamp(value, low, high));
  }
  void WriteNumber(const char* option, const AravisNumber& number, double value) {
    WriteNumber(option, number, value, [](double of_number) { return of_number; });
  }
  AravisNumber Exposure() { return {session_, names_.exposure, names_.exposure_us}; }

  void WriteExposure(std::optional<double> exposure_us) {
    if (!exposure_us) return;
    if (names_.exposure.empty())
      throw Refused(who_, "the camera has no exposure in a unit of time",
                    "leave exposure_us out ('ulf features' shows what it has)");
    SwitchOff(fmt::format("exposure_us={:g}", *exposure_us), "ExposureAuto");
    WriteNumber("exposure_us", Exposure(), *exposure_us);
  }

  void WriteGain(const AravisOptions& options) {
    if (!options.gain_db && !options.gain_raw) return;
    SwitchOff(options.gain_raw ? fmt::format("gain_raw={}", *options.gain_raw)
                               : fmt::format("gain_db={:g}", *options.gain_db),
              "GainAuto");
    if (!names_.gain_of_all.empty()) Prefer(names_.gain_selector, names_.gain_of_all);
    if (options.gain_raw) {
      if (names_.gain_raw.empty()) throw Refused(who_, "the camera has no raw gain", "give gain_db");
      return WriteNumber("gain_raw", {session_, names_.gain_raw}, *options.gain_raw);
    }
    if (names_.gain.empty())
      throw Refused(
          who_,
          fmt::format("the camera has no gain in dB{}",
                      names_.gain_raw.empty()
                          ? "; leave gain_db out"
                          : "; it has units of its own: give gain_raw ('ulf features' shows its range)"));
    const AravisNumber gain(session_, names_.gain);
    if (!names_.gain_is_factor) return WriteNumber("gain_db", gain, *options.gain_db);
    WriteNumber("gain_db", gain, FactorOf(*options.gain_db), Decibels);
  }

  void WriteBlackLevel(std::optional<double> black_level) {
    if (!black_level) return;
    if (!Can(arv_camera_is_black_level_available))
      throw Refused(who_, "the camera's black level cannot be set", "leave black_level out");
    SwitchOff(fmt::format("black_level={:g}", *black_level), "BlackLevelAuto");
    // In the library's order, which is asked for the value.
    for (const char* name : {"Brightness", "BlackLevelRaw", "BlackLevel"})
      if (session_.Has(name)) return WriteNumber("black_level", {session_, name}, *black_level);
  }

  void WriteBalance(const std::optional<AravisWhiteBalance>& balance) {
    if (!balance) return;
    if (balance->by_camera) {
      if (names_.white_balance_auto.empty())
        throw Refused(who_, "the camera has no automatic white balance", "give white_balance=RED,BLUE");
      if (WordFor(session_, names_.white_balance_auto, AutomaticMode::kOnce).empty())
        throw Refused(who_,
                      fmt::format("white_balance=auto: the camera has {}",
                                  fmt::join(session_.Choices(names_.white_balance_auto), ", ")),
                      "give white_balance=RED,BLUE");
      return;
    }
    if (names_.balance_ratio.empty())
      throw Refused(who_, "the camera has no ratios for red and blue", "leave white_balance out");
    SwitchOff(fmt::format("white_balance={:g},{:g}", balance->red, balance->blue), "BalanceWhiteAuto");
    WriteWhiteBalance(session_, who_, names_, *balance);
  }

  // Enables the chunk data that the camera offers.
  void WriteChunks(bool wanted) {
    if (!Can(arv_camera_are_chunks_available)) {
      if (wanted) throw Refused(who_, "the camera adds no data to its frames", "leave chunks out");
      return;
    }
    if (!wanted) return Prefer("ChunkModeActive", "false");
    RequireSetting(session_, who_, "chunks=on", "ChunkModeActive", "true");
    for (const std::string& offered : session_.Choices("ChunkSelector"))
      for (const char* useful : {"ExposureTime", "Gain", "BlackLevel", "FrameID", "FrameId", "Framecounter",
                                 "Timestamp", "LineStatusAll"})
        if (offered == useful && WriteSetting(session_, "ChunkSelector", offered).empty() &&
            WriteSetting(session_, "ChunkEnable", "true").empty())
          configured_.chunks.push_back(offered);
    if (configured_.chunks.empty())
      configured_.notes.emplace_back("offers no useful chunk data (exposure, gain, number, time)");
  }

  void WriteFrameRate(std::optional<double> fps) {
    if (!fps) return;
    if (session_.Has("FPS")) return WriteListedRate(*fps);
    const AravisNumber rate = Rate();
    if (!rate.IsThere()) throw Refused(who_, "the camera's frame rate cannot be set", "leave fps out");
    const std::string why = EnableRate(rate, *fps);
    if (!why.empty() && !rate.Reads(*fps) && !rate.WhyFixed().empty())
      throw Refused(who_,
                    fmt::format("fps={:g}: {} {}, because {}", *fps, rate.Feature(), rate.WhyFixed(), why),
                    "leave fps out");
    WriteNumber("fps", rate, *fps);
  }

  // The Imaging Source's, which may be a list of rates: the library knows it.
  void WriteListedRate(double fps) {
    double low = 0, high = 0;
    CallOrThrow(who_, "frame rate", arv_camera_get_frame_rate_bounds, camera_, &low, &high);
    CheckRange("fps", fps, low, high);
    CallOrThrow(who_, "frame rate", arv_camera_set_frame_rate, camera_, fps);
  }

  // Also one that is not available at this moment: its switch may be off.
  AravisNumber Rate() {
    for (const char* name : {"AcquisitionFrameRate", "AcquisitionFrameRateAbs"})
      if (TryCall(arv_camera_is_feature_implemented, camera_, name).value_or(false)) return {session_, name};
    return {};
  }

  // A rate is available, can be written or is kept only while its switch lets it. Most are to be on, some
  // off. Returns why one could not be switched.
  std::string EnableRate(const AravisNumber& rate, double fps) {
    const auto is_free = [&] { return rate.WhyFixed().empty(); };
    std::string why;
    for (const auto& [name, mode] : kRateSwitches)
      if (std::string refused = SwitchAutomatic(session_, name, mode); !refused.empty()) why = refused;
    for (const auto& [name, mode] : kRateSwitches) {
      if (is_free() || rate.Reads(fps)) break;
      const AutomaticMode before = ModeOf(session_, name);
      if (before != AutomaticMode::kOn && before != AutomaticMode::kOff) continue;
      SwitchAutomatic(session_, name,
                      before == AutomaticMode::kOn ? AutomaticMode::kOff : AutomaticMode::kOn);
      if (!is_free()) SwitchAutomatic(session_, name, before);
    }
    return why;
  }

  void ReadWindow() {
    SensorWindow& window = configured_.window;
    window.binning_x =
        ReductionOf(session_, "BinningHorizontal") * ReductionOf(session_, "DecimationHorizontal");
    window.binning_y = ReductionOf(session_, "BinningVertical") * ReductionOf(session_, "DecimationVertical");
    gint x = 0, y = 0;
    CallOrThrow(who_, "region", arv_camera_get_region, camera_, &x, &y, &configured_.width,
                &configured_.height);
    // A camera that does not report its sensor's size reports the largest image, which tells nothing where it
    // is the present one: its size may be fixed.
    const auto full_size = [&](const char* of_sensor, const char* of_image, int binning, int end, int limit) {
      const auto read = [&](const char* feature) {
        return session_.Has(feature) ? TryCall(arv_camera_get_integer, camera_, feature).value_or(0) : 0;
      };
      const auto sensor = static_cast<int>(read(of_sensor)), image = static_cast<int>(read(of_image));
      return sensor > 0 ? sensor : binning * (image > end ? image : std::max(end, limit));
    };
    window.x = x * window.binning_x;
    window.y = y * window.binning_y;
    window.width = configured_.width * window.binning_x;
    window.height = configured_.height * window.binning_y;
    window.sensor_width =
        full_size("SensorWidth", "WidthMax", window.binning_x, x + configured_.width, limits_.width);
    window.sensor_height =
        full_size("SensorHeight", "HeightMax", window.binning_y, y + configured_.height, limits_.height);
  }

  // A share of the pixel format's full scale, or a percentage where the camera gives that unit.
  void ReadBlackLevel() {
    if (!Can(arv_camera_is_black_level_available)) return;
    const double value = TryCall(arv_camera_get_black_level, camera_).value_or(0.0);
    ArvGcNode* node = session_.Node("BlackLevel");
    const bool percent = ARV_IS_GC_FLOAT(node) &&
                         Text(arv_gc_float_get_unit(ARV_GC_FLOAT(node))).find('%') != std::string::npos;
    configured_.black_level = value / (percent ? 100 : std::pow(2.0, configured_.format.bits) - 1);
  }

  double ReadExposureSeconds() { return 1e-6 * Exposure().Read().value_or(0); }
  // 1 stands for an unknown gain.
  double ReadGain() {
    const std::optional<double> value = AravisNumber(session_, names_.gain).Read();
    if (!value || (names_.gain_is_factor && *value <= 0)) return 1;
    return names_.gain_is_factor ? *value : FactorOf(*value);
  }

  // Reads exposure and gain of every frame; 0 and 1 (unknown) while an automatic controls them.
  void ReadLight() {
    ReadBlackLevel();
    configured_.exposure_s = IsAutomaticOn(session_, "ExposureAuto") ? 0 : ReadExposureSeconds();
    configured_.gain = IsAutomaticOn(session_, "GainAuto") ? 1 : ReadGain();
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
    const auto now =
        PixelFormatByName(Text(TryCall(arv_camera_get_pixel_format_as_string, camera_).value_or(nullptr)));
    if (!now || now->code == configured_.format.code) return;
    configured_.notes.push_back(fmt::format("sends {} in place of {}", now->name, configured_.format.name));
    configured_.format = *now;
  }

  void ReadBack(const AravisOptions& options) {
    ReadFormat();
    ReadWindow();
    ReadLight();
    Note(ReadPayload(session_, configured_));
    const double exposure_s = ReadExposureSeconds();
    const double fps = Rate().Read().value_or(TryCall(arv_camera_get_frame_rate, camera_).value_or(0.0));
    configured_.period_s = std::max(fps > 0 ? 1 / fps : 0, exposure_s);
    const bool is_switched_off =
        std::any_of(kRateSwitches.begin(), kRateSwitches.end(), [&](const auto& each) {
          return each.second == AutomaticMode::kOn && ModeOf(session_, each.first) == AutomaticMode::kOff;
        });
    if (fps > 0 && (options.fps || !is_switched_off)) configured_.set_fps = fps;
    if (options.fps) Compare("fps", *options.fps, fps, 0);
    if (options.exposure_us)
      Compare("exposure_us", *options.exposure_us, 1e6 * exposure_s, Exposure().Step());
    if (options.gain_db) CompareGain(*options.gain_db);
    if (options.gain_raw)
      Compare("gain_raw", *options.gain_raw, AravisNumber(session_, names_.gain_raw).Read().value_or(0), 0);
    if (options.black_level)
      Compare("black_level", *options.black_level, TryCall(arv_camera_get_black_level, camera_).value_or(0.0),
              AravisNumber(session_, session_.Has("BlackLevel") ? "BlackLevel" : "").Step());
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
  if (const std::string why = WriteSetting(session, "ChunkModeActive", "false"); !why.empty())
    throw Error("{}: chunk data off: {}", who, why);
  configured.chunks.clear();
  ReadPayload(session, configured);
}

}  // namespace ulf::acquisition
