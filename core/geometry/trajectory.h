// Trajectories, which are poses with times: their files, alignment and errors.
//
// TUM format: one line per pose, `time tx ty tz qx qy qz qw` (seconds, camera to world); lines that start
// with # are comments. Errors are computed after a similarity alignment of the camera centres (Umeyama 1991)
// and defined as in Sturm et al. 2012: ATE is the distance of centres, RPE the error of the relative motion
// over a fixed step. Lengths are in the truth's unit.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/geometry/rigid3.h"
#include "core/geometry/similarity3.h"

namespace ulf {

struct TimedPose {
  double time_s = 0;
  Rigid3 cam_from_world;
};

// These read and write a TUM file. They throw Error naming the file and, if it is no pose, the line. `note`
// is a comment's text, without a line break, that says what times and lengths are; empty: none.
std::vector<TimedPose> ReadTum(const std::filesystem::path& path);
void WriteTum(const std::filesystem::path& path, std::span<const TimedPose> poses,
              const std::string& note = {});

struct TrajectoryError {
  int matched = 0;
  double ate_rmse = 0;
  double ate_median = 0;
  double ate_max = 0;
  int steps = 0;        // number of steps of about `rpe_step_s`; if 0, the next three fields mean nothing
  double rpe_rmse = 0;  // translation over `rpe_step_s`
  double rpe_rotation_rmse_deg = 0;  // rotation over `rpe_step_s`
  double drift = 0;  // median over the steps: error of the translation, as a share of the true motion
  double rotation_rmse_deg = 0;  // between true rotations and those turned by truth_from_estimated
  double scale = 1;              // truth units per estimated unit
  Similarity3 truth_from_estimated;
  struct AtTime {
    double time_s = 0;
    double distance = 0;  // between the two camera centres
    // Angle between the two rotations after the rotational alignment that minimises it over all poses:
    // centres that lie close together do not determine the rotation.
    double turn_deg = 0;
  };
  std::vector<AtTime> errors;  // one for each pose with a counterpart
};

// Compares the estimated poses, which are in order of time, with true poses at the nearest times, at most
// `tolerance_s` off. Returns none if fewer than three have a counterpart, or if their centres lie on a line.
std::optional<TrajectoryError> CompareTrajectories(std::span<const TimedPose> estimated,
                                                   std::span<const TimedPose> truth, double tolerance_s,
                                                   double rpe_step_s = 1.0);

}  // namespace ulf
