// The data of a light field: photographs with poses, and a sphere around the subject (thesis, section 2.1).
// light_field_io.h reads and writes it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
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

// "x,y,z,r" in world units; throws Refusal.
Subject ParseSubject(const std::string& text);

// How a sensor reads its rows one after the other (a rolling shutter).
struct ShutterReadout {
  double readout_s = 0;           // from the first row to the last; negative: from the last; 0: all at once
  std::optional<double> sigma_s;  // one standard deviation, where it was measured; none: it was given
  bool operator==(const ShutterReadout&) const = default;
};

// Another exposure of a view, for merging.
struct ViewExposure {
  // As of a view: relative to the light field. An image or a master, or both.
  std::string image_path;
  std::string master_path;
  std::optional<Transfer> master_transfer;
  Mosaic master_mosaic = Mosaic::kNone;
  std::optional<std::array<double, 3>> raw_white_balance;
  // From the view's camera to where the camera stood for this exposure. Its translation is in world units.
  Rigid3 exposure_from_view;
  bool pose_is_between =
      false;  // not found in the exposure itself: interpolated between frames before and after
  double device_time_s = 0, host_time_s = 0;
  double exposure_s = 0;  // known, above 0
  double gain = 1;        // linear
  double black_level = 0;
  std::optional<double> f_number;
};

// A view and its exposures as one picture of linear light.
struct MergedExposures {
  std::string path;        // relative to the light field: OpenEXR
  int exposures = 0;       // that went into it, the view's own among them
  double ghost_share = 0;  // of the pixels: one exposure alone, because they disagree by more than noise
};

// A recorded frame: image, camera, pose.
struct View {
  int id = 0;               // given once, in order of recording, never used again
  std::string image_path;   // relative to the light field, '/'-separated: 8-bit sRGB for every tool
  std::string master_path;  // what the camera gave beyond 8-bit sRGB; empty when there is nothing more
  std::string mask_path;    // one channel, of the image's size, 0: not to be used; empty: all is used
  // How the master's numbers are to be read; none where it is a file of its own kind (a camera's raw file).
  std::optional<Transfer> master_transfer;
  Mosaic master_mosaic = Mosaic::kNone;
  int camera = 0;  // index into LightField::cameras
  Rigid3 cam_from_world;
  // As it was given when the view was recorded; later adjustments change the one above.
  std::optional<Rigid3> recorded_cam_from_world;
  double device_time_s = 0;
  double host_time_s = 0;
  double exposure_s = 0;  // 0: unknown
  double gain = 1;        // linear
  double black_level = 0;
  // Where the camera told them with the picture: its number there, and its lines, one bit each.
  std::optional<std::uint64_t> frame_id, line_status;
  bool on_shared_clock = false;  // device_time_s is by a clock that IEEE 1588 sets
  std::optional<double> f_number;
  std::optional<double> focal_mm;  // of the lens, as the camera told it
  std::string lens = {};           // its model in its maker's words; empty: not known
  // Of a master that is a raw file: the factors of the sensor's red, green and blue by which it is developed
  // (green is 1), where they are not the file's own: those of the light field's first raw file of this
  // camera.
  std::optional<std::array<double, 3>> raw_white_balance;
  double tracking_quality = 1;  // 0 to 1
  // Where a rolling shutter was compensated: the camera's velocity while the rows were read, in the frame of
  // its middle row: rotation (rad/s), then translation (world units/s).
  std::optional<std::array<double, 6>> twist;
  std::optional<double> bound_px;  // the criterion's value when it was recorded; none for the first view
  std::vector<ViewExposure> exposures = {};  // besides its own, in the order in which they were taken
  std::optional<MergedExposures> merged = {};

  Eigen::Vector3d CenterInWorld() const { return cam_from_world.OriginInSource(); }
};

