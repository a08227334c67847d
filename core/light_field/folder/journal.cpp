#include "core/light_field/folder/journal.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/json_fields.h"
#include "core/base/json_text.h"
#include "core/base/shell_word.h"
#include "core/geometry/camera_json.h"
#include "core/light_field/findings.h"
#include "core/light_field/formats/view_json.h"
#include "core/light_field/journal_stamp.h"
#include "core/light_field/light_field.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kMostInDoubt = 10000;  // views; more mean that a number was damaged, too; guessed
// These events hold neither a view nor a pose.
constexpr const char* kEventsWithoutViews[] = {"subject",   "up",      "goal",   "readout",  "gap",
                                               "remove",    "unposed", "close",  "exposure", "merged",
                                               "turntable", "masks",   "camera", "checked"};

// Adds a camera of the header, or of a line of its own.
void AppendCamera(const json& camera, const std::string& where, JournalContents& contents) {
  NewCamera added{CameraFromJson({camera, where}), {}, {}, ""};
  if (camera.contains("flat_field")) added.flat_field = FlatFieldFromJson(camera["flat_field"], where);
  if (camera.contains("color_profile"))
    added.color_profile = ColorProfileFromJson(camera["color_profile"], where);
  added.calibration_source = JsonPlace{camera, where}.Text("calibration_source", "");
  contents.light_field.AddCamera(added);
  contents.recorded_cameras.resize(contents.light_field.cameras.size(), added.camera);
}

void ApplyHeader(const JsonPlace& event, JournalContents& contents) {
  const int version = event.Integer("version");
  if (version > kJournalVersion)
    throw NewerFormatError("{}: journal version {} is newer than this program's {}; use a newer ulf",
                           event.where, version, kJournalVersion);
  for (const json& camera : event.Raw("cameras")) AppendCamera(camera, event.where, contents);
  ReadCaptureJson(event, contents.light_field);
  if (contents.light_field.cameras.size() == 1) NoteCalibrationSource(event, 0, contents.light_field);
}

// Reports a complete line that is ignored: it names a path that leaves the folder, or is of a newer version.
// A repair keeps such lines.
class LineStaysError : public Error {
 public:
  using Error::Error;
};

// Views name cameras by index: if a camera's line is damaged, none may take its place.
void ApplyCamera(const JsonPlace& event, JournalContents& contents) {
  LightField& light_field = contents.light_field;
  const int index = event.Integer("index"), there = static_cast<int>(light_field.cameras.size());
  const JsonPlace camera = event.Inside("camera");
  if (index > there)
    throw LineStaysError("{}: camera {} cannot be read without camera {}, which is missing", event.where,
                         index, there);
  if (index < there) {  // the header was made again, with later corrections
    const CameraModel noted = CameraFromJson(camera);
    if (index >= 0) contents.recorded_cameras[static_cast<std::size_t>(index)] = noted;
    return;
  }
  AppendCamera(camera.object, camera.where, contents);
  NoteCalibrationSource(event, index, light_field);
}

// Calls `read`, which checks paths.
template <typename Read>
void ReadPaths(const Read& read) {
  try {
    read();
  } catch (const Error& error) {
    throw LineStaysError(std::string(error.what()));
  }
}

// Reads the paths of a view or photograph whose other properties are read.
void ReadFiles(const JsonPlace& event, const LightField& light_field, View& view) {
  view.image_path = event.Text("image");
  ReadPaths([&] {
    view.image_path = PathBelow(view.image_path, event.where);
    RequirePathsBelow(event.where, view);
  });
  view.camera = event.Integer("camera", 0);
  if (view.camera < 0 || view.camera >= static_cast<int>(light_field.cameras.size()))
    throw LineStaysError("{}: camera {} is not among the cameras before", event.where, view.camera);
}

