// Simulates a person who holds the simulated camera, to test whether people can cover a subject with what the
// display shows (docs/capture.md, "Simulated people").
//
// The person sees what the display draws and nothing else (operator/shown_sphere.h and the line of
// instruction): the dot, the arrow and the paint on the side of the sphere that faces the camera, their
// colours, and what the line says (operator/instruction.h). A picture has no scale and no orientation, so the
// person steers by eye, in shares of the subject's distance. Of the true world the person knows which way is
// down, roughly how far away the subject is, and where the hand was a moment ago, to go back there when
// tracking is lost.
//
// The person reacts after a delay. The hand is a damped spring with limited acceleration, so it overshoots;
// it trembles and drifts. Places on the sphere are read with an error in disc radii; the distance is read
// from the colours around the dot, of which faint ones pass for green, and from the line. Novices do all this
// worse, look away from the subject now and then, and rush.
//
// With guidance the person goes where the arrow points. Without it the person scans rows at a spacing judged
// by the painted discs, with an error, then goes for what still looks unpainted.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "acquisition/simulator/hand.h"
#include "coverage/session/capture_state.h"

namespace ulf::coverage {

struct OperatorOptions {
  bool follows_guidance = true;
  bool novice = false;
  std::uint64_t seed = 1;
  // Parses "guided", "unguided", "novice" or "unguided-novice", each with a seed if wanted: "novice:7".
  // Throws Refusal that lists them.
  static OperatorOptions Parse(const std::string& text);
};

// Describes how the person stands before the subject when they begin, in the simulator's world; metres.
struct OperatorStart {
  Rigid3 cam_from_world;
  Eigen::Vector3d up_in_world;
  double distance = 1;  // to the subject
};

class SimulatedOperator : public acquisition::HandMotion {
 public:
  SimulatedOperator(const OperatorOptions& options, const OperatorStart& start);
  ~SimulatedOperator() override;

  // Call it after every frame, with the state that the display shows and the simulator's time.
  void See(double time_s, const CaptureState& state);
  // Returns where the hand holds the camera. Times increase from call to call; the last second may be asked
  // for again.
  Rigid3 CamFromWorld(double time_s) const override;

 private:
  struct Person;
  const std::unique_ptr<Person> person_;
};

// Makes the person of `text` (OperatorOptions::Parse()) before the scene of `uri`. Throws Refusal unless
// `uri` is a simulated scene.
std::shared_ptr<SimulatedOperator> MakeSimulatedOperator(const DeviceUri& uri, const std::string& text);

}  // namespace ulf::coverage
