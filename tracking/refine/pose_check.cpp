#include "tracking/refine/pose_check.h"

#include <fmt/format.h>

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
#include "tracking/refine/repetitions.h"
#include "tracking/refine/view_matching.h"
#include "tracking/refine/view_pairs.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector3d;

// The constants are guessed, except where a line says so.
constexpr int kCheckCorners = 1200;              // a view, about
constexpr int kCheckMaxSidePx = 1000;            // larger pictures are reduced
constexpr std::size_t kCheckMinMatches = 15;     // shared by three views, or by two where no third shows them
constexpr std::size_t kUndoubtedMinMatches = 8;  // of two views, where a repetition left so few
// A corner that is off by more standard deviations contradicts: more misses wrong poses, less blames right
// ones whose errors are those of the set, but larger than most (settled: docs/measured/tracking.md, "Views
// whose poses their neighbours contradict").
constexpr double kCheckMostSigmas = 4;
// A share of the picture's width: a set whose poses are usually off by more is wrong as a whole, and its
// views are measured by this.
constexpr double kCheckUsualShare = 0.005;
// Two neighbours tell nothing about a view in which their errors would be so many times as large.
constexpr double kCheckMostEnlarged = 4;
// Share of the corners that another pose must explain before a pose is called wrong: else the matches are.
constexpr double kCheckExplainedShare = 0.6;
constexpr int kViewsElsewhere = 24;  // views that a view without matching neighbours is compared with

// The nearest views and one in each direction are compared: farther ones share fewer corners without helping.
constexpr PairOptions kNearPairs{.nearest = 4, .small_parallax_deg = 4, .large_parallax_deg = 4};

// A neighbour of a view, with the neighbour's corner for each of the view's; -1: none.
struct MatchedNeighbour {
  int view = 0;
  std::vector<int> corner;
  double error_px = 0;  // median distance from the epipolar lines of the recorded poses
};

// A corner of a view, triangulated from two neighbours. Its error is the distance from its projection.
struct PlacedCorner {
  int corner = 0;
  Vector3d in_world = Vector3d::Zero();
  double error_px = 0, sigma_px = 1;
};

// The test of a view's pose against two neighbours that agree with each other.
struct ViewTest {
  int first = 0, second = 0;  // the neighbours
  std::vector<PlacedCorner> corners;
  double sigmas = 0;  // of its corners' errors, median
  double weight = 1;  // falls with the square of how much the neighbours' own errors are enlarged
  bool epipolar_lines_contradict = false;  // the view's epipolar lines in both neighbours contradict, too
};

// The views, with one standard deviation, px, of where each shows a corner of the others by its pose.
struct MatchedSet {
  const RefineScene& scene;
  std::vector<double> sigma_px;
  std::vector<std::vector<MatchedNeighbour>> neighbours;
  const Repetitions& repetitions;
};

// A point triangulated from two rays and projected into a third view, and how far the projection moves, px,
// when either is off by its sigma.
struct Transferred {
  Vector3d in_world = Vector3d::Zero();
  std::optional<Eigen::Vector2d> img;  // none: not before the third camera
  double moved_px = 0;
};

// Returns the ray turned by `angle` towards the other camera, along the epipolar line.
Vector3d TurnedTowards(const Vector3d& ray, const Vector3d& other_center, double angle) {
  const Vector3d across = other_center - other_center.dot(ray) * ray;
  return across.norm() > 0 ? (ray + angle * across.normalized()).normalized() : ray;
}

std::optional<Transferred> Transfer(const MatchedSet& set, int view, int first, const Vector3d& first_ray,
                                    int second, const Vector3d& second_ray) {
  const RefineScene& scene = set.scene;
  const RefineView &own = scene.view(view), &one = scene.view(first), &other = scene.view(second);
  const auto seen_from = [&](const Vector3d& ray, const Vector3d& other_ray) -> std::optional<Transferred> {
    const auto point = TriangulatePoint(one.cam_from_world, ray, other.cam_from_world, other_ray);
    if (!point) return std::nullopt;
    return Transferred{*point, scene.LensOf(own).ImgFromCam(own.cam_from_world * *point)};
  };
  std::optional<Transferred> transferred = seen_from(first_ray, second_ray);
  if (!transferred || !transferred->img) return transferred;
  const auto angle = [&](int v) { return set.sigma_px[At(v)] / scene.LensOf(scene.view(v)).MeanFocalPx(); };
  const auto first_off = seen_from(
      TurnedTowards(first_ray, one.cam_from_world * other.cam_from_world.OriginInSource(), angle(first)),
      second_ray);
  const auto second_off = seen_from(
      first_ray,
      TurnedTowards(second_ray, other.cam_from_world * one.cam_from_world.OriginInSource(), angle(second)));
  if (!first_off || !first_off->img || !second_off || !second_off->img) return std::nullopt;
  transferred->moved_px =
      std::hypot((*first_off->img - *transferred->img).norm(), (*second_off->img - *transferred->img).norm());
  return transferred;
}

