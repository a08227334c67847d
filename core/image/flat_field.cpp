#include "core/image/flat_field.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "core/base/json_fields.h"
#include "core/base/quantile.h"

namespace ulf {
namespace {

// Thresholds of the estimate; shares are of full scale or of the light in the middle. All are guessed.
// Frames are refused that have more than kMostClippedOfCard of their values above kFullCard, or are darker on
// average.
constexpr double kFullCard = 0.98, kMostClippedOfCard = 0.002, kLeastLightOfCard = 0.06;
// A cell is dust if it is darker than the model by this many robust standard deviations, and by this share.
constexpr double kDustSigmas = 5, kLeastDust = 0.01;
// A richer model is taken when its BIC is lower by this and its error on left-out cells by so many standard
// errors (as in acquisition/calibration/lens_choice.h).
constexpr double kBicMargin = 10, kBetterStandardErrors = 2;
// Limits for the card's area in dark spots, the residual, and the fall-off of the lighting over the card.
constexpr double kMostDust = 0.1, kMostResidual = 0.015, kMostGradient = 0.35;

constexpr int kCellColumns = 48, kCellRows = 36;

struct Power {
  int x, y;
};

// A term of the model: a sum of powers with fixed weights (a radius squared is x x + y y).
using Term = std::vector<std::pair<Power, double>>;

Term RadiusTo(int exponent) {
  const int n = exponent / 2;
  Term term;
  double binomial = 1;
  for (int k = 0; k <= n; ++k) {
    term.push_back({{2 * (n - k), 2 * k}, binomial});
    binomial = binomial * (n - k) / (k + 1);
  }
  return term;
}

struct Model {
  std::string name;
  std::vector<Term> terms;
};

std::vector<Model> Models() {
  std::vector<Model> models = {{"even light", {}},
                               {"r^2", {RadiusTo(2)}},
                               {"r^2 r^4", {RadiusTo(2), RadiusTo(4)}},
                               {"r^2 r^4 r^6", {RadiusTo(2), RadiusTo(4), RadiusTo(6)}}};
  for (const int degree : {4, 6}) {
    Model model{"all powers up to " + std::to_string(degree), {}};
    for (int total = 2; total <= degree; ++total)
      for (int y = 0; y <= total; ++y) model.terms.push_back({{{total - y, y}, 1.0}});
    models.push_back(model);
  }
  return models;
}

// Logarithms of the light of all frames together, cell by cell.
struct Cells {
  Eigen::ArrayXd x, y;   // of a cell's middle, in half diagonals from the image's middle
  Eigen::MatrixX3d log;  // mean over frames
  Eigen::ArrayXd used;   // 1, or 0
};

double TrimmedMean(std::vector<float>& values) {
  const auto cut = static_cast<std::ptrdiff_t>(values.size() / 10);
  std::nth_element(values.begin(), values.begin() + cut, values.end());
  std::nth_element(values.begin() + cut, values.end() - 1 - cut, values.end());
  double sum = 0;
  for (auto value = values.begin() + cut; value != values.end() - cut; ++value) sum += *value;
  return sum / static_cast<double>(values.end() - values.begin() - 2 * cut);
}

Cells CellsOf(const std::vector<cv::Mat>& lights) {
  const cv::Size size = lights[0].size();
  const double half_diagonal = 0.5 * std::hypot(size.width, size.height);
  constexpr int kCells = kCellRows * kCellColumns;
  Cells cells{Eigen::ArrayXd(kCells), Eigen::ArrayXd(kCells), Eigen::MatrixX3d::Zero(kCells, 3),
              Eigen::ArrayXd::Ones(kCells)};
  for (int i = 0; i < kCells; ++i) {
    const int row = i / kCellColumns, column = i % kCellColumns;
    const cv::Rect box(
        {column * size.width / kCellColumns, row * size.height / kCellRows},
        cv::Point((column + 1) * size.width / kCellColumns, (row + 1) * size.height / kCellRows));
    cells.x(i) = (box.x + 0.5 * box.width - 0.5 * size.width) / half_diagonal;
    cells.y(i) = (box.y + 0.5 * box.height - 0.5 * size.height) / half_diagonal;
    for (const cv::Mat& light : lights)
      for (int c = 0; c < 3; ++c) {
        std::vector<float> values;
        for (int v = box.y; v < box.y + box.height; ++v)
          for (int u = box.x; u < box.x + box.width; ++u) values.push_back(light.at<cv::Vec3f>(v, u)[c]);
        cells.log(i, c) += std::log(std::max(1e-6, TrimmedMean(values))) / static_cast<double>(lights.size());
      }
  }
  return cells;
}

// The columns are 1, x, y (the lighting), then the model's terms.
Eigen::MatrixXd Design(const Cells& cells, const Model& model) {
  const auto terms = static_cast<Eigen::Index>(model.terms.size());
  Eigen::MatrixXd design = Eigen::MatrixXd::Zero(cells.x.size(), 3 + terms);
  design.leftCols<3>() << Eigen::VectorXd::Ones(cells.x.size()), cells.x.matrix(), cells.y.matrix();
  for (Eigen::Index t = 0; t < terms; ++t)
    for (const auto& [power, weight] : model.terms[static_cast<std::size_t>(t)])
      design.col(3 + t).array() += weight * cells.x.pow(power.x) * cells.y.pow(power.y);
  return design;
}

// Solves least squares on the rows that are `used`; residuals are of all rows.
struct Fit {
  Eigen::MatrixXd coefficients, residuals;
  double SquaresOf(const Eigen::ArrayXd& rows) const {
    return (rows * residuals.rowwise().squaredNorm().array()).sum();
  }
};
Fit Solve(const Eigen::MatrixXd& design, const Eigen::MatrixXd& logs, const Eigen::ArrayXd& used) {
  const Eigen::MatrixXd weighted = used.matrix().asDiagonal() * design;
  Fit fit;
  fit.coefficients = (weighted.transpose() * design).ldlt().solve(weighted.transpose() * logs);
  fit.residuals = logs - design * fit.coefficients;
  return fit;
}

// Marks cells that are much darker than the richest model as unused; returns how many spots they form.
int RemoveDust(Cells& cells) {
  constexpr double kNormalQuartile = 0.6745;  // median of |x| for a Gaussian of sigma 1
  const Eigen::MatrixXd design = Design(cells, Models().back());
  for (int round = 0; round < 4; ++round) {
    const Eigen::ArrayXd means = Solve(design, cells.log, cells.used).residuals.rowwise().mean();
    const Eigen::ArrayXd sizes = means.abs();
    const double gate =
        std::max(kLeastDust, kDustSigmas * Median({sizes.begin(), sizes.end()}) / kNormalQuartile);
    cells.used = (means > -gate).cast<double>();
  }
  cv::Mat spots(kCellRows, kCellColumns, CV_8UC1);
  for (int i = 0; i < kCellRows * kCellColumns; ++i)
    spots.at<std::uint8_t>(i / kCellColumns, i % kCellColumns) = cells.used(i) == 0;
  cv::Mat labels;
  return cv::connectedComponents(spots, labels) - 1;
}

// Returns the simplest model that no richer one beats clearly, by BIC and on left-out cells (as
// lens_choice.h).
struct Scored {
  Fit fit;
  double bic = 0;
  Eigen::ArrayXd left_out;  // squared error, by fold
};

Scored Score(const Cells& cells, const Model& model) {
  constexpr int kFolds = 8;
  const Eigen::MatrixXd design = Design(cells, model);
  Scored scored{Solve(design, cells.log, cells.used), 0, Eigen::ArrayXd(kFolds)};
  const double count = 3 * cells.used.sum();
  scored.bic = count * std::log(scored.fit.SquaresOf(cells.used) / count + 1e-18) +
               3 * static_cast<double>(design.cols()) * std::log(count);
  // Neighbouring cells are not independent, so a fold leaves out whole patches of cells.
  constexpr int kPatch = 6;
  for (int fold = 0; fold < kFolds; ++fold) {
    Eigen::ArrayXd in_fold = cells.used;
    for (int i = 0; i < in_fold.size(); ++i)
      if ((i % kCellColumns / kPatch + 3 * (i / kCellColumns / kPatch)) % kFolds != fold) in_fold(i) = 0;
    const Fit fit = Solve(design, cells.log, cells.used - in_fold);
    scored.left_out(fold) = fit.SquaresOf(in_fold) / std::max(1.0, in_fold.sum());
  }
  return scored;
}

bool IsClearlyBetter(const Scored& other, const Scored& than) {
  if (other.bic > than.bic - kBicMargin) return false;
  const Eigen::ArrayXd better = than.left_out - other.left_out;
  const auto count = static_cast<double>(better.size());
  const double squares = (better - better.mean()).square().sum();
  return better.mean() > kBetterStandardErrors * std::sqrt(squares / (count - 1) / count);
}

std::string ExposureProblem(const std::vector<cv::Mat>& lights) {
  for (std::size_t f = 0; f < lights.size(); ++f) {
    const cv::Mat values = lights[f].reshape(1);
    const double clipped =
        static_cast<double>(cv::countNonZero(values > kFullCard)) / static_cast<double>(values.total());
    if (clipped > kMostClippedOfCard)
      return fmt::format(
          "frame {}: {:.1f} % of the values are clipped; expose less, so that the card is at half of full "
          "scale",
          f + 1, 100 * clipped);
    const cv::Scalar mean = cv::mean(lights[f]);
    for (int c = 0; c < 3; ++c)
      if (mean[c] < kLeastLightOfCard)
        return fmt::format(
            "frame {}: the card is too dark ({:.1f} % of full scale); expose more, to about half", f + 1,
            100 * mean[c]);
  }
  return {};
}

void AddPowers(const Model& model, const Eigen::MatrixXd& coefficients, FlatField& flat_field) {
  for (std::size_t t = 0; t < model.terms.size(); ++t)
    for (const auto& [power, weight] : model.terms[t]) {
      FlatFieldPower term{power.x, power.y, {}};
      for (int c = 0; c < 3; ++c)
        term.bgr[static_cast<std::size_t>(c)] = weight * coefficients(static_cast<Eigen::Index>(3 + t), c);
      flat_field.powers.push_back(term);
    }
}

}  // namespace

cv::Mat FlatField::Light(int used_width, int used_height) const {
  const double half_diagonal = 0.5 * std::hypot(width, height);
  int degree = 0;
  for (const FlatFieldPower& power : powers) degree = std::max({degree, power.x, power.y});
  const auto powers_of = [&](double value) {
    std::vector<double> list(static_cast<std::size_t>(degree) + 1, 1);
    for (std::size_t i = 1; i < list.size(); ++i) list[i] = list[i - 1] * value;
    return list;
  };
  std::vector<std::vector<double>> xs;
  for (int u = 0; u < used_width; ++u)
    xs.push_back(powers_of((offset_x + scale_x * (u + 0.5) - 0.5 * width) / half_diagonal));
  cv::Mat light(used_height, used_width, CV_32FC3);
  for (int v = 0; v < used_height; ++v) {
    const std::vector<double> ys = powers_of((offset_y + scale_y * (v + 0.5) - 0.5 * height) / half_diagonal);
    for (int u = 0; u < used_width; ++u) {
      std::array<double, 3> sum{};
      for (const FlatFieldPower& power : powers) {
        const double value = xs[static_cast<std::size_t>(u)][static_cast<std::size_t>(power.x)] *
                             ys[static_cast<std::size_t>(power.y)];
        for (std::size_t c = 0; c < 3; ++c) sum[c] += power.bgr[c] * value;
      }
      light.at<cv::Vec3f>(v, u) = {std::exp(static_cast<float>(sum[0])), std::exp(static_cast<float>(sum[1])),
                                   std::exp(static_cast<float>(sum[2]))};
    }
  }
  return light;
}

Image FlatField::Corrected(const Image& image, double black_level) const {
  cv::Mat linear = LinearFloat(image);
  const cv::Scalar black = cv::Scalar::all(black_level);
  cv::Mat corrected = linear - black;
  cv::divide(corrected, Light(image.width(), image.height()), corrected);
  corrected += black;
  return {corrected, Transfer::kLinear};
}

FlatField FlatField::ForWindow(const SensorWindow& estimated, const SensorWindow& used) const {
  FlatField moved = *this;
  moved.scale_x = static_cast<double>(used.binning_x) / estimated.binning_x;
  moved.scale_y = static_cast<double>(used.binning_y) / estimated.binning_y;
  moved.offset_x = static_cast<double>(used.x - estimated.x) / estimated.binning_x;
  moved.offset_y = static_cast<double>(used.y - estimated.y) / estimated.binning_y;
  return moved;
}

FlatField FlatField::ForSize(int used_width, int used_height) const {
  FlatField moved = *this;
  moved.scale_x = static_cast<double>(width) / used_width;
  moved.scale_y = static_cast<double>(height) / used_height;
  return moved;
}

FlatFieldResult EstimateFlatField(const std::vector<Image>& cards, double black_level) {
  FlatFieldResult result;
  result.frames = static_cast<int>(cards.size());
  std::vector<cv::Mat> lights;
  for (const Image& card : cards) {
    cv::Mat light = LinearFloat(card);
    light -= cv::Scalar::all(black_level);
    lights.push_back(light);
  }
  if (lights.empty()) result.refusal = "no frame of a card";
  for (const cv::Mat& light : lights)
    if (light.size() != lights[0].size()) result.refusal = "the frames have different sizes";
  if (result.ok() && (lights[0].cols < 2 * kCellColumns || lights[0].rows < 2 * kCellRows))
    result.refusal = "the frames are too small";
  if (result.ok()) result.refusal = ExposureProblem(lights);
  if (!result.ok()) return result;

  Cells cells = CellsOf(lights);
  result.dust = RemoveDust(cells);
  const std::vector<Model> models = Models();
  std::vector<Scored> scored;
  for (const Model& model : models) scored.push_back(Score(cells, model));
  std::size_t chosen = 0;
  while (chosen + 1 < models.size() &&
         std::any_of(scored.begin() + static_cast<std::ptrdiff_t>(chosen) + 1, scored.end(),
                     [&](const Scored& richer) { return IsClearlyBetter(richer, scored[chosen]); }))
    ++chosen;

  const Fit& fit = scored[chosen].fit;
  result.model = models[chosen].name;
  FlatField& flat_field = result.flat_field;
  flat_field.width = cards[0].width();
  flat_field.height = cards[0].height();
  AddPowers(models[chosen], fit.coefficients, flat_field);
  const double count = cells.used.sum();
  const Eigen::ArrayXd means = fit.residuals.rowwise().mean();
  result.residual = std::sqrt((cells.used * means.square()).sum() / std::max(1.0, count));
  result.gradient = 2 * std::hypot(fit.coefficients(1, 1), fit.coefficients(2, 1));
  const cv::Mat light = flat_field.Light(flat_field.width, flat_field.height);
  for (int c = 0; c < 3; ++c) {
    float darkest = std::numeric_limits<float>::infinity();
    for (const cv::Point at : {cv::Point(0, 0), cv::Point(light.cols - 1, 0), cv::Point(0, light.rows - 1),
                               cv::Point(light.cols - 1, light.rows - 1)})
      darkest = std::min(darkest, light.at<cv::Vec3f>(at)[c]);
    result.corner_bgr[static_cast<std::size_t>(c)] = darkest;
  }
  const double left_out = 1 - count / (kCellColumns * kCellRows);
  if (left_out > kMostDust)
    result.refusal = fmt::format(
        "{:.0f} % of the card is darker in spots: shadows, dirt or print on the card", 100 * left_out);
  else if (result.residual > kMostResidual)
    result.refusal = fmt::format(
        "the card is uneven: no smooth darkening explains {:.1f} % of the light; take a plain matt card, out "
        "of focus and evenly lit",
        100 * result.residual);
  else if (result.gradient > kMostGradient)
    result.refusal =
        fmt::format("the light falls off by {:.0f} % over the card; light it evenly", 100 * result.gradient);
  return result;
}

nlohmann::json FlatFieldToJson(const FlatField& flat_field) {
  nlohmann::json powers = nlohmann::json::array();
  for (const FlatFieldPower& power : flat_field.powers)
    powers.push_back({{"x", power.x}, {"y", power.y}, {"bgr", power.bgr}});
  return {{"width", flat_field.width},
          {"height", flat_field.height},
          {"log_light_powers", powers},
          {"offset", {flat_field.offset_x, flat_field.offset_y}},
          {"scale", {flat_field.scale_x, flat_field.scale_y}}};
}

FlatField FlatFieldFromJson(const nlohmann::json& json, const std::string& where) {
  const JsonPlace place{json, where + ", flat_field"};
  FlatField flat_field;
  flat_field.width = place.Integer("width");
  flat_field.height = place.Integer("height");
  if (flat_field.width <= 0 || flat_field.height <= 0)
    throw Error("{}: {}x{} is no image size", place.where, flat_field.width, flat_field.height);
  const nlohmann::json& powers = place.Raw("log_light_powers");
  if (!powers.is_array()) throw Error("{}: 'log_light_powers' must be a list", place.where);
  for (const nlohmann::json& entry : powers) {
    const JsonPlace power{entry, place.where};
    FlatFieldPower term{power.Integer("x"), power.Integer("y"), {}};
    if (term.x < 0 || term.y < 0 || term.x + term.y > 12)
      throw Error("{}: x^{} y^{} is not among the powers used here", place.where, term.x, term.y);
    const std::vector<double> bgr = power.Numbers("bgr", 3);
    std::ranges::copy(bgr, term.bgr.begin());
    flat_field.powers.push_back(term);
  }
  const std::vector<double> offset = place.Numbers("offset", 2), scale = place.Numbers("scale", 2);
  flat_field.offset_x = offset[0];
  flat_field.offset_y = offset[1];
  flat_field.scale_x = scale[0];
  flat_field.scale_y = scale[1];
  return flat_field;
}

}  // namespace ulf
