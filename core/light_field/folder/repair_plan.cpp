#include "core/light_field/folder/repair_plan.h"

#include <algorithm>
#include <set>

#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/shell_word.h"
#include "core/light_field/findings.h"
#include "core/light_field/folder/folder_check.h"
#include "core/light_field/folder/followed_links.h"
#include "core/light_field/folder/quick_checks.h"
#include "core/light_field/folder/view_files.h"
#include "core/light_field/formats/colmap_files.h"
#include "core/light_field/formats/transforms_json.h"
#include "core/light_field/journal_stamp.h"
#include "core/light_field/points/point_io.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

// The readable part of the journal. If its header is lost, transforms.json gives one, or else the cameras of
// sparse/0.
struct Found {
  JournalContents journal;
  std::optional<LightField> header;    // cameras and device
  std::optional<LightField> settings;  // the header with subject, goal and counts
  std::string problem;                 // why its own header cannot be used
  std::string damage;                  // the same of a damaged one, without advice
  const char* header_from = kTransformsFile;
};

// Throws Error if the cameras cannot be read.
std::vector<CameraModel> CamerasOfModel(const fs::path& sparse) {
  std::vector<CameraModel> cameras;
  for (const auto& [id, camera] : ReadColmapCameras(sparse / "cameras.txt")) cameras.push_back(camera);
  return cameras;
}

// Returns true if ulf wrote the model: then its cameras are the journal's, in the same order.
bool HeaderFromModel(const fs::path& dir, Found& found) {
  const fs::path sparse = dir / "sparse/0";
  if (!fs::is_regular_file(sparse / "images.txt") || !ReadColmapPoses(sparse / "images.txt").made_from)
    return false;
  LightField header;
  header.root = dir;
  try {
    header.cameras = CamerasOfModel(sparse);
  } catch (const Error& error) {
    found.problem += fmt::format("; {}", error.what());
    return false;
  }
  found.header = header;
  found.header_from = "sparse/0";
  return !found.header->cameras.empty();
}

bool HeaderFromTransforms(const fs::path& dir, Found& found) {
  if (!fs::is_regular_file(dir / kTransformsFile)) return false;
  TransformsText text;
  try {
    text = ReadTransformsText(dir / kTransformsFile);
  } catch (const NewerFormatError&) {
    throw;
  } catch (const Error& error) {
    found.problem += fmt::format("; {}", error.what());
    return false;
  }
  if (!text.ours) {
    found.problem += fmt::format("; {} is by another program", kTransformsFile);
    return false;
  }
  LightField& header = found.header.emplace();
  static_cast<CaptureFacts&>(header) = text.light_field;
  header.root = text.light_field.root;
  header.cameras = text.light_field.cameras;
  header.calibration_sources = text.light_field.calibration_sources;
  header.measured = text.light_field.measured;
  found.settings = std::move(text.light_field);
  return true;
}

Found FindJournal(const fs::path& dir) {
  Found found;
  if (fs::exists(dir / kJournalFile) && !fs::is_regular_file(dir / kJournalFile))
    throw Error("{}: is no file; move it away, then repair", (dir / kJournalFile).string());
  try {
    if (!fs::exists(dir / kJournalFile))
      throw Error("{}: there is no journal", (dir / kJournalFile).string());
    found.journal = ReadJournal(dir / kJournalFile);
    return found;
  } catch (const NewerFormatError&) {
    throw;
  } catch (const DamagedHeaderError& error) {
    found.problem = error.what();
    found.damage = error.problem;
  } catch (const Error& error) {
    found.problem = error.what();
  }
  if (!HeaderFromTransforms(dir, found) && !HeaderFromModel(dir, found))
    throw Error(
        "{}; no other file of ulf holds the cameras: {}", found.problem,
        fs::is_regular_file(dir / kTransformsFile)
            ? fmt::format("take the set in with 'ulf import {} -o NEW'", ShellWord(dir.string()))
            : fmt::format("check the path, or restore {} or {} from a copy", kJournalFile, kTransformsFile));
  if (fs::is_regular_file(dir / kJournalFile))
    found.journal = ReadJournal(dir / kJournalFile, *found.header);
  else
    found.journal.light_field = *found.header;
  return found;
}

