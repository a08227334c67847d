// How large a map grows, and what goes again. Keyframe distance, what is superfluous, seldom found and too
// little parallax are charted against accuracy on two recordings (docs/charts/map_size.png;
// docs/tracking_measured.md, "The map").
#pragma once

namespace ulf::tracking {

struct MapperOptions {
  // A keyframe is offered when the camera has moved by this share of the scene's depth or turned so far since
  // the nearest one, and sooner when it sees less.
  double keyframe_moved = 0.03;
  double keyframe_turned_deg = 10;
  // A keyframe goes when this share of its points are seen by three others as closely.
  double superfluous_share = 0.9;
  // A point goes within its first keyframes when it is found in less than this share of the frames that
  // should have seen it, or when no third keyframe sees it.
  double min_found_share = 0.25;
  double min_parallax_deg = 1;  // between the two views that make a point
  // The whole map is adjusted when it has grown by this factor since it last was.
  double adjust_all_growth = 1.1;
};

}  // namespace ulf::tracking
