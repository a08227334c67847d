// Measures contenders in turn, because other programs on the machine disturb all times: what disturbs one
// contender disturbs the next one as well.
#pragma once

#include <functional>
#include <vector>

#include "core/base/quantile.h"
#include "tests/measure/chart.h"

namespace ulf::test {

// Runs a round of every contender before the next round, until `goes_on(rounds so far)` returns false. Who
// begins changes, so that a machine that grows busier favours nobody. Returns the rounds of each contender.
template <typename Round>
std::vector<std::vector<Round>> InTurn(const std::vector<std::function<Round()>>& contenders,
                                       const std::function<bool(std::size_t)>& goes_on) {
  std::vector<std::vector<Round>> rounds(contenders.size());
  for (std::size_t round = 0; goes_on(round); ++round)
    for (std::size_t i = 0; i < contenders.size(); ++i) {
      const std::size_t turn = (i + round) % contenders.size();
      rounds[turn].push_back(contenders[turn]());
    }
  return rounds;
}

// Compares our way of doing something with a bare one: medians, and the spread of ratios round by round.
template <typename Round>
class Paired {
 public:
  // Runs all rounds.
  Paired(const std::function<Round()>& ours, const std::function<Round()>& bare, std::size_t rounds)
      : rounds_(InTurn<Round>({ours, bare}, [=](std::size_t done) { return done < rounds; })) {}

  const std::vector<Round>& ours() const { return rounds_[0]; }
  const std::vector<Round>& bare() const { return rounds_[1]; }
  template <typename Value>
  Spread Ratios(Value Round::*value) const {
    std::vector<double> ratios;
    for (std::size_t i = 0; i < ours().size(); ++i)
      ratios.push_back(static_cast<double>(ours()[i].*value) / static_cast<double>(bare()[i].*value));
    return Spread::Of(ratios);
  }
  template <typename Value>
  static double MedianOf(const std::vector<Round>& rounds, Value Round::*value) {
    std::vector<double> values;
    for (const Round& round : rounds) values.push_back(static_cast<double>(round.*value));
    return Median(values);
  }

 private:
  std::vector<std::vector<Round>> rounds_;
};

}  // namespace ulf::test
