#include "tracking/refine/pose_check.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include "core/base/at.h"
#include "core/base/counted.h"
#include "core/base/parallel_for.h"
#include "core/base/quantile.h"
#include "core/geometry/angles.h"
#include "core/geometry/triangulation.h"
#include "tracking/estimation/absolute_pose.h"
#include "tracking/estimation/two_view_motion.h"
#include "tracking/refine/pose_conventions.h"
#include "tracking/refine/view_matching.h"
#include "tracking/refine/view_pairs.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector3d;

// The views nearest to each, and one in each direction: farther ones share fewer corners without helping.
constexpr PairOptions kNearPairs{.nearest = 4, .small_parallax_deg = 4, .large_parallax_deg = 4};

// A neighbour of a view, with the neighbour's corner for each of the view's; -1: none.
struct Matched {
  int view = 0;
  std::vector<int> corner;
  double error_px = 0;  // median distance from the epipolar lines of the recorded poses
};

// A corner of a view, and where two neighbours put it.
struct PlacedCorner {
  int corner = 0;
  Vector3d in_world = Vector3d::Zero();
  double error_px = 0, sigma_px = 1;
};

// What two neighbours that agree with each other say about a view.
struct Testimony {
  int first = 0, second = 0;  // the neighbours
  std::vector<PlacedCorner> corners;
  double sigmas = 0;              // median
  double weight = 1;              // the less these neighbours' own errors are enlarged, the more they can see
  bool lines_contradict = false;  // the view's epipolar lines in both neighbours contradict, too
};

// The views, with one standard deviation, px, of where each shows a corner of the others by its pose.
struct MatchedSet {
  const RefineScene& scene;
  std::vector<double> sigma_px;
  std::vector<std::vector<Matched>> neighbours;
};

// Where two rays meet, and how far the projection into a third view moves, px, when either is off by its sigma.
struct Meeting {
  Vector3d in_world = Vector3d::Zero();
  std::optional<Eigen::Vector2d> img;  // none: not before the third camera
  double moved_px = 0;
};

// The ray turned by `angle` towards the other camera, along the epipolar line: across it nothing moves.
Vector3d TurnedTowards(const Vector3d& ray, const Vector3d& other_center, double angle) {
  const Vector3d across = other_center - other_center.dot(ray) * ray;
  return across.norm() > 0 ? (ray + angle * across.normalized()).normalized() : ray;
}

std::optional<Meeting> Meet(const MatchedSet& set, int view, int first, const Vector3d& first_ray, int second,
                            const Vector3d& second_ray) {
  const RefineScene& scene = set.scene;
  const RefineView &own = scene.view(view), &one = scene.view(first), &other = scene.view(second);
  const auto seen_from = [&](const Vector3d& ray, const Vector3d& other_ray) -> std::optional<Meeting> {
    const auto point = TriangulatePoint(one.cam_from_world, ray, other.cam_from_world, other_ray);
    if (!point) return std::nullopt;
    return Meeting{*point, scene.LensOf(own).ImgFromCam(own.cam_from_world * *point)};
  };
  std::optional<Meeting> meeting = seen_from(first_ray, second_ray);
  if (!meeting || !meeting->img) return meeting;
  const auto angle = [&](int v) { return set.sigma_px[At(v)] / scene.LensOf(scene.view(v)).MeanFocalPx(); };
  const auto first_off = seen_from(
      TurnedTowards(first_ray, one.cam_from_world * other.cam_from_world.OriginInSource(), angle(first)),
      second_ray);
  const auto second_off = seen_from(
      first_ray,
      TurnedTowards(second_ray, other.cam_from_world * one.cam_from_world.OriginInSource(), angle(second)));
  if (!first_off || !first_off->img || !second_off || !second_off->img) return std::nullopt;
  meeting->moved_px =
      std::hypot((*first_off->img - *meeting->img).norm(), (*second_off->img - *meeting->img).norm());
  return meeting;
}

