// The data of a light field: photographs with poses, and a sphere around the subject (thesis "Unstructured
// Light Fields", MIT 2012, section 2.1). core/light_field/folder/light_field_io.h reads and writes it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/geometry/sensor_window.h"
#include "core/image/color_profile.h"
#include "core/image/flat_field.h"
#include "core/image/image.h"
#include "core/light_field/findings.h"

namespace ulf {

// The bounding sphere of the subject, in world units.
struct Subject {
  Eigen::Vector3d center_in_world = Eigen::Vector3d::Zero();
  double radius = 0;
  bool operator==(const Subject&) const = default;
};

// Parses "x,y,z,r" in world units. Throws Refusal for anything else, and unless r is positive.
Subject ParseSubject(const std::string& text);

// A rolling shutter's readout, row after row.
struct ShutterReadout {
  double readout_s = 0;           // first row to last; negative: upwards; 0: global shutter
  std::optional<double> sigma_s;  // standard deviation; none: not measured
  bool operator==(const ShutterReadout&) const = default;
};

// The files of one exposure, and how it was taken.
struct StoredExposure {
  std::string image_path;   // relative to the light field, '/'-separated: 8-bit sRGB for every tool
  std::string master_path;  // the picture beyond 8-bit sRGB; empty if there is nothing more
  // The transfer function of the master's numbers; none for a camera's raw file.
  std::optional<Transfer> master_transfer;
  Mosaic master_mosaic = Mosaic::kNone;
  // The factors of the sensor's red, green and blue with which a raw master is developed (green is 1), if
  // they are not the file's own but those of the light field's first raw file of this camera.
  std::optional<std::array<double, 3>> raw_white_balance;
  double device_time_s = 0;  // both times are as in Frame (core/frames/frame.h)
  double host_time_s = 0;
  double exposure_s = 0;   // 0: unknown
  double gain = 1;         // as a factor
  double black_level = 0;  // as a share of full scale
  std::optional<double> f_number;
};

// Another exposure of a view, for merging: an image or a master, or both, and a known exposure time.
struct ViewExposure : StoredExposure {
  // The transform from the view's camera frame to this exposure's. Its translation is in world units.
  Rigid3 exposure_from_view;
  bool pose_is_between = false;  // interpolated between frames before and after, not found in the exposure
};

// A view and its exposures merged to one picture of linear light.
struct MergedExposures {
  std::string path;        // OpenEXR, relative to the light field
  int exposures = 0;       // number of merged exposures with the view's own
  double ghost_share = 0;  // share of pixels that use one exposure, because others disagree
};

// A recorded frame: image, camera, pose.
struct View : StoredExposure {
  int id = 0;                      // unique, in order of recording, never used again
  std::string mask_path;           // one channel, of the image's size, 0: excluded; empty: no mask
  bool mask_marks_unused = false;  // the opposite, 0: used; only in sets of instant-ngp, never in a journal
  int camera = 0;                  // index into LightField::cameras
  Rigid3 cam_from_world;
  // The pose when the view was recorded; later corrections change cam_from_world only.
  std::optional<Rigid3> recorded_cam_from_world;
  // The frame's number and the states of the camera's lines, one bit each, if the camera sent them.
  std::optional<std::uint64_t> frame_id, line_status;
  bool on_shared_clock = false;    // IEEE 1588 sets the clock of device_time_s
  std::optional<double> focal_mm;  // of the lens, mm, as the camera reports it
  std::string lens = {};           // model as its maker names it; empty if unknown
  double tracking_quality = 1;     // 0 to 1, by the pose's predicted error; 1 is best (docs/tracking.md)
  // The camera's velocity during readout, if a rolling shutter was compensated, in the middle row's frame:
  // rotation (rad/s), then translation (world units/s).
  std::optional<std::array<double, 6>> twist;
  // The coverage bound when the view was recorded, px of the coverage image; none for the first view.
  std::optional<double> bound_px;
  std::vector<ViewExposure> exposures = {};  // further exposures, in order of time
  std::optional<MergedExposures> merged = {};

