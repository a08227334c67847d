// ./run measure charts: what each stage costs against how wrong it is. Each chart stands in a file beside
// this one, with its words.
#include "tests/measure/runner.h"

int main(int count, char** words) {
  using namespace ulf::test;
  return RunMeasurements({"charts", "Makes the charts of docs/measured/charts/", Registered()}, count, words);
}
