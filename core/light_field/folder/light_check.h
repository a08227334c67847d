// Checks whether the light of a session stayed constant, and how much of its photographs is clipped.
//
// Points that several views show should send the same light to all of them, once exposures are taken into
// account. For each pair of views the median ratio over their shared points is one measurement; the views'
// gains, one for each channel, follow from all of them by least squares. A lamp that warms up, or a cloud,
// shows as gains that differ between earlier and later views: in brightness, between blue and red, or between
// green and the others. The session is split where the two parts differ most, and the difference is reported
// if it exceeds what the scene itself could do (gloss) and chance.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/light_field/folder/light_at_points.h"
#include "core/light_field/light_field.h"

namespace ulf {

// A lasting change between views `from_first` to `from_last`, by id, and the later `to_first` to `to_last`.
struct LampDrift {
  enum class Kind { kBrightness, kBlueness, kGreenness };
  Kind kind = Kind::kBrightness;
  // Later - earlier natural logarithm of light, of blue / red, or of green / the mean of the others.
  double difference = 0;
  double standard_error = 0;
  int from_first = 0, from_last = 0, to_first = 0, to_last = 0;

  std::string Words() const;  // "views 41 to 80 are 12 % bluer than views 1 to 40"
};

// Light that fluctuates: no part of the views differs from the rest for good.
struct LampFluctuation {
  LampDrift::Kind kind = LampDrift::Kind::kBrightness;
  double spread = 0;          // range of that logarithm that contains four fifths of the views
  std::string Words() const;  // "blue against red goes up and down by 23 %"
};

struct LightCheck {
  std::size_t views = 0;                     // number of views read
  std::map<int, std::string> unread = {};    // by view: why its photograph cannot be read, with its name
  std::uint64_t pixels = 0, clipped_px = 0;  // pixels of these views
  int most_clipped_view = 0;                 // id; 0: none has clipped pixels
  double most_clipped_share = 0;
  std::string not_compared = {};  // why the lamp was not judged; empty: it was judged
  std::size_t compared = 0;       // number of views whose light was compared
  bool exposure_is_told = false;  // the camera gave exposure times; else gains were measured (View::gain)
  std::vector<LampDrift> drifts = {};
  std::vector<LampFluctuation> fluctuations = {};  // only kinds without a drift
};

// Reads a hundred views at most, evenly chosen in time, always the same ones, because another choice could
// change the result. Lists photographs that cannot be read, and any JPEG or PNG without its end, in `unread`.
// If no view has an exposure time, the capture has measured gains from overlaps
// (coverage/session/record/exposure), which hide changes of a lamp's brightness, but not of its colour.
LightCheck CheckLight(const LightField& light_field, const std::function<void(double share)>& progress = {});

}  // namespace ulf
