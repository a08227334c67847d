// Where the subject of a set by another program is, whose cameras need not look at one point: sets that face
// one way tell it by the depths of what they show.
#pragma once

#include <optional>
#include <string>

#include "core/light_field/formats/posed_set.h"

namespace ulf {

struct SubjectOfSet {
  Subject subject;
  std::string told_by;  // "the optical axes", "the points" or "the depth bounds"
};

// The point nearest to the optical axes (SubjectFromAxes), unless points or bounds show that nothing is
// there. Else the mean of the points on the axes at the depth in whose middle, counted by disparity, each
// view's points or bounds lie. Points that do not belong to the poses (quick_checks.h) tell nothing. The
// sphere's image is as wide as `width_share` of the pictures. None: none of these tells it.
std::optional<SubjectOfSet> FindSubject(const PosedSet& set, double width_share = 0.28);

// Why FindSubject() finds none, and the way out: a clause.
std::string WhyNoSubject(const LightField& light_field);

}  // namespace ulf