// Returns the journal's camera for each camera of the other file: the one of most common views, or one with
// the same model.
std::map<int, int> MatchCameras(const LightField& journal, const LightField& other) {
  std::map<int, std::map<int, int>> votes;
  for (const View& view : other.views)
    if (const View* ours = journal.FindView(view.id)) ++votes[view.camera][ours->camera];
  std::map<int, int> matched;
  for (int camera = 0; camera < static_cast<int>(other.cameras.size()); ++camera) {
    const auto same = std::ranges::find(journal.cameras, other.cameras[static_cast<std::size_t>(camera)]);
    if (const auto found = votes.find(camera); found != votes.end())
      matched[camera] = std::ranges::max_element(found->second, [](const auto& a, const auto& b) {
                          return a.second < b.second;
                        })->first;
    else if (same != journal.cameras.end())
      matched[camera] = static_cast<int>(same - journal.cameras.begin());
    else if (journal.cameras.size() == 1 && other.cameras.size() == 1)
      matched[camera] = 0;
  }
  return matched;
}

bool HasItsImage(const fs::path& dir, const View& view) {
  return fs::is_regular_file(dir / view.image_path) ||
         (PictureFollowsFromMaster(view) && fs::is_regular_file(dir / view.master_path));
}

// Recovers views from transforms.json, which contains all values of a view; camera indices become the
// journal's.
void RecoverFromTransforms(const fs::path& dir, const LightField& journal, const FolderCheck& check,
                           RepairPlan& plan) {
  if (!check.transforms.KnowsMoreThanJournal()) return;
  const LightField& other = *check.from_transforms;
  std::map<int, int> cameras = MatchCameras(journal, other);
  for (const auto& [id, view] : check.transforms.unknown) {
    if (cameras.contains(view.camera)) continue;
    cameras[view.camera] = static_cast<int>(journal.cameras.size() + plan.new_cameras.size());
    plan.new_cameras.push_back(
        {other.cameras[static_cast<std::size_t>(view.camera)], {}, {}, other.CalibrationSource(view.camera)});
  }
  std::map<int, View> without_image;
  for (auto [id, view] : check.transforms.unknown) {
    const auto camera = cameras.find(view.camera);
    if (camera == cameras.end()) continue;
    view.camera = camera->second;
    (HasItsImage(dir, view) ? plan.recovered : without_image)[id] = view;
  }
  if (!without_image.empty())
    plan.found.push_back(fmt::format("{}: the photographs of {} are missing: they cannot come back",
                                     (dir / kTransformsFile).string(), ViewNumbers(without_image)));
  for (const auto& [id, view] : check.transforms.lost_poses) plan.poses[id] = view.cam_from_world;
  // If the journal contains later lines, its poses are newer.
  const bool is_newer =
      check.transforms.lineage == Lineage::kJournalShort || check.transforms.lineage == Lineage::kUnknown;
  if (!is_newer) return;
  for (const auto& [id, view] : check.transforms.other_poses) plan.poses[id] = view.cam_from_world;
  for (const auto& [theirs, ours] : cameras) {
    const CameraModel& camera = other.cameras[static_cast<std::size_t>(theirs)];
    if (ours < static_cast<int>(journal.cameras.size()) &&
        !(camera == journal.cameras[static_cast<std::size_t>(ours)]))
      plan.cameras[ours] = {camera, other.CalibrationSource(theirs)};
  }
  if (check.transforms.lineage == Lineage::kJournalShort) plan.settings = other;
}

// The model names no masters: a file of the view's name in masters/ is the master if some transfer curve and
// mosaic make the photograph from it.
void FindMaster(const fs::path& dir, const std::vector<CameraModel>& cameras, View& view) {
  const fs::path master = fs::path("masters") / fs::path(view.image_path).stem().concat(".tif");
  if (!fs::is_regular_file(dir / master) || !fs::is_regular_file(dir / view.image_path)) return;
  LightField alone;
  alone.root = dir;
  alone.cameras = cameras;
  View& tried = alone.views.emplace_back(view);
  tried.master_path = master.generic_string();
  for (const Transfer transfer : {Transfer::kLinear, Transfer::kSrgb})
    for (const Mosaic mosaic : {Mosaic::kNone, Mosaic::kRggb, Mosaic::kGrbg, Mosaic::kGbrg, Mosaic::kBggr}) {
      tried.master_transfer = transfer;
      tried.master_mosaic = mosaic;
      try {
        PictureFromMaster(dir, tried);
        if (const PictureCheck check = CheckPictures(alone);
            !check.others.empty() || !check.damaged_masters.empty())
          continue;
      } catch (const std::exception&) {
        continue;  // wrong interpretation
      }
      view = tried;
      return;
    }
}

