// A control loop at 500 Hz with a watchdog: the arm moves to a wall and presses on it.
//
//     g++ -std=c++17 -O2 touch_wall.cpp -o touch_wall $(pkg-config --cflags --libs cpp-httplib) -pthread
//     ./touch_wall http://127.0.0.1:8080
//
// The arm is simulated. For a real arm, replace `Arm::measure` and `Arm::command`.
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "revprio.hpp"

using revprio::Clock;
using revprio::Json;

namespace {

volatile std::sig_atomic_t is_interrupted = 0;

Json controller(double period_s) {
    return Json::parse(R"({
        "robot": "sawyer_dh",
        "tasks": [
            {"name": "push", "axes": ["x"], "law": {"kind": "force", "inertia": 15, "damping": 150,
                "target_force": {"kind": "constant", "value": 30}}},
            {"name": "hold", "axes": ["y", "z", "rx", "ry", "rz"], "law": {"kind": "impedance",
                "inertia": [15, 15, 80, 80, 80], "damping": [150, 150, 280, 280, 280],
                "stiffness": [1000, 1000, 100, 100, 100], "target_pose": "initial"}}
        ]})")
        .patch(Json::array({{{"op", "add"}, {"path", "/period_s"}, {"value", period_s}}}));
}

/// A simulated arm that follows its commands exactly, with a wall 1 cm in front of the tool.
class Arm {
public:
    explicit Arm(revprio::Client& client) : client_(client), start_x_(tool_x()) {}

    revprio::Measurement measure() {
        revprio::Measurement now;
        now.joint_position = q_;
        now.joint_velocity = qdot_;
        force_n = std::max(1000 * (tool_x() - start_x_ - 0.01), 0.0);
        now.force = {force_n, 0, 0};
        return now;
    }

    void command(const std::vector<double>& velocity, double period_s) {
        qdot_ = velocity;
        for (std::size_t joint = 0; joint < q_.size(); ++joint) q_[joint] += period_s * velocity[joint];
    }

    double force_n = 0;

private:
    double tool_x() {
        return client_.kinematics({{"robot", "sawyer_dh"}, {"joint_position", q_}}).at("pose").at("position").at(0);
    }

    revprio::Client& client_;
    std::vector<double> q_{2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2};
    std::vector<double> qdot_ = std::vector<double>(7, 0.0);
    double start_x_;
};

} // namespace

int main(int argc, char** argv) try {
    const double period_s = 0.002;
    const int periods = argc > 2 ? std::atoi(argv[2]) : 1500;
    const auto period = std::chrono::duration_cast<Clock::duration>(revprio::Seconds(period_s));
    const std::string url = argc > 1 ? argv[1] : "http://127.0.0.1:8080";
    revprio::Client client(url);
    revprio::Session session(client, controller(period_s));
    revprio::Client arm_client(url); // only one thread may use a client
    revprio::Watchdog watchdog = revprio::Watchdog::of(arm_client.robot("sawyer_dh"));
    Arm arm(arm_client);
    std::signal(SIGINT, [](int) { is_interrupted = 1; });

    // The call of the service blocks, so `Loop` has a separate thread. The arm gets a command in every period.
    revprio::Loop loop(session, watchdog);
    auto tick = Clock::now();
    std::exception_ptr failure;
    try {
        for (int i = 0; i < periods && !is_interrupted; ++i, std::this_thread::sleep_until(tick += period)) {
            loop.ask(arm.measure());
            loop.wait_until(tick + period);
            arm.command(loop.command(), period_s);
        }
    } catch (...) {
        failure = std::current_exception(); // a refused state, or a session that has ended: the arm still moves
    }
    for (loop.stop(); !loop.is_at_rest(); std::this_thread::sleep_for(period)) arm.command(loop.command(), period_s);
    if (failure) std::rethrow_exception(failure);
    const revprio::LoopReport report = loop.report();
    std::printf("%.2f N; %.2f ms per period, requested %.2f ms\n", arm.force_n, 1e3 * report.achieved_period_s,
                1e3 * period_s);
    if (report.slow_windows > 0) std::fprintf(stderr, "%s\n", report.warning.c_str());
} catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
