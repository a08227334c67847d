// Finds the subject of a set by another program, whose cameras need not look at one point: for sets that face
// one way, the depths of the points tell it.
#pragma once

#include <optional>
#include <string>

#include "core/light_field/formats/posed_set.h"

namespace ulf {

struct SubjectOfSet {
  Subject subject;
  std::string told_by;  // "the optical axes", "the points" or "the depth bounds"
};

// Returns a sphere around the point nearest to the optical axes (SubjectFromAxes), unless points or bounds
// show that nothing is there; otherwise around the mean of the points on the axes at the median disparity of
// each view's points or bounds. Points that do not belong to the poses (quick_checks.h) are ignored. The
// sphere's image has the share kSubjectSize of the pictures' width. Returns none if all of these fail.
std::optional<SubjectOfSet> FindSubject(const PosedSet& set);

// Says why FindSubject() finds none, and the remedy, as a clause.
std::string WhyNoSubject(const LightField& light_field);

}  // namespace ulf
