// Solves hierarchies of 35 joints with DAQP's hierarchical solver: hierarchies FILE. hierarchies.py describes the file.
// Prints one line per way: name,median_s,p99_s,error,level_1_error; and a remark with the errors of all levels.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "timing.hpp"

extern "C" {
#include "api.h"
#include "utils.h"
}

constexpr int joints = 35, rows = 32, independent = 100;
constexpr std::array<int, 5> ends{0, 12, 18, 24, 32};

struct Hierarchy {
  std::array<double, joints> lower, upper;
  std::array<double, rows * joints> A;
  std::array<double, rows> b;
  std::array<double, joints> exact;

  // The norm of A x - b of a level.
  double residual(const double* x, int level) const {
    double sum = 0;
    for (int i = ends[level]; i < ends[level + 1]; ++i) {
      double row = -b[i];
      for (int j = 0; j < joints; ++j) row += A[i * joints + j] * x[j];
      sum += row * row;
    }
    return std::sqrt(sum);
  }
};

static std::vector<Hierarchy> read(const char* path) {
  static_assert(sizeof(Hierarchy) == sizeof(double) * (3 * joints + rows * joints + rows));
  std::ifstream file(path, std::ios::binary);
  std::vector<Hierarchy> hierarchies;
  for (Hierarchy h; file.read(reinterpret_cast<char*>(&h), sizeof h);) hierarchies.push_back(h);
  return hierarchies;
}

// DAQP takes limits as the first level, which is hard. Without the last level, the joint speed as small as possible,
// its answer is one of many.
struct Daqp {
  static constexpr int most = joints + rows + joints;
  std::array<double, (rows + joints) * joints> A{};
  std::array<double, most> lower{}, upper{}, multipliers{};
  std::array<int, most> sense{};
  std::array<int, 6> break_points{joints, joints + 12, joints + 18, joints + 24, joints + 32, most};
  std::array<double, joints> x{};
  DAQPSettings settings;
  DAQPWorkspace work{};
  DAQPProblem problem{};
  DAQPResult result{};
  bool is_warm = false;

  explicit Daqp(bool least_speed) {
    daqp_default_settings(&settings);
    for (int j = 0; j < joints; ++j) A[(rows + j) * joints + j] = 1;
    problem.n = joints;
    problem.ms = joints;
    problem.m = least_speed ? most : joints + rows;
    problem.nh = least_speed ? 6 : 5;
    problem.A = A.data();
    problem.blower = lower.data();
    problem.bupper = upper.data();
    problem.sense = sense.data();
    problem.break_points = break_points.data();
    result.x = x.data();
    result.lam = multipliers.data();
  }
  void set(const Hierarchy& h) {
    std::copy(h.A.begin(), h.A.end(), A.begin());
    std::copy(h.lower.begin(), h.lower.end(), lower.begin());
    std::copy(h.upper.begin(), h.upper.end(), upper.begin());
    std::copy(h.b.begin(), h.b.end(), lower.begin() + joints);
    std::copy(h.b.begin(), h.b.end(), upper.begin() + joints);
  }
  bool solve_cold(const Hierarchy& h) {
    set(h);
    sense.fill(0);
    daqp_quadprog(&result, &problem, &settings);
    return result.exitflag > 0;
  }
  // The workspace keeps the active constraints of the call before.
  bool solve_warm(const Hierarchy& h) {
    set(h);
    if (!is_warm) {
      work.settings = &settings;
      is_warm = true;
      if (setup_daqp(&problem, &work, nullptr) < 0) return false;
    } else if (daqp_update_ldp(DAQP_UPDATE_M + DAQP_UPDATE_d, &work, &problem) < 0) {
      return false;
    }
    daqp_solve(&result, &work);
    return result.exitflag > 0;
  }
};

static void report(const std::string& name, bool least_speed, bool warm, const Hierarchy* first, int count) {
  Daqp daqp(least_speed);
  auto solve = [&](std::size_t i) { return warm ? daqp.solve_warm(first[i]) : daqp.solve_cold(first[i]); };
  auto [median, p99] = problem_by_problem(15, count, solve);
  double error = 0, outside = 0;
  std::array<double, 4> worse{};
  int failed = 0;
  for (int i = 0; i < count; ++i) {
    failed += !solve(i);
    const Hierarchy& h = first[i];
    for (int j = 0; j < joints; ++j) outside = std::max({outside, daqp.x[j] - h.upper[j], h.lower[j] - daqp.x[j]});
    if (std::isnan(h.exact[0])) continue;
    for (int j = 0; j < joints; ++j) error = std::max(error, std::abs(daqp.x[j] - h.exact[j]));
    for (int k = 0; k < 4; ++k)
      worse[k] = std::max(worse[k], h.residual(daqp.x.data(), k) - h.residual(h.exact.data(), k));
  }
  std::printf("%s,%.4e,%.4e,", name.c_str(), median, p99);
  if (least_speed) std::printf("%.1e", error);
  std::printf(",%.1e\n", worse[0]);
  std::printf("%s: residuals of levels 1 to 4 above the optimum by up to %.1e %.1e %.1e %.1e; %d of %d failed; limits "
              "exceeded by up to %.1e\n",
              name.c_str(), worse[0], worse[1], worse[2], worse[3], failed, count, outside);
}

int main(int, char** arguments) {
  auto hierarchies = read(arguments[1]);
  const Hierarchy *start = hierarchies.data(), *trajectory = start + independent;
  int periods = int(hierarchies.size()) - independent;
  for (bool least_speed : {false, true}) {
    std::string solver = least_speed ? "DAQP hierarchical with least speed" : "DAQP hierarchical";
    report("35 joints: " + solver + ", cold", least_speed, false, start, independent);
    report("35 joints along a trajectory: " + solver + ", cold", least_speed, false, trajectory, periods);
    report("35 joints along a trajectory: " + solver + ", warm", least_speed, true, trajectory, periods);
  }
}
