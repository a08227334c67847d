// Writes a camera's features. Each is read first: cameras describe as read-only what they have fixed, and a
// feature that has the wanted value needs no write.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/aravis/aravis_calls.h"
#include "acquisition/aravis/aravis_session.h"

namespace ulf::acquisition {

// Returns whether the camera's description says that the feature is read-only.
bool IsReadOnly(const AravisSession& session, const std::string& feature);
// Returns why a feature cannot be written now: "is read-only", "is locked by another setting", "is not
// available now"; empty if it can be.
std::string WhyFixed(const AravisSession& session, const std::string& feature);
// Returns the feature's value as text ("Off", "true", "512"); none if it is not there or not readable now.
std::optional<std::string> ReadSetting(const AravisSession& session, const std::string& feature);
// Writes `value` unless the feature has it. Returns why the feature does not have it afterwards ("GainAuto
// reads Continuous and is read-only"), or an empty text.
std::string WriteSetting(const AravisSession& session, const std::string& feature, const std::string& value);
// Writes a value that the option `asked` of the URI ("trigger=Line0") needs. Throws Refusal that begins with
// `who` and names the feature, its value, and the way out.
void RequireSetting(const AravisSession& session, const std::string& who, const std::string& asked,
                    const std::string& feature, const std::string& value);
// Returns the refusal of an option, `asked` ("trigger=Line0"), whose value is none of the choices.
Refusal NoSuchChoice(const std::string& who, const std::string& asked,
                     const std::vector<std::string>& choices);

// A numeric feature of a camera, an integer on some and a float on others. All values are in ulf's unit.
class AravisNumber {
 public:
  // `unit`: how many of ulf's units are one of the camera's. An empty `feature` is one that it does not have.
  AravisNumber() = default;
  AravisNumber(const AravisSession& session, std::string feature, double unit = 1);

  bool IsThere() const { return !feature_.empty(); }
  const std::string& Feature() const { return feature_; }
  // Returns none when the feature is not there, or not readable now.
  std::optional<double> Read() const;
  // Returns whether the feature has the value, so that it needs no write. One that cannot be written may
  // differ by half a step or a thousandth.
  bool Reads(double value) const;
  std::string WhyFixed() const;  // as above
  // Writes the value, rounded to the camera's steps if it is an integer. Throws Error beginning with `who`.
  void Write(const std::string& who, double value) const;
  // Returns the smallest and the largest value. Throws Error that begins with `who`.
  std::pair<double, double> Bounds(const std::string& who) const;
  // Returns the distance of neighbouring values; 0 if the camera names none.
  double Step() const;

 private:
  const AravisSession* session_ = nullptr;
  ArvCamera* camera_ = nullptr;
  std::string feature_;
  double unit_ = 1;
  bool is_whole_ = false;
};

}  // namespace ulf::acquisition
