#include "core/light_field/folder/light_check.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/image/files/picture_end.h"

namespace ulf {
namespace {

constexpr std::size_t kLeastShared = 12;  // points for a pair to count. Guessed.
constexpr int kLeastViews = 10;           // in a connected set; with fewer the lamp is not judged. Guessed.
constexpr int kLeastPart = 5;             // views on either side of a cut. Guessed.
// A drift is reported from this difference (of the logarithm) and so many standard errors on. Guessed;
// simulated sessions without drift come to 0.003 (docs/rendering.md, Light that changes), what people see of
// recorded ones is not known.
constexpr double kLeastDifference = 0.03, kDriftStandardErrors = 5;
// The least spread of light that goes up and down. Three simulated captures in steady light came to 0.02 at
// most, handheld_kitchen, under automatic exposure and white balance, to 0.13 in brightness and 0.56 in blue.
// Guessed.
constexpr double kLeastWaverSpread = 0.08;

constexpr int kMostViews = 100;  // sets the time. Guessed.

using LogLight = std::array<double, 3>;  // B G R, per exposure

struct LitView {
  int id = 0;
  std::map<std::size_t, LogLight> points;  // by index into LightField::points
};

// Returns the logarithm of the exposure, which divides a view's light; none if only other views have one.
std::optional<double> LogExposure(const View& view, bool has_times, bool has_apertures) {
  if (has_times && !(view.exposure_s > 0)) return std::nullopt;
  if (has_apertures && !view.f_number) return std::nullopt;
  if (!(view.gain > 0)) return std::nullopt;
  return std::log(view.gain) + (has_times ? std::log(view.exposure_s) : 0) -
         (view.f_number ? 2 * std::log(*view.f_number) : 0);
}

std::vector<std::size_t> EvenlyChosen(std::size_t count, int most) {
  std::vector<std::size_t> chosen;
  const auto wanted = std::min(count, static_cast<std::size_t>(most));
  for (std::size_t i = 0; i < wanted; ++i) chosen.push_back(i * count / wanted);
  return chosen;
}

std::vector<LitView> ReadViews(const LightField& light_field,
                               const std::function<void(double share)>& progress, LightCheck& check) {
  const auto& views = light_field.views;
  const bool has_times = std::ranges::any_of(views, [](const View& view) { return view.exposure_s > 0; });
  check.exposure_is_told = has_times;
  const bool has_apertures =
      std::ranges::any_of(views, [](const View& view) { return view.f_number.has_value(); });
  std::map<int, std::vector<std::pair<std::size_t, Eigen::Vector2d>>> seen;  // by view
  for (std::size_t p = 0; p < light_field.points.size(); ++p)
    for (const ViewObservation& observation : light_field.points[p].track)
      seen[observation.view_id].emplace_back(p, observation.in_img);
  std::vector<LitView> lit;
  const std::vector<std::size_t> chosen = EvenlyChosen(views.size(), kMostViews);
  for (std::size_t n = 0; n < chosen.size(); ++n) {
    if (progress) progress(static_cast<double>(n) / static_cast<double>(chosen.size()));
    const View& view = views[chosen[n]];
    try {
      cv::Mat clipped;
      const LightAtPoints light(light_field, view, &clipped);
      const CameraModel& camera = light_field.CameraOf(view);
      const auto all = static_cast<std::uint64_t>(camera.width) * static_cast<std::uint64_t>(camera.height);
      const auto full = clipped.empty() ? 0 : static_cast<std::uint64_t>(cv::countNonZero(clipped));
      ++check.views;
      check.pixels += all;
      check.clipped_px += full;
      if (const double share = static_cast<double>(full) / static_cast<double>(all);
          share > check.most_clipped_share) {
        check.most_clipped_share = share;
        check.most_clipped_view = view.id;
      }
      const auto log_exposure = LogExposure(view, has_times, has_apertures);
      if (!log_exposure) continue;
      LitView& out = lit.emplace_back(LitView{view.id, {}});
      for (const auto& [point, img] : seen[view.id])
        if (const auto bgr = light.At(img))
          out.points[point] = {std::log((*bgr)[0]) - *log_exposure, std::log((*bgr)[1]) - *log_exposure,
                               std::log((*bgr)[2]) - *log_exposure};
    } catch (const Error& error) {
      check.unread[view.id] = error.what();
    }
  }
  for (std::size_t n = 0, next = 0; n < views.size(); ++n) {
    if (next < chosen.size() && chosen[next] == n) {
      ++next;
      continue;
    }
    const std::filesystem::path file = light_field.root / views[n].image_path;
    std::error_code unknown;
    if (std::filesystem::exists(file, unknown) && !ImageFileIsWhole(file))
      check.unread[views[n].id] =
          fmt::format("{}: the image is truncated; copy it again from its source", file.string());
  }
  return lit;
}

struct PairRatio {
  std::size_t a = 0, b = 0;
  LogLight ratio{};  // a's light over b's
  double weight = 0;
};

std::vector<PairRatio> RatiosOf(const std::vector<LitView>& views, std::size_t least_shared) {
  constexpr std::size_t kEnough = 100;  // points: more of the same pair add little. Guessed.
  std::vector<PairRatio> pairs;
  for (std::size_t a = 0; a < views.size(); ++a)
    for (std::size_t b = a + 1; b < views.size(); ++b) {
      std::array<std::vector<double>, 3> logs;
      for (const auto& [point, light] : views[a].points)
        if (const auto other = views[b].points.find(point); other != views[b].points.end())
          for (std::size_t c = 0; c < 3; ++c) logs[c].push_back(light[c] - other->second[c]);
      if (logs[0].size() < least_shared) continue;
      PairRatio pair{a, b, {}, static_cast<double>(std::min(logs[0].size(), kEnough))};
      for (std::size_t c = 0; c < 3; ++c) pair.ratio[c] = Median(std::move(logs[c]));
      pairs.push_back(pair);
    }
  return pairs;
}

// Returns the indices of the largest set of views that pairs connect, ascending.
std::vector<std::size_t> Connected(std::size_t count, const std::vector<PairRatio>& pairs) {
  std::vector<std::size_t> root(count);
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto root_of = [&](std::size_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (const PairRatio& pair : pairs) root[root_of(pair.a)] = root_of(pair.b);
  std::map<std::size_t, std::vector<std::size_t>> sets;
  for (std::size_t i = 0; i < count; ++i) sets[root_of(i)].push_back(i);
  std::vector<std::size_t> largest;
  for (auto& [of, members] : sets)
    if (members.size() > largest.size()) largest = std::move(members);
  return largest;
}

// Returns log gains of the views `of`, B G R in columns, with mean 0.
Eigen::MatrixXd GainsOf(const std::vector<std::size_t>& of, const std::vector<PairRatio>& pairs) {
  std::map<std::size_t, Eigen::Index> place;
  for (const std::size_t view : of) place.emplace(view, static_cast<Eigen::Index>(place.size()));
  const auto count = static_cast<Eigen::Index>(of.size());
  // One more equation makes the gains sum to 0.
  Eigen::MatrixXd normal = Eigen::MatrixXd::Ones(count, count), right = Eigen::MatrixXd::Zero(count, 3);
  for (const PairRatio& pair : pairs) {
    const auto a = place.find(pair.a), b = place.find(pair.b);
    if (a == place.end() || b == place.end()) continue;
    normal(a->second, a->second) += pair.weight;
    normal(b->second, b->second) += pair.weight;
    normal(a->second, b->second) -= pair.weight;
    normal(b->second, a->second) -= pair.weight;
    const Eigen::RowVector3d ratio = pair.weight * Eigen::RowVector3d::Map(pair.ratio.data());
    right.row(a->second) += ratio;
    right.row(b->second) -= ratio;
  }
  return normal.ldlt().solve(right);
}

struct Cut {
  std::size_t at = 0;  // first of the later part
  double difference = 0, standard_error = 0;
};

// Sums of squares and of products of neighbours of the residuals of a line through each part.
struct Left {
  double squares = 0, products = 0;
};
void LeaveOfLine(const Eigen::ArrayXd& values, Left& left) {
  const Eigen::Index count = values.size();
  const double last = 0.5 * static_cast<double>(count - 1);
  const Eigen::ArrayXd at = Eigen::ArrayXd::LinSpaced(count, -last, last), off = values - values.mean();
  const Eigen::ArrayXd beside = off - (at * off).sum() / at.square().sum() * at;
  left.squares += beside.square().sum();
  left.products += (beside.head(count - 1) * beside.tail(count - 1)).sum();
}

// Splits the values, in order of time, into two parts of one value each with least squares.
Cut BestCut(const Eigen::ArrayXd& values, Eigen::Index least_part) {
  Cut best;
  double least = std::numeric_limits<double>::infinity();
  for (Eigen::Index at = least_part; at + least_part <= values.size(); ++at) {
    const Eigen::ArrayXd first = values.head(at), later = values.tail(values.size() - at);
    const double before = first.mean(), after = later.mean();
    const double squares = (first - before).square().sum() + (later - after).square().sum();
    if (squares >= least) continue;
    least = squares;
    best = {static_cast<std::size_t>(at), after - before, 0};
  }
  // A lamp that keeps drifting is no noise, so lines are fitted to the two parts. Neighbours in time look
  // from nearly the same place, and err alike: there are fewer independent values than views.
  Left left;
  const auto cut = static_cast<Eigen::Index>(best.at);
  LeaveOfLine(values.head(cut), left);
  LeaveOfLine(values.tail(values.size() - cut), left);
  const auto count = static_cast<double>(values.size()), first = static_cast<double>(best.at);
  const double alike = std::clamp(left.squares > 0 ? left.products / left.squares : 0, 0.0, 0.9);
  const double variance = left.squares / (count - 4) * (1 + alike) / (1 - alike);
  best.standard_error = std::sqrt(variance * (1 / first + 1 / (count - first)));
  return best;
}

}  // namespace

std::string LampDrift::Words() const {
  const double percent = 100 * std::expm1(std::abs(difference));
  const bool more = difference > 0;
  const char* how = kind == Kind::kBrightness ? (more ? "brighter" : "darker")
                    : kind == Kind::kBlueness ? (more ? "bluer" : "redder")
                                              : (more ? "greener" : "less green");
  // A text "50 % darker" means half of the light.
  const double shown = kind == Kind::kBrightness && !more ? -100 * std::expm1(difference) : percent;
  return fmt::format("views {} to {} are {:.0f} % {} than views {} to {}", to_first, to_last, shown, how,
                     from_first, from_last);
}

std::string LampFluctuation::Words() const {
  const char* what = kind == LampDrift::Kind::kBrightness ? "brightness"
                     : kind == LampDrift::Kind::kBlueness ? "blue against red"
                                                          : "green against blue and red";
  return fmt::format("{} goes up and down by {:.0f} %", what, 100 * std::expm1(spread));
}

LightCheck CheckLight(const LightField& light_field, const std::function<void(double share)>& progress) {
  LightCheck check;
  const std::vector<LitView> views = ReadViews(light_field, progress, check);
  const std::vector<PairRatio> pairs = RatiosOf(views, kLeastShared);
  const std::vector<std::size_t> compared = Connected(views.size(), pairs);
  if (static_cast<int>(compared.size()) < std::max(kLeastViews, 2 * kLeastPart) || pairs.empty()) {
    check.not_compared =
        "too few views share points whose light could be compared; ulf refine measures points that all views "
        "share";
    return check;
  }
  check.compared = compared.size();
  const Eigen::MatrixXd gains = GainsOf(compared, pairs);
  const auto look_at = [&](LampDrift::Kind kind, const Eigen::VectorXd& values) {
    const Cut cut = BestCut(values, kLeastPart);
    if (std::abs(cut.difference) < kLeastDifference ||
        std::abs(cut.difference) < kDriftStandardErrors * cut.standard_error) {
      const std::vector<double> all(values.begin(), values.end());
      const double spread = Quantile(all, 0.9) - Quantile(all, 0.1);
      if (spread > kLeastWaverSpread) check.fluctuations.push_back({kind, spread});
      return;
    }
    check.drifts.push_back({kind, cut.difference, cut.standard_error, views[compared.front()].id,
                            views[compared[cut.at - 1]].id, views[compared[cut.at]].id,
                            views[compared.back()].id});
  };
  look_at(LampDrift::Kind::kBrightness, gains.rowwise().mean());
  look_at(LampDrift::Kind::kBlueness, gains.col(0) - gains.col(2));
  look_at(LampDrift::Kind::kGreenness, gains.col(1) - 0.5 * (gains.col(0) + gains.col(2)));
  return check;
}

}  // namespace ulf
