// The light field on disk: a folder with the files that nerfstudio, instant-ngp and COLMAP's readers open.
// The append-only journal is authoritative; Close(), Resume() and `ulf repair` derive transforms.json and
// sparse/0 from it. Reading never writes.
//
//   journal.jsonl  transforms.json  sparse/0/  images/  masters/  masks/  points.ulf  points.ply  unposed/
//   kept/  cache/
//
// docs/disk_format.md has every file and key; docs/light_field.md says what is promised about them.
//
// The writer writes a view's files to temporary names, syncs and renames them, syncs the folders, then
// appends the journal line and syncs it; several views may share each step. A process killed at any moment
// loses at most the views of an AddViews() that has not returned; a damaged end of the journal is ignored.
// View numbers are used once: no file of a recorded view is ever overwritten, and a file that the writer
// replaces but did not make is moved to kept/.
//
// If a view has a master, its photograph in images/ may be written after the journal line. If the process is
// killed before, the next writer makes the photograph from the master; readers use the master meanwhile.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/frames/frame.h"
#include "core/light_field/folder/view_files.h"
#include "core/light_field/light_field.h"
#include "core/light_field/new_camera.h"

namespace ulf {

// Reads DIR from its journal, else from transforms.json (keys of nerfstudio and instant-ngp). Throws Error
// that names file, frame and key for a value that is missing, of the wrong type, not finite, not a rotation,
// or a path outside DIR. Damaged journal lines are left out. These and all differences between the files
// (folder_check.h) are reported in LightField::doubts and as warnings.
LightField ReadLightField(const std::filesystem::path& dir);

// The view's photograph as stored, checked against its camera's size. Throws Error when missing or truncated.
Image ReadRecordedImage(const LightField& light_field, const View& view);
// The same, for rendering: divided by its camera's flat field and in linear sRGB by its colour profile, if there is one
// (then linear float, three channels).
// `clipped`: becomes the pixels of which only a lower bound of the light is known (core/image/clipped.h): CV_8UC1 of the
// image's size, 255 there; empty where there is none.
Image ReadViewImage(const LightField& light_field, const View& view, cv::Mat* clipped = nullptr);

// Whether a mask, or the alpha of a PNG, excludes parts of the photograph.
bool HasMask(const LightField& light_field, const View& view);
// CV_8UC1 of the photograph's size, 0: excluded; empty: nothing is excluded. A mask of another size is resized (nearest
// pixel). Throws Error for a mask that is missing or of another aspect.
cv::Mat ReadViewMask(const LightField& light_field, const View& view);

// The view's master with its transfer and mosaic, or the photograph if there is no master; the black level is
// in the view. A camera's raw file is developed (core/image/files/raw_file.h), cropped to the camera model's size. Throws
// Error as ReadViewImage does.
Image ReadViewMaster(const LightField& light_field, const View& view);

// Whether the view has more than 8 bits: a master that ulf reads, or a photograph in EXR or of 16 bits.
bool HasMoreThanEightBits(const LightField& light_field, const View& view);
// The view's image of most light, for rendering: its merged exposures, else its master if ulf reads it, else its photograph; with flat field, colour
// profile and `clipped` as in ReadViewImage. A raw file that has a profile is developed by that profile's white balance.
Image ReadViewLight(const LightField& light_field, const View& view, cv::Mat* clipped = nullptr);

// The values in the journal's header.
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

class LightFieldWriter {
 public:
  // A new light field in DIR, which must not exist or be empty. Throws Error otherwise.
  static LightFieldWriter Create(const std::filesystem::path& dir, const CaptureHeader& header);
  // Opens a light field for more views, whether it was closed or its process killed. Throws Error for a
  // second writer, and, without writing anything, Error that names `ulf repair` when the journal has lost
  // views that other files still contain or when photographs differ from their masters.
  static LightFieldWriter Resume(const std::filesystem::path& dir);
  LightFieldWriter(LightFieldWriter&&) noexcept;
  LightFieldWriter& operator=(LightFieldWriter&&) noexcept;
  ~LightFieldWriter();  // releases the lock without closing, as when the process is killed

