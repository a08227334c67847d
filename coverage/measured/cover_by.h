// Chooses what decides whether a viewpoint is covered: the bound (coverage/bound/criterion.h), the error that
// is measured at frames (error_meter.h), or both.
#pragma once

#include <string>

namespace ulf::coverage {

enum class CoverBy {
  kBound,     // a recorded view shows the subject within the threshold, whatever its shape
  kMeasured,  // the recorded views predict the frame well enough; where that cannot be measured, the bound
  kBoth,      // the bound and the measured error must both allow it
};
const char* Name(CoverBy by);                   // "bound", "measured" or "both"
CoverBy CoverByNamed(const std::string& name);  // kBound for any other name

struct CoverGoal {
  CoverBy by = CoverBy::kBound;
  // The least peak signal-to-noise ratio, dB, of a frame's prediction inside the subject's silhouette, in
  // small pictures (docs/capture.md, "Measured errors"). Guessed.
  double db = 33;
  // Parses "bound", "measured", "both", or "measured:35", "both:35" (10 to 50 dB); throws Refusal.
  static CoverGoal Parse(const std::string& text);
};

}  // namespace ulf::coverage
