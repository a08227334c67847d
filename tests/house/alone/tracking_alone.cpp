// The tracker without OpenGL and without a camera library: linked with all of ulf_tracking and nothing else.
#include <cstdio>

#include "tests/support/floors.h"
#include "tracking/tracker/tracker.h"

int main() {
  ulf::CameraModel camera;
  camera.width = 64;
  camera.height = 48;
  camera.fx = camera.fy = 60;
  camera.cx = 32;
  camera.cy = 24;
  ulf::Tracker tracker(camera, {.deterministic = true});
  const ulf::Track track = tracker.Step({});
  std::printf("a frame without pixels is %s\n", track.skipped ? "skipped" : "tracked");
  return track.skipped ? 0 : 1;
}
