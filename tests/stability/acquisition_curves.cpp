#include "tests/stability/curve.h"

namespace ulf::test {

std::vector<Curve> AcquisitionCurves() { return {}; }

}  // namespace ulf::test
