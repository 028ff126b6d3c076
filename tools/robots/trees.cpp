// Times Pinocchio's kinematics of a tree: trees MODEL, a model that `saveToText` wrote. The input has the names of links in
// its first line and a posture in each further one. Prints the least mean time of a posture over repeated passes, ns: the
// Jacobians of all joints, and pose and Jacobian of each link.
#include <chrono>
#include <cstdio>
#include <iostream>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/serialization.hpp>

using Clock = std::chrono::steady_clock;

static double seconds(Clock::time_point since) { return std::chrono::duration<double>(Clock::now() - since).count(); }

int main(int, char** arguments) {
  pinocchio::Model model;
  model.loadFromText(arguments[1]);
  pinocchio::Data data(model);
  std::string line, name;
  std::getline(std::cin, line);
  std::vector<pinocchio::FrameIndex> frames;
  for (std::istringstream words(line); words >> name;) frames.push_back(model.getFrameId(name, pinocchio::BODY));
  std::vector<Eigen::VectorXd> postures;
  while (std::getline(std::cin, line)) {
    std::istringstream numbers(line);
    Eigen::VectorXd q(model.nq);
    for (int i = 0; i < model.nq; ++i) numbers >> q[i];
    postures.push_back(q);
  }
  pinocchio::Data::Matrix6x jacobian = pinocchio::Data::Matrix6x::Zero(6, model.nv);
  double least = std::numeric_limits<double>::infinity(), sum = 0;
  for (const auto start = Clock::now(); seconds(start) < 0.2;) {
    const auto pass = Clock::now();
    for (const auto& q : postures) {
      pinocchio::computeJointJacobians(model, data, q);
      for (const auto frame : frames) {
        pinocchio::updateFramePlacement(model, data, frame);
        jacobian.setZero();
        pinocchio::getFrameJacobian(model, data, frame, pinocchio::LOCAL_WORLD_ALIGNED, jacobian);
        sum += jacobian(0, 0) + data.oMf[frame].translation()[0];
      }
    }
    least = std::min(least, seconds(pass) / postures.size());
  }
  // The sum keeps the compiler from leaving out the work.
  std::fprintf(stderr, "%g\n", sum);
  std::printf("%.1f\n", 1e9 * least);
}