// None where the neighbours share too few corners with the view, do not agree about most of them, or stand so that
// their own errors would pass for the view's.
std::optional<Testimony> Ask(const MatchedSet& set, int view, const Matched& first, const Matched& second,
                             const PoseCheckOptions& options) {
  const RefineScene& scene = set.scene;
  const RefineView &own = scene.view(view), &one = scene.view(first.view), &other = scene.view(second.view);
  const Eigen::Matrix3d essential = EssentialFromPose(other.cam_from_world * one.cam_from_world.Inverse());
  if (!(essential.norm() > 0)) return std::nullopt;
  const double focal_px = scene.LensOf(one).MeanFocalPx();
  const double agree_px = options.most_sigmas *
                          std::hypot(set.sigma_px[At(first.view)], set.sigma_px[At(second.view)]) /
                          std::sqrt(2.0);
  Testimony testimony{first.view, second.view, {}, 0, 1, false};
  std::size_t shared = 0, agreed = 0;
  std::vector<double> sigmas, enlarged;
  for (std::size_t corner = 0; corner < first.corner.size(); ++corner) {
    if (first.corner[corner] < 0 || second.corner[corner] < 0) continue;
    ++shared;
    const Vector3d &ray = one.features[first.corner[corner]].ray,
                   &other_ray = other.features[second.corner[corner]].ray;
    if (EpipolarError(essential, {ray, other_ray}) * focal_px > agree_px) continue;
    ++agreed;
    const auto meeting = Meet(set, view, first.view, ray, second.view, other_ray);
    if (!meeting) continue;
    const int index = static_cast<int>(corner);
    const double sigma_px = std::hypot(set.sigma_px[At(view)], meeting->moved_px);
    const double error_px = meeting->img ? (*meeting->img - own.features[index].img).norm()
                                         : std::numeric_limits<double>::infinity();
    testimony.corners.push_back({index, meeting->in_world, error_px, sigma_px});
    sigmas.push_back(error_px / sigma_px);
    enlarged.push_back(sigma_px / set.sigma_px[At(view)]);
  }
  const double usually_enlarged = Median(std::move(enlarged));
  if (testimony.corners.size() < options.min_matches || 2 * agreed < shared ||
      usually_enlarged > options.most_enlarged)
    return std::nullopt;
  testimony.weight = 1 / (usually_enlarged * usually_enlarged);
  testimony.sigmas = Median(std::move(sigmas));
  const double least_px = options.most_sigmas * set.sigma_px[At(view)];
  testimony.lines_contradict = first.error_px > least_px && second.error_px > least_px;
  return testimony;
}

// The pose that most of what is said about a view agrees on, beside the recorded one; none where it agrees on none.
std::optional<ContradictedView> BetterPose(const MatchedSet& set, int view,
                                           const std::vector<const Testimony*>& said,
                                           const PoseCheckOptions& options) {
  const RefineView& own = set.scene.view(view);
  std::map<int, PlacedCorner> surest;
  std::set<int> by;
  for (const Testimony* testimony : said) {
    if (testimony->sigmas > options.most_sigmas) by.insert({testimony->first, testimony->second});
    for (const PlacedCorner& corner : testimony->corners) {
      const auto [at, is_new] = surest.emplace(corner.corner, corner);
      if (!is_new && corner.sigma_px < at->second.sigma_px) at->second = corner;
    }
  }
  std::vector<PointObservation> observations;
  std::vector<double> all_sigmas;
  for (const auto& [index, corner] : surest) {
    observations.push_back({corner.in_world, own.features[index].img, 1});
    all_sigmas.push_back(corner.sigma_px);
  }
  const auto found = AbsolutePose(set.scene.LensOf(own), observations,
                                  {.threshold_px = options.most_sigmas * Median(std::move(all_sigmas)),
                                   .min_inliers = static_cast<int>(options.min_matches),
                                   .seed = static_cast<unsigned>(view) + 1});
  if (!found || static_cast<double>(found->inliers.size()) <
                    options.explained_share * static_cast<double>(observations.size()))
    return std::nullopt;
  ContradictedView contradicted;
  contradicted.view = view;
  std::vector<double> errors, distances;
  const Vector3d center = found->cam_from_world.OriginInSource();
  for (const int i : found->inliers) {
    const PointObservation& seen = observations[At(i)];
    const auto img = set.scene.LensOf(own).ImgFromCam(own.cam_from_world * seen.point_in_world);
    errors.push_back(img ? (*img - seen.img).norm() : std::numeric_limits<double>::infinity());
    distances.push_back((seen.point_in_world - center).norm());
  }
  contradicted.error_px = Median(std::move(errors));
  contradicted.turned_deg =
      Degrees(RotationAngle(found->cam_from_world.rotation * own.cam_from_world.rotation.conjugate()));
  contradicted.moved_share =
      (own.cam_from_world.OriginInSource() - center).norm() / Median(std::move(distances));
  contradicted.by.assign(by.begin(), by.end());
  return contradicted;
}

