// Proposes a better sphere for the subject from the geometry that is made during the capture: the bound
// requires views of the whole sphere, so that one that is too large takes needless views, and what sticks out
// of one that is too small remains uncovered.
#pragma once

#include <optional>
#include <string>

#include "core/light_field/light_field.h"
#include "coverage/bound/capture_presets.h"
#include "coverage/bound/coverage_map.h"
#include "coverage/session/record/capture_lens.h"
#include "coverage/session/record/capture_options.h"
#include "coverage/session/record/live_geometry.h"

namespace ulf::coverage {

struct SubjectProposal {
  Subject subject;
  bool lies_beside = false;  // it sticks out of the present sphere because of its place rather than its size
  // The views that the cap takes with the present sphere, and with this one; none: no cap, or no view can
  // cover.
  std::optional<double> views_now, views_then;
};

// `now`: the sphere that the proposal is for.
std::string InWords(const SubjectProposal& proposal, const Subject& now);

class SubjectProposer {
 public:
  // `lens` and `options` outlive it.
  SubjectProposer(const CaptureLens& lens, const CaptureOptions& options) : lens_(lens), options_(options) {}

  // Call it after every frame; `mesh` may be null, `sphere` is the present one, `distance` the camera's from
  // its centre. Returns a proposal when it is new: two meshes in a row must agree that the subject's radius
  // is 0.65 of the sphere's or less, or that it reaches out to 1.33 radii or more.
  std::optional<SubjectProposal> Update(const std::shared_ptr<const LiveMesh>& mesh, const Subject& sphere,
                                        double distance);
  // Returns the proposal that is still open for this sphere; none: there is none.
  const std::optional<SubjectProposal>& proposal() const { return proposal_; }

 private:
  bool AreAlike(const Subject& a, const Subject& b) const;
  std::optional<double> ViewsFor(const Subject& subject, double distance) const;

  const CaptureLens& lens_;
  const CaptureOptions& options_;
  std::shared_ptr<const LiveMesh> mesh_;  // the last that was looked at
  std::optional<Subject> sphere_, seen_before_;
  std::optional<SubjectProposal> proposal_;
};

}  // namespace ulf::coverage
