#include "acquisition/aravis/aravis_setting.h"

#include <fmt/format.h>

#include <algorithm>
#include <cfloat>
#include <cmath>

#include "acquisition/aravis/aravis_description.h"

namespace ulf::acquisition {
namespace {

// So near that a camera's own rounding explains it; farther off, what is fixed is another value. Guessed.
constexpr double kSameNumber = 1e-9, kSameFixedNumber = 1e-3;

constexpr const char* kNotNow = "is not available now";

void WriteText(const AravisSession& session, const std::string& feature, const std::string& value,
               GError** error) {
  ArvDevice* device = session.Device();
  const char* name = feature.c_str();
  switch (KindOf(session.Node(feature)).value_or(FeatureType::kString)) {
    case FeatureType::kBoolean:
      return arv_device_set_boolean_feature_value(device, name, value == "true", error);
    case FeatureType::kInteger:
      return arv_device_set_integer_feature_value(device, name, g_ascii_strtoll(value.c_str(), nullptr, 10),
                                                  error);
    case FeatureType::kFloat:
      return arv_device_set_float_feature_value(device, name, g_ascii_strtod(value.c_str(), nullptr), error);
    default:
      return arv_device_set_string_feature_value(device, name, value.c_str(), error);
  }
}

// "reads Off and is read-only", "reads Off and does not become On: REASON".
std::string WhyNotTaken(const std::string& reads, const std::string& wanted, const std::string& fixed,
                        const std::string& reason) {
  return fmt::format("{} and {}", reads.empty() ? "cannot be read" : "reads " + reads,
                     fixed.empty() ? fmt::format("does not become {}: {}", wanted, reason) : fixed);
}

}  // namespace

bool IsReadOnly(const AravisSession& session, const std::string& feature) {
  ArvGcNode* node = session.Node(feature);
  return node && ARV_IS_GC_FEATURE_NODE(node) &&
         arv_gc_feature_node_get_actual_access_mode(ARV_GC_FEATURE_NODE(node)) == ARV_GC_ACCESS_MODE_RO;
}

std::string WhyFixed(const AravisSession& session, const std::string& feature) {
  ArvGcNode* node = session.Node(feature);
  if (!node || !ARV_IS_GC_FEATURE_NODE(node)) return "is not there";
  ArvGcFeatureNode* it = ARV_GC_FEATURE_NODE(node);
  if (!TryCall(arv_gc_feature_node_is_available, it).value_or(true)) return kNotNow;
  if (IsReadOnly(session, feature)) return "is read-only";
  if (TryCall(arv_gc_feature_node_is_locked, it).value_or(false)) return "is locked by another setting";
  return "";
}

std::optional<std::string> ReadSetting(const AravisSession& session, const std::string& feature) {
  if (!session.Has(feature)) return std::nullopt;
  ArvGcNode* node = session.Node(feature);
  const std::optional<std::string> text = ValueOf(node);
  // An enumeration whose register has none of its numbers.
  if (text == "" && KindOf(node) == FeatureType::kEnumeration) return std::nullopt;
  return text;
}

std::string WriteSetting(const AravisSession& session, const std::string& feature, const std::string& value) {
  const std::optional<std::string> now = ReadSetting(session, feature);
  if (now == value) return "";
  const auto failure = FailureOf([&](GError** error) { WriteText(session, feature, value, error); });
  if (!failure) return "";
  return fmt::format("{} {}", feature,
                     WhyNotTaken(now.value_or(""), value, WhyFixed(session, feature), *failure));
}

void RequireSetting(const AravisSession& session, const std::string& who, const std::string& asked,
                    const std::string& feature, const std::string& value) {
  const std::string why = WriteSetting(session, feature, value);
  if (why.empty()) return;
  throw Refused(who, fmt::format("{} needs {}={}, but {}", asked, feature, value, why),
                fmt::format("leave {} out", asked.substr(0, asked.find('='))));
}

Refusal NoSuchChoice(const std::string& who, const std::string& asked,
                     const std::vector<std::string>& choices) {
  return {who, "",
          fmt::format("{}: the camera has {}", asked,
                      choices.empty() ? "none" : fmt::format("{}", fmt::join(choices, ", "))),
          ""};
}

AravisNumber::AravisNumber(const AravisSession& session, std::string feature, double unit)
    : session_(&session), camera_(session.Camera()), feature_(std::move(feature)), unit_(unit) {
  is_whole_ = IsThere() && KindOf(session.Node(feature_)) == FeatureType::kInteger;
}

std::optional<double> AravisNumber::Read() const {
  if (!IsThere()) return std::nullopt;
  const char* name = feature_.c_str();
  const auto value = TryCall([&](GError** error) {
    return is_whole_ ? static_cast<double>(arv_camera_get_integer(camera_, name, error))
                     : arv_camera_get_float(camera_, name, error);
  });
  return value ? std::optional(unit_ * *value) : std::nullopt;
}

std::string AravisNumber::WhyFixed() const { return acquisition::WhyFixed(*session_, feature_); }

bool AravisNumber::Reads(double value) const {
  const std::optional<double> now = Read();
  if (!now) return false;
  const std::string fixed = WhyFixed();
  const double same = fixed.empty() ? kSameNumber * std::abs(value)
                                    : std::max(kSameFixedNumber * std::abs(value), Step() / 2);
  return fixed != kNotNow && std::abs(*now - value) <= same;
}

void AravisNumber::Write(const std::string& who, double value) const {
  if (Reads(value)) return;
  const char* name = feature_.c_str();
  const auto put = [&](auto set, auto wanted) {
    const std::optional<double> now = Read();
    if (const auto failure = FailureOf(set, camera_, name, wanted))
      throw Error("{}: {} {}", who, feature_,
                  WhyNotTaken(now ? fmt::format("{:g}", *now) : "", fmt::format("{:g}", value), WhyFixed(),
                              *failure));
  };
  if (!is_whole_) return put(arv_camera_set_float, value / unit_);
  gint64 low = 0, high = 0;
  CallOrThrow(who, feature_, arv_camera_get_integer_bounds, camera_, name, &low, &high);
  const gint64 step =
      std::max<gint64>(1, TryCall(arv_camera_get_integer_increment, camera_, name).value_or(1));
  gint64 wanted = std::llround(value / unit_);
  // A camera that tells no smallest value counts its steps from 0.
  if (step > 1) {
    const gint64 from = std::max<gint64>(0, low);
    wanted = from + std::llround(static_cast<double>(wanted - from) / static_cast<double>(step)) * step;
    if (wanted > high) wanted -= step;
  }
  put(arv_camera_set_integer, wanted);
}

std::pair<double, double> AravisNumber::Bounds(const std::string& who) const {
  const char* name = feature_.c_str();
  if (is_whole_) {
    gint64 low = 0, high = 0;
    CallOrThrow(who, feature_, arv_camera_get_integer_bounds, camera_, name, &low, &high);
    return {unit_ * static_cast<double>(low), unit_ * static_cast<double>(high)};
  }
  double low = 0, high = 0;
  CallOrThrow(who, feature_, arv_camera_get_float_bounds, camera_, name, &low, &high);
  return {unit_ * low, unit_ * high};
}

double AravisNumber::Step() const {
  if (!IsThere()) return 0;
  const char* name = feature_.c_str();
  const double step =
      is_whole_ ? static_cast<double>(TryCall(arv_camera_get_integer_increment, camera_, name).value_or(1))
                : TryCall(arv_camera_get_float_increment, camera_, name).value_or(0.0);
  // If a camera gives none, the library returns the smallest or the largest of its type.
  return std::isfinite(step) && step > 2 * DBL_MIN && step < 1e300 ? unit_ * step : 0;
}

}  // namespace ulf::acquisition
