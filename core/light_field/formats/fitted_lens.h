// Takes lenses that another program describes by a formula of its own into our camera model.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "core/geometry/camera_fit.h"
#include "core/geometry/camera_model.h"

namespace ulf {

class FittedLenses {
 public:
  // `formula` is the other program's formula, `start` our camera that comes nearest to it, with the kind of
  // lens that is fitted. Returns `start` if it moves no pixel by more than 0.02 px, else the fit. Throws an
  // Error that begins with `where`, names the `lens` and gives the `remedy`, if that moves any by more than
  // two pixels, or the formula does not reach all of the picture.
  CameraModel Take(const Projection& formula, const CameraModel& start, const std::string& lens,
                   const std::string& where, const std::string& remedy);

  // Adds a doubt for each lens, with the number of cameras that were fitted and how far pixels move.
  void Note(std::vector<std::string>& doubts) const;

 private:
  struct Fits {
    std::size_t cameras = 0;
    double largest_px = 0;
  };
  std::map<std::string, Fits> fits_;  // by the lens
};

}  // namespace ulf
