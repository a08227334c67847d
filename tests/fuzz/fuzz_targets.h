// The doors by which files and lines of others come in, each as a function of bytes: for the fuzzer, which
// looks for bytes that break one, and for the everyday test, which reads the corpus again.
//
// A door may throw Error and nothing else, takes no more memory than kMostMemory for the small files that
// a fuzzer makes, and what it returns is finite and names no file outside its folder. What breaks that
// ends the process.
#pragma once

#include <filesystem>
#include <span>
#include <string_view>

namespace ulf::test {

struct FuzzTarget {
  const char* name;
  void (*read)(std::string_view bytes);
};

std::span<const FuzzTarget> FuzzTargets();
// Null: there is none of that name.
const FuzzTarget* FuzzTargetByName(std::string_view name);

// ---- For the doors themselves ----

// Folders in memory for what a fuzzer makes: readers of ours take paths.
//
// Replaces the files of one folder of this process's, which is removed at the end. Several files share the
// bytes: each ends where a line "=====" stands, and the last ones may be missing. Names may have folders.
std::filesystem::path FuzzFolder(std::string_view bytes, std::span<const char* const> names);
// One file with all the bytes.
std::filesystem::path FuzzFile(std::string_view bytes, const char* name);

// A folder of small photographs, 0001.png to 0004.png of 64 x 48 pixels, which stays.
std::filesystem::path FuzzPhotographs();

// The same photographs in a new folder, which must not lead out of another one (hard links).
void PutFuzzPhotographs(const std::filesystem::path& folder);

// Ends the process with the words and the place: something that a reader must never return or throw.
[[noreturn]] void Broken(const char* what);

// Doors by which cameras come in: what arrives by a cable or a network. Aravis itself reads streams and
// descriptions; here is what our code makes of bytes before and behind it.
//
// A picture as it came, behind a line `FORMAT WIDTH HEIGHT ROW_BYTES` (core/frames/pixel_format.h).
void CameraImageDoor(std::string_view bytes);

// A camera's answer to a discovery packet.
void GigeAnswerDoor(std::string_view bytes);

// Requests to the simulated camera, each behind its length in two bytes, big-endian. What its filter lets
// through lies within its registers and is written by who controls it.
void GvcpRequestsDoor(std::string_view bytes);

}  // namespace ulf::test