// Views and what is said about them, until no view is left that most of it contradicts.
class Verdicts {
 public:
  Verdicts(const MatchedSet& set, const std::vector<std::vector<Testimony>>& said,
           const PoseCheckOptions& options)
      : set_(set), said_(said), options_(options), counts_(said.size(), true) {
    while (const auto worst = Worst()) {
      const int view = *worst;
      if (auto better = BetterPose(set_, view, Standing(view), options_))
        contradicted_.emplace(view, std::move(*better));
      else
        untold_.insert(view);
      counts_[At(view)] = false;
    }
  }
  // What others say about a view whose own poses are not in doubt.
  std::vector<const Testimony*> Standing(int view) const {
    std::vector<const Testimony*> standing;
    for (const Testimony& testimony : said_[At(view)])
      if (counts_[At(testimony.first)] && counts_[At(testimony.second)]) standing.push_back(&testimony);
    return standing;
  }
  const std::map<int, ContradictedView>& contradicted() const { return contradicted_; }
  bool AgreesOnNoPose(int view) const { return untold_.contains(view); }

 private:
  std::optional<int> Worst() const {
    std::optional<int> worst;
    std::pair<double, double> most{0.5, 0};  // the share that contradicts, and by how much
    for (int view = 0; view < static_cast<int>(said_.size()); ++view) {
      if (!counts_[At(view)]) continue;
      const std::vector<const Testimony*> standing = Standing(view);
      // One pair of neighbours may itself be wrong, along the line between the two, where they cannot see it.
      if (standing.empty() || (standing.size() == 1 && !standing[0]->lines_contradict)) continue;
      std::vector<double> sigmas;
      double all = 0, against = 0;
      for (const Testimony* testimony : standing) {
        sigmas.push_back(testimony->sigmas);
        all += testimony->weight;
        if (testimony->sigmas > options_.most_sigmas) against += testimony->weight;
      }
      const std::pair now(against / all, Median(sigmas));
      if (now.first > 0.5 && now > most) {
        most = now;
        worst = view;
      }
    }
    return worst;
  }

  const MatchedSet& set_;
  const std::vector<std::vector<Testimony>>& said_;
  const PoseCheckOptions& options_;
  std::vector<bool> counts_;  // as a witness
  std::map<int, ContradictedView> contradicted_;
  std::set<int> untold_;
};

// One standard deviation, px, of the usual distance from the epipolar lines of the recorded poses.
double UsualErrorPx(const std::vector<UnguidedPair>& pairs, const PoseCheckOptions& options) {
  constexpr double kMedianOfNormal = 0.6745;  // of the absolute value, unit variance
  std::vector<double> medians;
  for (const UnguidedPair& pair : pairs)
    if (pair.errors_px.size() >= options.min_matches)
      medians.push_back(Median(pair.errors_px) / kMedianOfNormal);
  return Median(std::move(medians));
}

std::vector<double> SigmasPx(const RefineScene& scene, const RefineInput& input, double usual_px,
                             const PoseCheckOptions& options) {
  constexpr double kLeastPx = 0.3;  // of a corner by itself
  std::vector<double> sigmas;
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const CameraModel& lens = scene.LensOf(scene.views[v]);
    const double usual = std::clamp(usual_px, kLeastPx, std::max(kLeastPx, options.usual_share * lens.width));
    sigmas.push_back(std::hypot(usual, input.views[v].center_error_share * lens.MeanFocalPx()));
  }
  return sigmas;
}

// The second view of a pair as the first one's neighbour.
Matched OfFirst(const RefineScene& scene, const UnguidedPair& pair) {
  Matched matched{pair.second, std::vector<int>(At(scene.view(pair.first).features.size()), -1),
                  Median(pair.errors_px)};
  for (const FeatureMatch& match : pair.matches) matched.corner[At(match.first)] = match.second;
  return matched;
}

std::vector<std::vector<Matched>> NeighboursBy(const RefineScene& scene,
                                               const std::vector<UnguidedPair>& pairs,
                                               const PoseCheckOptions& options) {
  std::vector<std::vector<Matched>> neighbours(scene.views.size());
  for (const UnguidedPair& pair : pairs) {
    if (pair.errors_px.size() < options.min_matches) continue;
    UnguidedPair back{pair.second, pair.first, {}, pair.errors_px};
    for (const FeatureMatch& match : pair.matches)
      back.matches.push_back({match.second, match.first, match.distance});
    neighbours[At(pair.first)].push_back(OfFirst(scene, pair));
    neighbours[At(pair.second)].push_back(OfFirst(scene, back));
  }
  return neighbours;
}

