// Client of the revprio service: joint velocities for redundant arms by reverse task priority.
//
// Header-only, C++17. Needs cpp-httplib and nlohmann/json (Debian: libcpp-httplib-dev nlohmann-json3-dev). Bodies are
// JSON values with the field names of the OpenAPI document. All units are SI; revolute joints use rad and rad/s.
#pragma once

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <exception>
#include <mutex>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <httplib.h>
#include <nlohmann/json.hpp>

namespace revprio {

using Json = nlohmann::json;
using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

/// What the presets `push` and `wipe` may be told beyond the force. All units are SI.
struct PressOptions {
    Json hold = "rest";                         ///< Axes that a further task holds; "rest": all others; `nullptr`: no such task.
    double period_s = 0.001;                    ///< Period of the controller.
    double lag_s = 0.03;                        ///< Lag of the arm's velocity loop: the default of the `drive` of a controller.
    int delay_periods = 2;                      ///< Delay of a command: the default of the `drive` of a controller.
    std::optional<double> approach_speed = {};  ///< Default: the largest that keeps 1.2 times the force.
    std::optional<double> stiffest = {};        ///< Stiffness of the stiffest contact, N/m; default 1e6.
    std::optional<double> max_force = {};       ///< Force at which the tool leaves; default: none.
};

/// What the preset `wipe` may be told beyond `PressOptions`.
struct WipeOptions : PressOptions {
    double stroke_m = 0.1; ///< Way from the start along the axis and back; negative: the other direction.
    double speed = 0.05;   ///< Largest speed, m/s.
    double start_time_s = 0; ///< `time_s` of the states at which the motion begins; on the clock of Unix it counts from the first state.
    Json frame = "base";   ///< Axes of pressing, motion and hold; a pose for a tilted surface.
    std::optional<double> max_tilt_rad = {}; ///< Largest tilt of a surface of unknown direction, which the axes follow; default: they stay.
};

namespace presets {

inline Json contact_law(double newtons, const PressOptions& options) {
    if (!std::isfinite(newtons) || newtons == 0)
        throw std::invalid_argument("give a force; its sign is the direction in which the tool presses");
    Json law{{"kind", "contact"}, {"target_force", {{"kind", "constant"}, {"value", newtons}}}};
    if (options.approach_speed) law["approach_speed"] = *options.approach_speed;
    if (options.stiffest) law["stiffest"] = *options.stiffest;
    if (options.max_force) law["max_force"] = *options.max_force;
    return law;
}

inline double pose_gain(const PressOptions& options) {
    const double to_rest = options.lag_s + options.delay_periods * options.period_s;
    return to_rest <= 0 ? 2.0 : std::min(2.0, 1 / (8 * to_rest));
}

inline void hold_others(Json& tasks, const std::vector<std::string>& moved, const Json& frame, const PressOptions& options) {
    if (!options.hold.is_null() && !options.hold.is_array() && options.hold != "rest")
        throw std::invalid_argument("hold: give \"rest\", an array of axes or nullptr, not " + options.hold.dump());
    Json held = Json::array();
    const auto is_moved = [&](const Json& axis) { return std::find(moved.begin(), moved.end(), axis) != moved.end(); };
    if (options.hold.is_array()) {
        for (const Json& axis : options.hold) {
            if (is_moved(axis) || std::find(held.begin(), held.end(), axis) != held.end())
                throw std::invalid_argument("leave " + axis.dump() + " out of the axes to hold: it has a task already");
            held.push_back(axis);
        }
    }
    if (options.hold == "rest")
        for (const char* axis : {"x", "y", "z", "rx", "ry", "rz"})
            if (!is_moved(axis)) held.push_back(axis);
    if (held.empty()) return;
    const Json law{{"kind", "pose"}, {"gain", pose_gain(options)}};
    tasks.push_back({{"name", "hold"}, {"axes", held}, {"frame", frame}, {"law", law}});
}

} // namespace presets

/// Returns the tasks that press with a force (N, N·m for an axis of rotation) along one axis of the base and hold the others. The sign
/// of the force is the direction in which the tool presses. The law `contact` needs no stiffness; see docs/contact.md.
inline Json push(const std::string& axis, double newtons, const PressOptions& options = {}) {
    Json tasks = Json::array();
    tasks.push_back({{"name", "push"}, {"axes", {axis}}, {"law", presets::contact_law(newtons, options)}});
    presets::hold_others(tasks, {axis}, "base", options);
    return tasks;
}

/// Returns the tasks that press along one axis and move back and forth along another one, "x", "y" or "z". The motion begins at
/// `start_time_s`, also while the tool still approaches the surface. State it if the tasks replace others while the arm moves, or if the
/// first state has another time than 0: the arm would else catch up with the motion, faster than `speed`.
inline Json wipe(const std::string& axis, double newtons, const std::string& along, const WipeOptions& options = {}) {
    if ((along != "x" && along != "y" && along != "z") || along == axis)
        throw std::invalid_argument("move along x, y or z, and along another axis than the one along which the tool presses");
    if (!std::isfinite(options.stroke_m) || options.stroke_m == 0)
        throw std::invalid_argument("give a way; its sign is the direction in which the motion begins");
    if (!std::isfinite(options.speed) || options.speed <= 0) throw std::invalid_argument("give a speed above 0");
    if (!(std::abs(options.start_time_s) <= 1e6))
        throw std::invalid_argument("give a start time up to 1e6 s on the clock of the states; on that of Unix it counts from the first state");
    const double half = options.stroke_m / 2;
    const double rate = options.speed / std::abs(half);
    Json way{{"kind", "sine"}, {"offset", half}, {"amplitude", half}, {"angular_frequency_rad_s", rate},
             {"phase_rad", -std::acos(0.0) - rate * options.start_time_s}};
    if (options.start_time_s != 0) way["start_time_s"] = options.start_time_s;
    const Json sweep{{"kind", "pose"}, {"gain", presets::pose_gain(options)}, {"target_displacement", way}};
    Json law = presets::contact_law(newtons, options);
    if (options.max_tilt_rad) {
        if (!(*options.max_tilt_rad > 0 && *options.max_tilt_rad <= 1.4)) {
            throw std::invalid_argument("give a largest tilt above 0, and at most 1.4 rad");
        }
        law["surface"] = {{"max_tilt_rad", *options.max_tilt_rad}};
    }
    Json tasks = Json::array();
    tasks.push_back({{"name", "push"}, {"axes", {axis}}, {"frame", options.frame}, {"law", law}});
    tasks.push_back({{"name", "wipe"}, {"axes", {along}}, {"frame", options.frame}, {"law", sweep}});
    presets::hold_others(tasks, {axis, along}, options.frame, options);
    return tasks;
}

/// Base class of all errors that concern the service.
class Error : public std::runtime_error {
public:
    Error(const std::string& what, bool is_silence) : std::runtime_error(what), is_silence(is_silence) {}

