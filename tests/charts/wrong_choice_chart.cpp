// What each wrong choice of a model costs: too little model where a scene needs more, too much where less
// would do, in error and in time (or in what takes the time) over those of the choice that the program makes.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "acquisition/simulator/simulated_board.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/base/quantile.h"
#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "render/quality/choice.h"
#include "render/quality/quality.h"
#include "render/stereo/proxy_builder.h"
#include "tests/acquisition/calibration/synthetic_board_views.h"
#include "tests/charts/studio_views.h"
#include "tests/charts/tracking/tracking_runs.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"
#include "tests/tracking/refine/refine_views.h"

namespace ulf::test {
namespace {

using Eigen::Vector3d;

constexpr char kTooSimple[] = "too little model";
constexpr char kTooRich[] = "too much model";

// Of one run each.
struct Price {
  double cost = 0, error = 0;
};

// Ratios of wrong over right, seed by seed, in one panel of a table.
struct Prices {
  Table& table;
  std::string panel;
  void Add(const char* series, const std::string& name, const Price& wrong, const Price& right) const {
    table.Add(panel, series, name, wrong.cost / right.cost, wrong.error / right.error);
  }
};

double ErrorOf(double psnr_db) { return std::pow(10, -psnr_db / 20); }

void PriceLenses(unsigned seed, const Prices& prices) {
  for (const char* lens : {"pinhole", "barrel"}) {
    const SyntheticBoardViews spec{
        .camera = SimulatedLens(lens, 640, 480), .views = 24, .noise_px = 0.1, .seed = seed};
    const CalibrationResult result = CalibrateFromViews(Board(), MakeViews(spec), 640, 480);
    if (!result.ok()) throw Error("the {} lens of seed {} cannot be calibrated", lens, seed);
    const std::vector<CandidateResult>& table = result.choice.table;
    const auto by_size = [](const CandidateResult& a, const CandidateResult& b) {
      return a.fit.candidate.Parameters() < b.fit.candidate.Parameters();
    };
    const auto price = [](const CandidateResult& candidate) {
      return Price{static_cast<double>(candidate.fit.candidate.Parameters()), candidate.LeftOutRmsPx()};
    };
    const Price right = price(table[result.choice.chosen]);
    if (std::string(lens) == "barrel")
      prices.Add(kTooSimple, "a lens without distortion for a barrel",
                 price(*std::min_element(table.begin(), table.end(), by_size)), right);
    else
      prices.Add(kTooRich, "all coefficients for a pinhole",
                 price(*std::max_element(table.begin(), table.end(), by_size)), right);
  }
}

// The pose of two views by OpenCV's homography, the best of its decompositions, and by its essential matrix.
struct TwoViews {
  std::vector<cv::Point2d> first, second;
  Eigen::Matrix3d rotation;
  double ErrorOf(const cv::Mat& estimated) const {
    Eigen::Matrix3d r;
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column) r(row, column) = estimated.at<double>(row, column);
    return std::max(1e-3, Eigen::AngleAxisd(r * rotation.transpose()).angle() * 180 / M_PI);
  }
};

double ByHomography(const TwoViews& views, double threshold) {
  const cv::Mat h = cv::findHomography(views.first, views.second, cv::RANSAC, threshold);
  std::vector<cv::Mat> rotations, translations, normals;
  cv::decomposeHomographyMat(h, cv::Mat::eye(3, 3, CV_64F), rotations, translations, normals);
  double best = 180;
  for (const cv::Mat& rotation : rotations) best = std::min(best, views.ErrorOf(rotation));
  return best;
}

double ByEssentialMatrix(const TwoViews& views, double threshold) {
  const cv::Mat eye = cv::Mat::eye(3, 3, CV_64F);
  const cv::Mat essential =
      cv::findEssentialMat(views.first, views.second, eye, cv::RANSAC, 0.999, threshold);
  cv::Mat rotation, translation;
  cv::recoverPose(essential.rowRange(0, 3), views.first, views.second, eye, rotation, translation);
  return views.ErrorOf(rotation);
}

void PriceMotions(unsigned seed, const Prices& prices) {
  for (const Shape shape : {Shape::kDeep, Shape::kFlat}) {
    // Of twenty draws, because one may be easy.
    Price right, wrong;
    for (unsigned draw = 0; draw < 20; ++draw) {
      const RelativeScene scene = MakeRelativeScene(400, shape, 0.6, 0.5, 0.2, 1000 * seed + draw);
      TwoViews views{{}, {}, scene.second_from_first.RotationMatrix()};
      for (const RayPair& pair : scene.pairs) {
        const Vector3d a = pair.first / pair.first.z(), b = pair.second / pair.second.z();
        views.first.emplace_back(a.x(), a.y());
        views.second.emplace_back(b.x(), b.y());
      }
      constexpr double kFocalPx = 525;
      double start = ThreadCpuSeconds();
      const RelativePoseResult found = RelativePose(scene.pairs, {.focal_px = kFocalPx, .seed = draw + 1});
      const double right_s = ThreadCpuSeconds() - start;
      if (found.outcome != RelativePoseOutcome::kFound) continue;  // said, and no map is started
      start = ThreadCpuSeconds();
      const double error = shape == Shape::kDeep ? ByHomography(views, 1.5 / kFocalPx)
                                                 : ByEssentialMatrix(views, 1.5 / kFocalPx);
      wrong.cost += ThreadCpuSeconds() - start;
      right.cost += right_s;
      wrong.error += error * error;
      const double off = std::max(1e-3, RotationAngle(found.second_from_first.rotation *
                                                      scene.second_from_first.rotation.conjugate()) *
                                            180 / M_PI);
      right.error += off * off;
    }
    right.error = std::sqrt(right.error);
    wrong.error = std::sqrt(wrong.error);
    if (shape == Shape::kDeep)
      prices.Add(kTooSimple, "a homography for a deep scene (OpenCV)", wrong, right);
    else
      prices.Add(kTooRich, "an essential matrix for a wall (OpenCV)", wrong, right);
  }
}

void PriceLensesOfRefinement(unsigned seed, const Prices& prices) {
  const auto views = MakeViews(12, 0, 0, seed);
  views->input.lenses[0].fx *= 0.95;
  views->input.lenses[0].fy *= 0.95;
  const auto price = [&](bool intrinsics) {
    const double before = ProcessCpuMs();
    const RefineResult result = RefineRoom(*views, intrinsics);
    return Price{ProcessCpuMs() - before, After(*views, result).center};
  };
  prices.Add(kTooSimple, "a focal length kept that is 5 % off", price(false), price(true));
}

void PriceMaps(const std::vector<unsigned>& seeds, int frames, const Prices& prices) {
  struct Kind {
    const char* series;
    const char* name;
    std::function<void(MapperOptions&)> change;
    bool by_points;
  };
  const std::vector<Kind> kinds{
      {kTooSimple, "a keyframe each 12 % of the depth", [](MapperOptions& o) { o.keyframe_moved = 0.12; },
       false},
      {kTooRich, "a keyframe each 1.5 %", [](MapperOptions& o) { o.keyframe_moved = 0.015; }, false},
      {kTooSimple, "keyframes gone at 60 % seen", [](MapperOptions& o) { o.superfluous_share = 0.6; }, true},
      {kTooRich, "no keyframe ever gone", [](MapperOptions& o) { o.superfluous_share = 1.01; }, true}};
  for (const unsigned seed : seeds) {
    std::vector<TrackedCase> cases{{kStudio, {.deterministic = true, .seed = seed}, frames}};
    for (const Kind& kind : kinds) {
      cases.push_back(cases.front());
      kind.change(cases.back().options.mapping);
    }
    const std::vector<TrackedRun> runs = TrackRuns(cases);
    for (std::size_t i = 0; i < kinds.size(); ++i) {
      const auto price = [&](const TrackedRun& run) {
        return Price{kinds[i].by_points ? run.points : run.keyframes, run.after_mm};
      };
      prices.Add(kinds[i].series, kinds[i].name, price(runs[i + 1]), price(runs[0]));
    }
  }
}

// What is called right here is what the program takes.
void RequireChoice(const RenderScene& scene, const std::shared_ptr<const Proxy>& simple,
                   const std::shared_ptr<const Proxy>& rich, const std::shared_ptr<const Proxy>& right) {
  const Choice choice =
      ChooseByEvidence(scene, {{.kind = FieldKind::kSubdivision}}, {simple, rich}, RendererKind::kGl);
  if (choice.proxy != right)
    throw Error("the program takes the {} where the {} was to be the right choice ({})", choice.proxy->Name(),
                right->Name(), choice.why);
}

void PricePictures(unsigned seed, const Effort& effort, const Prices& prices) {
  const StudioOptions options{
      .seed = seed, .threshold_px = effort.Of(24.0, 12.0), .width = 360, .height = 240};
  const auto scene = StudioScene(options);
  const auto truth = StudioTruth(options, effort.Of(3, 10));
  const auto renderer = MakeRenderer(scene, {});
  const auto price = [&](const FieldOptions& field) {
    renderer->SetField(field);
    const RenderedQuality quality = MeasureRendering(*renderer, truth);
    return Price{quality.cpu_ms, ErrorOf(quality.psnr_db)};
  };
  const FieldOptions once{.kind = FieldKind::kSubdivision, .level = 1};
  const Price plane = price(once);
  const auto mesh = std::make_shared<TriangleMesh>(
      BuildProxy(*scene, {.size_px = 360, .depth_maps = effort.Of(8, 24)}).mesh);
  const auto proxy = std::make_shared<MeshProxy>(scene->subject, mesh);
  RequireChoice(*scene, scene->proxy, proxy, proxy);
  renderer->SetProxy(proxy);
  const Price right = price(once);
  prices.Add(kTooSimple, "a plane for a studio", plane, right);
  prices.Add(kTooSimple, "the nearest view", price({.kind = FieldKind::kNearest}), right);
  prices.Add(kTooSimple, "linear weights", price({.kind = FieldKind::kLinear}), right);
  prices.Add(kTooRich, "three levels of subdivision",
             price({.kind = FieldKind::kSubdivision, .level = kFinestLevel}), right);
  prices.Add(kTooRich, "lumigraph at every pixel", price({.kind = FieldKind::kLumigraphPerPixel}), right);
}

void PriceMeshOfAWall(unsigned seed, const Effort& effort, const Prices& prices) {
  const auto scene = MakeScene(
      {.viewpoints = CapViewpoints(50, 0.5, 2.0, 0.03, seed), .width = 360, .height = 240, .focal_px = 300});
  const auto renderer = MakeRenderer(scene, {});
  const CameraModel camera = CameraModel::Pinhole(360, 240, 330);
  const auto price = [&] {
    std::vector<double> ms, psnr;
    for (int i = 0; i < effort.Of(3, 8); ++i) {
      const Rigid3 pose = LookAt({0.5 * std::sin(2.0 * i), 0.4 * std::cos(1.3 * i), 1.8}, Vector3d::Zero(),
                                 Vector3d::UnitY());
      const Rendering first = renderer->Render(camera, pose);
      const double before = ProcessCpuMs();
      renderer->Render(camera, pose);
      ms.push_back(ProcessCpuMs() - before);
      const cv::Mat truth = PhotographOfPlane(camera, pose);
      psnr.push_back(
          CompareImages(Srgb8FromLinear(first.linear), truth, cv::Mat(truth.size(), CV_8U, 255)).psnr_db);
    }
    return Price{Median(ms), ErrorOf(Median(psnr))};
  };
  const auto wall = std::make_shared<PlaneProxy>(scene->subject, PlaneProxy::InWorld{Vector3d::UnitZ(), 0.0});
  renderer->SetProxy(wall);
  const Price plane = price();
  const auto mesh = std::make_shared<TriangleMesh>(
      BuildProxy(*scene, {.size_px = 360, .depth_maps = effort.Of(8, 24)}).mesh);
  const auto proxy = std::make_shared<MeshProxy>(scene->subject, mesh);
  RequireChoice(*scene, wall, proxy, wall);
  renderer->SetProxy(proxy);
  prices.Add(kTooRich, "a mesh for a wall", price(), plane);
}

Chart MeasureWrongChoices(const Effort& effort) {
  const std::vector<unsigned> seeds = effort.Seeds(3);
  Table table;
  const Prices geometry{table, "lens, motion, map, refinement"}, pictures{table, "pictures"};
  const ChartAxis error{"error, times that of the right choice", true};
  table.Panel(geometry.panel, Log("parameters, time, keyframes or points, times as many"), error,
              {.compared = false, .joined = false});
  table.Panel(pictures.panel, Log("a picture's processor time, times that of the right choice"), error,
              {.compared = false, .joined = false});
  for (const unsigned seed : seeds) {
    PriceLenses(seed, geometry);
    PriceMotions(seed, geometry);
    PriceLensesOfRefinement(seed, geometry);
    PricePictures(seed, effort, pictures);
    PriceMeshOfAWall(seed, effort, pictures);
  }
  PriceMaps(seeds, effort.Of(60, 200), geometry);
  return {.panels = table.panels()};
}

CHART(wrong_choice, MeasureWrongChoices, "What a wrong choice of model costs, over the choice that is made",
      R"(Above one: worse, or dearer. Three seeds; bars: lowest to highest. Lens: 24 views of the board,
  error of left-out views, parameters. Motion: rotation, 20 pairs of views, half a pixel, a fifth wrong
  matches; the homography is OpenCV's and the best of its decompositions counts. Refinement: 12 views of the
  drawn room, centres. Map: the simulated studio, 200 frames, centres, keyframes or points. Pictures: the
  studio over its mesh, a drawn wall over its plane; error is the root mean square of levels, cost processor
  time.)");

}  // namespace
}  // namespace ulf::test