// A name is reused once its photograph has become a view: the last line counts.
void ApplyUnposed(const JsonPlace& event, LightField& light_field) {
  UnposedPhotograph photograph;
  ReadPhotographJson(event, photograph.view);
  ReadFiles(event, light_field, photograph.view);
  photograph.problem = event.Text("problem", "");
  std::erase_if(light_field.unposed, [&](const UnposedPhotograph& other) {
    return other.view.image_path == photograph.view.image_path;
  });
  light_field.unposed.push_back(std::move(photograph));
}

void ApplyView(const JsonPlace& event, JournalContents& contents) {
  LightField& light_field = contents.light_field;
  View view;
  view.id = event.Integer("id");
  if (view.id < 1) throw Error("{}: there is no view {}; they count from 1", event.where, view.id);
  if (light_field.FindView(view.id) || contents.removed.contains(view.id))
    throw Error("{}: view {} is recorded twice; the first one is used", event.where, view.id);
  ReadViewJson(event, view);
  ReadFiles(event, light_field, view);
  view.cam_from_world = PoseFromJson(event, "cam_from_world");
  view.recorded_cam_from_world = view.cam_from_world;
  contents.next_view_id = std::max(contents.next_view_id, view.id + 1);
  const auto after = std::upper_bound(light_field.views.begin(), light_field.views.end(), view.id,
                                      [](int id, const View& other) { return id < other.id; });
  light_field.views.insert(after, std::move(view));
}

// Reads the whole event before it changes anything: a damaged one changes nothing.
void ApplyPoses(const JsonPlace& event, JournalContents& contents) {
  LightField& light_field = contents.light_field;
  std::vector<std::pair<View*, Rigid3>> poses;
  std::map<std::size_t, CorrectedLens> cameras;
  const JsonPlace given = event.Inside("poses");
  for (const auto& [id, pose] : given.object.items())
    if (View* view = light_field.FindView(std::atoi(id.c_str())))
      poses.emplace_back(view, PoseFromJson(given, id.c_str()));
  std::optional<std::string> unknown_camera;
  const std::string source =
      event.Text("calibration_source", "");  // for all cameras, in lines of older writers
  if (event.Has("cameras"))
    for (const auto& [index, camera] : event.Raw("cameras").items()) {
      const auto at = static_cast<std::size_t>(std::atoi(index.c_str()));
      if (at >= light_field.cameras.size())
        unknown_camera = index;
      else
        cameras[at] = {CameraFromJson({camera, event.where}),
                       JsonPlace{camera, event.where}.Text("calibration_source", source)};
    }
  for (const auto& [view, pose] : poses) {
    view->cam_from_world = pose;
    for (DamagedLine& line : contents.damaged) line.poses.erase(view->id);
  }
  for (const auto& [index, lens] : cameras) {
    light_field.cameras[index] = lens.camera;
    if (!lens.calibration_source.empty())
      light_field.calibration_sources[static_cast<int>(index)] = lens.calibration_source;
  }
  if (unknown_camera)
    throw LineStaysError("{}: camera {} is not among the cameras before; the poses are taken", event.where,
                         *unknown_camera);
}

View& ViewOf(const JsonPlace& event, LightField& light_field) {
  View* view = light_field.FindView(event.Integer("view"));
  if (!view) throw LineStaysError("{}: there is no view {} (any more)", event.where, event.Integer("view"));
  return *view;
}

void ApplyExposure(const JsonPlace& event, LightField& light_field) {
  View& view = ViewOf(event, light_field);
  View with_exposure;
  with_exposure.exposures.push_back(ExposureFromJson(event));
  ReadPaths([&] { RequirePathsBelow(event.where, with_exposure); });
  view.exposures.push_back(with_exposure.exposures.front());
}

void ApplyMerged(const JsonPlace& event, LightField& light_field) {
  View& view = ViewOf(event, light_field);
  View with_merged;
  with_merged.merged = MergedFromJson(event);
  ReadPaths([&] { RequirePathsBelow(event.where, with_merged); });
  view.merged = with_merged.merged;
}

