// ./run measure stability: drives every stage into the place where it fails, and writes the page beside the
// folder of its pictures.
#include <filesystem>

#include "core/base/atomic_file.h"
#include "tests/measure/curve.h"

namespace ulf::test {
namespace {

void WritePage(const std::filesystem::path& folder) {
  std::vector<MeasuredCurve> measured;
  for (const Curve& curve : AllCurves()) {
    if (!curve.never_breaks.empty()) continue;
    const auto table = folder / (curve.name + ".csv");
    measured.push_back(std::filesystem::exists(table) ? FromChart(curve, ReadChart(table))
                                                      : MeasuredCurve{.curve = curve});
  }
  WriteFileAtomically(std::filesystem::path(folder).replace_extension(".md"),
                      StabilityPage(measured, folder.filename().string()));
}

}  // namespace
}  // namespace ulf::test

int main(int count, char** words) {
  using namespace ulf::test;
  MeasuringProgram program{"stability", "Drives every stage into the place where it fails", {}, WritePage};
  for (const Curve& curve : AllCurves())
    if (curve.never_breaks.empty()) program.measurements.push_back(MeasurementOf(curve));
  return RunMeasurements(program, count, words);
}