    /// Whether a later call may succeed: the service cannot be reached, is late, or is overloaded.
    bool is_silence;
};

/// The service cannot be reached, the connection was lost, or the answer did not come in time.
class NoAnswer : public Error {
public:
    NoAnswer(const std::string& url, const std::string& cause, bool is_late)
        : Error("no answer from " + url + ": " + cause + "; is the service running there?", true), is_late(is_late) {}

    /// Whether the time limit was exceeded.
    bool is_late;
};

/// The answer is not one of a revprio service.
class ForeignAnswer : public Error {
public:
    ForeignAnswer(const std::string& url, int status)
        : Error("the answer of " + url + " (status " + std::to_string(status) + ") is not from a revprio service",
                status >= 500) {}
};

/// The service refused a request; the fields give the reason (RFC 9457, application/problem+json).
class Problem : public Error {
public:
    Problem(const Json& problem, std::optional<double> retry_after_s)
        : Error(message_of(problem), is_temporary(problem.at("status"))), type(problem.at("type")),
          detail(problem.at("detail")), pointer(pointer_of(problem)), status(problem.at("status")),
          retry_after_s(retry_after_s) {}

    std::string type;                    ///< Stable identifier of the kind of problem.
    std::string detail;                  ///< Description of the problem, with the remedy.
    std::string pointer;                 ///< JSON pointer of the invalid field, empty if there is none.
    int status;                          ///< HTTP status.
    std::optional<double> retry_after_s; ///< Value of the header `Retry-After`, s.

private:
    static std::string pointer_of(const Json& problem) {
        return problem.contains("pointer") && problem["pointer"].is_string() ? problem["pointer"].get<std::string>() : "";
    }
    static std::string message_of(const Json& problem) {
        const std::string pointer = pointer_of(problem);
        return problem.at("detail").get<std::string>() + " (" + std::to_string(problem.at("status").get<int>()) + " " +
               problem.at("type").get<std::string>() + (pointer.empty() ? "" : " at " + pointer) + ")";
    }
    static bool is_temporary(int status) { return status >= 500 || status == 408 || status == 429; }
};

/// Returns a random word for an owner token or an idempotency key.
inline std::string random_word() {
    std::random_device source;
    std::string word;
    for (int i = 0; i < 32; ++i) word += "0123456789abcdef"[source() % 16];
    return word;
}

/// Options of a client.
struct Options {
    std::string token;                 ///< Content of the service's --token-file; white space around it does not count.
    Seconds timeout{10.0};             ///< Time limit of one attempt of a call.
    Seconds step_timeout{0.1};         ///< Time limit of one attempt of a control period.
    int retries = 2;                   ///< Maximum number of retries; only calls that are safe to repeat are retried.
    std::string owner = random_word(); ///< Owner token of the sessions of this client; other clients cannot step them.
};

/// Returns whether a request may be sent again when it is unknown if the service received it. A POST may not if it creates
/// something, or can advance a simulation by a number of periods.
inline bool may_repeat(const std::string& method, const std::string& path) {
    if (method != "POST") return true;
    const bool creates = path == "/v1/robots" || path == "/v1/simulations" || path == "/v1/controllers";
    const std::string control = "/control";
    return !creates && (path.size() < control.size() || path.compare(path.size() - control.size(), control.size(), control) != 0);
}

/// A client of one service. It keeps one connection open. Only one thread at a time may use it.
class Client {
public:
    explicit Client(std::string url = "http://127.0.0.1:8080", Options options = {})
        : url_(std::move(url)), options_(std::move(options)), http_(url_) {
        http_.set_keep_alive(true);
        http_.set_tcp_nodelay(true);
        http_.set_default_headers({{"Accept", "application/json"}, {"Revprio-Owner", options_.owner}});
        const std::string token = checked_token(options_.token);
        if (!token.empty()) http_.set_bearer_token_auth(token);
    }

