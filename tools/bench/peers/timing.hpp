// Timing of the C++ peers, the same as that of revprio-bench.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <vector>

struct Quantiles {
  double median, p99;
};

inline double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

inline double median_of(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

// Times call(index) for each problem, in order, in several rounds. The quantiles are those of the medians of each
// problem, so that other load on the machine does not reach them. The time to read the clock is subtracted.
template <class Call>
Quantiles problem_by_problem(int rounds, std::size_t count, Call call) {
  std::vector<double> clock(10000);
  for (double& time : clock) time = seconds_since(std::chrono::steady_clock::now());
  double cost = median_of(clock);
  std::vector<std::vector<double>> times(count);
  for (int round = 0; round < rounds; ++round)
    for (std::size_t index = 0; index < count; ++index) {
      auto start = std::chrono::steady_clock::now();
      call(index);
      times[index].push_back(std::max(seconds_since(start) - cost, 0.0));
    }
  std::vector<double> medians;
  for (const auto& problem : times) medians.push_back(median_of(problem));
  std::sort(medians.begin(), medians.end());
  return {medians[medians.size() / 2], medians[std::lround(0.99 * (medians.size() - 1))]};
}