// Recovers views from sparse/0, which contains poses, cameras and names only.
void RecoverFromModel(const fs::path& dir, const LightField& journal, const FolderCheck& check,
                      RepairPlan& plan) {
  if (!check.model.KnowsMoreThanJournal()) return;
  const bool transforms_tell_poses = check.transforms.KnowsMoreThanJournal();
  std::vector<CameraModel> cameras = journal.cameras;
  for (const NewCamera& camera : plan.new_cameras) cameras.push_back(camera.camera);
  const auto all_are_known = [&] {
    return std::ranges::all_of(check.model.unknown, [&](const auto& id_and_view) {
      return id_and_view.second.camera < static_cast<int>(cameras.size());
    });
  };
  if (plan.new_cameras.empty() && !all_are_known()) {
    // These cameras are the journal's, in the same order.
    const std::vector<CameraModel> of_model = CamerasOfModel(dir / "sparse/0");
    for (std::size_t i = cameras.size(); i < of_model.size(); ++i) {
      cameras.push_back(of_model[i]);
      plan.new_cameras.push_back({of_model[i], {}, {}, ""});
    }
  }
  for (auto [id, view] : check.model.unknown) {
    const bool camera_known = view.camera >= 0 && view.camera < static_cast<int>(cameras.size());
    if (plan.recovered.contains(id) || !camera_known || !HasItsImage(dir, view)) continue;
    FindMaster(dir, cameras, view);
    plan.recovered[id] = view;
  }
  // A truncated file has corrections of some views only; poses would be inconsistent.
  if (!transforms_tell_poses && check.model.lineage == Lineage::kJournalShort && !check.model.is_cut)
    for (const auto& [id, view] : check.model.other_poses) plan.poses[id] = view.cam_from_world;
}

// Views are recovered even if their folder was moved.
void PlanRemovals(const fs::path& dir, const LightField& light_field, const FolderCheck& check,
                  RepairPlan& plan) {
  const std::size_t gone = check.missing_images.size(), views = light_field.views.size();
  if (gone == 0) return;
  const std::string missing =
      fmt::format("{}: the photographs of {} are missing", dir.string(), ViewNumbers(check.missing_images));
  if (gone > 1 && 2 * gone > views) {
    plan.found.push_back(missing + ": most of all; put images/ and masters/ back where they were");
    return;
  }
  plan.found.push_back(missing);
  plan.taken_out = check.missing_images;
}

// A photograph that differs from its master can be made again; one of the wrong size without a master cannot.
void PlanPictures(const fs::path& dir, const LightField& light_field, RepairPlan& plan) {
  const PictureCheck check = CheckPictures(light_field);
  if (!check.damaged_masters.empty()) {
    const View* first = light_field.FindView(*check.damaged_masters.begin());
    plan.found.push_back(fmt::format(
        "{}: the masters of {} cannot be read ({} is truncated or damaged{}): their photographs of 8 "
        "bits are used; copy the masters again from their source",
        dir.string(), ViewNumbers(check.damaged_masters), first->master_path,
        check.damaged_masters.size() > 1 ? ", and so are others" : ""));
  }
  if (const std::size_t damaged = check.damaged.size(); damaged > 0) {
    const bool are_most = damaged > 1 && 2 * damaged > light_field.views.size();
    plan.found.push_back(
        fmt::format("{}: the photographs of {} cannot be read and have no other copy here; copy them again "
                    "from their source{}",
                    dir.string(), ViewNumbers(check.damaged),
                    are_most ? ": they are more than half of all" : ", or their views are taken out"));
    if (!are_most) plan.taken_out.insert(check.damaged.begin(), check.damaged.end());
  }
  std::set<int> alone;
  for (const View& view : light_field.views) {
    if (!check.others.contains(view.id)) continue;
    if (PictureFollowsFromMaster(view) && fs::is_regular_file(dir / view.master_path))
      plan.pictures_of_others.insert(view.id);
    else
      alone.insert(view.id);
  }
  if (!alone.empty())
    plan.found.push_back(
        fmt::format("{}: the photographs of {} differ in size from their camera; restore them", dir.string(),
                    ViewNumbers(alone)));
}

