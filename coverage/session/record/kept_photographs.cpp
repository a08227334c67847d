#include "coverage/session/record/kept_photographs.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/view_files.h"

namespace ulf::coverage {
namespace fs = std::filesystem;
namespace {

fs::path FolderBeside(const fs::path& light_field) {
  // "name/" means the same as "name".
  const fs::path named = light_field.has_filename() ? light_field : light_field.parent_path();
  return named.string() + ".photographs";
}

// Writes the camera's own files, or the pixels where it gave none, under the next free number.
void KeepBeside(const fs::path& folder, const Frame& frame) {
  std::vector<ViewFile> files;
  for (const auto* file : {&frame.encoded, &frame.raw})
    if (*file) files.push_back({(*file)->extension, ContentOf(*(*file)->bytes)});
  if (files.empty()) {
    ViewFiles made = MakeViewFiles(frame, true, MakePictures::kNow);
    for (auto* file : {&made.image, &made.master})
      if (*file) files.push_back(std::move(**file));
  }
  MakeFolder(folder);
  std::string stem;
  const auto path_of = [&](const ViewFile& file) { return folder / (stem + file.extension); };
  for (int number = 1; stem.empty(); ++number) {
    stem = fmt::format("{:06}", number);
    if (std::ranges::any_of(files, [&](const ViewFile& file) { return fs::exists(path_of(file)); }))
      stem.clear();
  }
  std::vector<std::pair<fs::path, FileContent>> together;
  for (const ViewFile& file : files) together.emplace_back(path_of(file), file.content);
  FileBatch batch;
  batch.Write(together);
  batch.Commit();
}

}  // namespace

std::optional<fs::path> SavePhotograph(LightFieldWriter* writer, const fs::path& light_field,
                                       const Frame& frame, std::string& problem) {
  try {
    if (writer) {
      writer->KeepUnposed(frame);
      return light_field / "unposed";
    }
  } catch (const std::exception& error) {
    problem = error.what();
  }
  try {
    KeepBeside(FolderBeside(light_field), frame);
    return FolderBeside(light_field);
  } catch (const std::exception& error) {
    problem = error.what();
    return std::nullopt;
  }
}

}  // namespace ulf::coverage
