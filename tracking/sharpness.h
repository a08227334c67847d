// How sharp a picture is, against the recent ones: a blurred frame stands out, whatever the scene.
#pragma once

#include <deque>

#include "tracking/features.h"

namespace ulf {

class Sharpness {
 public:
  // Fine detail of this frame over the recent frames' median; 1 while there are none.
  double Step(const Pyramid& pyramid);

 private:
  std::deque<double> recent_;
};

}  // namespace ulf
