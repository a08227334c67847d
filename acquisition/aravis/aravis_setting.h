// The one door by which a camera's features are written. Each is read first: cameras describe as read-only
// what they have fixed, and what reads as wanted needs no write.
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "acquisition/aravis/aravis_calls.h"
#include "acquisition/aravis/aravis_session.h"

namespace ulf::acquisition {

// Whether its description says so.
bool IsReadOnly(const AravisSession& session, const std::string& feature);
// Why a feature cannot be written now: "is read-only", "is locked by another setting", "is not available
// now"; empty: it can be.
std::string WhyFixed(const AravisSession& session, const std::string& feature);
// Its value as text ("Off", "true", "512"); none: it is not there, or cannot be read now.
std::optional<std::string> ReadSetting(const AravisSession& session, const std::string& feature);
// Writes `value` unless the feature reads so. Returns why it does not have the value: "GainAuto reads
// Continuous and is read-only"; empty: it has.
std::string WriteSetting(const AravisSession& session, const std::string& feature, const std::string& value);
// The same for what was asked for by name, `asked`: "trigger=Line0". Throws Refusal that begins with `who`
// and names the feature, its value, and the way out.
void RequireSetting(const AravisSession& session, const std::string& who, const std::string& asked,
                    const std::string& feature, const std::string& value);

// A number of a camera, which some cameras have whole and others not, in the unit that ulf counts in.
class AravisNumber {
 public:
  // `unit`: ours in one of the camera's. Empty `feature`: the camera does not have it.
  AravisNumber() = default;
  AravisNumber(const AravisSession& session, std::string feature, double unit = 1);

  bool IsThere() const { return !feature_.empty(); }
  const std::string& Feature() const { return feature_; }
  // None: not there, or not readable now.
  std::optional<double> Read() const;
  // Whether it needs no write; one that is fixed need only be so near that no other value could be meant.
  bool Reads(double value) const;
  std::string WhyFixed() const;
  // Rounded to the camera's steps where it counts in whole numbers. Throws Error that begins with `who`.
  void Write(const std::string& who, double value) const;
  // Smallest and largest. Throws Error that begins with `who`.
  std::pair<double, double> Bounds(const std::string& who) const;
  // 0: it has none.
  double Step() const;

 private:
  template <typename Set>
  void Put(const std::string& who, double wanted, Set&& set) const;

  const AravisSession* session_ = nullptr;
  ArvCamera* camera_ = nullptr;
  std::string feature_;
  double unit_ = 1;
  bool is_whole_ = false;
};

}  // namespace ulf::acquisition