// Further neighbours of a view about which those around it by its pose say nothing: it may belong elsewhere. It is
// compared with views all over the set, then with those around the most similar one.
void LookElsewhere(const RefineScene& scene, int view, const std::vector<std::pair<int, int>>& near,
                   const PoseCheckOptions& options, std::vector<Matched>& neighbours) {
  const int count = static_cast<int>(scene.views.size()), compared = std::min(count, options.elsewhere);
  std::set<int> known{view};
  for (const auto& [first, second] : near)
    if (first == view || second == view) known.insert({first, second});
  const auto compare = [&](int other) {
    if (!scene.view(other).registered || !known.insert(other).second) return std::size_t{0};
    const UnguidedPair pair = MatchUnguided(scene, view, other);
    if (pair.errors_px.size() < options.min_matches) return std::size_t{0};
    neighbours.push_back(OfFirst(scene, pair));
    return pair.matches.size();
  };
  std::size_t most = 0;
  int like = -1;
  for (int k = 0; k < compared; ++k) {
    const int other = k * count / compared;
    if (const std::size_t matches = compare(other); matches > most) {
      most = matches;
      like = other;
    }
  }
  if (like < 0) return;
  for (const auto& [first, second] : near)
    if (first == like || second == like) compare(first == like ? second : first);
}

std::vector<Testimony> AskAll(const MatchedSet& set, int view, const PoseCheckOptions& options) {
  const std::vector<Matched>& matched = set.neighbours[At(view)];
  std::vector<Testimony> said;
  for (std::size_t i = 0; i < matched.size(); ++i)
    for (std::size_t j = i + 1; j < matched.size(); ++j)
      if (auto testimony = Ask(set, view, matched[i], matched[j], options))
        said.push_back(std::move(*testimony));
  return said;
}

// The names of the first of these views, and whether there are more.
template <typename Of>
std::string SomeOf(const std::vector<Of>& views, const std::vector<std::string>& names) {
  constexpr std::size_t kNamed = 4;
  std::string some;
  for (std::size_t i = 0; i < std::min(kNamed, views.size()); ++i)
    some += (i == 0 ? "" : ", ") + names[At(views[i].view)];
  return some + (views.size() > kNamed ? ", ..." : "");
}

// How many times as large as the pictures that are compared most photographs are.
double ReducedBy(const RefineScene& scene, const RefineInput& input) {
  std::vector<double> times;
  for (const RefineView& view : scene.views)
    times.push_back(static_cast<double>(input.lenses[At(view.lens)].width) / scene.LensOf(view).width);
  return Median(std::move(times));
}

}  // namespace