    /// Computes joint velocities for tasks, and the result of each task.
    Json resolve(const Json& request) { return post("/v1/resolve", request); }
    /// Resolves many requests at once. Returns, in the same order, an answer or a problem for each.
    Json resolve_batch(const Json& items) { return post("/v1/resolve/batch", {{"items", items}}).at("items"); }
    /// Returns tool pose (m), Jacobian (6 × n, base axes, linear rows first), singular values and link frames.
    Json kinematics(const Json& request) { return post("/v1/kinematics", request); }
    /// Returns stability margins of one axis in contact: maximum lag (s) and delay (periods), minimum damping.
    Json stability(const Json& request) { return post("/v1/stability", request); }
    /// Returns a robot with the limits and units of its joints.
    Json robot(const std::string& name) { return call("GET", "/v1/robots/" + name); }

    /// Sends any other call; `body` is sent unless it is null. `repeatable`: whether the call may be sent again when it
    /// is unknown if the service received it; default: `may_repeat`. `headers`: additional headers.
    Json call(const std::string& method, const std::string& path, const Json& body = nullptr,
              std::optional<bool> repeatable = {}, std::optional<Seconds> timeout = {}, const httplib::Headers& headers = {}) {
        const std::string content = body.is_null() ? "" : require_finite(body).dump();
        auto pause = Seconds(0.02);
        for (int left = options_.retries;; --left, pause *= 2) {
            try {
                return send(method, path, content, timeout.value_or(options_.timeout), headers);
            } catch (const Problem& problem) {
                const Seconds wait = problem.retry_after_s ? Seconds(*problem.retry_after_s) : pause;
                const bool is_busy = problem.status == 503 || problem.status == 429;
                if (left == 0 || !is_busy || wait >= timeout.value_or(options_.timeout)) throw;
                std::this_thread::sleep_for(wait);
            } catch (const NoAnswer& failure) {
                if (left == 0 || !repeatable.value_or(may_repeat(method, path)) || failure.is_late) throw;
                std::this_thread::sleep_for(pause);
            }
        }
    }

