// Findings of checks of a light field. docs/light_field.md ("Checks") says of each check what it judges, who
// runs it, who repeats what it found, and what it costs.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace ulf {

enum class Check {
  kFiles,    // files of the folder that disagree or are damaged: these are in LightField::doubts
  kPoints,   // points that do not belong to the poses
  kSubject,  // a subject that no photograph shows, or far beyond what the cameras tell apart
  kPoses,    // poses that disagree with what the photographs show
  kLight     // a lamp that changed between earlier and later views
};
inline constexpr Check kChecks[] = {Check::kFiles, Check::kPoints, Check::kSubject, Check::kPoses,
                                    Check::kLight};
const char* Name(Check check);  // "files", ...

// Says what a check found wrong.
struct Finding {
  std::string check;                 // Name() of a Check, or of one that a newer ulf knows
  std::string text;                  // for people; "{views}" in it stands for the views
  std::map<int, std::string> views;  // their photographs by id; empty: the light field as a whole is wrong

  std::string Words() const;  // the text with the views' numbers and photographs in place of "{views}"
};

// Replaces the check's earlier findings by `found`.
void Replace(Check check, const std::vector<Finding>& found, std::vector<Finding>& findings);

// Logs a warning for each finding, once in a process: some commands read a light field several times.
void WarnOnce(const std::filesystem::path& light_field, const std::vector<Finding>& findings);

// Does the same for texts that name the light field themselves.
void WarnOnce(const std::vector<std::string>& words);

// Digests of what a check judged of a view, which reveal later changes.
struct JudgedView {
  std::string photograph, pose;  // empty: the check does not depend on it
  bool operator==(const JudgedView&) const = default;
};
// A finding of an earlier run, kept in the journal. It lapses for views whose photograph or pose has changed.
struct KeptFinding {
  std::string check, text;
  bool whole = false;  // about the light field as a whole; `views` are examples
  std::map<int, JudgedView> views;
  bool operator==(const KeptFinding&) const = default;
};

// Returns "view 7" or "views 3, 5 to 9 and 12", for many runs of ids "... and 20 more"; "" for no view.
std::string ViewNumbers(const std::set<int>& ids);

// Does the same for the keys of a map.
template <typename Value>
std::string ViewNumbers(const std::map<int, Value>& by_id) {
  std::set<int> ids;
  for (const auto& [id, value] : by_id) ids.insert(id);
  return ViewNumbers(ids);
}

}  // namespace ulf
