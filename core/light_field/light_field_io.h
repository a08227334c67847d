// The light field on disk: a folder with the files that nerfstudio, instant-ngp and COLMAP's readers open.
// The append-only journal is the truth; transforms.json and sparse/0 are derived from it on Close(), on
// Resume() and by `ulf repair`, never on reading: reading writes nothing.
//
//   journal.jsonl  transforms.json  sparse/0/  images/  masters/  masks/  points.ply  unposed/  kept/  cache/
//
// A view's files are written to temporary names, synced, renamed, the folders synced, then the journal line
// appended and synced; several views may go through each of these steps together. A process killed at any
// moment loses at most the views that AddViews() was given and had not returned, and a torn end of the
// journal is ignored. Numbers are given once: no file of a recorded view is ever written over, and what a
// writer replaces that it has not made goes to kept/ first.
//
// Where there is a master, the photograph in images/ may come after the journal line: it follows from the
// master, and is made from it by the next writer, should the process be killed before; readers read the
// master instead.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/image/frame.h"
#include "core/light_field/light_field.h"
#include "core/light_field/view_files.h"

namespace ulf {

// Reads DIR from its journal where there is one, else from transforms.json (nerfstudio's and instant-ngp's
// keys). Writes nothing. Throws Error naming file, frame and key for anything missing, mistyped, not finite,
// not a rotation, or outside DIR. Damaged lines of a journal are left out; these, and whatever the folder's
// files tell differently (core/light_field/folder_check.h), stand in LightField::doubts and are warned of.
LightField ReadLightField(const std::filesystem::path& dir);

// The view's photograph as stored, checked against its camera's size. Throws Error when missing or truncated.
Image ReadRecordedImage(const LightField& light_field, const View& view);
// The same, for rendering: where its camera has a flat field, divided by it (linear float, three channels).
Image ReadViewImage(const LightField& light_field, const View& view);

// Whether parts of the photograph are not to be used: by a mask, or by the alpha of a PNG.
bool HasMask(const LightField& light_field, const View& view);
// CV_8UC1 of the photograph's size, 0: not to be used; empty where all is. Throws Error for a mask that is
// missing or of another size.
cv::Mat ReadViewMask(const LightField& light_field, const View& view);

// What the camera gave for the view: the master with its transfer and pattern, or the photograph where that
// is all there was; its black level stands in the view. Throws Error as ReadViewImage does, and for a master
// that only a raw converter reads.
Image ReadViewMaster(const LightField& light_field, const View& view);

// Whether more than the 8 bits of a photograph are there to be rendered from: a master that this program
// reads, or a photograph in EXR or of 16 bits.
bool HasMoreThanEightBits(const LightField& light_field, const View& view);
// The most that there is of the view's light, for rendering: its master where that is there and this program
// reads it, else its photograph; divided by its camera's flat field as in ReadViewImage.
Image ReadViewLight(const LightField& light_field, const View& view);

// What the journal's header says about a capture.
struct CaptureHeader {
  CameraModel camera;
  std::string device_uri;
  std::string device_serial, device_maker, device_model;
  std::optional<SensorWindow> window;
  std::string calibration_source;
  std::optional<FlatField> flat_field;
  std::string units = "arbitrary";
  std::optional<double> threshold_px;
  int coverage_width_px = 640;
};

class LightFieldWriter {
 public:
  // A new light field in DIR, which must not exist or be empty. Throws Error otherwise.
  static LightFieldWriter Create(const std::filesystem::path& dir, const CaptureHeader& header);
  // Opens one for more views, whether it was closed or killed. A second writer is refused, and so is a folder
  // whose journal has lost what other files still hold, or whose photographs are not their masters' (Error
  // that names `ulf repair`; then nothing has been written).
  static LightFieldWriter Resume(const std::filesystem::path& dir);
  LightFieldWriter(LightFieldWriter&&) noexcept;
  LightFieldWriter& operator=(LightFieldWriter&&) noexcept;
  ~LightFieldWriter();  // releases the lock; does not close: an open journal is what a kill leaves, too

  // A mosaic's master is the mosaic itself, with its pattern, instead of the 16-bit linear colours made from
  // it.
  void KeepMosaics(bool keep);

  // The number of a view that is to be added, which no other gets, whether it is added or not. Above all that
  // any file of the light field bears. May be called beside everything else.
  int ReserveViewId();
  // Writes the image (and its master where the frame is more than 8-bit sRGB) and the journal line. Paths and
  // id of `view` are given here; what was written is returned. When the disk refuses (DiskFullError, Error)
  // nothing of the view stays behind, and it can be added again.
  View AddView(const Frame& frame, View view);
  // Several in one wait for the disk, in this order; all of them or, when the disk refuses, none. Each has
  // the id that was reserved for it, or 0 for the next one: throws Error for one that was not reserved or is
  // not above those of all views. A photograph that is not among the files is to follow by
  // WritePictureFromMaster().
  struct NewView {
    Frame frame;
    View view;
    ViewFiles files;
  };
  std::vector<View> AddViews(std::span<const NewView> views);
  // The files for a frame; may be called beside everything else but KeepMosaics().
  ViewFiles Files(const Frame& frame, MakePictures pictures) const;
  // In one step with the cameras (by index) that changed with them.
  void UpdatePoses(const std::map<int, Rigid3>& cam_from_world_by_view,
                   const std::map<int, CameraModel>& cameras = {});
  void SetSubject(const Subject& subject);
  void SetUp(const Eigen::Vector3d& up_in_world);
  void SetGoal(const CoverageGoal& goal);
  // In place of those that there are, unless there are none of the new ones. Points that no view is known to
  // show were brought from elsewhere: their files go to kept/.
  void SetPoints(std::vector<ScenePoint> points);
  // Time in which nothing could be recorded (tracking lost, device lost): kept so that review can show it.
  void NoteGap(double from_s, double to_s, const std::string& reason);
  // The photograph and its master (NNNNNN.master.*) move to unposed/, nothing is deleted.
  void RemoveView(int view_id);
  // Keeps a photograph that has no pose, and its master, in unposed/.
  void KeepUnposed(const Frame& frame);
  // Derives transforms.json, sparse/0 and points.ply; the journal gets its close line.
  void Close(double capture_s, const std::map<std::string, std::uint64_t>& reasons = {});

  const LightField& Contents() const;
  int NextViewId() const;  // that the next reservation will give

 private:
  struct State;
  explicit LightFieldWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

// A closed light field at light_field.root from values whose images are already in place: journal and derived
// files.
void WriteLightField(const LightField& light_field);

// What of images/ follows from masters and is missing; warns of what cannot be made, and counts it.
std::size_t MakeMissingPictures(const LightField& light_field);

// transforms.json, sparse/0 and points.ply from the values, with the stamp of the journal that is there.
void WriteDerivedFiles(const LightField& light_field);

}  // namespace ulf
