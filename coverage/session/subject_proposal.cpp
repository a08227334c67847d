#include "coverage/session/subject_proposal.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "core/base/counted.h"
#include "coverage/bound/capture_prediction.h"

namespace ulf::coverage {
namespace {

// The radius that was seen, as a share of the sphere's: between these the sphere stays. Guessed: the
// thinnest things are not in the mesh, and simulated subjects are found at 0.7 to 1.1 of their radius
// (subject_in_mesh_test).
constexpr double kProposalSmaller = 0.65, kProposalLarger = 1.33;
constexpr int kProposalLeastMaps = 8;  // that a mesh needs to tell. Guessed.
// Two meshes one after the other must agree within these shares of the radius, in size and in place; what is
// farther off is another sphere. Guessed.
constexpr double kProposalSameRadius = 0.15, kProposalSameCenter = 0.15;

}  // namespace

std::string InWords(const SubjectProposal& proposal, const Subject& now) {
  const bool is_smaller = proposal.subject.radius < now.radius;
  std::string words =
      proposal.lies_beside
          ? fmt::format(
                "the subject seems to lie beside the middle of its sphere, by {:.0f} % of the radius, and "
                "sticks out of it",
                100 * (proposal.subject.center_in_world - now.center_in_world).norm() / now.radius)
          : fmt::format("the subject seems to be {} than its sphere: radius {:.3g}, not {:.3g}",
                        is_smaller ? "smaller" : "larger", proposal.subject.radius, now.radius);
  if (proposal.views_now && proposal.views_then)
    words += fmt::format("; with such a sphere the cap takes about {}, not {:.0f}",
                         Counted(std::lround(*proposal.views_then), "view"), *proposal.views_now);
  else if (!is_smaller || proposal.lies_beside)
    words += "; what sticks out is not looked after";
  return words + " (G, or the request subject proposed, places it)";
}

bool SubjectProposer::AreAlike(const Subject& a, const Subject& b) const {
  return std::abs(a.radius / b.radius - 1) <= kProposalSameRadius &&
         (a.center_in_world - b.center_in_world).norm() <= kProposalSameCenter * b.radius;
}

std::optional<double> SubjectProposer::ViewsFor(const Subject& subject, double distance) const {
  const auto predicted =
      Predict(SetupAt(lens_.recorded(), options_.coverage_width_px, subject, distance, options_.threshold_px),
              options_.cap, options_.until_share);
  return predicted && predicted->views ? std::optional(predicted->views->usual) : std::nullopt;
}

std::optional<SubjectProposal> SubjectProposer::Update(const std::shared_ptr<const LiveMesh>& mesh,
                                                       const Subject& sphere, double distance) {
  if (sphere_ && !AreAlike(*sphere_, sphere)) {
    proposal_.reset();  // somebody has placed another one
    seen_before_.reset();
  }
  sphere_ = sphere;
  if (!mesh || mesh == std::exchange(mesh_, mesh) || mesh->maps < kProposalLeastMaps) return std::nullopt;
  const std::optional<Subject> before = std::exchange(seen_before_, mesh->subject_seen);
  const std::optional<Subject>& seen = mesh->subject_seen;
  if (!seen || !before || !AreAlike(*seen, *before)) return std::nullopt;
  const double ratio = seen->radius / sphere.radius;
  const double offset = (seen->center_in_world - sphere.center_in_world).norm() / sphere.radius;
  const double reach = ratio + offset;
  if (ratio > kProposalSmaller && reach < kProposalLarger) {
    proposal_.reset();
    return std::nullopt;
  }
  const bool is_new = !proposal_ || !AreAlike(*seen, proposal_->subject);
  proposal_ = SubjectProposal{.subject = *seen,
                              .lies_beside = reach >= kProposalLarger && offset > ratio - 1,
                              .views_now = ViewsFor(sphere, distance),
                              .views_then = ViewsFor(*seen, distance)};
  return is_new ? proposal_ : std::nullopt;
}

}  // namespace ulf::coverage
