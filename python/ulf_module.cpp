// The Python module `ulf`: a light field's poses, intrinsics, photographs, masks, depth and coverage as NumPy
// arrays, and its renderings. It is a door beside the command line, over the same libraries.
//
// Frames and pixels are those of core/geometry (cameras x right, y down, z forward; pixel centres at integer
// + 0.5), arrays are in row-major order, colours R, G, B. What the libraries throw becomes ulf.Error, and a
// request that cannot be met ulf.Refusal, with the same texts. Long calls release Python's lock, and a
// LightField may be used from several threads.
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/view_images.h"
#include "core/light_field/light_field.h"
#include "python/opened_field.h"

namespace ulf::python {
namespace {

namespace py = pybind11;
using Eigen::Matrix3d;
using Eigen::Matrix4d;

// Calls without Python's lock, so that its other threads go on.
template <typename Call>
auto Unlocked(const Call& call) {
  const py::gil_scoped_release release;
  return call();
}

// ---- Arrays ----

template <typename Number>
py::array ArrayOf(const cv::Mat& pixels) {
  std::vector<py::ssize_t> shape{pixels.rows, pixels.cols};
  if (pixels.channels() > 1) shape.push_back(pixels.channels());
  py::array_t<Number> array(shape);
  cv::Mat into(pixels.size(), pixels.type(), array.mutable_data());
  if (pixels.channels() == 3)
    cv::cvtColor(pixels, into, cv::COLOR_BGR2RGB);
  else
    pixels.copyTo(into);
  return array;
}

// True where the mask is not 0.
py::array Booleans(const cv::Mat& mask) {
  py::array_t<bool> array({mask.rows, mask.cols});
  bool* to = array.mutable_data();
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x) *to++ = mask.at<std::uint8_t>(y, x) != 0;
  return array;
}

// n x 3 numbers; `of(i)` gives a row.
template <typename Number, typename Of>
py::array Rows(std::size_t count, const Of& of) {
  py::array_t<Number> array({static_cast<py::ssize_t>(count), py::ssize_t{3}});
  Number* to = array.mutable_data();
  for (std::size_t i = 0; i < count; ++i)
    for (int c = 0; c < 3; ++c) *to++ = of(i)[c];
  return array;
}

Rigid3 PoseFrom(const Matrix4d& cam_from_world) {
  constexpr double kRounding = 1e-4;  // of a rotation in single precision. Guessed.
  const Matrix3d rotation = cam_from_world.topLeftCorner<3, 3>();
  if (!cam_from_world.allFinite() ||
      (rotation * rotation.transpose() - Matrix3d::Identity()).norm() > kRounding ||
      rotation.determinant() < 0 ||
      (cam_from_world.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).norm() > kRounding)
    throw Refusal("cam_from_world", "", "is no rigid transform",
                  "give a 4 x 4 matrix of a rotation and a translation, as View.cam_from_world is");
  return Rigid3::FromMatrix(cam_from_world);
}

// ---- Cameras ----

Matrix3d Intrinsics(const CameraModel& camera) {
  Matrix3d k = Matrix3d::Identity();
  k(0, 0) = camera.fx;
  k(1, 1) = camera.fy;
  k(0, 2) = camera.cx;
  k(1, 2) = camera.cy;
  return k;
}

const char* DistortionName(const CameraModel& camera) {
  switch (camera.distortion) {
    case Distortion::kRadialTangential:
      return "radial-tangential";
    case Distortion::kFisheye:
      return "fisheye";
    case Distortion::kNone:
      break;
  }
  return "none";
}

CameraModel CameraFrom(int width, int height, const Matrix3d& k) {
  if (k(0, 1) != 0 || k(1, 0) != 0 || k.row(2) != Eigen::RowVector3d(0, 0, 1))
    throw Refusal("K", "", "is no matrix of focal lengths and a principal point",
                  "give [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]");
  CameraModel camera{width, height, k(0, 0), k(1, 1), k(0, 2), k(1, 2)};
  camera.Validate("the camera");
  return camera;
}

// The pinhole camera of a rendering. Width or height alone keeps the shape, both keep the horizontal field of
// view.
CameraModel SizedPinhole(CameraModel camera, int width, int height) {
  constexpr int kMost = 16384;  // the largest picture that ulf renders
  if (width < 0 || height < 0 || width > kMost || height > kMost)
    throw Refusal(width < 0 || width > kMost ? "width" : "height",
                  std::to_string(width < 0 || width > kMost ? width : height), "is no number of pixels",
                  "give 1 to " + std::to_string(kMost));
  camera = camera.WithoutDistortion();
  if (width == 0 && height == 0) return camera;
  if (width == 0)
    width = std::max(1, static_cast<int>(std::lround(1.0 * camera.width * height / camera.height)));
  const int kept = std::max(1, static_cast<int>(std::lround(1.0 * camera.height * width / camera.width)));
  camera = camera.ScaledTo(width, kept);
  if (height > 0) {
    camera.cy += 0.5 * (height - kept);
    camera.height = height;
  }
  return camera;
}

// ---- What Python sees ----

// A view, which keeps its light field.
struct OpenedView {
  std::shared_ptr<OpenedField> field;
  std::size_t index = 0;
  const View& view() const { return field->light_field().views[index]; }
  const LightField& light_field() const { return field->light_field(); }
};

template <typename Number, typename Of>
py::array OfCells(const CapCoverage& coverage, const Of& of) {
  py::array_t<Number> array(static_cast<py::ssize_t>(coverage.cells.size()));
  std::transform(coverage.cells.begin(), coverage.cells.end(), array.mutable_data(), of);
  return array;
}

void AddCamera(py::module_& module) {
  py::class_<CameraModel>(module, "Camera", "Intrinsics. Pixel centres are at integer + 0.5.")
      .def(py::init(&CameraFrom), py::arg("width"), py::arg("height"), py::arg("K"),
           "A pinhole camera with the 3 x 3 matrix K, pixels.")
      .def_readonly("width", &CameraModel::width)
      .def_readonly("height", &CameraModel::height)
      .def_property_readonly("K", &Intrinsics,
                             "The 3 x 3 matrix of focal lengths and principal point, pixels.")
      .def_property_readonly(
          "distortion", &DistortionName,
          "'none', 'radial-tangential' (k1 k2 p1 p2 k3) or 'fisheye' (k1 k2 k3 k4), as OpenCV's.")
      .def_property_readonly(
          "coefficients",
          [](const CameraModel& camera) { return Eigen::Matrix<double, 5, 1>(camera.coefficients.data()); })
      .def("undistorted", &CameraModel::WithoutDistortion, "The same camera as a pinhole.");
}

void AddView(py::module_& module) {
  py::class_<OpenedView>(module, "View", "A photograph with its pose.")
      .def_property_readonly("id", [](const OpenedView& self) { return self.view().id; })
      .def_property_readonly(
          "name", [](const OpenedView& self) { return self.view().image_path; },
          "The photograph's path in the light field.")
      .def_property_readonly(
          "path", [](const OpenedView& self) { return self.light_field().root / self.view().image_path; })
      .def_property_readonly("camera",
                             [](const OpenedView& self) { return self.light_field().CameraOf(self.view()); })
      .def_property_readonly(
          "cam_from_world", [](const OpenedView& self) { return self.view().cam_from_world.Matrix(); },
          "4 x 4: from the world to the camera (x right, y down, z forward).")
      .def_property_readonly(
          "center", [](const OpenedView& self) { return self.view().CenterInWorld(); },
          "Where the camera stood, in the world.")
      .def_property_readonly(
          "time_s", [](const OpenedView& self) { return self.view().device_time_s; },
          "By the camera's clock; 0 where none is known.")
      .def_property_readonly(
          "exposure_s", [](const OpenedView& self) { return self.view().exposure_s; },
          "0 where it is unknown.")
      .def(
          "picture",
          [](const OpenedView& self) {
            return ArrayOf<std::uint8_t>(
                Unlocked([&] { return Srgb8(ReadRecordedImage(self.light_field(), self.view())); }));
          },
          "The photograph as recorded, distortion included: height x width x 3, 8-bit sRGB.")
      .def(
          "light",
          [](const OpenedView& self) {
            return ArrayOf<float>(
                Unlocked([&] { return LinearFloat(ReadViewLight(self.light_field(), self.view())); }));
          },
          "Linear light of the merged exposures, the master or the photograph, in shares of full scale: "
          "height x "
          "width x 3, float32.")
      .def(
          "mask",
          [](const OpenedView& self) -> py::object {
            const cv::Mat mask = Unlocked([&] { return ReadViewMask(self.light_field(), self.view()); });
            if (mask.empty()) return py::none();
            return Booleans(mask);
          },
          "True where pixels count: height x width. None where all do.")
      .def(
          "depth",
          [](const OpenedView& self) {
            const SeenDepth seen = Unlocked([&] { return self.field->DepthOf(self.view()); });
            return py::make_tuple(ArrayOf<float>(seen.depth), seen.camera);
          },
          "(depth, camera): depth along the optical axis in world units, float32, NaN where it is unknown, "
          "and the "
          "pinhole Camera of its pixels. From the view's depth map, or the mesh.");
}

void AddField(py::module_& module) {
  py::class_<OpenedField, std::shared_ptr<OpenedField>>(module, "LightField", "Photographs with poses.")
      .def_property_readonly("root", [](const OpenedField& self) { return self.light_field().root; })
      .def_property_readonly(
          "units", [](const OpenedField& self) { return self.light_field().units; },
          "Of the world: 'metres' or 'arbitrary'.")
      .def_property_readonly(
          "doubts", [](const OpenedField& self) { return self.light_field().doubts; },
          "Sentences on files that disagree or are damaged.")
      .def_property_readonly(
          "subject",
          [](const OpenedField& self) -> py::object {
            const auto& subject = self.light_field().subject;
            if (!subject) return py::none();
            return py::make_tuple(subject->center_in_world, subject->radius);
          },
          "(centre, radius) of the subject's sphere in the world, or None.")
      .def_property_readonly(
          "up", [](const OpenedField& self) { return self.light_field().UpInWorld(); },
          "Upwards in the world, of unit length.")
      .def("__len__", [](const OpenedField& self) { return self.light_field().views.size(); })
      .def_property_readonly(
          "views",
          [](const std::shared_ptr<OpenedField>& self) {
            std::vector<OpenedView> views;
            for (std::size_t i = 0; i < self->light_field().views.size(); ++i) views.push_back({self, i});
            return views;
          },
          "In order of id.")
      .def_property_readonly(
          "points",
          [](const OpenedField& self) {
            const auto& points = self.light_field().points;
            return Rows<double>(
                points.size(), [&](std::size_t i) -> const auto& { return points[i].position_in_world; });
          },
          "n x 3, in the world.")
      .def_property_readonly(
          "point_colors",
          [](const OpenedField& self) {
            const auto& points = self.light_field().points;
            return Rows<std::uint8_t>(
                points.size(), [&](std::size_t i) -> const auto& { return points[i].rgb; });
          },
          "n x 3, 8-bit sRGB.")
      .def(
          "coverage",
          [](const OpenedField& self, const std::optional<std::pair<double, double>>& cap_deg,
             const std::optional<double>& threshold_px) {
            return Unlocked([&] { return CoverageOfCap(self.light_field(), cap_deg, threshold_px); });
          },
          py::arg("cap_deg") = py::none(), py::arg("threshold_px") = py::none(),
          "Coverage of a cap by the bound, (azimuth, elevation) in degrees about the first view (the "
          "capture's goal, or "
          "the whole "
          "sphere), within threshold_px (the capture's, or 7).")
      .def(
          "render",
          [](OpenedField& self, const Matrix4d& cam_from_world, int width, int height,
             const std::optional<CameraModel>& camera, bool linear) {
            if (self.light_field().views.empty())
              throw Error("{}: holds no views to render from", self.light_field().root.string());
            const LightField& light_field = self.light_field();
            const CameraModel pinhole = SizedPinhole(
                camera ? *camera : light_field.CameraOf(light_field.views.front()), width, height);
            const Rigid3 pose = PoseFrom(cam_from_world);
            const cv::Mat light = Unlocked([&] { return self.Render(pinhole, pose); });
            return linear ? ArrayOf<float>(light) : ArrayOf<std::uint8_t>(Srgb8FromLinear(light));
          },
          py::arg("cam_from_world"), py::arg("width") = 0, py::arg("height") = 0,
          py::arg("camera") = py::none(), py::arg("linear") = false,
          "What a camera at this 4 x 4 pose sees, over the light field's best geometry: height x width x 3, "
          "8-bit "
          "sRGB, or linear light of the median exposure in float32. The camera is the first view's without "
          "its "
          "distortion unless another is given; width or height resize it.")
      .def(
          "left_out",
          [](OpenedField& self, const std::vector<int>& ids, const std::string& proxy) {
            return Unlocked([&] { return self.LeftOut(ids, proxy); });
          },
          py::arg("ids"), py::arg("proxy") = "auto",
          "Renders these views (their ids) from all others, as ulf evaluate does. A mesh knows the left-out "
          "photographs if it was made with them.");
  py::class_<LeftOutPicture>(module, "LeftOut",
                             "A left-out view, rendered from the others, beside its photograph.")
      .def_readonly("id", &LeftOutPicture::view_id)
      .def_property_readonly(
          "rendered", [](const LeftOutPicture& self) { return ArrayOf<std::uint8_t>(self.rendered); },
          "Height x width x 3, 8-bit sRGB, at the photograph's exposure.")
      .def_property_readonly(
          "photograph", [](const LeftOutPicture& self) { return ArrayOf<std::uint8_t>(self.photograph); },
          "The same without its distortion.")
      .def_property_readonly(
          "valid", [](const LeftOutPicture& self) { return Booleans(self.valid); },
          "True where the photograph has light.")
      .def_readonly("psnr_db", &LeftOutPicture::psnr_db)
      .def_readonly("ssim", &LeftOutPicture::ssim);
}

void AddCoverage(py::module_& module) {
  py::class_<CapCoverage>(module, "Coverage", "What views cover: a share, and a grid of directions.")
      .def_property_readonly(
          "share", [](const CapCoverage& self) { return self.map.CoveredShare(); },
          "Of the cap's solid angle, 0 to 1.")
      .def_property_readonly("threshold_px",
                             [](const CapCoverage& self) { return self.map.options().threshold_px; })
      .def_property_readonly(
          "directions",
          [](const CapCoverage& self) {
            return Rows<double>(
                self.cells.size(), [&](std::size_t i) -> const auto& { return self.cells[i].direction; });
          },
          "n x 3, unit vectors from the subject in the world.")
      .def_property_readonly("solid_angle_sr",
                             [](const CapCoverage& self) {
                               return OfCells<double>(self,
                                                      [](const auto& cell) { return cell.solid_angle_sr; });
                             })
      .def_property_readonly(
          "bound_px",
          [](const CapCoverage& self) {
            return OfCells<double>(self, [](const auto& cell) { return cell.covering.bound_px; });
          },
          "Of the best view, pixels of the coverage image; inf where a direction is open.")
      .def_property_readonly(
          "view_id",
          [](const CapCoverage& self) {
            return OfCells<int>(self, [&](const auto& cell) {
              const int view = cell.covering.index;
              return view < 0 ? -1 : self.view_ids[static_cast<std::size_t>(view)];
            });
          },
          "The view that covers a direction; -1 where it is open.");
}

std::shared_ptr<OpenedField> Open(const std::filesystem::path& dir,
                                  const std::optional<std::pair<Eigen::Vector3d, double>>& subject) {
  LightField light_field = Unlocked([&] { return ReadLightField(dir); });
  if (subject && !(subject->first.allFinite() && subject->second > 0 && std::isfinite(subject->second)))
    throw Refusal("subject", "", "is no sphere", "give (centre, radius), in the light field's world");
  if (subject) light_field.subject = {subject->first, subject->second};
  return std::make_shared<OpenedField>(std::move(light_field));
}

}  // namespace

PYBIND11_MODULE(ulf, module) {
  module.doc() = "Light fields of ulf as NumPy arrays.";
  // The library is one for the process: a name in its register could be another's.
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("ulf", std::make_shared<spdlog::sinks::stderr_sink_mt>()));
  spdlog::set_pattern("ulf: %v");
  spdlog::set_level(spdlog::level::warn);
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_ERROR);
  const auto error = py::register_exception<Error>(module, "Error", PyExc_RuntimeError);
  py::register_exception<Refusal>(module, "Refusal", error);
  AddCamera(module);
  AddView(module);
  AddField(module);
  AddCoverage(module);
  module.def(
      "open", &Open, py::arg("dir"), py::arg("subject") = py::none(),
      "Opens a light field, or a folder with transforms.json, and changes nothing in it. subject: (centre, "
      "radius) of the subject's sphere in the world, in place of the light field's.");
}

}  // namespace ulf::python
