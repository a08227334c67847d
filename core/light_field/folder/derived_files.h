// Makes the derived files of a light field: transforms.json, sparse/0 and points.ply from the journal and
// points.ulf, and photographs in images/ from their masters. Callers move a derived file that another program
// or a person has changed to kept/ before it is replaced.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "core/light_field/folder/folder_check.h"
#include "core/light_field/light_field.h"

namespace ulf {

// Writes transforms.json, sparse/0 and, if there are points, points.ply and points.ulf, with the stamp of the
// journal on disk. Throws DiskFullError, Error.
void WriteDerivedFiles(const LightField& light_field);
// Does the same but logs a warning instead of throwing: a capture can continue without these files.
void WriteDerivedFilesOrWarn(const LightField& light_field);

// Makes the photographs of images/ that are missing and can be made from their masters. Returns how many
// could not be made; logs a warning for each.
std::size_t MakeMissingPictures(const LightField& light_field);

// Moves `dir`/`name` to kept/, as `as` or the next free name. Returns its new path, or none if there was no
// such file. Throws Error if it cannot be moved.
std::optional<std::filesystem::path> MoveToKept(const std::filesystem::path& dir, const std::string& name,
                                                const std::string& as);

// Gives the file another name in kept/, for one that stays in its place until another one replaces it.
void LinkToKept(const std::filesystem::path& dir, const std::string& name);

// Moves to kept/ the derived files that another program or a person has changed (`check`) and, with
// `points_are_in_doubt`, the files of the points. Logs a warning for each.
void KeepForeignFiles(const std::filesystem::path& dir, const FolderCheck& check, bool points_are_in_doubt);

}  // namespace ulf
