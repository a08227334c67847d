// Finds matches that may show two places which look the same, in scenes that repeat themselves (tiles, equal
// walls): such matches tell nothing about poses.
//
// A corner repeats itself if another place of its own picture has a descriptor that would pass for a match.
// What a picture shows once may still look like something else in another picture. If a pair's poses explain
// a part of its matches that is set apart from the others, these others are taken for such. Under wrong poses
// or a wrong lens errors change smoothly over the picture, and no part is set apart.
#pragma once

#include <span>
#include <vector>

#include "tracking/refine/view_pairs.h"

namespace ulf::tracking {

class Repetitions {
 public:
  // Compares the corners of each of the scene's pictures, and judges the scene by the pairs' matches. The
  // scene must outlive this.
  Repetitions(const RefineScene& scene, const std::vector<UnguidedPair>& pairs);
  // Returns the share of these matches, of which a corner repeats itself.
  double share() const { return share_; }
  // Whether matches of the scene must be doubted.
  bool IsRepetitive() const;
  // Drops a pair's doubtful matches if the scene is repetitive.
  void DropFrom(UnguidedPair& pair) const;
  // Returns whether, in a repetitive scene, the poses of a view and a neighbour explain a part of their
  // matches that is set apart, and another pose of the view does not: then that is the pose of a place that
  // looks the same. `corners` has the neighbour's corner for each of the view's; -1: none.
  bool ConfirmAgainst(int view, int neighbour, std::span<const int> corners,
                      const Rigid3& other_cam_from_world) const;

 private:
  bool Repeats(const UnguidedPair& pair, const FeatureMatch& match) const;

  const RefineScene& scene_;
  std::vector<std::vector<bool>> repeats_;  // by view and corner
  double share_ = 0;
};

}  // namespace ulf::tracking
