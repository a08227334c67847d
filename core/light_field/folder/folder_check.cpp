#include "core/light_field/folder/folder_check.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <functional>
#include <opencv2/core.hpp>
#include <set>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/mutex.h"
#include "core/base/parallel_for.h"
#include "core/base/shell_word.h"
#include "core/image/files/image_header.h"
#include "core/image/files/picture_end.h"
#include "core/image/files/picture_file.h"
#include "core/light_field/findings.h"
#include "core/light_field/folder/view_files.h"
#include "core/light_field/formats/colmap_files.h"
#include "core/light_field/formats/image_names.h"
#include "core/light_field/formats/set_format.h"
#include "core/light_field/formats/transforms_json.h"
#include "core/light_field/journal_stamp.h"
#include "core/light_field/light_field.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

// Returns false also if a link leads to itself or a folder may not be entered.
bool IsFile(const fs::path& file) {
  std::error_code unknown;
  return fs::is_regular_file(file, unknown);
}

// The largest difference between equal poses: rounding of a pose that was written as text and read.
constexpr double kSamePose = 1e-9;

bool IsSamePose(const Rigid3& a, const Rigid3& b) {
  const double scale = std::max(1.0, a.translation.norm());
  return (a.Matrix() - b.Matrix()).cwiseAbs().maxCoeff() <= kSamePose * scale;
}

// Counts the journal up to its last whole line: a power cut may leave a longer file without content.
Lineage LineageOf(const std::optional<JournalStamp>& made_from, const fs::path& file,
                  const JournalContents& journal) {
  if (!made_from) return Lineage::kUnknown;
  if (made_from->bytes > journal.whole_bytes) return Lineage::kJournalShort;
  if (StampOf(file, made_from->bytes) != made_from) return Lineage::kJournalOther;
  return made_from->bytes >= journal.derived_bytes ? Lineage::kCurrent : Lineage::kOlder;
}

std::set<int> Ids(const std::map<int, View>& views) {
  std::set<int> ids;
  for (const auto& [id, view] : views) ids.insert(ids.end(), id);
  return ids;
}

// Adds the differences between `views` and the journal.
void Compare(const std::vector<View>& views, const JournalContents& journal, Derived& derived) {
  for (const View& view : views) {
    if (const View* known = journal.light_field.FindView(view.id)) {
      // View numbers of another program refer to other photographs.
      if (SafeName(known->image_path) != SafeName(view.image_path)) derived.lineage = Lineage::kForeign;
      if (!IsSamePose(known->cam_from_world, view.cam_from_world)) derived.other_poses[view.id] = view;
    } else if (!journal.removed.contains(view.id)) {
      derived.unknown[view.id] = view;
    }
  }
}

// Tells whether views of both have different cameras. A lens whose coefficients are all 0 is none.
bool CamerasDiffer(const LightField& journal, const LightField& other) {
  const auto plain = [](CameraModel camera) {
    if (camera.distortion == Distortion::kRadialTangential && camera.coefficients == std::array<double, 5>{})
      camera.distortion = Distortion::kNone;
    return camera;
  };
  return std::ranges::any_of(other.views, [&](const View& view) {
    const View* known = journal.FindView(view.id);
    return known && !(plain(journal.CameraOf(*known)) == plain(other.CameraOf(view)));
  });
}

// Runs `check` on a file that exists; it is unreadable if `check` throws.
Derived CheckFile(const fs::path& file, const std::function<void(Derived&)>& check) {
  Derived derived;
  if (!fs::is_regular_file(file)) return derived;
  try {
    check(derived);
  } catch (const std::exception& error) {
    derived.lineage = Lineage::kUnreadable;
    derived.problem = error.what();
  }
  return derived;
}

Derived CheckTransforms(const fs::path& dir, const JournalContents& journal,
                        std::optional<LightField>& content) {
  const fs::path file = dir / kTransformsFile;
  return CheckFile(file, [&](Derived& derived) {
    TransformsText text = ReadTransformsText(file);
    derived.lineage = LineageOf(text.made_from, dir / kJournalFile, journal);
    if (text.made_from) derived.made_from_bytes = text.made_from->bytes;
    Compare(text.light_field.views, journal, derived);
    if (!text.ours) derived.lineage = Lineage::kForeign;
    derived.other_cameras = CamerasDiffer(journal.light_field, text.light_field);
    if (derived.lineage == Lineage::kJournalOther)
      for (const DamagedLine& line : journal.damaged)
        for (const int id : line.poses)
          if (const auto pose = derived.other_poses.find(id); pose != derived.other_poses.end())
            derived.lost_poses.insert(*pose);
    content = std::move(text.light_field);
  });
}