  Eigen::Vector3d CenterInWorld() const { return cam_from_world.OriginInSource(); }
};

// Returns whether the view's light has Rec. 709 primaries without a colour profile: the camera encoded its
// picture as sRGB, or its raw file is developed by the file's own matrix. Otherwise (a linear master) the
// colours are the sensor's own.
inline bool HasRec709Colors(const View& view) { return view.master_transfer != Transfer::kLinear; }

// A view's observation of a point: pixels of its image as recorded, distortion included.
struct ViewObservation {
  int view_id = 0;
  Eigen::Vector2d in_img = Eigen::Vector2d::Zero();
};

struct ScenePoint {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  std::array<std::uint8_t, 3> rgb{128, 128, 128};
  double error_px = 0;                   // mean reprojection error of its observations
  std::vector<ViewObservation> track{};  // at most one a view; empty if unknown
};

// The goal of a capture: a cap, in degrees of azimuth and elevation, and the share of it that is enough.
struct CoverageGoal {
  Eigen::Vector2d cap_deg;
  double share = 1;
  bool operator==(const CoverageGoal&) const = default;
};

// How well recorded views predicted frames of a capture (docs/capture.md, "Measured errors"), by direction.
struct MeasuredDirection {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  // from the subject, unit, world frame
  double nearest_view_angle = 0;  // radians, to the nearest recorded view at that moment
  double one_sided = 0;           // 0: the views stand all round the frame; 1: all on one side of it
  double db = 0, db_outside = 0;  // PSNR in dB, inside the subject's silhouette and around it
  double misregistration_px = 0;  // px of the small pictures that are compared
  std::string cause;              // name of the error's cause
};
struct MeasuredErrors {
  std::string cover = "bound";  // name of the rule by which a viewpoint counts as covered
  double goal_db = 0;           // PSNR that is enough
  std::uint64_t frames = 0;     // number of measured frames
  std::vector<MeasuredDirection> directions;
};

// Says that the camera stood while the subject turned on a printed board, whose frame is the world. The masks
// of such a light field exclude the still background; renderings are empty there.
struct Turntable {
  std::string board;  // in the form of core/fiducials/board.h; empty: none or unknown
  bool operator==(const Turntable&) const = default;
};

// A photograph in unposed/.
struct UnposedPhotograph {
  View view;            // id 0 and no pose
  std::string problem;  // why it cannot become a view; empty: it can, with a pose
};

// A camera for a light field, which begins with one and gets another for each lens that the user gives later.
struct NewCamera {
  CameraModel camera;
  std::optional<FlatField> flat_field;
  std::optional<ColorProfile> color_profile;
  std::string calibration_source;
};

// The width of the coverage image, pixels, to which thresholds refer.
inline constexpr int kCoverageWidthPx = 640;
// The width of the image of the subject's sphere, for a subject that is found automatically, as a share of
// the picture's width.
inline constexpr double kSubjectSize = 0.28;

// The device and the choices with which a capture begins.
struct CaptureFacts {
  std::string device_uri;
  std::string device_serial, device_maker, device_model;
  std::optional<SensorWindow> window;  // the part of the sensor in the views; none: unknown, or photographs
  std::string units = "arbitrary";     // or "metres"
  std::optional<double> threshold_px;  // largest bound at which a direction counts as covered
  int coverage_width_px = kCoverageWidthPx;  // in this image's pixels bounds and threshold are
};

// The values of the journal's header, noted when a capture begins.
struct CaptureHeader : NewCamera, CaptureFacts {};

struct LightField : CaptureFacts {
  std::filesystem::path root;  // the folder
  std::vector<CameraModel> cameras;
  // Measured flat fields by index into cameras. The photographs are uncorrected; ReadViewImage divides by it.
  std::map<int, FlatField> flat_fields;
  std::map<int, ColorProfile> color_profiles;  // by the same index; ReadViewImage applies it
  std::vector<View> views;                     // in order of id
  // The journal's photographs without a pose. Their files may have been removed since, and others may lie
  // beside them (unposed_photographs.h).
  std::vector<UnposedPhotograph> unposed;
  std::optional<Subject> subject;
  std::optional<Eigen::Vector3d> up_in_world;  // unit; none: UpInWorld() finds it by the cameras
  std::optional<CoverageGoal> goal;            // the last one given; none: the operator ends the capture
  std::optional<Turntable> turntable;          // none: the subject did not turn
  std::optional<ShutterReadout> readout;       // measured or given in the last session; none: unknown
  // The origin of the intrinsics by index into cameras, if known.
  std::map<int, std::string> calibration_sources;
  std::set<int> taken_back;                      // ids of views that were recorded and removed again
  double capture_s = 0;                          // length of all sessions, by the device's clock
  std::map<std::string, std::uint64_t> reasons;  // number of frames by why they were recorded or not
  std::optional<MeasuredErrors> measured;        // none: the capture measured none
  std::vector<ScenePoint> points;
  // Number of observations left out on reading, because their error exceeded kMostTrackErrorPx.
  std::size_t misplaced_observations = 0;
  std::vector<std::string> doubts;  // sentences on files of the folder that disagree or are damaged
  std::vector<Finding> findings;    // what the other checks found (findings.h)