// Whether the view's light is read in Rec. 709 primaries without a colour profile: the camera encoded its
// picture as sRGB, or its raw file is developed by the file's own matrix. Else (a linear master) the colours
// are the sensor's own.
inline bool HasRec709Colors(const View& view) { return view.master_transfer != Transfer::kLinear; }

// Where a view shows a point: pixels of its image as it is recorded, distortion included.
struct ViewObservation {
  int view_id = 0;
  Eigen::Vector2d in_img = Eigen::Vector2d::Zero();
};

struct ScenePoint {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  std::array<std::uint8_t, 3> rgb{128, 128, 128};
  double error_px = 0;                   // mean distance of its observations from its projections
  std::vector<ViewObservation> track{};  // at most one a view; empty: not known
};

// What a capture is to cover: a cap of so many degrees of azimuth and elevation, and the share of it that is
// enough.
struct CoverageGoal {
  Eigen::Vector2d cap_deg;
  double share = 1;
  bool operator==(const CoverageGoal&) const = default;
};

// Which way is up for people who held these cameras: the mean of the cameras' upward axes; where these cancel
// out, the axis that the cameras' rightward axes share.
class UpOfCameras {
 public:
  void Add(const Eigen::Matrix3d& cam_from_world);
  Eigen::Vector3d Up() const;  // in the world, a unit vector; -y without any camera

 private:
  double count_ = 0;
  Eigen::Vector3d up_ = Eigen::Vector3d::Zero(), right_ = Eigen::Vector3d::Zero();  // sums
  Eigen::Matrix3d rights_ = Eigen::Matrix3d::Zero();
};

// The error that a capture measured at frames (docs/capture.md, "Measured errors"), by direction.
struct MeasuredDirection {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  // from the subject, unit, world frame
  double nearest_view_angle = 0;  // radians: of the nearest recorded view at that moment
  double one_sided = 0;           // 1: all views around stood on one side
  double db = 0, db_outside = 0;  // inside the subject's silhouette and around it, of small pictures
  double misregistration_px = 0;  // of small pictures
  std::string cause;              // of what is wrong, by name
};
struct MeasuredErrors {
  std::string cover = "bound";  // the name of the rule by which a viewpoint counts as covered
  double goal_db = 0;
  std::uint64_t frames = 0;  // at which it was measured
  std::vector<MeasuredDirection> directions;
};

// The camera stood while the subject turned on a printed board, whose frame is the world. What the masks of
// such a light field leave out stood still and is no part of the scene: pictures are empty there.
struct Turntable {
  std::string board;  // as core/fiducials/board.h writes it; empty: there was none, or it is not known
  bool operator==(const Turntable&) const = default;
};

// A photograph in unposed/.
struct UnposedPhotograph {
  View view;            // id 0 and no pose
  std::string problem;  // why it cannot become a view; empty: it can, once somebody knows where it was taken
};

struct LightField {
  std::filesystem::path root;
  std::vector<CameraModel> cameras;
  // By index into cameras, where one was measured: the photographs are as the camera made them, ReadViewImage
  // divides by it.
  std::map<int, FlatField> flat_fields;
  std::map<int, ColorProfile> color_profiles;  // the same: ReadViewImage applies it
  std::vector<View> views;                     // in order of id
  // What the journal says of photographs that were kept without a pose. Their files may be gone since, and
  // others may lie beside them (unposed_photographs.h).
  std::vector<UnposedPhotograph> unposed;
  std::optional<Subject> subject;
  std::optional<Eigen::Vector3d> up_in_world;  // unit; none: UpInWorld() tells it from the cameras
  std::string units = "arbitrary";             // or "metres"
  std::optional<double> threshold_px;          // what the capture was asked for, in coverage image pixels
  int coverage_width_px = 640;
  std::optional<CoverageGoal> goal;       // the last one that was given; none: the operator ends it
  std::optional<Turntable> turntable;     // none: the subject stood still
  std::optional<ShutterReadout> readout;  // what the last session measured or was given; none: not known
  std::string device_uri;
  std::string device_serial, device_maker, device_model;
  std::optional<SensorWindow> window;  // that the views show; none: not known, or photographs
  // By index into cameras, where it is told: where the intrinsics are from.
  std::map<int, std::string> calibration_sources;
  std::set<int> taken_back;  // ids of views that were recorded and are none of these any more
  double capture_s = 0;
  std::map<std::string, std::uint64_t> reasons;  // why frames were recorded or not, each a count of frames
  std::optional<MeasuredErrors> measured;        // none: the capture measured none
  std::vector<ScenePoint> points;
  // Seen farther from where the points are than kMostTrackErrorPx, and therefore left out on reading.
  std::size_t misplaced_observations = 0;
  std::vector<std::string> doubts;  // in words: where the folder's files disagree, or are damaged
  std::vector<Finding> findings;    // of the other checks: what does not fit in what the files say

