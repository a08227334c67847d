// Whether the light of a session stood still, and how much of its photographs is clipped.
//
// Points that several views show should send the same light to all of them, once exposures are taken into
// account. For each pair of views the median ratio over the points that they share is one measurement; the
// views' gains, one for each channel, follow from all of them by least squares. A lamp that warms up, or a
// cloud, shows as gains that differ between the earlier and the later views: in brightness, between blue and
// red, or between green and the others. The session is cut where the two parts differ most, and what they
// differ by is reported where it is more than what the scene itself could do (gloss) and more than chance.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/light_field/folder/light_at_points.h"
#include "core/light_field/light_field.h"

namespace ulf {

// Views `from_first` to `from_last`, by id, beside the later `to_first` to `to_last`.
struct LampDrift {
  enum class Kind { kBrightness, kBlueness, kGreenness };
  Kind kind = Kind::kBrightness;
  double difference =
      0;  // of the logarithm: of light; of blue over red; of green over the mean of the others
  double standard_error = 0;
  int from_first = 0, from_last = 0, to_first = 0, to_last = 0;

  std::string Words() const;  // "views 41 to 80 are 12 % bluer than views 1 to 40"
};

// Light that goes up and down and comes back: no part of the views differs from the rest for good.
struct LampWaver {
  LampDrift::Kind kind = LampDrift::Kind::kBrightness;
  double spread = 0;          // of the logarithm: four fifths of the views lie within it
  std::string Words() const;  // "blue against red goes up and down by 23 %"
};

struct LightCheck {
  std::size_t views = 0;                   // that were read
  std::map<int, std::string> unread = {};  // why a photograph cannot be read, in words that name it; by view
  std::uint64_t pixels = 0, clipped_px = 0;  // of these views
  int most_clipped_view = 0;                 // id; 0: none has clipped pixels
  double most_clipped_share = 0;
  std::string not_compared = {};  // why nothing is said of the lamp; empty: it was looked at
  std::size_t compared = 0;       // views whose light was
  bool exposure_is_told = false;  // by the camera; else gains were found by overlaps
  std::vector<LampDrift> drifts = {};
  std::vector<LampWaver> wavers = {};  // of kinds without a drift
};

// Looks at a hundred views at most, evenly chosen in time, the same ones whenever it is asked: another choice
// could come to another verdict. Photographs that cannot be read are named, and so is a JPEG or PNG without
// its end among all others. Where no view has an exposure time, gains were found by overlaps
// (coverage/session/record/exposure) and hide what a lamp's brightness did; its colour shows all the same.
LightCheck CheckLight(const LightField& light_field, const std::function<void(double share)>& progress = {});

}  // namespace ulf