// transforms.json rounds a pose to a matrix; the model has it to the last digit, which depth maps, mesh and
// points require.
void TakeExactPoses(const Derived& model, Derived& transforms) {
  for (auto* views : {&transforms.unknown, &transforms.other_poses, &transforms.lost_poses})
    for (auto& [id, view] : *views)
      for (const auto* exact : {&model.unknown, &model.other_poses})
        if (const auto found = exact->find(id);
            found != exact->end() && IsSamePose(found->second.cam_from_world, view.cam_from_world))
          view.cam_from_world = found->second.cam_from_world;
}

// Returns false for most truncated text files.
bool EndsWithNewline(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  stream.seekg(-1, std::ios::end);
  return stream.get() == '\n';
}

Derived CheckModel(const fs::path& dir, const JournalContents& journal) {
  const fs::path file = dir / "sparse/0/images.txt";
  return CheckFile(file, [&](Derived& derived) {
    const ColmapPoses poses = ReadColmapPoses(file);
    derived.lineage = LineageOf(poses.made_from, dir / kJournalFile, journal);
    if (poses.made_from) derived.made_from_bytes = poses.made_from->bytes;
    std::vector<View> views;
    for (const auto& [id, image] : poses.images) {
      View view;
      view.id = id;
      view.image_path = "images/" + image.name;
      view.camera = image.camera - 1;
      view.cam_from_world = image.cam_from_world;
      views.push_back(std::move(view));
    }
    Compare(views, journal, derived);
    derived.is_cut = !EndsWithNewline(file) || (derived.lineage == Lineage::kCurrent &&
                                                views.size() < journal.light_field.views.size());
    // Without a stamp only a file with equal content is ulf's.
    if (!poses.made_from && !(derived.unknown.empty() && derived.other_poses.empty()))
      derived.lineage = Lineage::kForeign;
  });
}

// Returns the number before the first dot or hyphen: 000012.png, 000012.master.tif, 000012-2.png.
int NumberOf(const fs::path& file) {
  const std::string name = file.filename().string();
  const std::size_t digits = std::min(name.find_first_not_of("0123456789"), name.size());
  if (digits == 0 || digits > 9 || (digits < name.size() && name[digits] != '.' && name[digits] != '-'))
    return 0;
  return std::stoi(name.substr(0, digits));
}

void CollectFiles(const fs::path& dir, const JournalContents& journal, FolderCheck& check) {
  std::set<std::string> named;
  for (const View& view : journal.light_field.views) {
    named.merge(FilesOf(view));
    named.insert(view.mask_path);
  }
  std::error_code refused;
  for (const char* folder : {"images", "masters", "masks", "unposed", kExposuresFolder, kMergedFolder})
    for (const auto& entry : fs::directory_iterator(dir / folder, refused)) {
      const int number = NumberOf(entry.path());
      if (number == 0) continue;
      check.highest_number = std::max(check.highest_number, number);
      const std::string path = folder + ("/" + entry.path().filename().string());
      if (folder == std::string("unposed") || named.contains(path) || journal.removed_files.contains(path) ||
          path.ends_with(kTemporaryEnding))
        continue;
      check.unnamed.push_back(path);
    }
  std::ranges::sort(check.unnamed);
  for (const auto& derived : {check.transforms, check.model})
    if (!derived.unknown.empty())
      check.highest_number = std::max(check.highest_number, derived.unknown.rbegin()->first);
  for (const View& view : journal.light_field.views) {
    const bool has_master = !view.master_path.empty() && IsFile(dir / view.master_path);
    const bool has_image = IsFile(dir / view.image_path);
    if (has_image) {
      if (!view.master_path.empty() && !has_master) check.missing_masters.insert(view.id);
    } else {
      const bool can_be_made = has_master && PictureFollowsFromMaster(view);
      (can_be_made ? check.unmade_images : check.missing_images).insert(view.id);
    }
  }
}

void AddWords(FolderCheck& check, const std::string& problem, const std::string& advice = "") {
  check.problems.push_back(problem);
  check.words.push_back(problem + advice);
}