PoseCheck CheckPoses(const RefineInput& input, const PoseCheckOptions& options) {
  const RefineStage reading{options.progress, 0, 0.6}, matching{options.progress, 0.6, 1};
  const RefineScene scene = ReadScene(
      input, {.max_side_px = options.max_side_px, .corners = options.corners, .masked = false}, reading);
  const std::vector<std::pair<int, int>> near = ChoosePairs(scene, kNearPairs);
  matching.Show(0, "comparing photographs with their poses");
  std::vector<UnguidedPair> pairs(near.size());
  ParallelFor(pairs.size(),
              [&](std::size_t p) { pairs[p] = MatchUnguided(scene, near[p].first, near[p].second); });
  MatchedSet set{scene, SigmasPx(scene, input, UsualErrorPx(pairs, options), options),
                 NeighboursBy(scene, pairs, options)};

  std::vector<std::vector<Testimony>> said(scene.views.size());
  ParallelFor(said.size(), [&](std::size_t v) {
    const int view = static_cast<int>(v);
    said[v] = AskAll(set, view, options);
    if (!said[v].empty() || !scene.view(view).registered) return;
    LookElsewhere(scene, view, near, options, set.neighbours[v]);
    said[v] = AskAll(set, view, options);
  });
  const Verdicts verdicts(set, said, options);
  for (std::size_t v = 0; v < said.size(); ++v) {
    std::vector<double> sigmas;
    for (const Testimony& testimony : said[v]) sigmas.push_back(testimony.sigmas);
    spdlog::debug("{}: {} testimonies, {:.2f} sigmas in the median", scene.views[v].name, sigmas.size(),
                  Median(sigmas));
  }

  // Where no third view shows the corners of two, these still confirm each other by their epipolar lines.
  std::vector<bool> fits_one(scene.views.size());
  std::vector<double> medians_px;
  for (const UnguidedPair& pair : pairs) {
    if (pair.errors_px.size() < options.min_matches) continue;
    const double median_px = Median(pair.errors_px);
    if (median_px > options.most_sigmas * set.sigma_px[At(pair.first)]) continue;
    fits_one[At(pair.first)] = fits_one[At(pair.second)] = true;
    const RefineView& first = scene.view(pair.first);
    medians_px.push_back(median_px * input.lenses[At(first.lens)].width / scene.LensOf(first).width);
  }
  PoseCheck check;
  check.error_px = Median(std::move(medians_px));
  if (const auto fit = FitOfPoses(scene, pairs, options.min_matches)) {
    spdlog::debug("off by {:.3f} px as they are compared; {:.3f} before both cameras", fit->error_px,
                  fit->before_share);
    check.fits_poorly = IsPoor(*fit);
    check.fit_error_px = fit->error_px * ReducedBy(scene, input);
    check.looks_away = fit->before_share < PoseFitLimits{}.before_share;
    if (check.fits_poorly) check.convention = PoseConvention(scene, pairs, options.min_matches);
  }
  const auto cannot_tell = [&](int view, std::string why) {
    UntoldView& one = check.untold.emplace_back();
    one.view = view;
    one.why = std::move(why);
  };
  for (int view = 0; view < static_cast<int>(scene.views.size()); ++view) {
    const RefineView& own = scene.view(view);
    if (const auto found = verdicts.contradicted().find(view); found != verdicts.contradicted().end()) {
      check.contradicted.push_back(found->second);
      check.contradicted.back().error_px *=
          static_cast<double>(input.lenses[At(own.lens)].width) / scene.LensOf(own).width;
    } else if (!own.registered) {
      cannot_tell(view, own.why);
    } else if (verdicts.AgreesOnNoPose(view)) {
      cannot_tell(view, "what its neighbours show of it agrees on no pose");
    } else if (set.neighbours[At(view)].empty()) {
      cannot_tell(view,
                  "shares too little with the pictures of its neighbours: without texture, blurred, or "
                  "of something else");
    } else if (verdicts.Standing(view).empty() && (!said[At(view)].empty() || !fits_one[At(view)])) {
      const bool disagree = said[At(view)].empty();
      cannot_tell(view, disagree ? "its neighbours do not agree with each other about what it shows"
                                 : "its neighbours are contradicted themselves");
    } else {
      ++check.agree;
    }
  }
  return check;
}

std::string FitInWords(const PoseCheck& check) {
  if (!check.convention.empty())
    return fmt::format("the poses are wrong as a whole: {}; mend them in the files of the set",
                       check.convention);
  if (check.looks_away)
    return "the poses are wrong as a whole: by them most of what the photographs show lies behind the "
           "cameras, and no change of their axes or direction mends that; are the photographs in another "
           "order "
           "than the poses?";
  if (check.fits_poorly)
    return fmt::format(
        "the poses fit the photographs poorly as a whole, {:.1f} px off in most pairs: are the photographs "
        "in "
        "another order than the poses, cropped, or by another lens? Where the poses are only inexact, 'ulf "
        "refine' makes them better",
        check.fit_error_px);
  return {};
}

std::string UntoldInWords(const PoseCheck& check, const std::vector<std::string>& names) {
  if (check.untold.empty()) return {};
  return fmt::format("{} more show too little in common to tell ({})", check.untold.size(),
                     SomeOf(check.untold, names));
}

std::vector<Finding> FindingsOf(const PoseCheck& check, const std::vector<View>& views) {
  std::vector<Finding> findings;
  const std::size_t wrong = check.contradicted.size(), agree = static_cast<std::size_t>(check.agree);
  if (wrong > 0 && check.convention.empty()) {  // else they are wrong for another reason
    Finding& of_views = findings.emplace_back();
    of_views.check = Name(Check::kPoses);
    of_views.text = fmt::format(
        "the poses of {{views}} disagree with what the photographs show, and those of {} agree: {}",
        Counted(agree, "view"),
        wrong > agree ? "are the photographs in another order than the poses, or cropped, or by another lens?"
                      : "are these photographs others than those that were posed?");
    for (const ContradictedView& each : check.contradicted)
      of_views.views[views[At(each.view)].id] = views[At(each.view)].image_path;
  }
  if (std::string whole = FitInWords(check); !whole.empty())
    findings.push_back({Name(Check::kPoses), std::move(whole), {}});
  return findings;
}

}  // namespace ulf::tracking