    const std::string& url() const { return url_; }
    /// Returns the owner token: clients that share sessions have the same one.
    const std::string& owner() const { return options_.owner; }
    Seconds step_timeout() const { return options_.step_timeout; }

private:
    /// Returns the token without the line break that ends its file.
    static std::string checked_token(const std::string& text) {
        const auto first = text.find_first_not_of(" \t\r\n");
        if (first == std::string::npos) return "";
        const std::string token = text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
        const auto is_sendable = [](unsigned char byte) { return byte >= ' ' && byte < 0x7f; };
        if (!std::all_of(token.begin(), token.end(), is_sendable))
            throw std::invalid_argument("the token has characters that cannot be sent; give the content of the file of --token-file");
        return token;
    }

    Json post(const std::string& path, const Json& body) { return call("POST", path, body); }

    Json send(const std::string& method, const std::string& path, const std::string& content, Seconds timeout,
              const httplib::Headers& headers) {
        const auto micros = std::chrono::duration_cast<std::chrono::microseconds>(timeout);
        http_.set_connection_timeout(micros);
        http_.set_read_timeout(micros);
        http_.set_write_timeout(micros);
        const auto start = Clock::now();
        const httplib::Result result = method == "POST"     ? http_.Post(path, headers, content, "application/json")
                                       : method == "PUT"    ? http_.Put(path, headers, content, "application/json")
                                       : method == "DELETE" ? http_.Delete(path, headers)
                                                            : http_.Get(path, headers);
        if (!result) throw NoAnswer(url_, httplib::to_string(result.error()), Clock::now() - start >= timeout);
        return read(*result);
    }

    Json read(const httplib::Response& response) const {
        const bool is_good = response.status >= 200 && response.status < 300;
        if (is_good && response.body.empty()) return nullptr;
        const Json body = Json::parse(response.body, nullptr, false);
        if (body.is_discarded()) throw ForeignAnswer(url_, response.status);
        if (is_good) return body;
        if (!body.is_object() || !body.contains("detail") || !body.contains("type") || !body.contains("status"))
            throw ForeignAnswer(url_, response.status);
        std::optional<double> after;
        const std::string header = response.get_header_value("Retry-After");
        if (!header.empty() && std::all_of(header.begin(), header.end(), ::isdigit)) after = std::stod(header);
        throw Problem(body, after);
    }

    /// Throws if a number is not finite, because the JSON library would write `null` for it.
    static const Json& require_finite(const Json& value) {
        if (value.is_number_float() && !std::isfinite(value.get<double>()))
            throw std::invalid_argument("every number of a request must be finite");
        if (value.is_structured())
            for (const Json& entry : value) require_finite(entry);
        return value;
    }

    std::string url_;
    Options options_;
    httplib::Client http_;
};

/// Measured values of an arm in one period.
struct Measurement {
    std::vector<double> joint_position;                ///< q, n, rad or m.
    std::optional<std::vector<double>> joint_velocity; ///< q̇, n, rad/s or m/s; default: the last command.
    std::optional<std::vector<double>> force;          ///< N; see wrench_convention, wrench_frame of the controller.
    std::optional<std::vector<double>> torque;         ///< N·m. Zero if only the force is given; the same holds for the force.
    Json targets = Json::object();   ///< New targets by task name, as in teleoperation; see `State` of the interface.
    Json obstacles = Json::array();  ///< Where the moving obstacles of the controller are.
    Json wrenches = Json::object();  ///< The wrenches of other tips than the tool, by the name of the tip.
    Json channels = Json::object();  ///< What arrived for channels besides the joints, by name.
    std::optional<double> time_s;    ///< When it was measured, s, on a clock that goes on with the real time.
                                     ///< Default of `Loop`: when `ask` was called, from the first call on. Default of
                                     ///< `Session`: the number of the call times the period, for loops that skip none.
};

/// A controller whose memory the service keeps. The destructor ends the session.
class Session {
public:
    Session(Client& client, const Json& controller)
        : client_(client), period_s_(controller.at("period_s")),
          created_(client.call("POST", "/v1/controllers", controller, true, {}, {{"Idempotency-Key", random_word()}})),
          path_("/v1/controllers/" + id()) {}
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;
    ~Session() {
        try {
            client_.call("DELETE", path_);
        } catch (const Error&) {
            // The service ends an idle session itself.
        }
    }

