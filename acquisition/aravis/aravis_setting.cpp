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

ArvGcNode* NodeOf(const AravisSession& session, const std::string& feature) {
  return feature.empty() ? nullptr : arv_device_get_feature(session.Device(), feature.c_str());
}

void WriteText(const AravisSession& session, const std::string& feature, const std::string& value,
               GError** error) {
  ArvDevice* device = session.Device();
  const char* name = feature.c_str();
  switch (KindOf(NodeOf(session, feature))) {
    case NodeKind::kBoolean:
      return arv_device_set_boolean_feature_value(device, name, value == "true", error);
    case NodeKind::kInteger:
      return arv_device_set_integer_feature_value(device, name, g_ascii_strtoll(value.c_str(), nullptr, 10),
                                                  error);
    case NodeKind::kReal:
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
  ArvGcNode* node = NodeOf(session, feature);
  return node && ARV_IS_GC_FEATURE_NODE(node) &&
         arv_gc_feature_node_get_actual_access_mode(ARV_GC_FEATURE_NODE(node)) == ARV_GC_ACCESS_MODE_RO;
}

std::string WhyFixed(const AravisSession& session, const std::string& feature) {
  ArvGcNode* node = NodeOf(session, feature);
  if (!node || !ARV_IS_GC_FEATURE_NODE(node)) return "is not there";
  ArvGcFeatureNode* it = ARV_GC_FEATURE_NODE(node);
  if (!CallOr([&](GError** e) { return arv_gc_feature_node_is_available(it, e); }, true)) return kNotNow;
  if (IsReadOnly(session, feature)) return "is read-only";
  if (CallOr([&](GError** e) { return arv_gc_feature_node_is_locked(it, e); }, false))
    return "is locked by another setting";
  return "";
}

std::optional<std::string> ReadSetting(const AravisSession& session, const std::string& feature) {
  ArvDevice* device = session.Device();
  const char* name = feature.c_str();
  const NodeKind kind = KindOf(NodeOf(session, feature));
  if (kind == NodeKind::kNone || kind == NodeKind::kCommand ||
      !CallOr([&](GError** e) { return arv_device_is_feature_available(device, name, e); }, false))
    return std::nullopt;
  GError* error = nullptr;
  std::optional<std::string> text;
  if (kind == NodeKind::kBoolean) {
    text = arv_device_get_boolean_feature_value(device, name, &error) ? "true" : "false";
  } else if (kind == NodeKind::kInteger) {
    text = fmt::format("{}", arv_device_get_integer_feature_value(device, name, &error));
  } else if (kind == NodeKind::kReal) {
    text = fmt::format("{}", arv_device_get_float_feature_value(device, name, &error));
  } else if (const char* value = arv_device_get_string_feature_value(device, name, &error); value && !error) {
    text = value;
  }
  if (error) text.reset();
  g_clear_error(&error);
  return text;
}

std::string WriteSetting(const AravisSession& session, const std::string& feature, const std::string& value) {
  const std::optional<std::string> now = ReadSetting(session, feature);
  if (now == value) return "";
  GError* error = nullptr;
  WriteText(session, feature, value, &error);
  if (!error) return "";
  const std::string why =
      fmt::format("{} {}", feature,
                  WhyNotTaken(now.value_or(""), value, WhyFixed(session, feature), Text(error->message)));
  g_clear_error(&error);
  return why;
}

void RequireSetting(const AravisSession& session, const std::string& who, const std::string& asked,
                    const std::string& feature, const std::string& value) {
  const std::string why = WriteSetting(session, feature, value);
  if (why.empty()) return;
  throw Refusal(who, "", fmt::format("{} needs {}={}, but {}", asked, feature, value, why),
                fmt::format("leave {} out", asked.substr(0, asked.find('='))));
}

AravisNumber::AravisNumber(const AravisSession& session, std::string feature, double unit)
    : session_(&session), camera_(session.Camera()), feature_(std::move(feature)), unit_(unit) {
  is_whole_ = IsThere() && KindOf(NodeOf(session, feature_)) == NodeKind::kInteger;
}

std::optional<double> AravisNumber::Read() const {
  if (!IsThere()) return std::nullopt;
  const char* name = feature_.c_str();
  GError* error = nullptr;
  const double value = is_whole_ ? static_cast<double>(arv_camera_get_integer(camera_, name, &error))
                                 : arv_camera_get_float(camera_, name, &error);
  if (!error) return unit_ * value;
  g_clear_error(&error);
  return std::nullopt;
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

template <typename Set>
void AravisNumber::Put(const std::string& who, double wanted, Set&& set) const {
  const std::optional<double> now = Read();
  GError* error = nullptr;
  set(&error);
  if (!error) return;
  const std::string reason = Text(error->message);
  g_clear_error(&error);
  throw Error(
      "{}: {} {}", who, feature_,
      WhyNotTaken(now ? fmt::format("{:g}", *now) : "", fmt::format("{:g}", wanted), WhyFixed(), reason));
}

void AravisNumber::Write(const std::string& who, double value) const {
  if (Reads(value)) return;
  const char* name = feature_.c_str();
  if (!is_whole_)
    return Put(who, value, [&](GError** e) { arv_camera_set_float(camera_, name, value / unit_, e); });
  gint64 low = 0, high = 0;
  CallOrThrow(who, feature_,
              [&](GError** e) { arv_camera_get_integer_bounds(camera_, name, &low, &high, e); });
  const gint64 step = std::max<gint64>(
      1, CallOr([&](GError** e) { return arv_camera_get_integer_increment(camera_, name, e); }, gint64{1}));
  gint64 wanted = std::llround(value / unit_);
  // A camera that tells no smallest value counts its steps from 0.
  if (step > 1) {
    const gint64 from = std::max<gint64>(0, low);
    wanted = from + std::llround(static_cast<double>(wanted - from) / static_cast<double>(step)) * step;
    if (wanted > high) wanted -= step;
  }
  Put(who, value, [&](GError** e) { arv_camera_set_integer(camera_, name, wanted, e); });
}

std::pair<double, double> AravisNumber::Bounds(const std::string& who) const {
  const char* name = feature_.c_str();
  if (is_whole_) {
    gint64 low = 0, high = 0;
    CallOrThrow(who, feature_,
                [&](GError** e) { arv_camera_get_integer_bounds(camera_, name, &low, &high, e); });
    return {unit_ * static_cast<double>(low), unit_ * static_cast<double>(high)};
  }
  double low = 0, high = 0;
  CallOrThrow(who, feature_, [&](GError** e) { arv_camera_get_float_bounds(camera_, name, &low, &high, e); });
  return {unit_ * low, unit_ * high};
}

double AravisNumber::Step() const {
  if (!IsThere()) return 0;
  const char* name = feature_.c_str();
  const double step =
      is_whole_
          ? static_cast<double>(CallOr(
                [&](GError** e) { return arv_camera_get_integer_increment(camera_, name, e); }, gint64{1}))
          : CallOr([&](GError** e) { return arv_camera_get_float_increment(camera_, name, e); }, 0.0);
  // Where a camera gives none, the library returns the smallest or the largest of its type.
  return std::isfinite(step) && step > 2 * DBL_MIN && step < 1e300 ? unit_ * step : 0;
}

}  // namespace ulf::acquisition