  Eigen::Vector3d UpInWorld() const;
  // Where the camera's intrinsics are from; empty: not told.
  std::string CalibrationSource(int camera) const;
  const CameraModel& CameraOf(const View& view) const {
    return cameras[static_cast<std::size_t>(view.camera)];
  }
};

// A camera that a light field gets: it has one to begin with, and another for each lens that was given on
// purpose since.
struct NewCamera {
  CameraModel camera;
  std::optional<FlatField> flat_field;
  std::optional<ColorProfile> color_profile;
  std::string calibration_source;
};

// New intrinsics of a camera that a light field has.
struct CorrectedLens {
  CameraModel camera;
  std::string calibration_source;  // empty: from where they were
};

// What a capture notes when it begins: the values in the journal's header.
struct CaptureHeader {
  CameraModel camera;
  std::string device_uri;
  std::string device_serial, device_maker, device_model;
  std::optional<SensorWindow> window;
  std::string calibration_source;
  std::optional<FlatField> flat_field;
  std::optional<ColorProfile> color_profile;
  std::string units = "arbitrary";
  std::optional<double> threshold_px;
  int coverage_width_px = 640;
};

inline cv::Size SizeOf(const CameraModel& camera) { return {camera.width, camera.height}; }
// Whether pictures of this size are the camera's, resized and not cropped: but for rounding to whole pixels.
inline bool HasAspectOf(const CameraModel& camera, cv::Size size) {
  constexpr double kRounding_px = 1;
  return std::abs(static_cast<double>(size.width) / camera.width * camera.height - size.height) <=
         kRounding_px;
}

// Exchanges the subject. Errors that were measured about another one lapse.
void PlaceSubject(const Subject& subject, LightField& light_field);

// Where the optical axes of all views come nearest to each other, before the cameras or behind; none: they
// are nearly parallel.
std::optional<Eigen::Vector3d> MeetingOfAxes(const LightField& light_field);

// There, with a radius from `width_share` of the median image width at the median distance; none where the
// axes are nearly parallel or meet behind the cameras.
std::optional<Subject> SubjectFromAxes(const LightField& light_field, double width_share = 0.28);

// The files of a view and of its other exposures (`ulf capture`, bracket). docs/light_field.md describes
// them.

inline constexpr const char* kExposuresFolder = "exposures";
inline constexpr const char* kMergedFolder = "merged";
// Of merged/*.exr, besides R, G and B: 1 where no exposure tells the light; 1 where an exposure is left out.
inline constexpr const char* kClippedChannel = "clipped";
inline constexpr const char* kGhostsChannel = "ghosts";

// exposures/000012-2 for the second one of view 12, without an ending; the master's is 000012-2.master.
std::string ExposureName(int view_id, std::size_t number);
// merged/000012.exr
std::string MergedPath(int view_id);

// All files that belong to a view alone, relative to the light field; not its mask.
std::set<std::string> FilesOf(const View& view);

// The exposure as a photograph of its own, for ReadViewMaster(): with the view's camera and id, the pose
// where it was taken.
View PhotographOf(const View& view, const ViewExposure& exposure);

}  // namespace ulf