  // Views and photographs without a pose are recorded under this camera from now on: at first the last one that there is.
  void UseCamera(int index);
  int CameraInUse() const;
  // The lens in use as it was noted, before any correction (`ulf refine`).
  const CameraModel& CameraAsNoted() const;
  // Notes another camera, and goes on under it; earlier views keep theirs. Returns its index. Throws Error for one of
  // another picture size.
  int AddCamera(const NewCamera& camera);

  // Selects the mosaic itself as the master of a mosaic frame, instead of demosaicked 16-bit linear colours.
  void KeepMosaics(bool keep);

  // Reserves the id of a view that is to be added: above all that any file of the light field bears, and
  // given to no other view, whether this one is added or not. Safe to call from any thread.
  int ReserveViewId();
  // Writes the image (and its master when the frame is more than 8-bit sRGB) and the journal line. Sets paths,
  // id and camera of `view` and returns it. When the disk refuses (DiskFullError, Error) nothing of the view
  // remains, and the caller can add it again.
  View AddView(const Frame& frame, View view);
  // Adds several views with one wait for the disk, in this order; all, or none when the disk refuses. Each
  // has the id that was reserved for it, or 0 for the next one; throws Error for an id that was not reserved
  // or is not above those of all views. The caller writes a photograph that is not among the files by
  // WritePictureFromMaster().
  struct NewView {
    Frame frame;
    View view;
    ViewFiles files;
  };
  std::vector<View> AddViews(std::span<const NewView> views);
  // The files for a frame; thread-safe except with KeepMosaics().
  ViewFiles Files(const Frame& frame, MakePictures pictures) const;
  // Another exposure of a view (exposures/); of a view that is not there (any more), a photograph in unposed/.
  // `exposure_from_view`: between the camera's frames; `pose_is_between`: it was not found in the exposure itself.
  void AddExposure(int view_id, const Frame& frame, const Rigid3& exposure_from_view, bool pose_is_between);
  // What the view's exposures were merged to (merged/), in place of an earlier one. `exr`: the file's bytes.
  void SetMerged(int view_id, const std::string& exr, int exposures, double ghost_share);
  // Poses by view id and changed cameras by index, in one step.
  void UpdatePoses(const std::map<int, Rigid3>& cam_from_world_by_view,
                   const std::map<int, CorrectedLens>& cameras = {});
  void SetSubject(const Subject& subject);
  void SetUp(const Eigen::Vector3d& up_in_world);
  void SetGoal(const CoverageGoal& goal);
  void SetReadout(const ShutterReadout& readout);
  void SetTurntable(const Turntable& turntable);
  // CV_8UC1 of the photograph's size by view id, 0: excluded. Masks that were there move to kept/.
  void SetMasks(const std::map<int, cv::Mat>& masks);
  // Replaces the points, unless `points` is empty. Existing points without observations came from another
  // program: their files go to kept/.
  void SetPoints(std::vector<ScenePoint> points);
  // Records a time in which no view could be recorded (tracking lost, device lost), for reviews.
  void NoteGap(double from_s, double to_s, const std::string& reason);
  // Takes all of these views out of the journal together. Their photographs and masters (NNNNNN.master.*) then move to
  // unposed/, nothing is deleted; what a kill or a full disk leaves unmoved, another call or the next writer moves.
  void RemoveViews(const std::set<int>& view_ids);
  // Keeps a photograph that has no pose, and its master, in unposed/. The journal notes what the frame says of itself, and
  // `problem`: why it can never become a view; empty: it may.
  void KeepUnposed(const Frame& frame, const std::string& problem = "");
  // Makes views of photographs in unposed/ (unposed_photographs.h) that have a pose now, each with its reserved id. The
  // journal names a photograph's copy before the one in unposed/ goes: a kill leaves it there, as a view, or as both.
  void AddUnposed(std::vector<View> photographs);
  // For Close(), in place of what an earlier session measured.
  void SetMeasured(MeasuredErrors measured);
  // Derives transforms.json, sparse/0 and points.ply; the journal gets its close line.
  void Close(double capture_s, const std::map<std::string, std::uint64_t>& reasons = {});

  const LightField& Contents() const;
  int NextViewId() const;  // that the next reservation will give

 private:
  struct State;
  explicit LightFieldWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

// Writes a closed light field at light_field.root, whose images exist already: journal and derived files.
void WriteLightField(const LightField& light_field);

}  // namespace ulf