// Returns none where the neighbours share too few corners with the view, do not agree about most of them, or
// stand so that their own errors would pass for the view's.
std::optional<ViewTest> TestByPair(const MatchedSet& set, int view, const MatchedNeighbour& first,
                                   const MatchedNeighbour& second) {
  const RefineScene& scene = set.scene;
  const RefineView &own = scene.view(view), &one = scene.view(first.view), &other = scene.view(second.view);
  const Eigen::Matrix3d essential = EssentialFromPose(other.cam_from_world * one.cam_from_world.Inverse());
  if (!(essential.norm() > 0)) return std::nullopt;
  const double focal_px = scene.LensOf(one).MeanFocalPx();
  const double agree_px = kCheckMostSigmas *
                          std::hypot(set.sigma_px[At(first.view)], set.sigma_px[At(second.view)]) /
                          std::sqrt(2.0);
  ViewTest test{first.view, second.view, {}, 0, 1, false};
  std::size_t shared = 0, agreed = 0;
  std::vector<double> sigmas, enlarged;
  for (std::size_t corner = 0; corner < first.corner.size(); ++corner) {
    if (first.corner[corner] < 0 || second.corner[corner] < 0) continue;
    ++shared;
    const Vector3d &ray = one.features[first.corner[corner]].ray,
                   &other_ray = other.features[second.corner[corner]].ray;
    if (EpipolarError(essential, {ray, other_ray}) * focal_px > agree_px) continue;
    ++agreed;
    const auto transferred = Transfer(set, view, first.view, ray, second.view, other_ray);
    if (!transferred) continue;
    const int index = static_cast<int>(corner);
    const double sigma_px = std::hypot(set.sigma_px[At(view)], transferred->moved_px);
    const double error_px = transferred->img ? (*transferred->img - own.features[index].img).norm()
                                             : std::numeric_limits<double>::infinity();
    test.corners.push_back({index, transferred->in_world, error_px, sigma_px});
    sigmas.push_back(error_px / sigma_px);
    enlarged.push_back(sigma_px / set.sigma_px[At(view)]);
  }
  const double usually_enlarged = Median(std::move(enlarged));
  if (test.corners.size() < kCheckMinMatches || 2 * agreed < shared || usually_enlarged > kCheckMostEnlarged)
    return std::nullopt;
  test.weight = 1 / (usually_enlarged * usually_enlarged);
  test.sigmas = Median(std::move(sigmas));
  const double least_px = kCheckMostSigmas * set.sigma_px[At(view)];
  test.epipolar_lines_contradict = first.error_px > least_px && second.error_px > least_px;
  return test;
}