// Masks of missing views are ignored.
void ApplyMasks(const JsonPlace& event, LightField& light_field) {
  std::vector<std::pair<View*, std::string>> paths;
  const JsonPlace given = event.Inside("masks");
  for (const auto& [id, path] : given.object.items())
    if (View* view = light_field.FindView(std::atoi(id.c_str()))) {
      const std::string path = given.Text(id.c_str());
      ReadPaths([&] { paths.emplace_back(view, PathBelow(path, given.where)); });
    }
  for (auto& [view, path] : paths) view->mask_path = std::move(path);
}

// Removes one view, or several together.
void ApplyRemoval(const JsonPlace& event, JournalContents& contents) {
  LightField& light_field = contents.light_field;
  std::set<int> ids;
  if (event.Has("ids")) {
    for (const double id : event.Numbers("ids", event.Raw("ids").size())) {
      if (id != std::floor(id) || !(id >= 1 && id <= kMostViewId))
        throw Error("{}: 'ids' holds {}, which is no view's number", event.where, id);
      ids.insert(static_cast<int>(id));
    }
  } else {
    ids.insert(event.Integer("id"));
  }
  for (const int id : ids) {
    contents.removed.insert(id);
    if (const View* view = light_field.FindView(id)) {
      contents.removed_files.merge(FilesOf(*view));
      light_field.taken_back.insert(id);
    }
  }
  std::erase_if(light_field.views, [&](const View& view) { return ids.contains(view.id); });
}

void ApplyChecked(const JsonPlace& event, JournalContents& contents) {
  std::vector<KeptFinding> kept = KeptFindingsFromJson(event);
  std::erase_if(contents.kept_findings,
                [&](const KeptFinding& each) { return each.check == event.Text("check"); });
  contents.kept_findings.insert(contents.kept_findings.end(), kept.begin(), kept.end());
}

void ApplyEvent(const JsonPlace& event, JournalContents& contents) {
  LightField& light_field = contents.light_field;
  const std::string kind = event.Text("event");
  if (kind == "header") {
    ApplyHeader(event, contents);
  } else if (kind == "camera") {
    ApplyCamera(event, contents);
  } else if (kind == "view") {
    ApplyView(event, contents);
  } else if (kind == "pose_update") {
    ApplyPoses(event, contents);
  } else if (kind == "subject") {
    PlaceSubject({Vector3FromJson(event, "center"), event.Positive("radius")}, light_field);
  } else if (kind == "up") {
    light_field.up_in_world = Vector3FromJson(event, "up").normalized();
  } else if (kind == "goal") {
    light_field.goal = CoverageGoalFromJson(event);
  } else if (kind == "readout") {
    light_field.readout = ReadoutFromJson(event);
  } else if (kind == "turntable") {
    light_field.turntable = Turntable{event.Text("board", "")};
  } else if (kind == "masks") {
    ApplyMasks(event, light_field);
  } else if (kind == "remove") {
    ApplyRemoval(event, contents);
  } else if (kind == "exposure") {
    ApplyExposure(event, light_field);
  } else if (kind == "merged") {
    ApplyMerged(event, light_field);
  } else if (kind == "unposed") {
    ApplyUnposed(event, light_field);
  } else if (kind == "checked") {
    ApplyChecked(event, contents);
  } else if (kind == "close") {
    light_field.capture_s = event.Number("capture_s", 0);
    if (event.Has("reasons")) light_field.reasons = ReasonsFromJson(event.Inside("reasons"));
    if (event.Has("measured")) light_field.measured = MeasuredFromJson(event.Inside("measured"));
  } else if (kind != "gap" && kind != "repaired") {
    throw LineStaysError("{}: unknown event '{}'; use a newer ulf", event.where, kind);
  }
}

std::optional<json> ParsedLine(std::string_view line) {
  json object = JsonOrDiscarded(line);
  if (object.is_discarded()) return std::nullopt;
  return object;
}

