// Writes a light field view by view, a new one or an existing one.
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

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/frames/frame.h"
#include "core/light_field/folder/view_files.h"
#include "core/light_field/light_field.h"

namespace ulf {

struct WriterState;

class LightFieldWriter {
 public:
  // Creates a light field in DIR, which must not exist or be empty. Throws Error otherwise.
  static LightFieldWriter Create(const std::filesystem::path& dir, const CaptureHeader& header);
  // Opens a light field for more views, whether it was closed or its process killed. Throws Error for a
  // second writer, and, without writing anything, Error that names `ulf repair` when the journal has lost
  // views that other files still contain or when photographs differ from their masters.
  static LightFieldWriter Resume(const std::filesystem::path& dir);
  LightFieldWriter(LightFieldWriter&&) noexcept;
  LightFieldWriter& operator=(LightFieldWriter&&) noexcept;
  ~LightFieldWriter();  // releases the lock without closing, as when the process is killed

  // Records later views and photographs without a pose under this camera; by default the last one.
  void UseCamera(int index);
  int CameraInUse() const;
  // Returns the lens in use as it was noted, before any correction (`ulf refine`).
  const CameraModel& CameraAsNoted() const;
  // Notes another camera and uses it; earlier views keep theirs. Returns its index. Throws Error for another
  // picture size.
  int AddCamera(const NewCamera& camera);

  // Selects the mosaic itself as the master of a mosaic frame, instead of demosaicked 16-bit linear colours.
  void KeepMosaics(bool keep);

  // Reserves the id of a view that is to be added. It is above all ids in the light field's file names, and
  // given once, whether the view is added or not. Any thread may call it.
  int ReserveViewId();
  // Writes the image (and its master if the frame is more than 8-bit sRGB) and the journal line. Sets paths,
  // id and camera of `view` and returns it. If the disk refuses (DiskFullError, Error) nothing of the view
  // remains, and the caller can add it again.
  View AddView(const Frame& frame, View view);
  // Adds several views with one wait for the disk, in this order; all, or none if the disk refuses. Each has
  // its reserved id, or 0 for the next one; throws Error for an id that was not reserved or is not above
  // those of all views. The caller writes a photograph that is not among the files by
  // WritePictureFromMaster().
  struct NewView {
    Frame frame;
    View view;
    ViewFiles files;
  };
  std::vector<View> AddViews(std::span<const NewView> views);
  // Encodes the files for a frame; thread-safe except with KeepMosaics().
  ViewFiles Files(const Frame& frame, MakePictures pictures) const;
  // Adds another exposure of a view (exposures/), or, if the view does not exist, a photograph in unposed/.
  // `exposure_from_view` maps between the camera's frames; `pose_is_between` says that it was interpolated,
  // not found in the exposure itself.
  void AddExposure(int view_id, const Frame& frame, const Rigid3& exposure_from_view, bool pose_is_between);
  // Sets the merged exposures of a view (merged/), replacing earlier ones. `exr` holds the file's bytes.
  void SetMerged(int view_id, const std::string& exr, int exposures, double ghost_share);
  // Corrects poses by view id and changed cameras by index, in one step.
  void UpdatePoses(const std::map<int, Rigid3>& cam_from_world_by_view,
                   const std::map<int, CorrectedLens>& cameras = {});
  void SetSubject(const Subject& subject);
  void SetUp(const Eigen::Vector3d& up_in_world);
  void SetGoal(const CoverageGoal& goal);
  void SetReadout(const ShutterReadout& readout);
  void SetTurntable(const Turntable& turntable);
  // Sets masks by view id, CV_8UC1 of the photograph's size, 0: excluded. Existing masks move to kept/.
  void SetMasks(const std::map<int, cv::Mat>& masks);
  // Replaces the points, unless `points` is empty. Existing points without observations came from another
  // program: their files move to kept/.
  void SetPoints(std::vector<ScenePoint> points);
  // Records a time in which no view could be recorded (tracking lost, device lost), for reviews.
  void NoteGap(double from_s, double to_s, const std::string& reason);
  // Takes all of these views out of the journal together. Their photographs and masters (NNNNNN.master.*)
  // then move to unposed/, nothing is deleted; another call or the next writer moves what a kill or a full
  // disk left.
  void RemoveViews(const std::set<int>& view_ids);
  // Keeps a photograph that has no pose, and its master, in unposed/. The journal notes the frame's metadata,
  // and as `problem` why it can never become a view, if so.
  void KeepUnposed(const Frame& frame, const std::string& problem = "");
  // Makes views of photographs in unposed/ (unposed_photographs.h) that have a pose now, each with its
  // reserved id. The journal names a photograph's copy before the one in unposed/ is removed: a kill leaves
  // either or both.
  void AddUnposed(std::vector<View> photographs);
  // Sets the errors that Close() writes, replacing those of an earlier session.
  void SetMeasured(MeasuredErrors measured);
  // Derives transforms.json, sparse/0 and points.ply; adds the close line to the journal.
  void Close(double capture_s, const std::map<std::string, std::uint64_t>& reasons = {});

  const LightField& Contents() const;
  int NextViewId() const;  // the id of the next reservation

 private:
  explicit LightFieldWriter(std::unique_ptr<WriterState> state);
  std::unique_ptr<WriterState> state_;
};

}  // namespace ulf
