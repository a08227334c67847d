// The quartic box spline of three directions, to which Loop subdivision converges where every vertex has six
// neighbours (Loop 1987; the polynomials are those of Stam, "Evaluation of Loop subdivision surfaces", 1998).
//
// Over one triangle it is a polynomial of degree four in the barycentric coordinates (u, v, w), a sum over
// the twelve vertices around:
//
//             9---10
//            / \ / \            0, 1, 2     the triangle's corners: (1, 0, 0), (0, 1, 0), (0, 0, 1)
//           5---2---4           3, 4, 5     beyond the edges 01, 12, 20
//          / \ / \ / \          6, 7        around corner 0, beside 3 and beside 5
//         7---0---1---8         8, 9 ...    in the same way around 1 (8 beside 4, 11 beside 3)
//          \ / \ / \ /                      and 2 (9 beside 5, 10 beside 4)
//           6---3---11
#pragma once

#include <Eigen/Core>
#include <array>

namespace ulf::render {

inline constexpr int kBoxSplineVertices = 12;
inline constexpr int kQuarticTerms = 15;

// The weights of the twelve vertices at a place. They are not negative and sum to one.
std::array<double, kBoxSplineVertices> BoxSplineWeights(const Eigen::Vector3d& barycentric);

// The products u^i v^j w^k with i + j + k = 4, times 4! / (i! j! k!): Bernstein's polynomials. In the order
// of `QuarticExponents()`, which the shader fan_batch.frag has, too.
std::array<double, kQuarticTerms> QuarticBernstein(const Eigen::Vector3d& barycentric);
const std::array<std::array<int, 3>, kQuarticTerms>& QuarticExponents();

// The coefficients of those products in the polynomial that has these values at the places (i, j, k) / 4.
std::array<double, kQuarticTerms> QuarticThrough(const std::array<double, kQuarticTerms>& values);

}  // namespace ulf::render