// Returns where the first complete line from `begin` on begins; npos if there is none.
std::size_t NextWholeLine(std::string_view bytes, std::size_t begin) {
  for (std::size_t end; (end = bytes.find('\n', begin)) != std::string_view::npos; begin = end + 1)
    if (IsJson(bytes.substr(begin, end - begin))) return begin;
  return std::string_view::npos;
}

bool MayHaveCorrectedPoses(std::string_view line) {
  if (line.find("\"event\":\"view\"") != std::string_view::npos) return false;
  return std::ranges::none_of(kEventsWithoutViews, [&](const char* kind) {
    return line.find(fmt::format("\"event\":\"{}\"", kind)) != std::string_view::npos;
  });
}

// A run of damaged lines is one entry, and so is all that is damaged beyond many places: a damaged journal
// must not need more memory and time than one of views.
void NoteDamaged(int number, bool is_json, std::string reason, std::string_view line,
                 JournalContents& contents) {
  constexpr std::size_t kMostPlaces = 100;  // guessed: blocks of a disk damage one or two
  const bool in_a_run = !is_json && !contents.damaged.empty() && !contents.damaged.back().is_json &&
                        contents.damaged.back().last + 1 == number;
  if (!in_a_run && contents.damaged.size() < kMostPlaces) {
    contents.damaged.push_back({number, number, 1, is_json, std::move(reason), {}, {}});
  } else {
    DamagedLine& entry = contents.damaged.back();
    entry.last = number;
    ++entry.lines;
    entry.reason = fmt::format("lines {} to {}: {}", entry.number, entry.last,
                               entry.IsWhole() ? "damaged" : fmt::format("{} of them damaged", entry.lines));
  }
  // No views come within a run.
  if (std::set<int>& poses = contents.damaged.back().poses; poses.empty() && MayHaveCorrectedPoses(line))
    for (const View& view : contents.light_field.views) poses.insert(view.id);
}

// Views are recorded in the order of their ids: ids missing around damaged lines were in them.
void NameMissingViews(JournalContents& contents) {
  if (contents.damaged.empty()) return;
  std::set<int> recorded;
  // The highest id before a line, and the lowest from it on.
  std::vector<int> highest{0}, lowest(contents.lines.size() + 1, contents.next_view_id);
  for (const JournalLine& line : contents.lines) {
    highest.push_back(std::max(highest.back(), line.view_id));
    if (line.view_id != 0) recorded.insert(line.view_id);
  }
  for (std::size_t i = contents.lines.size(); i-- > 0;)
    lowest[i] =
        contents.lines[i].view_id == 0 ? lowest[i + 1] : std::min(lowest[i + 1], contents.lines[i].view_id);
  for (DamagedLine& damaged : contents.damaged) {
    if (!damaged.IsWhole())
      for (const View& view : contents.light_field.views) damaged.poses.insert(view.id);
    const int before = highest[static_cast<std::size_t>(damaged.number - 1)],
              after = lowest[static_cast<std::size_t>(damaged.last)];
    if (after - before > kMostInDoubt) continue;
    for (int id = before + 1; id < after; ++id)
      if (!contents.removed.contains(id) && !recorded.contains(id)) damaged.views.insert(id);
    if (!damaged.views.empty() && damaged.IsWhole()) damaged.poses.clear();
  }
}

// Notes the view of a kept line: its number is taken, and the view is in doubt.
void NoteStayingView(const json& object, JournalContents& contents) {
  ++contents.staying_lines;
  if (object.value("event", "") != "view") return;
  const int id = object["id"].get<int>();  // validated by ReadViewJson()
  if (id < 1 || id > kMostViewId) return;
  contents.lines.back().view_id = id;
  contents.damaged.back().views.insert(id);
  contents.next_view_id = std::max(contents.next_view_id, id + 1);
}

