// Models where a person who sees the painted sphere goes next without guidance: along rows over the cap, at a
// spacing guessed from the discs on it, with a systematic and a random error, then to the nearest visible
// hole.
#pragma once

#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "acquisition/simulator/hand.h"
#include "coverage/operator/shown_sphere.h"

namespace ulf::coverage {

class RowsByEye {
 public:
  RowsByEye(std::uint64_t seed, bool novice);
  // Returns where to go from the dot, as angles about the sphere's frame; none when nothing looks unpainted,
  // or nothing is painted yet.
  std::optional<CapFrame::Angles> Toward(const ShownSphere& sphere, double time_s);

 private:
  class SeenPaint;
  struct Hole {
    CapFrame::Angles at;
    double seen_s = 0;
  };
  double Spread(double sigma);
  std::optional<CapFrame::Angles> FindHole(const ShownSphere& sphere, const SeenPaint& paint, double size);

  std::mt19937_64 random_;
  const bool novice_;
  const double own_spacing_;         // of rows, disc radii
  const acquisition::Waves wobble_;  // of a row's height, disc radii
  double radius_ = 0;                // of the discs, as last seen
  int upwards_ = 0;                  // 0: not begun
  int heading_ = 1;
  double level_ = 0;
  bool rows_done_ = false;
  std::optional<Hole> hole_;
  std::vector<Hole> given_up_;
};

}  // namespace ulf::coverage
