// Writes a light field view by view, to begin with or after a break.
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
  // A new light field in DIR, which must not exist or be empty. Throws Error otherwise.
  static LightFieldWriter Create(const std::filesystem::path& dir, const CaptureHeader& header);
  // Opens a light field for more views, whether it was closed or its process killed. Throws Error for a
  // second writer, and, without writing anything, Error that names `ulf repair` when the journal has lost
  // views that other files still contain or when photographs differ from their masters.
  static LightFieldWriter Resume(const std::filesystem::path& dir);
  LightFieldWriter(LightFieldWriter&&) noexcept;
  LightFieldWriter& operator=(LightFieldWriter&&) noexcept;
  ~LightFieldWriter();  // releases the lock without closing, as when the process is killed

  // Views and photographs without a pose are recorded under this camera from now on: at first the last one
  // that there is.
  void UseCamera(int index);
  int CameraInUse() const;
  // The lens in use as it was noted, before any correction (`ulf refine`).
  const CameraModel& CameraAsNoted() const;
  // Notes another camera, and goes on under it; earlier views keep theirs. Returns its index. Throws Error
  // for one of another picture size.
  int AddCamera(const NewCamera& camera);

  // Selects the mosaic itself as the master of a mosaic frame, instead of demosaicked 16-bit linear colours.
  void KeepMosaics(bool keep);

  // Reserves the id of a view that is to be added: above all that any file of the light field bears, and
  // given to no other view, whether this one is added or not. Safe to call from any thread.
  int ReserveViewId();
  // Writes the image (and its master when the frame is more than 8-bit sRGB) and the journal line. Sets
  // paths, id and camera of `view` and returns it. When the disk refuses (DiskFullError, Error) nothing of
  // the view remains, and the caller can add it again.
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
  // Another exposure of a view (exposures/); of a view that is not there (any more), a photograph in
  // unposed/. `exposure_from_view`: between the camera's frames; `pose_is_between`: it was not found in the
  // exposure itself.
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
  // Takes all of these views out of the journal together. Their photographs and masters (NNNNNN.master.*)
  // then move to unposed/, nothing is deleted; what a kill or a full disk leaves unmoved, another call or the
  // next writer moves.
  void RemoveViews(const std::set<int>& view_ids);
  // Keeps a photograph that has no pose, and its master, in unposed/. The journal notes what the frame says
  // of itself, and `problem`: why it can never become a view; empty: it may.
  void KeepUnposed(const Frame& frame, const std::string& problem = "");
  // Makes views of photographs in unposed/ (unposed_photographs.h) that have a pose now, each with its
  // reserved id. The journal names a photograph's copy before the one in unposed/ goes: a kill leaves it
  // there, as a view, or as both.
  void AddUnposed(std::vector<View> photographs);
  // For Close(), in place of what an earlier session measured.
  void SetMeasured(MeasuredErrors measured);
  // Derives transforms.json, sparse/0 and points.ply; the journal gets its close line.
  void Close(double capture_s, const std::map<std::string, std::uint64_t>& reasons = {});

  const LightField& Contents() const;
  int NextViewId() const;  // that the next reservation will give

 private:
  explicit LightFieldWriter(std::unique_ptr<WriterState> state);
  std::unique_ptr<WriterState> state_;
};

}  // namespace ulf
