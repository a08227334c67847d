// Writes a light field view by view, a new one or an existing one.
//
// The writer writes a view's files to temporary names, syncs and renames them, syncs the folders, then
// appends the journal line and syncs it; several views may share each step. A process killed at any moment
// loses at most the views of an AddViews() that has not returned. View numbers are used once: no file of a
// recorded view is ever overwritten, and a file that the writer replaces but did not make is moved to kept/.
// What changes the light field throws DiskFullError or Error if the disk refuses. One thread at a time may
// call the functions, except where they say otherwise.
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
  // Creates a light field in `dir`, which must not exist, be empty, or hold a capture that ended before its
  // first view. Throws Error otherwise.
  static LightFieldWriter Create(const std::filesystem::path& dir, const CaptureHeader& header);
  // Opens a light field for more views, whether it was closed or its process killed. Throws Error for a
  // second writer, and, without writing anything, an Error with the remedy when the journal has lost views
  // that other files still contain, or when photographs are missing or differ from their masters.
  static LightFieldWriter Resume(const std::filesystem::path& dir);
  LightFieldWriter(LightFieldWriter&&) noexcept;
  LightFieldWriter& operator=(LightFieldWriter&&) noexcept;
  ~LightFieldWriter();  // releases the lock without closing, as when the process is killed

  // Records later views and photographs without a pose under this camera; by default under the last one.
  void UseCamera(int index);
  int CameraInUse() const;
  // Returns the lens in use as it was noted, before any correction (`ulf refine`).
  const CameraModel& CameraAsNoted() const;
  // Notes another camera, uses it for later views and returns its index. Throws for another picture size.
  int AddCamera(const NewCamera& camera);

  // Selects the mosaic itself as the master of a mosaic frame, instead of demosaicked 16-bit linear colours.
  void KeepMosaics(bool keep);

  // Reserves the id of a view that is to be added. It is above all ids in the light field's file names, and
  // given once, whether the view is added or not. Any thread may call it.
  int ReserveViewId();
  // Writes the image (and its master if the frame is more than 8-bit sRGB) and the journal line. Sets id,
  // paths, camera and the frame's metadata in `view` and returns it. If the disk refuses, nothing of the view
  // remains, and the caller can add it again.
  View AddView(const Frame& frame, View view);
  // Adds several views with one wait for the disk, in this order; all, or none if the disk refuses. Each has
  // its reserved id, or 0 for the next one; throws Error for an id that was not reserved or is not above
  // those of all views. The caller writes photographs that `files` lacks by WritePictureFromMaster().
  struct NewView {
    Frame frame;
    View view;
    ViewFiles files;
  };
  std::vector<View> AddViews(std::span<const NewView> views);
  // Encodes the files for a frame. Several threads may call it, but not at the same time as KeepMosaics().
  ViewFiles Files(const Frame& frame, MakePictures pictures) const;
  // Adds another exposure of a view (exposures/), or, if the view does not exist, a photograph in unposed/.
  // The pose is as in ViewExposure.
  void AddExposure(int view_id, const Frame& frame, const Rigid3& exposure_from_view, bool pose_is_between);
  // Sets the merged exposures of a view (merged/), replacing earlier ones. `exr` holds the file's bytes, the
  // rest is as in MergedExposures. Throws Error if there is no such view.
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
  // Notes a time in which no view could be recorded (tracking lost, device lost), by the device's clock.
  void NoteGap(double from_s, double to_s, const std::string& reason);
  // Takes all of these views out of the journal together, then moves their photographs and masters
  // (NNNNNN.master.*) to unposed/. Another call or the next writer moves what a kill or a full disk left.
  void RemoveViews(const std::set<int>& view_ids);
  // Keeps a photograph that has no pose, and its master, in unposed/. The journal notes the frame's metadata,
  // and as `problem` why it can never become a view, if so.
  void KeepUnposed(const Frame& frame, const std::string& problem = "");
  // Makes views of photographs in unposed/ (unposed_photographs.h) that have a pose now, each with its
  // reserved id. The journal names a photograph's copy before the original is removed.
  void AddUnposed(std::vector<View> photographs);
  // Sets the errors that Close() writes, replacing those of an earlier session.
  void SetMeasured(MeasuredErrors measured);
  // Adds the close line to the journal, and derives transforms.json, sparse/0 and points.ply. `capture_s` and
  // `reasons` are as in LightField.
  void Close(double capture_s, const std::map<std::string, std::uint64_t>& reasons = {});

  const LightField& Contents() const;
  int NextViewId() const;  // the id of the next reservation

 private:
  explicit LightFieldWriter(std::unique_ptr<WriterState> state);
  std::unique_ptr<WriterState> state_;
};

}  // namespace ulf
