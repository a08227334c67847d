#include "tests/charts/solvers.h"

#include <opengv/types.hpp>

#include <opengv/absolute_pose/CentralAbsoluteAdapter.hpp>
#include <opengv/absolute_pose/methods.hpp>
#include <opengv/relative_pose/CentralRelativeAdapter.hpp>
#include <opengv/relative_pose/methods.hpp>

#include "tests/support/floors.h"
#include "tracking/estimation/relative_pose.h"

namespace ulf::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Vectors = std::span<const Vector3d>;

void AddPose(const opengv::transformation_t& world_from_cam, std::vector<Rigid3>& poses) {
  if (!world_from_cam.allFinite()) return;
  const Matrix3d rotation = world_from_cam.leftCols<3>();
  if (std::abs(rotation.determinant() - 1) > 1e-3) return;
  poses.push_back(Rigid3{Eigen::Quaterniond(rotation).normalized(), world_from_cam.col(3)}.Inverse());
}

template <auto kMethod>
std::vector<Rigid3> SolveAbsolute(Vectors points, Vectors rays) {
  const opengv::points_t gv_points(points.begin(), points.end());
  const opengv::bearingVectors_t gv_rays(rays.begin(), rays.end());
  opengv::absolute_pose::CentralAbsoluteAdapter adapter(gv_rays, gv_points);
  std::vector<Rigid3> poses;
  kMethod(adapter, poses);
  return poses;
}

void Gao(const opengv::absolute_pose::CentralAbsoluteAdapter& adapter, std::vector<Rigid3>& poses) {
  for (const auto& solution : opengv::absolute_pose::p3p_gao(adapter)) AddPose(solution, poses);
}
void Epnp(const opengv::absolute_pose::CentralAbsoluteAdapter& adapter, std::vector<Rigid3>& poses) {
  AddPose(opengv::absolute_pose::epnp(adapter), poses);
}
void Upnp(const opengv::absolute_pose::CentralAbsoluteAdapter& adapter, std::vector<Rigid3>& poses) {
  for (const auto& solution : opengv::absolute_pose::upnp(adapter)) AddPose(solution, poses);
}

// OpenGV's essential matrices are first^T E second = 0.
void AddEssential(const Matrix3d& essential, std::vector<Matrix3d>& essentials) {
  if (essential.allFinite()) essentials.emplace_back(essential.transpose());
}

template <auto kMethod>
std::vector<Matrix3d> SolveRelative(Vectors first, Vectors second) {
  const opengv::bearingVectors_t gv_first(first.begin(), first.end()),
      gv_second(second.begin(), second.end());
  opengv::relative_pose::CentralRelativeAdapter adapter(gv_first, gv_second);
  std::vector<Matrix3d> essentials;
  kMethod(adapter, essentials);
  return essentials;
}

void Nister(opengv::relative_pose::CentralRelativeAdapter& adapter, std::vector<Matrix3d>& essentials) {
  for (const auto& essential : opengv::relative_pose::fivept_nister(adapter))
    AddEssential(essential, essentials);
}
void SevenPoint(opengv::relative_pose::CentralRelativeAdapter& adapter, std::vector<Matrix3d>& essentials) {
  for (const auto& essential : opengv::relative_pose::sevenpt(adapter)) AddEssential(essential, essentials);
}
void EightPoint(opengv::relative_pose::CentralRelativeAdapter& adapter, std::vector<Matrix3d>& essentials) {
  AddEssential(opengv::relative_pose::eightpt(adapter), essentials);
}
// Iterates from no rotation, as between frames of a film.
void Eigensolver(opengv::relative_pose::CentralRelativeAdapter& adapter, std::vector<Matrix3d>& essentials) {
  opengv::eigensolverOutput_t output;
  output.rotation.setIdentity();  // it starts here, not at the adapter's rotation
  opengv::relative_pose::eigensolver(adapter, output);
  const Rigid3 first_from_second{Eigen::Quaterniond(output.rotation).normalized(), output.translation};
  if (!output.rotation.allFinite() || !(output.translation.norm() > 0)) return;
  Rigid3 second_from_first = first_from_second.Inverse();
  second_from_first.translation.normalize();
  essentials.push_back(EssentialFromPose(second_from_first));
}

}  // namespace

std::vector<NamedAbsoluteSolver> AbsoluteSolvers() {
  return {{"P3P Kneip", {3, SolveP3p}},
          {"P3P Gao", {3, SolveAbsolute<Gao>}},
          {"EPnP", {6, SolveAbsolute<Epnp>}},
          {"UPnP", {4, SolveAbsolute<Upnp>}}};
}

std::vector<NamedEssentialSolver> EssentialSolvers() {
  return {{"5 points, Stewenius", {5, SolveFivePoint}},
          {"5 points, Nister", {5, SolveRelative<Nister>}},
          {"7 points", {7, SolveRelative<SevenPoint>}},
          {"8 points", {8, SolveRelative<EightPoint>}},
          {"eigensolver", {10, SolveRelative<Eigensolver>}}};
}

}  // namespace ulf::test
