// Tells the frames of a camera that moves, of which each shows nearly what the one before showed, from single
// photographs, which show the same elsewhere in the picture or show something else.
#pragma once

#include <memory>
#include <opencv2/core.hpp>

namespace ulf::tracking {

// Pairs of successive pictures. Pairs with a picture that shows hardly any corners belong to neither.
struct SuccessionFound {
  int near = 0;   // what the first shows is within a tenth of the longer side of there in the second
  int apart = 0;  // it is not
};

class Succession {
 public:
  Succession();
  ~Succession();
  // `gray`: CV_8UC1 of any size; a picture of another size than the one before is apart from it.
  void Add(const cv::Mat& gray);
  const SuccessionFound& found() const { return found_; }

 private:
  struct State;
  std::unique_ptr<State> state_;
  SuccessionFound found_;
};

}  // namespace ulf::tracking