// Fits a pose to the corners of all tests of a view by consensus, without the recorded one; none where most
// corners agree on no pose, or on one that a neighbour rules out.
std::optional<ContradictedView> RefitPose(const MatchedSet& set, int view,
                                          const std::vector<const ViewTest*>& tests) {
  const RefineView& own = set.scene.view(view);
  std::map<int, PlacedCorner> most_certain;
  std::set<int> by;
  for (const ViewTest* test : tests) {
    if (test->sigmas > kCheckMostSigmas) by.insert({test->first, test->second});
    for (const PlacedCorner& corner : test->corners) {
      const auto [at, is_new] = most_certain.emplace(corner.corner, corner);
      if (!is_new && corner.sigma_px < at->second.sigma_px) at->second = corner;
    }
  }
  std::vector<PointObservation> observations;
  std::vector<double> all_sigmas;
  for (const auto& [index, corner] : most_certain) {
    observations.push_back({corner.in_world, own.features[index].img, 1});
    all_sigmas.push_back(corner.sigma_px);
  }
  const auto found = AbsolutePose(set.scene.LensOf(own), observations,
                                  {.threshold_px = kCheckMostSigmas * Median(std::move(all_sigmas)),
                                   .min_inliers = static_cast<int>(kCheckMinMatches),
                                   .seed = static_cast<unsigned>(view) + 1});
  if (!found || static_cast<double>(found->inliers.size()) <
                    kCheckExplainedShare * static_cast<double>(observations.size()))
    return std::nullopt;
  for (const MatchedNeighbour& each : set.neighbours[At(view)])
    if (set.repetitions.ConfirmAgainst(view, each.view, each.corner, found->cam_from_world))
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

// Removes the view that its tests contradict most, again and again, until no view is left that most of its
// tests contradict.
class OutlierSearch {
 public:
  OutlierSearch(const MatchedSet& set, const std::vector<std::vector<ViewTest>>& tests)
      : set_(set), tests_(tests), takes_part_(tests.size(), true) {
    while (const auto worst = Worst()) {
      const int view = *worst;
      if (auto better = RefitPose(set_, view, ValidTests(view)))
        contradicted_.emplace(view, std::move(*better));
      else
        no_consensus_.insert(view);
      takes_part_[At(view)] = false;
    }
  }
  // Returns the tests of a view by neighbours that have not been removed themselves.
  std::vector<const ViewTest*> ValidTests(int view) const {
    std::vector<const ViewTest*> valid;
    for (const ViewTest& test : tests_[At(view)])
      if (takes_part_[At(test.first)] && takes_part_[At(test.second)]) valid.push_back(&test);
    return valid;
  }
  const std::map<int, ContradictedView>& contradicted() const { return contradicted_; }
  bool HasNoConsensus(int view) const { return no_consensus_.contains(view); }
  // Whether a view was not removed, by view.
  const std::vector<bool>& TakesPart() const { return takes_part_; }

 private:
  std::optional<int> Worst() const {
    std::optional<int> worst;
    std::pair<double, double> most{0.5, 0};  // the share that contradicts, and by how much
    for (int view = 0; view < static_cast<int>(tests_.size()); ++view) {
      if (!takes_part_[At(view)]) continue;
      const std::vector<const ViewTest*> valid = ValidTests(view);
      // One pair of neighbours may itself be wrong, along the line between the two, where they cannot see it.
      if (valid.empty() || (valid.size() == 1 && !valid[0]->epipolar_lines_contradict)) continue;
      std::vector<double> sigmas;
      double all = 0, against = 0;
      for (const ViewTest* test : valid) {
        sigmas.push_back(test->sigmas);
        all += test->weight;
        if (test->sigmas > kCheckMostSigmas) against += test->weight;
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
  const std::vector<std::vector<ViewTest>>& tests_;
  std::vector<bool> takes_part_;  // in tests of others, by view
  std::map<int, ContradictedView> contradicted_;
  std::set<int> no_consensus_;
};

// Returns one standard deviation, px, of the usual distance from the epipolar lines of the recorded poses.
double UsualErrorPx(const std::vector<UnguidedPair>& pairs) {
  std::vector<double> medians;
  for (const UnguidedPair& pair : pairs)
    if (pair.errors_px.size() >= kCheckMinMatches)
      medians.push_back(Median(pair.errors_px) / kMedianOfNormal);
  return Median(std::move(medians));
}

std::vector<double> SigmasPx(const RefineScene& scene, const RefineInput& input, double usual_px) {
  constexpr double kLeastPx = 0.3;  // of a corner by itself
  std::vector<double> sigmas;
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const CameraModel& lens = scene.LensOf(scene.views[v]);
    const double usual = std::clamp(usual_px, kLeastPx, std::max(kLeastPx, kCheckUsualShare * lens.width));
    sigmas.push_back(std::hypot(usual, input.views[v].center_error_share * lens.MeanFocalPx()));
  }
  return sigmas;
}

// Returns the second view of a pair as the first one's neighbour.
MatchedNeighbour NeighbourOfFirst(const RefineScene& scene, const UnguidedPair& pair) {
  MatchedNeighbour matched{pair.second, std::vector<int>(At(scene.view(pair.first).features.size()), -1),
                           Median(pair.errors_px)};
  for (const FeatureMatch& match : pair.matches) matched.corner[At(match.first)] = match.second;
  return matched;
}

std::vector<std::vector<MatchedNeighbour>> NeighboursBy(const RefineScene& scene,
                                                        const std::vector<UnguidedPair>& pairs) {
  std::vector<std::vector<MatchedNeighbour>> neighbours(scene.views.size());
  for (const UnguidedPair& pair : pairs) {
    if (pair.errors_px.size() < kCheckMinMatches) continue;
    UnguidedPair back{pair.second, pair.first, {}, pair.errors_px};
    for (const FeatureMatch& match : pair.matches)
      back.matches.push_back({match.second, match.first, match.distance});
    neighbours[At(pair.first)].push_back(NeighbourOfFirst(scene, pair));
    neighbours[At(pair.second)].push_back(NeighbourOfFirst(scene, back));
  }
  return neighbours;
}

// Further neighbours of a view about which those around it by its pose say nothing: it may belong elsewhere.
// It is compared with views all over the set, then with those around the most similar one.
void MatchElsewhere(const RefineScene& scene, const Repetitions& repetitions, int view,
                    const std::vector<std::pair<int, int>>& near, std::vector<MatchedNeighbour>& neighbours) {
  const int count = static_cast<int>(scene.views.size()), compared = std::min(count, kViewsElsewhere);
  std::set<int> known{view};
  for (const auto& [first, second] : near)
    if (first == view || second == view) known.insert({first, second});
  const auto compare = [&](int other) {
    if (!scene.view(other).registered || !known.insert(other).second) return std::size_t{0};
    UnguidedPair pair = MatchUnguided(scene, view, other);
    repetitions.DropFrom(pair);
    if (pair.errors_px.size() < kCheckMinMatches) return std::size_t{0};
    neighbours.push_back(NeighbourOfFirst(scene, pair));
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

std::vector<ViewTest> TestByAllPairs(const MatchedSet& set, int view) {
  const std::vector<MatchedNeighbour>& matched = set.neighbours[At(view)];
  std::vector<ViewTest> tests;
  for (std::size_t i = 0; i < matched.size(); ++i)
    for (std::size_t j = i + 1; j < matched.size(); ++j)
      if (auto test = TestByPair(set, view, matched[i], matched[j])) tests.push_back(std::move(*test));
  return tests;
}

// Returns the names of the first of these views, and whether there are more.
template <typename Of>
std::string SomeOf(const std::vector<Of>& views, const std::vector<std::string>& names) {
  constexpr std::size_t kNamed = 4;
  std::string some;
  for (std::size_t i = 0; i < std::min(kNamed, views.size()); ++i)
    some += (i == 0 ? "" : ", ") + names[At(views[i].view)];
  return some + (views.size() > kNamed ? ", ..." : "");
}

// Returns how many times as large as the pictures that are compared most photographs are.
double ReducedBy(const RefineScene& scene, const RefineInput& input) {
  std::vector<double> times;
  for (const RefineView& view : scene.views)
    times.push_back(static_cast<double>(input.lenses[At(view.lens)].width) / scene.LensOf(view).width);
  return Median(std::move(times));
}

}  // namespace

PoseCheck CheckPoses(const RefineInput& input,
                     const std::function<void(double share, const std::string& stage)>& progress) {
  const RefineStage reading{progress, 0, 0.6}, matching{progress, 0.6, 1};
  const RefineScene scene = ReadScene(
      input, {.max_side_px = kCheckMaxSidePx, .corners = kCheckCorners, .keeps_masked = false}, reading);
  const std::vector<std::pair<int, int>> near = ChoosePairs(scene, kNearPairs);
  matching.Show(0, "comparing photographs with their poses");
  std::vector<UnguidedPair> pairs(near.size());
  ParallelFor(pairs.size(),
              [&](std::size_t p) { pairs[p] = MatchUnguided(scene, near[p].first, near[p].second); });
  const Repetitions repetitions(scene, pairs);
  for (UnguidedPair& pair : pairs) repetitions.DropFrom(pair);
  MatchedSet set{scene, SigmasPx(scene, input, UsualErrorPx(pairs)), NeighboursBy(scene, pairs), repetitions};

  std::vector<std::vector<ViewTest>> tests(scene.views.size());
  ParallelFor(tests.size(), [&](std::size_t v) {
    const int view = static_cast<int>(v);
    tests[v] = TestByAllPairs(set, view);
    if (!tests[v].empty() || !scene.view(view).registered) return;
    MatchElsewhere(scene, repetitions, view, near, set.neighbours[v]);
    tests[v] = TestByAllPairs(set, view);
  });
  const OutlierSearch outliers(set, tests);

  // If no third view shows the corners of two, these still confirm each other by their epipolar lines.
  std::vector<bool> fits_one(scene.views.size());
  std::vector<double> medians_px;
  for (const UnguidedPair& pair : pairs) {
    if (pair.errors_px.size() < kCheckMinMatches) continue;
    const double median_px = Median(pair.errors_px);
    if (median_px > kCheckMostSigmas * set.sigma_px[At(pair.first)]) continue;
    fits_one[At(pair.first)] = fits_one[At(pair.second)] = true;
    const RefineView& first = scene.view(pair.first);
    medians_px.push_back(median_px * input.lenses[At(first.lens)].width / scene.LensOf(first).width);
  }
  PoseCheck check;
  check.is_repetitive = repetitions.IsRepetitive();
  check.repeated_share = repetitions.share();
  check.error_px = Median(std::move(medians_px));
  const std::size_t least = check.is_repetitive ? kUndoubtedMinMatches : kCheckMinMatches;
  auto fit = FitOfPoses(scene, pairs, least);
  if (fit && IsPoor(*fit)) {
    pairs = PairsThatAgree(scene, pairs, least);
    fit = FitOfPoses(scene, pairs, least);
  }
  if (fit) {
    check.fits_poorly = IsPoor(*fit);
    check.fit_error_px = fit->error_px * ReducedBy(scene, input);
    check.looks_away = fit->before_share < kLeastBeforeShare;
    if (check.fits_poorly && !check.is_repetitive) check.convention = PoseConvention(scene, pairs, least);
  }
  if (!check.fits_poorly)
    check.obstructed = FindObstructedViews(scene, pairs, set.sigma_px, outliers.TakesPart(), input.read_mask);
  for (int view = 0; view < static_cast<int>(scene.views.size()); ++view) {
    const RefineView& own = scene.view(view);
    if (const auto found = outliers.contradicted().find(view); found != outliers.contradicted().end()) {
      check.contradicted.push_back(found->second);
      check.contradicted.back().error_px *=
          static_cast<double>(input.lenses[At(own.lens)].width) / scene.LensOf(own).width;
    } else if (!own.registered) {
      check.undecided.push_back({view, own.why});
    } else if (outliers.HasNoConsensus(view)) {
      check.undecided.push_back({view, "what its neighbours show of it agrees on no pose"});
    } else if (set.neighbours[At(view)].empty()) {
      check.undecided.push_back(
          {view, "shares too little with its neighbours: without texture, blurred, or of something else"});
    } else if (outliers.ValidTests(view).empty() && (!tests[At(view)].empty() || !fits_one[At(view)])) {
      const bool disagree = tests[At(view)].empty();
      check.undecided.push_back({view, disagree
                                           ? "its neighbours do not agree with each other about what it shows"
                                           : "its neighbours are contradicted themselves"});
    } else {
      ++check.agree;
    }
  }
  return check;
}

std::string FitInWords(const PoseCheck& check) {
  if (check.fits_poorly && check.is_repetitive)
    return fmt::format(
        "whether the poses fit cannot be told: most pairs of photographs are {:.1f} px off, but {:.0f} % of "
        "what they share looks like other places of the same picture (tiles, equal walls)",
        check.fit_error_px, 100 * check.repeated_share);
  if (!check.convention.empty())
    return fmt::format("the poses are wrong as a whole: {}; mend them in the files of the set",
                       check.convention);
  if (check.looks_away)
    return "the poses are wrong as a whole: by them most of what the photographs show lies behind the "
           "cameras, and no change of their axes or direction mends that; are the photographs in another "
           "order than the poses?";
  if (check.fits_poorly)
    return fmt::format(
        "the poses fit the photographs poorly as a whole, {:.1f} px off in most pairs: are the photographs "
        "in another order than the poses, cropped, or by another lens? Where the poses are only inexact, "
        "'ulf refine' makes them better",
        check.fit_error_px);
  return {};
}

std::string UndecidedInWords(const PoseCheck& check, const std::vector<std::string>& names) {
  if (check.undecided.empty()) return {};
  return fmt::format("{} more show too little in common to tell ({})", check.undecided.size(),
                     SomeOf(check.undecided, names));
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
        check.is_repetitive ? "are these poses or those of views beside them wrong, or do places look alike?"
        : wrong > agree
            ? "are the photographs in another order than the poses, or cropped, or by another lens?"
            : "are these photographs others than those that were posed?");
    for (const ContradictedView& each : check.contradicted)
      of_views.views[views[At(each.view)].id] = views[At(each.view)].image_path;
  }
  if (std::string whole = FitInWords(check); !whole.empty())
    findings.push_back({Name(Check::kPoses), std::move(whole), {}});
  for (Finding& each : FindingsOf(check.obstructed, views)) findings.push_back(std::move(each));
  return findings;
}

}  // namespace ulf::tracking