    /// Runs one control period. If the answer is lost, the client sends the state again with the same sequence number;
    /// the service never runs the same number twice.
    Json step(const Measurement& now) {
        const unsigned long sequence = next_++;
        const std::vector<double> none{0, 0, 0};
        Json state = {{"sequence", sequence},
                      {"time_s", now.time_s.value_or(static_cast<double>(sequence) * period_s_)},
                      {"joint_position", now.joint_position}};
        if (now.force || now.torque)
            state["wrench"] = {{"force", now.force.value_or(none)}, {"torque", now.torque.value_or(none)}};
        if (now.joint_velocity) state["joint_velocity"] = *now.joint_velocity;
        if (!now.targets.empty()) state["targets"] = now.targets;
        if (!now.obstacles.empty()) state["obstacles"] = now.obstacles;
        if (!now.wrenches.empty()) state["wrenches"] = now.wrenches;
        if (!now.channels.empty()) state["channels"] = now.channels;
        return client_.call("POST", path_ + "/step", state, true, client_.step_timeout());
    }

    /// Replaces the controller while the arm moves: adds, removes, reorders and changes tasks without a jump. Robot, period
    /// and drive must stay.
    void replace(const Json& controller) { created_ = client_.call("PUT", path_, controller); }

    std::string id() const { return created_.at("id"); }
    /// Returns the answer of the service: session name, joint order, and warnings about unstable contacts.
    const Json& created() const { return created_; }
    double period_s() const { return period_s_; }

private:
    Client& client_;
    double period_s_;
    Json created_;
    std::string path_;
    unsigned long next_ = 0;
};

/// Computes the joint velocities to command at any time, also when no answers come.
///
/// An answer is valid for `valid_for_ms` from the moment at which its *state* was measured. After that, the joints
/// brake together within the answer's `stop_time_s`, or each at `braking_deceleration` if the answer has none, and stay at
/// rest until a newer answer comes. If the controller's limits include positions, every joint then stops inside its
/// range. When answers come again, the joints accelerate with `braking_deceleration` until they have the velocity of the
/// answer.
class Watchdog {
public:
    /// `acceleration_limit`: deceleration of each joint, n, rad/s² or m/s², for joints for which the answer has none. The
    /// answer has precedence, because its `valid_for_ms` is correct for its own deceleration only.
    explicit Watchdog(std::vector<double> acceleration_limit)
        : acceleration_(std::move(acceleration_limit)), deceleration_(acceleration_),
          velocity_(acceleration_.size(), 0.0) {
        for (double limit : acceleration_)
            if (!(limit > 0)) throw std::invalid_argument("acceleration_limit: give one positive number per joint");
        if (acceleration_.empty()) throw std::invalid_argument("acceleration_limit: give one number per joint");
    }

    /// Creates a watchdog for a robot, as Client::robot returns it. A joint without any deceleration, in the answer or in
    /// the robot, stops at once.
    static Watchdog of(const Json& robot) {
        std::vector<double> limits;
        for (const Json& joint : robot.at("joints"))
            limits.push_back(number_or(joint.value("acceleration_limit", Json()), HUGE_VAL));
        return Watchdog(std::move(limits));
    }