void AddMessage(const fs::path& dir, const char* name, const Derived& derived, FolderCheck& check) {
  const std::string file = (dir / name).string(), word = ShellWord(dir.string());
  const std::string show = fmt::format("; 'ulf repair {}' shows what can be put back", word),
                    make = fmt::format(", 'ulf repair {}' makes it again", word);
  if (derived.lineage == Lineage::kUnreadable) {
    AddWords(check, derived.problem + "; it is derived from the journal", make);
  } else if (derived.KnowsMoreThanJournal()) {
    if (!derived.unknown.empty())
      AddWords(check,
               fmt::format("{} holds {} that the journal has lost ({})", file,
                           Counted(derived.unknown.size(), "view"), ViewNumbers(derived.unknown)),
               show);
    else if (derived.lost_poses.empty() && derived.other_poses.empty())
      AddWords(
          check,
          fmt::format("the journal was longer when {} was made from it: its last lines are lost (subject, "
                      "goal, counts of frames; all poses are there)",
                      file),
          show);
    else
      AddWords(
          check,
          fmt::format(
              "the journal was longer when {} was made from it: corrections of poses may be lost ({} differ)",
              file,
              Counted((derived.lost_poses.empty() ? derived.other_poses : derived.lost_poses).size(),
                      "pose")),
          show);
  } else if (derived.is_cut) {
    AddWords(check, file + " is cut short; it is derived from the journal", make);
  } else if (derived.lineage == Lineage::kForeign) {
    AddWords(check, file + " is by another program: the journal is used");
  } else if (derived.WasChanged()) {
    std::set<int> ids = Ids(derived.unknown);
    ids.merge(Ids(derived.other_poses));
    AddWords(check, fmt::format("{} differs from the journal ({}): the journal is used", file,
                                ids.empty() ? "its cameras" : ViewNumbers(ids)));
  }
}

// Mean difference, of 255 levels. The same picture made twice differs by rounding, two views of one scene by
// far more. Guessed.
constexpr double kSameLevels = 2;

template <typename Read>
cv::Mat PixelsOrNone(const Read& read) {
  try {
    return read();
  } catch (const std::exception&) {
    return {};
  }
}

void CheckPicture(const LightField& light_field, const View& view, PictureCheck& check) {
  const fs::path path = light_field.root / view.image_path;
  if (!IsFile(path)) return;  // reported elsewhere
  const CameraModel& camera = light_field.CameraOf(view);
  if (const auto header = ReadImageHeader(path.string());
      header && (header->width != camera.width || header->height != camera.height)) {
    check.others.insert(view.id);
    return;
  }
  if (!PictureFollowsFromMaster(view) || !IsFile(light_field.root / view.master_path)) {
    if (!ImageFileIsWhole(path.string()) ||
        PixelsOrNone([&] { return ReadImageFile(path.string()); }).empty())
      check.damaged.insert(view.id);
    return;
  }
  const cv::Mat made =
      PixelsOrNone([&] { return PictureFromMaster(light_field.root, view, SizeOf(camera)).pixels; });
  const cv::Mat stored = PixelsOrNone(
      [&] { return Srgb8({.pixels = ReadImageFile(path.string()), .transfer = Transfer::kSrgb}); });
  if (made.empty()) (stored.empty() ? check.damaged : check.damaged_masters).insert(view.id);
  if (made.empty()) return;
  const bool same =
      made.size() == stored.size() && cv::norm(made, stored, cv::NORM_L1) <=
                                          kSameLevels * static_cast<double>(made.total()) * made.channels();
  if (!same) check.others.insert(view.id);
}

}  // namespace

bool Derived::KnowsMoreThanJournal() const {
  if (!lost_poses.empty()) return true;
  switch (lineage) {
    case Lineage::kJournalShort:
      return true;
    case Lineage::kJournalOther:
    case Lineage::kUnknown:
      return !unknown.empty();
    default:
      return false;
  }
}

bool Derived::WasChanged() const {
  if (KnowsMoreThanJournal()) return false;
  switch (lineage) {
    case Lineage::kForeign:
      return true;
    case Lineage::kCurrent:
    case Lineage::kJournalOther:
    case Lineage::kUnknown:
      return !unknown.empty() || !other_poses.empty() || other_cameras;
    case Lineage::kOlder:
      return !unknown.empty();
    default:
      return false;
  }
}