  Eigen::Vector3d UpInWorld() const;  // unit
  // Adds the camera and returns its index.
  int AddCamera(const NewCamera& camera);
  // Returns the origin of the camera's intrinsics; empty if unknown.
  std::string CalibrationSource(int camera) const;
  const CameraModel& CameraOf(const View& view) const {
    return cameras[static_cast<std::size_t>(view.camera)];
  }
  // Returns the view of this id; null if there is none.
  const View* FindView(int id) const;
  View* FindView(int id) { return const_cast<View*>(std::as_const(*this).FindView(id)); }
  // Returns a checksum of the view's pose and camera (core/geometry/digest.h).
  std::uint64_t PoseDigest(const View& view) const;
};

// New intrinsics of a camera that a light field has.
struct CorrectedLens {
  CameraModel camera;
  std::string calibration_source;  // empty: unchanged
};

inline cv::Size SizeOf(const CameraModel& camera) { return {camera.width, camera.height}; }
// Returns whether pictures of this size are the camera's, resized and not cropped, except for rounding.
inline bool HasAspectOf(const CameraModel& camera, cv::Size size) {
  constexpr double kRounding_px = 1;
  return std::abs(static_cast<double>(size.width) / camera.width * camera.height - size.height) <=
         kRounding_px;
}

// Replaces the subject. Drops the measured errors if it differs by more than 5 % of its radius.
void PlaceSubject(const Subject& subject, LightField& light_field);

// Returns the point nearest to the optical axes of all views, before the cameras or behind; none for fewer
// than two views, or if the axes are nearly parallel.
std::optional<Eigen::Vector3d> ConvergenceOfAxes(const LightField& light_field);

// Returns a sphere around this point whose image has the share kSubjectSize of the pictures' width (by
// medians of distance and field of view); none if there is no such point, if it is behind a camera, or if
// fewer than half of the photographs show it.
std::optional<Subject> SubjectFromAxes(const LightField& light_field);

// Returns a sphere as large as the middle four fifths of the points, by each coordinate, which stands for the
// subject of a place that was walked through; none if there are fewer than ten points.
std::optional<Subject> MiddleOfPoints(const LightField& light_field);

// Returns the distances of the viewpoints from the subject's centre, world units, in their order. `center_of`
// is the member with a viewpoint's centre in the world, such as &View::CenterInWorld.
template <typename Viewpoints, typename Center>
std::vector<double> DistancesTo(const Subject& subject, const Viewpoints& viewpoints, Center center_of) {
  std::vector<double> distances;
  for (const auto& viewpoint : viewpoints)
    distances.push_back((std::invoke(center_of, viewpoint) - subject.center_in_world).norm());
  return distances;
}

// Names of files of a view and its other exposures, which a bracket takes (docs/light_field.md).

inline constexpr const char* kExposuresFolder = "exposures";
inline constexpr const char* kMergedFolder = "merged";
// Channels of merged/*.exr besides R, G, B: 1 where all exposures are clipped, and where one is left out.
inline constexpr const char* kClippedChannel = "clipped";
inline constexpr const char* kGhostsChannel = "ghosts";

// Returns exposures/000012-2, to which an extension is added, for the second further exposure of view 12; its
// master's name goes on with ".master".
std::string ExposureName(int view_id, std::size_t number);
// Returns merged/000012.exr.
std::string MergedPath(int view_id);

// Returns the paths of all files that belong to a view alone, relative to the light field, except its mask.
std::set<std::string> FilesOf(const View& view);

// Returns the exposure as a photograph for ReadViewMaster(): with the view's camera and id, and its own pose.
View PhotographOf(const View& view, const ViewExposure& exposure);

}  // namespace ulf
