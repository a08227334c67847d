// A person who holds the simulated camera, for proofs that a person can do it.
//
// They see what the display draws and nothing else (operator/shown_sphere.h, and the line of instruction):
// where the dot, the arrow and the paint are in the picture, on the side of the sphere that faces the camera,
// in which colour, and what the line says. No picture tells how large the world is or how it lies: they steer
// as people do, by eye: the hand moves right, the dot moves right, by so much of the subject's distance. Of
// the true world they feel what people feel: which way is down, about how far away the subject is, and where
// their hand was a moment ago, to go back there when they are told that tracking is lost.
//
// Eye and hand: what is seen acts after a delay; the hand follows what it is told as a damped spring, with
// limited acceleration, so it overshoots; it trembles and drifts. Places on the sphere are read to a share of
// a disc, distance from the colours about the dot, where faint ones pass for green, and from the line, when
// it speaks of it. Novices do all that worse, look away from the subject now and then and rush.
//
// With guidance they go where it points. Without it they scan rows by eye, at a spacing that they judge by
// the discs painted so far, with an error, then go for whatever still looks unpainted.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "acquisition/device/device.h"
#include "acquisition/simulator/hand_motion.h"
#include "coverage/session/capture_state.h"

namespace ulf::coverage {

struct OperatorOptions {
  bool follows_guidance = true;
  bool novice = false;
  std::uint64_t seed = 1;
  // "guided", "unguided", "novice", "unguided-novice", each with a seed if wanted: "novice:7". Throws
  // UsageError that lists them.
  static OperatorOptions Parse(const std::string& text);
};

// How the person stands before the subject when they begin; world frame metres.
struct OperatorStart {
  Rigid3 cam_from_world;
  Eigen::Vector3d up_in_world;
  double distance = 1;  // to the subject
};

class SimulatedOperator : public acquisition::HandMotion {
 public:
  SimulatedOperator(const OperatorOptions& options, const OperatorStart& start);
  ~SimulatedOperator() override;

  // What the display shows now, after every frame.
  void See(double time_s, const CaptureState& state);
  // Times go on from call to call, but for a second that may be asked for again.
  Rigid3 CamFromWorld(double time_s) const override;

 private:
  struct Person;
  const std::unique_ptr<Person> person_;
};

// As `ulf capture --operator` says it. Throws UsageError unless `uri` is a simulated scene.
std::shared_ptr<SimulatedOperator> OperatorBefore(const DeviceUri& uri, const std::string& text);

}  // namespace ulf::coverage