    /// Accepts the answer that came at `now` to the state measured at `measured_at`. Returns false and ignores the
    /// answer if it has expired, or if an answer to a later state was accepted before.
    bool obey(const Json& answer, Clock::time_point measured_at, Clock::time_point now) {
        auto velocity = answer.at("joint_velocity").get<std::vector<double>>();
        if (velocity.size() != velocity_.size())
            throw std::invalid_argument(std::to_string(velocity.size()) + " joint velocities for " +
                                        std::to_string(velocity_.size()) + " joints");
        const auto expires_at = measured_at + std::chrono::milliseconds(answer.at("valid_for_ms").get<long>());
        const bool is_first = !std::exchange(has_answer_, true);
        if (now > expires_at || measured_at < measured_at_) return false;
        // Before the first answer there is no ramp to return from: the service counts with its answer at once.
        resumes_ = resumes_ || (!is_first && is_commanded_ && commanded_at_ > expires_at_);
        velocity_ = std::move(velocity);
        measured_at_ = measured_at;
        expires_at_ = expires_at;
        stop_time_s_ = number_or(answer.value("stop_time_s", Json()), 0);
        const Json given = answer.value("braking_deceleration", Json::array());
        for (std::size_t joint = 0; joint < deceleration_.size(); ++joint)
            deceleration_[joint] = number_or(joint < given.size() ? given[joint] : Json(), acceleration_[joint]);
        return true;
    }

    /// Returns the joint velocities to command at `now`: n, rad/s or m/s. The arm keeps a command until the next one. In a
    /// loop, use the time of the next command instead of the present time: then the arm is never faster than the ramp.
    /// `Loop` does so.
    std::vector<double> command(Clock::time_point now) {
        std::vector<double> velocity = resumed(now);
        const auto are_near = [](double a, double b) { return std::abs(a - b) <= 1e-9; }; // Sums are not exact.
        const std::vector<double> wanted = ramp(now);
        resumes_ = resumes_ && !std::equal(velocity.begin(), velocity.end(), wanted.begin(), are_near);
        commanded_ = velocity;
        commanded_at_ = now;
        is_commanded_ = true;
        return velocity;
    }

    /// Starts the ramp to rest at `now`, if it has not started yet.
    void expire(Clock::time_point now) { expires_at_ = std::min(expires_at_, now); }

    /// Returns whether the ramp is over and all joints are at rest at `now`.
    bool is_at_rest(Clock::time_point now) const {
        const std::vector<double> velocity = resumed(now);
        return now >= expires_at_ && std::all_of(velocity.begin(), velocity.end(), [](double v) { return v == 0; });
    }

private:
    static double number_or(const Json& value, double other) { return value.is_number() ? value.get<double>() : other; }

    /// Returns the velocities of the last answer; after it has expired, those of the ramp to rest.
    std::vector<double> ramp(Clock::time_point now) const {
        if (now <= expires_at_) return velocity_;
        const double silence_s = Seconds(now - expires_at_).count();
        std::vector<double> velocity(velocity_.size());
        for (std::size_t joint = 0; joint < velocity.size(); ++joint) {
            if (stop_time_s_ > 0) {
                velocity[joint] = velocity_[joint] * std::max(1 - silence_s / stop_time_s_, 0.0);
                continue;
            }
            const double speed = std::max(std::abs(velocity_[joint]) - deceleration_[joint] * silence_s, 0.0);
            velocity[joint] = std::copysign(speed, velocity_[joint]);
        }
        return velocity;
    }

    /// Returns the ramp; after an interruption what is within reach from the last command.
    std::vector<double> resumed(Clock::time_point now) const {
        std::vector<double> velocity = ramp(now);
        if (!resumes_) return velocity;
        const double elapsed_s = std::max(Seconds(now - commanded_at_).count(), 0.0);
        for (std::size_t joint = 0; joint < velocity.size(); ++joint) {
            const double reach = std::isinf(deceleration_[joint]) ? HUGE_VAL : deceleration_[joint] * elapsed_s;
            velocity[joint] = std::min(std::max(velocity[joint], commanded_[joint] - reach), commanded_[joint] + reach);
        }
        return velocity;
    }

