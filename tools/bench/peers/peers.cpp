// Solves the problems with Pinocchio and Eigen, eiquadprog or DAQP: peers PROBLEMS TRAJECTORY ARM. Prints one line per
// peer: name,median_s,p99_s,error,task_1_error. Each call includes kinematics and resolution.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/multibody.hpp>

#include <eiquadprog/eiquadprog-fast.hpp>

#include "timing.hpp"

extern "C" {
#include "api.h"
}

using Jacobian = Eigen::Matrix<double, 6, 7>;
using Joints = Eigen::Matrix<double, 7, 1>;

struct Problem {
  Eigen::VectorXd q;
  Eigen::Matrix<double, 6, 1> xdot;
  Joints limit, closed, exact;
};

static std::vector<Problem> read(const char* path) {
  std::ifstream file(path);
  std::vector<Problem> problems;
  for (std::string line; std::getline(file, line);) {
    std::istringstream cells(line);
    Problem p{Eigen::VectorXd(7), {}, {}, {}, {}};
    auto next = [&] { std::string cell; std::getline(cells, cell, ','); return std::stod(cell); };
    for (int i = 0; i < 7; ++i) p.q[i] = next();
    for (int i = 0; i < 6; ++i) p.xdot[i] = next();
    for (Joints* v : {&p.limit, &p.closed, &p.exact})
      for (int i = 0; i < 7; ++i) (*v)[i] = next();
    problems.push_back(p);
  }
  return problems;
}

struct Arm {
  pinocchio::Model model;
  pinocchio::Data data;
  pinocchio::FrameIndex tool;
  pinocchio::Data::Matrix6x J6;

  // Each joint has one row and rotates about z; the last row is the tool. See problems.py for the columns.
  explicit Arm(const char* path) {
    std::ifstream file(path);
    std::vector<pinocchio::SE3> placements;
    for (std::string line; std::getline(file, line);) {
      std::istringstream cells(line);
      Eigen::Matrix<double, 12, 1> v;
      for (int i = 0; i < 12; ++i) { std::string cell; std::getline(cells, cell, ','); v[i] = std::stod(cell); }
      Eigen::Matrix3d R = Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(v.data());
      placements.emplace_back(R, v.tail<3>());
    }
    pinocchio::JointIndex joint = 0;
    for (std::size_t i = 0; i + 1 < placements.size(); ++i)
      joint = model.addJoint(joint, pinocchio::JointModelRZ(), placements[i], "j" + std::to_string(i));
    tool = model.addFrame(pinocchio::Frame("tool", joint, placements.back(), pinocchio::OP_FRAME));
    data = pinocchio::Data(model);
    J6 = pinocchio::Data::Matrix6x::Zero(6, model.nv);
  }

  Jacobian jacobian(const Eigen::VectorXd& q) {
    pinocchio::computeJointJacobians(model, data, q);
    pinocchio::updateFramePlacement(model, data, tool);
    pinocchio::getFrameJacobian(model, data, tool, pinocchio::LOCAL_WORLD_ALIGNED, J6);
    return J6;
  }
};

constexpr double regularisation = 1e-8;

// Two levels: min |J_1 v - x_1|^2, then min |J_2 v - x_2|^2 with J_1 v fixed. Both add a small multiple of |v|^2,
// because the solver needs a strictly convex problem.
struct Eiquadprog {
  eiquadprog::solvers::EiquadprogFast solver;
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(7, 7), CE0 = Eigen::MatrixXd::Zero(0, 7), CE1 = Eigen::MatrixXd::Zero(1, 7);
  Eigen::MatrixXd CI = Eigen::MatrixXd::Zero(14, 7);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(7), ce0 = Eigen::VectorXd::Zero(0), ce1 = Eigen::VectorXd::Zero(1);
  Eigen::VectorXd ci = Eigen::VectorXd::Zero(14), v = Eigen::VectorXd::Zero(7);

  Eiquadprog() {
    CI.topRows(7).setIdentity();
    CI.bottomRows(7) = -Eigen::MatrixXd::Identity(7, 7);
  }
  void level(const auto& J, const auto& x, const Eigen::MatrixXd& CE, const Eigen::VectorXd& ce) {
    H.noalias() = J.transpose() * J;
    H.diagonal().array() += regularisation;
    g.noalias() = -(J.transpose() * x);
    solver.reset(7, CE.rows(), 14);
    solver.solve_quadprog(H, g, CE, ce, CI, ci, v);
  }
  Joints solve(const Jacobian& J, const Problem& p) {
    ci << p.limit, p.limit;
    level(J.topRows<1>(), p.xdot.head<1>(), CE0, ce0);
    CE1 = J.topRows<1>();
    ce1 = -(CE1 * v);
    level(J.bottomRows<5>(), p.xdot.tail<5>(), CE1, ce1);
    return v;
  }
};