// Applies the line or notes that it is damaged.
void ApplyLine(std::string_view line, const std::optional<json>& object, JournalContents& contents) {
  const int number = static_cast<int>(contents.lines.size());
  JournalLine& read = contents.lines.back();
  const std::size_t views_before = contents.light_field.views.size();
  try {
    if (!object) return NoteDamaged(number, false, fmt::format("line {}: damaged", number), line, contents);
    ApplyEvent({*object, fmt::format("line {}", number)}, contents);
    read.whole = true;
    if (contents.light_field.views.size() > views_before) read.view_id = (*object)["id"].get<int>();
  } catch (const LineStaysError& error) {
    read.stays = true;
    NoteDamaged(number, true, error.what(), line, contents);
    NoteStayingView(*object, contents);
  } catch (const Error& error) {
    NoteDamaged(number, true, error.what(), line, contents);
  }
}

void ReadHeader(const std::optional<json>& object, const std::string& where, JournalContents& contents) {
  const std::string advice = fmt::format("'ulf repair {}' shows what can be put back",
                                         ShellWord(contents.light_field.root.string()));
  if (!object) throw DamagedHeaderError(where + ": the header is damaged", advice);
  const JsonPlace event{*object, where};
  try {
    if (event.Text("event") != "header")
      throw Error("{}: a journal begins with its header; this file is none", where);
    ApplyHeader(event, contents);
  } catch (const NewerFormatError&) {
    throw;
  } catch (const Error& error) {
    throw DamagedHeaderError(error.what(), advice);
  }
}

bool IsCheckedLine(const std::optional<json>& object) {
  return object && object->is_object() && object->contains("event") && (*object)["event"] == "checked";
}

JournalContents Read(const fs::path& file, const LightField* header) {
  JournalContents contents;
  if (header) contents.light_field = *header;
  contents.light_field.root = FolderOf(file);
  const std::string bytes = ReadWholeFile(file);
  std::size_t begin = 0, next_whole = 0;
  for (std::size_t end; (end = bytes.find('\n', begin)) != std::string::npos; begin = end + 1) {
    const std::string_view line = std::string_view(bytes).substr(begin, end - begin);
    const auto object = ParsedLine(line);
    // Blocks of a file reach the disk in any order: lines before its end may be damaged, too.
    if (!object && next_whole <= begin) next_whole = NextWholeLine(bytes, end + 1);
    if (next_whole == std::string_view::npos) break;
    contents.lines.push_back({begin, end, false, 0});
    if (contents.lines.size() > 1) {
      ApplyLine(line, object, contents);
    } else if (!header) {
      ReadHeader(object, fmt::format("{}, line 1", file.string()), contents);
      contents.lines.back().whole = true;
    }
    contents.whole_bytes = end + 1;
    if (!IsCheckedLine(object)) contents.derived_bytes = end + 1;
  }
  if (contents.whole_bytes == 0 && !header)
    throw Error(
        "{}: the journal has no header: the capture was killed before it began, or the file is damaged; 'ulf "
        "repair {}' shows what can be put back",
        file.string(), ShellWord(contents.light_field.root.string()));
  NameMissingViews(contents);
  return contents;
}

}  // namespace

std::string DamagedLine::Words() const {
  const auto are = [](const std::set<int>& ids) { return ids.size() == 1 ? "is" : "are"; };
  std::string words = reason + (lines == 1 ? "; the line is left out" : "; these lines are left out");
  if (!views.empty()) words += fmt::format("; {} {} in doubt", ViewNumbers(views), are(views));
  if (!poses.empty())
    words += fmt::format("; it may have corrected poses: {} {} in doubt", ViewNumbers(poses), are(poses));
  return words;
}

JournalContents ReadJournal(const fs::path& file) { return Read(file, nullptr); }

JournalContents ReadJournal(const fs::path& file, const LightField& header) { return Read(file, &header); }

}  // namespace ulf
