#include "acquisition/aravis/aravis_number.h"

#include <algorithm>
#include <cfloat>
#include <cmath>

#include "acquisition/aravis/aravis_description.h"

namespace ulf::acquisition {

AravisNumber::AravisNumber(const AravisSession& session, std::string feature, double unit)
    : camera_(session.Camera()), feature_(std::move(feature)), unit_(unit) {
  is_whole_ =
      IsThere() && KindOf(arv_device_get_feature(session.Device(), feature_.c_str())) == NodeKind::kInteger;
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

void AravisNumber::Write(const std::string& who, double value) const {
  const char* name = feature_.c_str();
  if (!is_whole_) {
    Must(who, feature_, [&](GError** e) { arv_camera_set_float(camera_, name, value / unit_, e); });
    return;
  }
  gint64 low = 0, high = 0;
  Must(who, feature_, [&](GError** e) { arv_camera_get_integer_bounds(camera_, name, &low, &high, e); });
  const gint64 step = std::max<gint64>(
      1, Maybe([&](GError** e) { return arv_camera_get_integer_increment(camera_, name, e); }, gint64{1}));
  gint64 wanted = std::llround(value / unit_);
  // A camera that tells no smallest value counts its steps from 0.
  if (step > 1) {
    const gint64 from = std::max<gint64>(0, low);
    wanted = from + std::llround(static_cast<double>(wanted - from) / static_cast<double>(step)) * step;
    if (wanted > high) wanted -= step;
  }
  Must(who, feature_, [&](GError** e) { arv_camera_set_integer(camera_, name, wanted, e); });
}

std::pair<double, double> AravisNumber::Bounds(const std::string& who) const {
  const char* name = feature_.c_str();
  if (is_whole_) {
    gint64 low = 0, high = 0;
    Must(who, feature_, [&](GError** e) { arv_camera_get_integer_bounds(camera_, name, &low, &high, e); });
    return {unit_ * static_cast<double>(low), unit_ * static_cast<double>(high)};
  }
  double low = 0, high = 0;
  Must(who, feature_, [&](GError** e) { arv_camera_get_float_bounds(camera_, name, &low, &high, e); });
  return {unit_ * low, unit_ * high};
}

double AravisNumber::Step() const {
  if (!IsThere()) return 0;
  const char* name = feature_.c_str();
  const double step =
      is_whole_
          ? static_cast<double>(Maybe(
                [&](GError** e) { return arv_camera_get_integer_increment(camera_, name, e); }, gint64{1}))
          : Maybe([&](GError** e) { return arv_camera_get_float_increment(camera_, name, e); }, 0.0);
  // Where a camera gives none, the library returns the smallest or the largest of its type.
  return std::isfinite(step) && step > 2 * DBL_MIN && step < 1e300 ? unit_ * step : 0;
}

}  // namespace ulf::acquisition