// The same two levels with DAQP.
struct Daqp {
  double H[49], f[7], A[7], upper[8], lower[8], x[7], lam[8];
  int sense[8] = {0};
  Eigen::Map<Eigen::Matrix<double, 7, 7, Eigen::RowMajor>> Hm{H};
  Eigen::Map<Joints> fm{f}, xm{x};

  void level(const auto& J, const auto& t, int rows) {
    Hm.noalias() = J.transpose() * J;
    Hm.diagonal().array() += regularisation;
    fm.noalias() = -(J.transpose() * t);
    DAQPProblem qp{};
    qp.n = 7; qp.m = 7 + rows; qp.ms = 7; qp.H = H; qp.f = f; qp.A = A; qp.bupper = upper; qp.blower = lower; qp.sense = sense;
    DAQPResult result{};
    result.x = x; result.lam = lam;
    DAQPSettings settings;
    daqp_default_settings(&settings);
    std::fill(std::begin(sense), std::end(sense), 0);
    if (rows) sense[7] = 5;  // active and immutable: an equality constraint
    daqp_quadprog(&result, &qp, &settings);
  }
  Joints solve(const Jacobian& J, const Problem& p) {
    for (int i = 0; i < 7; ++i) { upper[i] = p.limit[i]; lower[i] = -p.limit[i]; }
    level(J.topRows<1>(), p.xdot.head<1>(), 0);
    Eigen::Map<Eigen::Matrix<double, 1, 7>> first_row(A);
    first_row = J.topRows<1>();
    upper[7] = lower[7] = (J.topRows<1>() * xm).value();
    level(J.bottomRows<5>(), p.xdot.tail<5>(), 1);
    return xm;
  }
};

// Eq. (32) with damped normal equations and without limits: the usual fast implementation.
static Joints normal_equations(const Jacobian& J, const Problem& p) {
  auto solve = [](const auto& A, const auto& b) -> Joints {
    auto AAt = (A * A.transpose()).eval();
    AAt.diagonal().array() += regularisation;
    return A.transpose() * AAt.ldlt().solve(b);
  };
  Joints q2 = solve(J.bottomRows<5>(), p.xdot.tail<5>());
  Eigen::Matrix<double, 6, 1> unit = Eigen::Matrix<double, 6, 1>::Unit(0);
  Joints T = solve(J, unit);
  double gap = p.xdot[0] - J.row(0).dot(q2);
  return q2 + T * gap / J.row(0).dot(T);
}

// Eq. (32) with Eigen's rank-revealing decomposition.
static Joints orthogonal(const Jacobian& J, const Problem& p) {
  Joints q2 = J.bottomRows<5>().completeOrthogonalDecomposition().solve(p.xdot.tail<5>());
  Joints T = J.completeOrthogonalDecomposition().solve(Eigen::Matrix<double, 6, 1>::Unit(0));
  double gap = p.xdot[0] - J.row(0).dot(q2);
  return q2 + T * gap / J.row(0).dot(T);
}

static void report(const char* name, Arm& arm, const std::vector<Problem>& problems, bool limited,
                   const std::function<Joints(const Jacobian&, const Problem&)>& solve) {
  double error = 0, first = 0;
  for (const auto& p : problems) {
    Jacobian J = arm.jacobian(p.q);
    Joints v = solve(J, p), exact = limited ? p.exact : p.closed;
    error = std::max(error, (v - exact).cwiseAbs().maxCoeff());
    first = std::max(first, std::abs((J.row(0) * (v - exact)).value()));
  }
  auto [median, p99] = problem_by_problem(200, problems.size(), [&](std::size_t i) {
    Joints v = solve(arm.jacobian(problems[i].q), problems[i]);
    asm volatile("" : : "g"(v.data()) : "memory");
  });
  std::printf("%s,%.4e,%.4e,%.1e,%.1e\n", name, median, p99, error, first);
}

int main(int, char** arguments) {
  auto problems = read(arguments[1]);
  auto trajectory = read(arguments[2]);
  Arm arm(arguments[3]);
  Eiquadprog eiquadprog;
  Daqp daqp;
  auto [median, p99] = problem_by_problem(200, problems.size(), [&](std::size_t i) {
    Jacobian J = arm.jacobian(problems[i].q);
    asm volatile("" : : "g"(J.data()) : "memory");
  });
  std::printf("kinematics: Pinocchio (C++),%.4e,%.4e,,\n", median, p99);
  report("closed form: Pinocchio + Eigen LDLT of J J^T", arm, problems, false, normal_equations);
  report("closed form: Pinocchio + Eigen complete orthogonal", arm, problems, false, orthogonal);
  report("limits: Pinocchio + eiquadprog, two levels", arm, problems, true,
         [&](const Jacobian& J, const Problem& p) { return eiquadprog.solve(J, p); });
  report("limits: Pinocchio + DAQP, two levels", arm, problems, true,
         [&](const Jacobian& J, const Problem& p) { return daqp.solve(J, p); });
  report("trajectory: Pinocchio + DAQP, two levels, cold", arm, trajectory, true,
         [&](const Jacobian& J, const Problem& p) { return daqp.solve(J, p); });
}
