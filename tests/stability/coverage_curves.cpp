#include "tests/stability/curve.h"

namespace ulf::test {

std::vector<Curve> CoverageCurves() { return {}; }

}  // namespace ulf::test