// Returns whether two texts differ by the rounding of numbers alone, as texts by two builds of ulf for one
// journal may.
bool SameButForRounding(const std::string& a, const std::string& b) {
  constexpr double kRounding = 1e-12;
  constexpr char kOfNumbers[] = "0123456789+-.eE";
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    const std::size_t end_a = std::min(a.find_first_not_of(kOfNumbers, i), a.size()),
                      end_b = std::min(b.find_first_not_of(kOfNumbers, j), b.size());
    const std::string number_a = a.substr(i, end_a - i), number_b = b.substr(j, end_b - j);
    if (number_a != number_b) {
      const bool are_decimal = number_a.find_first_of(".e") != std::string::npos ||
                               number_b.find_first_of(".e") != std::string::npos;
      const double x = std::strtod(number_a.c_str(), nullptr), y = std::strtod(number_b.c_str(), nullptr);
      if (!are_decimal || !(std::abs(x - y) <= kRounding * std::max({1.0, std::abs(x), std::abs(y)})))
        return false;
    }
    i = end_a;
    j = end_b;
    if (i < a.size() && j < b.size() && a[i++] != b[j++]) return false;
  }
  return i == a.size() && j == b.size();
}

// Finds derived files of this journal that were damaged or edited, and points that cannot be read.
void CompareDerived(const fs::path& dir, const JournalContents& journal, const FolderCheck& check,
                    RepairPlan& plan) {
  LightField light_field = journal.light_field;
  ReadPoints(light_field);
  WarnOnce(dir, KnownFindings(journal.kept_findings, light_field));
  for (const std::string& doubt : light_field.doubts) plan.found.push_back(doubt);
  plan.damaged_points = !light_field.doubts.empty();
  const bool no_ply = !light_field.points.empty() && !fs::exists(dir / "points.ply");
  if (no_ply) plan.found.push_back(fmt::format("{}: is missing", (dir / "points.ply").string()));
  plan.new_derived |= plan.damaged_points || no_ply;
  if (check.transforms.lineage != Lineage::kCurrent || check.model.lineage != Lineage::kCurrent) return;
  const auto stamp = [&](const Derived& derived) {
    return StampOf(dir / kJournalFile, derived.made_from_bytes);
  };
  const ColmapFiles colmap = ToColmapText(ToColmap(light_field), stamp(check.model));
  // points.ulf rounds observations and points: only the number of lines is compared for their files.
  const auto compare = [&](const char* name, bool same) {
    if (same) return;
    plan.found.push_back(
        fmt::format("{}: differs from what ulf made from the journal", (dir / name).string()));
    (name == std::string(kTransformsFile) ? plan.other_transforms : plan.other_model) = true;
    plan.new_derived = true;
  };
  const auto text = [&](const char* name) {
    return fs::is_regular_file(dir / name) ? ReadWholeFile(dir / name) : std::string();
  };
  const auto lines = [](const std::string& of) { return std::ranges::count(of, '\n'); };
  const std::string images = text("sparse/0/images.txt"), points = text("sparse/0/points3D.txt");
  compare("sparse/0/cameras.txt", SameButForRounding(text("sparse/0/cameras.txt"), colmap.cameras));
  compare("sparse/0/images.txt", images.ends_with('\n') && lines(images) == lines(colmap.images));
  compare("sparse/0/points3D.txt", points.ends_with('\n'));
  // Earlier versions did not write measured errors there.
  if (check.from_transforms && !check.from_transforms->measured) light_field.measured.reset();
  compare(kTransformsFile, SameButForRounding(text(kTransformsFile),
                                              TransformsJsonText(light_field, stamp(check.transforms))));
}

// Lists the values of the header and the journal that sparse/0 lacks.
std::string FieldsMissingInModel() {
  return fmt::format(
      "sparse/0 holds poses and cameras alone: the rest of the header cannot be put back (device, threshold, "
      "where the calibration is from, flat field, colour profile); without the journal's other lines, nor "
      "can subject, up, goal and times (ulf render and ulf info take {}, a resumed capture takes {})",
      Parameter("subject"), Parameter("quality"));
}