FolderCheck CheckFolder(const fs::path& dir, const JournalContents& journal, bool being_written) {
  FolderCheck check;
  check.refused_links = RefusedLinks(dir, journal.light_field.views);
  if (!check.refused_links.empty()) {
    AddWords(check, Words(dir, check.refused_links));
    return check;
  }
  for (const DamagedLine& line : journal.damaged)
    AddWords(check, fmt::format("{}, {}", (dir / kJournalFile).string(), line.Words()));
  if (!being_written) {
    check.transforms = CheckTransforms(dir, journal, check.from_transforms);
    check.model = CheckModel(dir, journal);
    TakeExactPoses(check.model, check.transforms);
    const auto behind = [](const Derived& derived) {
      return derived.lineage == Lineage::kMissing || derived.lineage == Lineage::kOlder;
    };
    check.not_closed = behind(check.transforms) || behind(check.model);
    AddMessage(dir, kTransformsFile, check.transforms, check);
    // Names only one of two files that contain the same views.
    if (!(check.transforms.KnowsMoreThanJournal() &&
          Ids(check.transforms.unknown) == Ids(check.model.unknown)))
      AddMessage(dir, "sparse/0/images.txt", check.model, check);
    if (fs::exists(dir / "sparse/0/images.bin"))
      AddWords(
          check,
          fmt::format("{}: COLMAP reads the binary model that lies there, not the text model of this light "
                      "field; move the .bin files elsewhere",
                      (dir / "sparse/0").string()));
  }
  CollectFiles(dir, journal, check);
  if (!being_written && !check.unnamed.empty() && !check.KnowsMoreThanJournal())
    AddWords(check, fmt::format("{}: the journal does not name {} ({}{}); nothing will be written over {}",
                                dir.string(), Counted(check.unnamed.size(), "file"), check.unnamed.front(),
                                check.unnamed.size() > 1 ? " to " + check.unnamed.back() : "",
                                check.unnamed.size() == 1 ? "it" : "them"));
  if (!check.missing_masters.empty())
    AddWords(check, fmt::format("{}: the masters of {} are missing: their photographs of 8 bits are used",
                                dir.string(), ViewNumbers(check.missing_masters)));
  if (!being_written && !check.unmade_images.empty())
    AddWords(check, fmt::format("{}: images/ has no photographs of {}: they are read from masters/, and "
                                "'ulf repair {} --write' makes them again",
                                dir.string(), ViewNumbers(check.unmade_images), ShellWord(dir.string())));
  return check;
}

void RequireImages(const LightField& light_field, const FolderCheck& check) {
  if (!check.refused_links.empty()) throw Error("{}", Words(light_field.root, check.refused_links));
  if (check.missing_images.empty()) return;
  const int id = *check.missing_images.begin();
  const auto view = std::ranges::find_if(light_field.views, [id](const View& each) { return each.id == id; });
  throw Error(
      "{0}: the image '{1}' of view {2} is missing{3}; restore it, or take such views out: ulf repair {4}",
      light_field.root.string(), view->image_path, id,
      check.missing_images.size() > 1 ? fmt::format(" (and {} more)", check.missing_images.size() - 1) : "",
      ShellWord(light_field.root.string()));
}

PictureCheck CheckPictures(const LightField& light_field) {
  struct {
    Mutex mutex;
    PictureCheck found ULF_GUARDED_BY(mutex);
  } shared;
  ParallelFor(light_field.views.size(), [&](std::size_t i) {
    PictureCheck one;
    CheckPicture(light_field, light_field.views[i], one);
    const MutexLock lock(shared.mutex);
    shared.found.others.merge(one.others);
    shared.found.damaged.merge(one.damaged);
    shared.found.damaged_masters.merge(one.damaged_masters);
  });
  const MutexLock lock(shared.mutex);
  return shared.found;
}

bool IsJournalMissing(const fs::path& dir) {
  if (fs::exists(dir / kJournalFile)) return false;
  const auto stamped = [&](const char* name, const auto& read) {
    if (!fs::is_regular_file(dir / name)) return false;
    try {
      return read(dir / name).made_from.has_value();
    } catch (const Error&) {
      return false;
    }
  };
  return stamped(kTransformsFile, ReadTransformsText) || stamped("sparse/0/images.txt", ReadColmapPoses);
}

Error MissingJournalError(const fs::path& dir) {
  const std::string folder = dir.string(), word = ShellWord(folder);
  if (!fs::is_directory(dir))
    return Error("{}: there is no such folder; give the folder of a light field", folder);
  if (IsJournalMissing(dir))
    return Error("{}: the journal is missing; 'ulf repair {}' shows how to restore it", folder, word);
  if (const std::vector<SetFormat> formats = FormatsIn(dir); !formats.empty())
    return Error(
        "{}: a set by another program ({}), which is never written to; 'ulf import {} -o NEW' makes a light "
        "field of it",
        folder, Name(formats.front()), word);
  return Error(
      "{}: holds no light field (no journal.jsonl); check the path, or record one with 'ulf capture -o {}'",
      folder, word);
}

}  // namespace ulf