    std::vector<double> acceleration_;
    std::vector<double> deceleration_;
    std::vector<double> velocity_;
    std::vector<double> commanded_;
    double stop_time_s_ = 0; ///< 0: each joint brakes at its own deceleration.
    Clock::time_point measured_at_{};
    Clock::time_point expires_at_{};
    Clock::time_point commanded_at_{};
    bool is_commanded_ = false;
    bool has_answer_ = false;
    bool resumes_ = false; ///< Whether commands must return from the last command to the answers.
};

/// Statistics of a control loop.
struct LoopReport {
    unsigned long periods = 0;  ///< Number of periods: calls of `Loop::ask`.
    unsigned long answered = 0; ///< Number of states whose answer came within a period.
    unsigned long steps = 0;    ///< Number of answered states, in time or late. While one is late, no other is sent.
    unsigned long skipped = 0;  ///< Number of periods that passed without a call of `Loop::ask`.
    double achieved_period_s = HUGE_VAL; ///< Mean time between two answered states, s; infinite before the second.
    double longest_period_s = 0;         ///< Longest time between two answered states, s; 0 before the second.
    unsigned long slow_windows = 0;      ///< Number of seconds in which over 5 % of the periods had no answer.
    std::string warning;                 ///< Figures and remedy of the last such second; empty if there was none.
};

/// Updates the statistics of a control loop.
class Pace {
public:
    explicit Pace(double period_s) : period_s_(period_s) {}

    /// Starts a period at `now`.
    void begin(Clock::time_point now) {
        if (report_.periods++ == 0) start_ = window_start_ = now;
        const auto passed = static_cast<unsigned long>(Seconds(now - start_).count() / period_s_);
        const unsigned long number = std::max(next_, passed);
        report_.skipped += number - next_;
        skipped_ += number - next_;
        next_ = number + 1;
        // A single late answer of a slow loop is no reason to warn: judge at least 50 periods.
        const double elapsed_s = Seconds(now - window_start_).count();
        if (elapsed_s < std::max(1.0, 50 * period_s_)) return;
        judge(number - first_, elapsed_s);
        first_ = number;
        window_start_ = now;
        answers_ = skipped_ = 0;
        waited_s_ = 0;
    }

    /// Counts the answer that came at `now` to a state.
    void answer(Clock::time_point measured_at, Clock::time_point now) {
        const double waited_s = Seconds(now - measured_at).count();
        ++answers_;
        waited_s_ += waited_s;
        if (waited_s <= period_s_) ++report_.answered;
        if (report_.steps++ == 0) {
            first_measured_ = measured_at;
        } else {
            const double elapsed_s = Seconds(measured_at - first_measured_).count();
            report_.achieved_period_s = elapsed_s / static_cast<double>(report_.steps - 1);
            report_.longest_period_s = std::max(report_.longest_period_s, Seconds(measured_at - last_measured_).count());
        }
        last_measured_ = measured_at;
    }

    const LoopReport& report() const { return report_; }

private:
    void judge(unsigned long periods, double elapsed_s) {
        const double missing = static_cast<double>(periods) - static_cast<double>(answers_);
        if (missing <= 0.05 * static_cast<double>(periods)) return;
        const auto tenths = [](double value) {
            char text[32];
            std::snprintf(text, sizeof text, "%.1f", value);
            return std::string(text);
        };
        const std::string waits = answers_ == 0
                                      ? "no valid answer came"
                                      : "answers took " + tenths(1e3 * waited_s_ / static_cast<double>(answers_)) + " ms";
        const bool is_loop_late = 2 * static_cast<double>(skipped_) > missing;
        ++report_.slow_windows;
        report_.warning =
            "The loop reached " + std::to_string(answers_) + " of " + std::to_string(periods) + " periods in the last " +
            tenths(elapsed_s) + " s; " + waits + ". " +
            (is_loop_late ? "The loop itself is late: make its other work faster, free the machine, or use a longer period."
                          : "Use a longer period, or a faster connection to the service.");
    }