RepairPlan PlanFrom(const fs::path& dir, const Found& found) {
  const JournalContents& journal = found.journal;
  const FolderCheck check = CheckFolder(dir, journal, false);
  RepairPlan plan;
  plan.views_before = plan.views_after = journal.light_field.views.size();
  if (!check.refused_links.empty()) {  // their targets are neither missing nor damaged
    plan.found = check.words;
    return plan;
  }
  if (found.header)
    plan.found.push_back(
        fmt::format("{}; {}", found.damage.empty() ? found.problem : found.damage,
                    found.settings ? "a flat field or a colour profile that the header had cannot be put back"
                                   : FieldsMissingInModel()));
  plan.header_from = found.header_from;
  plan.found.insert(plan.found.end(), check.problems.begin(), check.problems.end());
  plan.header = found.header;
  for (const DamagedLine& line : journal.damaged) plan.damaged_lines += static_cast<std::size_t>(line.lines);
  plan.damaged_lines -= journal.staying_lines;
  plan.longest_stamp = std::max(check.transforms.made_from_bytes, check.model.made_from_bytes);
  RecoverFromTransforms(dir, journal.light_field, check, plan);
  RecoverFromModel(dir, journal.light_field, check, plan);
  if (found.settings) plan.settings = found.settings;
  PlanRemovals(dir, journal.light_field, check, plan);
  PlanPictures(dir, journal.light_field, plan);
  for (const View& view : journal.light_field.views)
    plan.missing_pictures |= PictureFollowsFromMaster(view) && !fs::exists(dir / view.image_path) &&
                             fs::is_regular_file(dir / view.master_path);
  plan.new_journal = plan.header || !plan.recovered.empty() || !plan.poses.empty() || !plan.cameras.empty() ||
                     !plan.taken_out.empty() || plan.settings || plan.damaged_lines > 0;
  plan.new_derived = plan.new_journal || check.not_closed || !check.transforms.IsOurs() ||
                     !check.model.IsOurs() || check.model.is_cut;
  if (!plan.new_journal) CompareDerived(dir, journal, check, plan);
  plan.views_after = plan.views_before + plan.recovered.size() - plan.taken_out.size();
  return plan;
}

void PlanPictureSteps(const fs::path& dir, RepairPlan& plan) {
  if (plan.pictures_of_others.empty()) return;
  const std::string views = ViewNumbers(plan.pictures_of_others);
  plan.found.push_back(
      fmt::format("{}: the photographs in images/ of {} differ from their masters", dir.string(), views));
  plan.steps.push_back(
      fmt::format("move the photographs of {} to unposed/ and make them again from their masters", views));
}

void PlanSteps(const fs::path& dir, RepairPlan& plan) {
  if (plan.header) plan.steps.push_back(fmt::format("give the journal a header from {}", plan.header_from));
  if (!plan.recovered.empty())
    plan.steps.push_back(fmt::format("put {} back into the journal ({})",
                                     Counted(plan.recovered.size(), "view"), ViewNumbers(plan.recovered)));
  if (!plan.poses.empty())
    plan.steps.push_back(fmt::format("take over {} whose correction the journal has lost",
                                     Counted(plan.poses.size(), "pose")));
  if (!plan.cameras.empty()) plan.steps.push_back("take over the corrected intrinsics");
  if (plan.settings && !plan.header)
    plan.steps.push_back(fmt::format("put back the subject, up, goal and counts of the session that {} holds",
                                     kTransformsFile));
  if (!plan.taken_out.empty())
    plan.steps.push_back(fmt::format("take {} out of the light field", ViewNumbers(plan.taken_out)));
  if (plan.new_journal)
    plan.steps.push_back(!fs::exists(dir / kJournalFile)
                             ? "write a journal"
                             : fmt::format("write the journal again{}; the old one stays in kept/",
                                           plan.damaged_lines == 0
                                               ? ""
                                               : " without " + Counted(plan.damaged_lines, "damaged line")));
  PlanPictureSteps(dir, plan);
  if (plan.missing_pictures) plan.steps.push_back(kMakePicturesStep);
  if (plan.new_derived)
    plan.steps.push_back(
        "write transforms.json, sparse/0 and the points' files again; files that differ from the journal go "
        "to kept/");
}

}  // namespace

RepairPlan PlanRepair(const fs::path& dir) {
  if (!fs::is_directory(dir))
    throw Error("{}: there is no such folder; give the folder of a light field", dir.string());
  const std::vector<OutsideLink> refused = RefusedLinks(dir, {});
  if (std::ranges::find(refused, kJournalFile, &OutsideLink::link) != refused.end())
    RequireFollowed(dir, refused);
  RepairPlan plan = PlanFrom(dir, FindJournal(dir));
  PlanSteps(dir, plan);
  return plan;
}

JournalContents ReadDamagedJournal(const fs::path& dir) { return FindJournal(dir).journal; }

}  // namespace ulf
