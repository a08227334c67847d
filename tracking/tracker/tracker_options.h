// What the tracker decides by, part by part.
//
// Radii and shifts in pixels are for images 640 px wide and scale with the width (PxAt640). "Measured" names
// the chart or page; "guessed" values were set once and worked.
#pragma once

#include <optional>

#include "tracking/estimation/absolute_pose.h"
#include "tracking/features/matching.h"
#include "tracking/map/frame_locator.h"
#include "tracking/map/mapper_options.h"

namespace ulf::tracking {

// Starting a map (initializer.h).
struct InitializerOptions {
  // Median over the two views that start the map. Smaller angles leave the depths open, larger ones make the
  // operator wait. Guessed.
  double min_parallax_deg = 0.8;
  int min_matches = 60;  // between the two views; fewer start again from a new reference. Guessed
  // Share of the matches that give points. Measured: 0.98 and more where a scene stands still; less than 0.75
  // where half of it moves, or tiles are taken for their neighbours (docs/tracking_measured.md, "How a map starts").
  double min_point_share = 0.85;
  // A match lies within this share of the image's width of where its feature was last seen. Guessed.
  double search_radius = 0.08;
  int max_distance = kSureDistance + 10;  // bits. Guessed
  double max_ratio = 0.85;                // best distance / second best. Guessed
  // A part of the image (a twelfth) that lies off the epipolar lines to one side by more than this, in the
  // median of at least so many matches, moves on its own. Measured: less than half of it where a scene stands
  // still, drawn and recorded.
  double max_part_shift_px = 1;
  int min_part_matches = 8;
};

// Following turns alone (turn_tracker.h). Guessed.
struct TurnOptions {
  int min_directions = 30;  // that agree, and
  double min_share = 0.5;   // their share of the matches
  double threshold_px = 6;  // agree to within this: as much parallax as a map starts with
  // Share of the width, about where a direction is expected; after a frame in which nothing fitted.
  double search_radius = 0.12, search_radius_after_miss = 0.5;
  int max_distance = kSureDistance + 10;  // bits
  double max_ratio = 0.85;
  double keyframe_turned_deg = 8;  // from the nearest
  int keyframes_tried = 3, keyframes_tried_after_miss = 10;
  std::size_t most_keyframes = 200;
};

// Deciding whether the shutter rolls (readout_search.h).
struct ReadoutSearchOptions {
  double certain_sigmas = 6;  // a smaller readout may be chance. Guessed
  // The same where a wrong lens may look like rows: of so few keyframes, or once images contradict the lens. Up to 11
  // deviations were seen of a focal length that was 15 % off, 12 and more of rolling shutters.
  double doubted_sigmas = 12;
  int early_keyframes = 8;
  // A measured readout of so many deviations is reckoned with until it is decided, and this one before the first
  // measurement: a phone or a webcam takes 10 to 33 ms. Guessed.
  double suspected_sigmas = 3, usual_readout_s = 0.02;
  double least_readout_s = 0.002;  // a shorter readout moves hardly anything by a tenth of a pixel
  // A given readout that is off by less, or by less than this share of what images tell, is not contradicted: a map that
  // was made under it holds the measured one back. Guessed.
  double least_wrong_s = 0.005, least_wrong_share = 0.3;
  double settled_share = 0.05;  // of the readout: a smaller change is not applied. Guessed
  int times_certain = 2;        // measurements in a row before the tracker reports it. Guessed
  int most_changes = 6;         // applied readouts, then the search ends. Guessed
  int enough_keyframes = 24;    // after so many the tracker decides that the shutter is global. Guessed
};

// What is known of a rolling shutter. Readouts run from the first row to the last; negative: from the last.
struct ReadoutArgs {
  std::optional<double> readout_s = {};  // 0: a global shutter; none: the tracker measures it
  bool compensate_found = true;  // compensate what the tracker finds, from then on; else only report it
};

// What becomes of the given lens, where the map's images contradict it.
enum class LensUse {
  kFixed,  // nothing: it is not checked
  kCheck,  // the tracker says so
  // The tracker goes on with the lens that fits, and poses follow; a rolling shutter that is found is compensated in any
  // case, since it looks like another lens.
  kRefine
};

struct TrackerOptions {
  bool deterministic = false;  // mapping runs inside Step(): the same frames give the same bytes
  unsigned seed = 1;           // of every random draw
  // Corners a frame, twice as many while the map starts. Measured: docs/charts/tracking.png.
  int features = 850;
  // Images with a longer side are reduced to it; 0: tracked as they come. Measured:
  // docs/charts/tracking_side.png.
  int max_side_px = 960;
  // A live camera does not wait: when the mapper is behind, keyframes are left out. A replay, whose frames come
  // faster than a camera's, waits for the mapper before every frame and leaves none out.
  bool wait_for_mapper = false;
  ReadoutArgs readout = {};
  LensUse lens = LensUse::kCheck;
  // Nobody has calibrated the given lens (a focal length from Exif data, a data sheet, a guess). With LensUse::kRefine it
  // is then replaced as soon as the map tells a better one, contradicted or not.
  bool lens_is_guess = false;

  // Following: search radii about the predicted pose, again about it, and about the last pose. Guessed.
  double near_px = 12, far_px = 30, last_pose_px = 40;
  // A velocity is known between frames that are at most so far apart. Guessed.
  double longest_step_s = 0.25;
  // A map that is lost before it has been tracked for so many frames is discarded. Guessed.
  int proven_frames = 10;
  // A camera that has been lost for so long begins another part of the map. Without `begin_parts` it stays lost until it
  // is back. Guessed.
  bool begin_parts = true;
  double begin_part_after_s = 1;
  int try_main_part_every = 5;  // frames that are followed apart from it. Guessed
  // A map made from recorded views needs so many points. Guessed.
  int min_seed_points = 60;

  FeatureOptions corners = {};
  InitializerOptions start = {};
  TurnOptions turns = {};
  LocatorOptions locator = {};
  ReadoutSearchOptions readout_search = {};
  MapperOptions mapping = {};
};

}  // namespace ulf::tracking