    double period_s_;
    LoopReport report_;
    Clock::time_point start_{}, window_start_{}, first_measured_{}, last_measured_{};
    unsigned long next_ = 0; ///< Number of the next period.
    unsigned long first_ = 0, answers_ = 0, skipped_ = 0; ///< Of the last second: first period, answers, skipped periods.
    double waited_s_ = 0;
};

/// Calls the service in a separate thread, so that a late answer never delays the control loop.
///
/// In each period, call `ask` with the measured state, then `wait_until` with the end of the period, and send the
/// result of `command` to the arm. While no answers come, `command` returns a ramp to rest. Once the arm is at rest,
/// `command` throws the last failure. If the service refuses a state, `command` throws at once: call `stop`, and keep
/// sending the result of `command` to the arm until `is_at_rest`. `report` says whether the loop keeps its period.
class Loop {
public:
    Loop(Session& session, Watchdog& watchdog)
        : session_(session), watchdog_(watchdog), pace_(session.period_s()), caller_([this] { run(); }) {}
    Loop(const Loop&) = delete;
    Loop& operator=(const Loop&) = delete;
    ~Loop() {
        {
            std::lock_guard lock(mutex_);
            is_shut_down_ = true;
        }
        changed_.notify_all();
        caller_.join();
    }

    /// Sends a state, unless the answer to an earlier state is still pending. Call it when the state has just been measured.
    void ask(Measurement now) {
        std::lock_guard lock(mutex_);
        const auto measured_at = Clock::now();
        if (pace_.report().periods == 0) started_at_ = measured_at;
        pace_.begin(measured_at);
        if (pending_state_) return;
        // The number of the state does not tell the time: no state is sent while an answer is late.
        if (!now.time_s) now.time_s = Seconds(measured_at - started_at_).count();
        pending_state_ = std::move(now);
        measured_at_ = measured_at;
        changed_.notify_all();
    }

    /// Waits for the answer until `end` at the latest; returns whether the call has finished.
    bool wait_until(Clock::time_point end) {
        std::unique_lock lock(mutex_);
        return changed_.wait_until(lock, end, [this] { return !pending_state_; });
    }

    /// Returns the joint velocities to command now: n, rad/s or m/s.
    std::vector<double> command() {
        std::lock_guard lock(mutex_);
        const auto now = Clock::now();
        if (failure_ && !is_stopped_ && (!is_silence_ || watchdog_.is_at_rest(now))) std::rethrow_exception(failure_);
        const auto period = std::chrono::duration_cast<Clock::duration>(Seconds(session_.period_s()));
        return watchdog_.command(now + period);
    }

    /// Starts the ramp to rest. After this, answers are ignored and `command` does not throw.
    void stop() {
        std::lock_guard lock(mutex_);
        is_stopped_ = true;
        watchdog_.expire(Clock::now());
    }

    /// Returns whether the ramp is over and all joints are at rest.
    bool is_at_rest() {
        std::lock_guard lock(mutex_);
        return watchdog_.is_at_rest(Clock::now());
    }

    /// Returns the statistics of the loop: skipped periods, achieved period, and a warning if it is too slow.
    LoopReport report() {
        std::lock_guard lock(mutex_);
        return pace_.report();
    }

private:
    /// Body of the calling thread.
    void run() {
        std::unique_lock lock(mutex_);
        for (;;) {
            changed_.wait(lock, [this] { return is_shut_down_ || pending_state_; });
            if (is_shut_down_) return;
            const Measurement now = *pending_state_;
            lock.unlock();
            Json answer;
            std::exception_ptr failure;
            bool is_silence = false;
            try {
                answer = session_.step(now);
            } catch (const Error& error) {
                failure = std::current_exception();
                is_silence = error.is_silence;
            } catch (...) {
                failure = std::current_exception();
            }
            lock.lock();
            failure_ = failure;
            is_silence_ = is_silence;
            const auto answered_at = Clock::now();
            if (!failure && !is_stopped_ && watchdog_.obey(answer, measured_at_, answered_at))
                pace_.answer(measured_at_, answered_at);
            pending_state_.reset();
            changed_.notify_all();
        }
    }

    Session& session_;
    Watchdog& watchdog_;
    Pace pace_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::optional<Measurement> pending_state_;
    Clock::time_point started_at_{}, measured_at_{};
    std::exception_ptr failure_;
    bool is_silence_ = false;
    bool is_stopped_ = false;
    bool is_shut_down_ = false;
    std::thread caller_; // declared last: the thread uses the other members
};

} // namespace revprio
