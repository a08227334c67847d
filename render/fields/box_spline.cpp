#include "render/fields/box_spline.h"

#include <Eigen/LU>
#include <cmath>

#include "core/base/at.h"

namespace ulf::render {
namespace {

// Stam's polynomials times twelve. There are three, up to the order of u, v and w.
double OfCorner(double u, double v, double w) {  // the corner u = 1
  const double u2 = u * u, v2 = v * v, w2 = w * w;
  return 6 * u2 * u2 + 24 * u2 * u * (v + w) + 24 * u2 * (v2 + w2) + 60 * u2 * v * w +
         8 * u * (v2 * v + w2 * w) + 36 * u * v * w * (v + w) + v2 * v2 + 6 * v2 * v * w + 12 * v2 * w2 +
         6 * v * w2 * w + w2 * w2;
}
double BeyondEdge(double u, double v, double w) {  // the edge w = 0
  const double u2 = u * u, v2 = v * v;
  return u2 * u2 + 6 * u2 * u * v + 12 * u2 * v2 + 6 * u * v2 * v + v2 * v2 + 2 * w * (u2 * u + v2 * v) +
         6 * u * v * w * (u + v);
}
double Outermost(double u, double v) {  // around the corner u = 1, towards v
  return u * u * u * (u + 2 * v);
}

using Coefficients = Eigen::Matrix<double, kQuarticTerms, kQuarticTerms>;

Coefficients CoefficientsFromValues() {
  Coefficients values;
  for (int place = 0; place < kQuarticTerms; ++place) {
    const auto& [i, j, k] = QuarticExponents()[At(place)];
    const auto terms = QuarticBernstein(Eigen::Vector3d(i, j, k) / 4);
    for (int term = 0; term < kQuarticTerms; ++term) values(place, term) = terms[At(term)];
  }
  return values.inverse();
}

}  // namespace

std::array<double, kBoxSplineVertices> BoxSplineWeights(const Eigen::Vector3d& barycentric) {
  const double u = barycentric.x(), v = barycentric.y(), w = barycentric.z();
  std::array<double, kBoxSplineVertices> weights{
      OfCorner(u, v, w),   OfCorner(v, w, u),   OfCorner(w, u, v),  //
      BeyondEdge(u, v, w), BeyondEdge(v, w, u), BeyondEdge(w, u, v), Outermost(u, v), Outermost(u, w),
      Outermost(v, w),     Outermost(w, u),     Outermost(w, v),     Outermost(v, u)};
  for (double& weight : weights) weight /= 12;
  return weights;
}

const std::array<std::array<int, 3>, kQuarticTerms>& QuarticExponents() {
  static const auto kExponents = [] {
    std::array<std::array<int, 3>, kQuarticTerms> exponents{};
    std::size_t term = 0;
    for (int i = 4; i >= 0; --i)
      for (int j = 4 - i; j >= 0; --j) exponents[term++] = {i, j, 4 - i - j};
    return exponents;
  }();
  return kExponents;
}

std::array<double, kQuarticTerms> QuarticBernstein(const Eigen::Vector3d& barycentric) {
  constexpr std::array kFactorial{1, 1, 2, 6, 24};
  std::array<double, kQuarticTerms> terms{};
  for (std::size_t term = 0; term < terms.size(); ++term) {
    const auto& exponents = QuarticExponents()[term];
    terms[term] = kFactorial[4];
    for (int axis = 0; axis < 3; ++axis)
      terms[term] *= std::pow(barycentric(axis), exponents[At(axis)]) / kFactorial[At(exponents[At(axis)])];
  }
  return terms;
}

std::array<double, kQuarticTerms> QuarticThrough(const std::array<double, kQuarticTerms>& values) {
  static const Coefficients kCoefficientsFromValues = CoefficientsFromValues();
  std::array<double, kQuarticTerms> coefficients{};
  for (int term = 0; term < kQuarticTerms; ++term)
    for (int place = 0; place < kQuarticTerms; ++place)
      coefficients[At(term)] += kCoefficientsFromValues(term, place) * values[At(place)];
  return coefficients;
}

}  // namespace ulf::render
