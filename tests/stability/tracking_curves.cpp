#include "tests/stability/curve.h"

namespace ulf::test {

std::vector<Curve> TrackingCurves() { return {}; }

}  // namespace ulf::test
