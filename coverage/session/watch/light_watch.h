// Detects changes of the pictures' light that are not the scene's: automatic exposure, and flickering lamps.
//
// It compares points that are tracked from picture to picture (picture_tracks.h): a change common to all of
// them is the exposure or the lamps, whatever the camera looks at. Where a camera reports its exposure, that
// is divided out first. A slow change is an automatic, or a lamp; one that goes up and down at one frequency
// is a lamp on an alternating current, seen at the frame rate. Under a rolling shutter each row sees another
// moment of the lamp, and bands run over the picture.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "coverage/session/watch/picture_tracks.h"

namespace ulf::coverage {

struct LightFinding {
  // The largest change so far of the light of the same things within two seconds, relative to the reported
  // exposure; natural logarithm. None: no change of an eighth or more was seen.
  std::optional<double> changed;
  // The amplitude of the largest flicker so far, as a share of the light; none: not seen.
  std::optional<double> flickers;
  double changed_s = 0, flickered_s = 0;  // when each was seen last, by PicturePair's clock
  // How many periods its bands have over the picture's height; none: the whole picture flickers at once.
  std::optional<double> bands;
};

class LightWatch {
 public:
  // `told`: natural logarithm of the present exposure (time times gain) over that before, as the camera
  // reports it; 0 where it does not. A pair that does not continue the last one restarts the watch.
  const LightFinding& Update(const PicturePair& pair, double told);

 private:
  struct Moment {
    double time_s = 0, log_light = 0;
    std::vector<float> explained;  // by bands of each number, of the squared deviations
    double deviations = 0;         // sum of their squares
    std::size_t points = 0;
  };
  void LookForChange();
  void LookForFlicker();
  void LookForBands();

  std::deque<Moment> moments_;
  LightFinding finding_;
};

}  // namespace ulf::coverage
