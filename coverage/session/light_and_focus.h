// Before the first view: whether the pictures are bright enough and in focus, by the live frames themselves.
//
// A picture is out of focus when its finest detail is missing while coarser detail is there: half its size, the
// finest octave (what a Gaussian of one pixel takes away) is compared with the next one, each by its strongest
// edges. Edges of photographs in focus differ little between octaves. Measured on seven sets of photographs by
// others, 480 to 1500 pixels wide: 1.0 to 2.3 as they are, 0.5 to 0.75 blurred by a Gaussian of three.
#pragma once

#include <deque>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/image/image.h"
#include "core/light_field/light_field.h"
#include "coverage/bound/subject_light.h"

namespace ulf::coverage {

struct FineDetailOptions {
  int most_px = 1024;  // of each side that are looked at, in the middle of `area`; more takes longer
  // Share of the pixels that count as the strongest edges of an octave. Guessed.
  double strongest = 0.02;
  // Grey values that the coarser octave's strongest edges need: less may be noise, and the picture is looked at
  // once more at half the size, where a lens far out of focus still shows edges. Guessed.
  double least_texture = 6;
  int times_halved = 2;
};
// The finest octave's edges against the next one's. None: too little texture to tell.
std::optional<double> FineDetail(const cv::Mat& grey8, const cv::Rect& area,
                                 const FineDetailOptions& options = {});

struct PictureFinding {
  std::optional<SubjectLight> light;  // of the subject's image; without a subject of the middle
  std::optional<double> fine_detail;  // FineDetail(), the best of the last frames; none: cannot be told yet
};

class LightAndFocusCheck {
 public:
  // Guessed.
  struct Options {
    double every_s = 0.25;  // a frame is looked at so often; each costs some milliseconds
    double best_of_s = 2;   // a moving camera blurs some frames
  };
  LightAndFocusCheck() = default;
  explicit LightAndFocusCheck(const Options& options) : options_(options) {}

  // `subject` and its camera pose: none while they are not known.
  const PictureFinding& After(double time_s, const Image& image, const CameraModel& camera,
                              const std::optional<Rigid3>& cam_from_world,
                              const std::optional<Subject>& subject);

 private:
  struct Looked {
    double time_s = 0;
    std::optional<double> fine_detail;
  };
  Options options_;
  std::deque<Looked> looked_;
  PictureFinding finding_;
};

}  // namespace ulf::coverage
