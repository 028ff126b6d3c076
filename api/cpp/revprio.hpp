// Client of the revprio service: joint velocities for redundant arms by reverse task priority.
//
// Header-only, C++17, on cpp-httplib and nlohmann/json (Debian: libcpp-httplib-dev nlohmann-json3-dev). Bodies are JSON
// values with the field names of the OpenAPI document; SI units, rad and rad/s for revolute joints.
#pragma once

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
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

/// Anything that goes wrong with the service.
class Error : public std::runtime_error {
public:
    Error(const std::string& what, bool is_silence) : std::runtime_error(what), is_silence(is_silence) {}

    /// Whether a later call may succeed: the service cannot be reached, is late, or has no time.
    bool is_silence;
};

/// The service cannot be reached, the connection broke, or the answer did not come in time.
class NoAnswer : public Error {
public:
    NoAnswer(const std::string& url, const std::string& cause, bool is_late)
        : Error("no answer from " + url + ": " + cause + "; is the service running there?", true), is_late(is_late) {}

    /// Whether the time was over.
    bool is_late;
};

/// Something answered, but not as a revprio service does.
class ForeignAnswer : public Error {
public:
    ForeignAnswer(const std::string& url, int status)
        : Error(url + " answered with status " + std::to_string(status) + ", but not as a revprio service does",
                status >= 500) {}
};

/// The service refused a request and says why (RFC 9457, application/problem+json).
class Problem : public Error {
public:
    Problem(const Json& problem, std::optional<double> retry_after_s)
        : Error(sentence(problem), is_passing(problem.at("status"))), type(problem.at("type")),
          detail(problem.at("detail")), pointer(pointer_of(problem)), status(problem.at("status")),
          retry_after_s(retry_after_s) {}

    std::string type;                    ///< Stable identifier of the kind of problem.
    std::string detail;                  ///< What is wrong, with the remedy.
    std::string pointer;                 ///< JSON pointer of the offending field, empty if there is none.
    int status;                          ///< HTTP status.
    std::optional<double> retry_after_s; ///< What `Retry-After` asks for, s.

private:
    static std::string pointer_of(const Json& problem) {
        return problem.contains("pointer") && problem["pointer"].is_string() ? problem["pointer"].get<std::string>() : "";
    }
    static std::string sentence(const Json& problem) {
        const std::string pointer = pointer_of(problem);
        return problem.at("detail").get<std::string>() + " (" + std::to_string(problem.at("status").get<int>()) + " " +
               problem.at("type").get<std::string>() + (pointer.empty() ? "" : " at " + pointer) + ")";
    }
    static bool is_passing(int status) { return status >= 500 || status == 408 || status == 429; }
};

/// How a client is set up.
struct Options {
    std::string token;                 ///< What the service was given as --token-file.
    Seconds timeout{10.0};             ///< Longest time for one attempt of a call.
    Seconds step_timeout{0.1};         ///< The same for a control period.
    int retries = 2;                   ///< Repetitions of a call at most, only where they cannot do harm.
};

/// A client of one service over one connection that stays open; one thread at a time may use it.
class Client {
public:
    explicit Client(std::string url = "http://127.0.0.1:8080", Options options = {})
        : url_(std::move(url)), options_(std::move(options)), http_(url_) {
        http_.set_keep_alive(true);
        http_.set_tcp_nodelay(true);
        http_.set_default_headers({{"Accept", "application/json"}});
        if (!options_.token.empty()) http_.set_bearer_token_auth(options_.token);
    }

    /// Joint velocities for tasks at a posture, and what became of each task.
    Json resolve(const Json& request) { return post("/v1/resolve", request); }
    /// Many questions at once: for each an answer or, where it is refused, a problem, in the same order.
    Json resolve_batch(const Json& items) { return post("/v1/resolve/batch", {{"items", items}}).at("items"); }
    /// Tool pose (m), Jacobian (6 × n, base axes, linear rows first), singular values and link frames.
    Json kinematics(const Json& request) { return post("/v1/kinematics", request); }
    /// How much lag (s) and delay (periods) one axis in contact bears, and how little damping it needs.
    Json stability(const Json& request) { return post("/v1/stability", request); }
    /// A robot with the limits and units of its joints.
    Json robot(const std::string& name) { return call("GET", "/v1/robots/" + name); }

    /// Any other call; `body` is sent unless it is null. `repeatable`: whether it may be sent again when nobody knows if
    /// the service has seen it.
    Json call(const std::string& method, const std::string& path, const Json& body = nullptr, bool repeatable = true,
              std::optional<Seconds> timeout = {}) {
        const std::string content = body.is_null() ? "" : finite(body).dump();
        auto pause = Seconds(0.02);
        for (int left = options_.retries;; --left, pause *= 2) {
            try {
                return send(method, path, content, timeout.value_or(options_.timeout));
            } catch (const Problem& problem) {
                const Seconds asked = problem.retry_after_s ? Seconds(*problem.retry_after_s) : pause;
                const bool is_busy = problem.status == 503 || problem.status == 429;
                if (left == 0 || !is_busy || asked >= timeout.value_or(options_.timeout)) throw;
                std::this_thread::sleep_for(asked);
            } catch (const NoAnswer& failure) {
                if (left == 0 || !repeatable || failure.is_late) throw;
                std::this_thread::sleep_for(pause);
            }
        }
    }

    const std::string& url() const { return url_; }
    Seconds step_timeout() const { return options_.step_timeout; }

private:
    Json post(const std::string& path, const Json& body) { return call("POST", path, body); }

    Json send(const std::string& method, const std::string& path, const std::string& content, Seconds timeout) {
        const auto micros = std::chrono::duration_cast<std::chrono::microseconds>(timeout);
        http_.set_connection_timeout(micros);
        http_.set_read_timeout(micros);
        http_.set_write_timeout(micros);
        const auto start = Clock::now();
        const httplib::Result result = method == "POST"     ? http_.Post(path, content, "application/json")
                                       : method == "DELETE" ? http_.Delete(path)
                                                            : http_.Get(path);
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

    /// The library would write `null` for what is not finite.
    static const Json& finite(const Json& value) {
        if (value.is_number_float() && !std::isfinite(value.get<double>()))
            throw std::invalid_argument("every number of a request must be finite");
        if (value.is_structured())
            for (const Json& entry : value) finite(entry);
        return value;
    }

    std::string url_;
    Options options_;
    httplib::Client http_;
};

/// What an arm measures in one period.
struct Measurement {
    std::vector<double> joint_position;                ///< q, n, rad or m.
    std::optional<std::vector<double>> joint_velocity; ///< q̇, n, rad/s or m/s; the last command stands for it.
    std::vector<double> force{0, 0, 0};                ///< N, as the controller's wrench_convention and _frame say.
    std::vector<double> torque{0, 0, 0};               ///< N·m.
};

/// A controller whose memory the service keeps; ends with the object.
class Session {
public:
    Session(Client& client, const Json& controller)
        : client_(client), period_s_(controller.at("period_s")),
          created_(client.call("POST", "/v1/controllers", controller, false)), path_("/v1/controllers/" + id()) {}
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;
    ~Session() {
        try {
            client_.call("DELETE", path_);
        } catch (const Error&) {
            // The service ends it by itself when it is idle.
        }
    }

    /// One control period. A state whose answer is lost on the way is sent again under the same number, which is never
    /// stepped twice.
    Json step(const Measurement& now) {
        const unsigned long sequence = next_++;
        Json state = {{"sequence", sequence},
                      {"time_s", static_cast<double>(sequence) * period_s_},
                      {"joint_position", now.joint_position},
                      {"wrench", {{"force", now.force}, {"torque", now.torque}}}};
        if (now.joint_velocity) state["joint_velocity"] = *now.joint_velocity;
        return client_.call("POST", path_ + "/step", state, true, client_.step_timeout());
    }

    std::string id() const { return created_.at("id"); }
    /// Joint order, and warnings about contacts that would bounce.
    const Json& created() const { return created_; }
    double period_s() const { return period_s_; }

private:
    Client& client_;
    double period_s_;
    Json created_;
    std::string path_;
    unsigned long next_ = 0;
};

/// Gives the joint velocities to command at any time, whether answers come or not: the last answer counts for
/// `valid_for_ms` from the moment at which its *state* was measured; after that each joint slows down to rest with its
/// largest acceleration, and stays there until a newer answer comes.
class Watchdog {
public:
    /// `acceleration_limit`: n, rad/s² or m/s².
    explicit Watchdog(std::vector<double> acceleration_limit)
        : acceleration_(std::move(acceleration_limit)), velocity_(acceleration_.size(), 0.0) {
        for (double limit : acceleration_)
            if (!(limit > 0)) throw std::invalid_argument("acceleration_limit: give one positive number per joint");
        if (acceleration_.empty()) throw std::invalid_argument("acceleration_limit: give one number per joint");
    }

    /// With the acceleration limits of a robot, as Client::robot gives it.
    static Watchdog of(const Json& robot) {
        std::vector<double> limits;
        for (const Json& joint : robot.at("joints")) limits.push_back(joint.at("acceleration_limit"));
        return Watchdog(std::move(limits));
    }

    /// Takes an answer that comes now; false if it does not count: it has expired, or is older than the last one.
    bool obey(const Json& answer, Clock::time_point measured_at, Clock::time_point now) {
        auto velocity = answer.at("joint_velocity").get<std::vector<double>>();
        if (velocity.size() != velocity_.size())
            throw std::invalid_argument(std::to_string(velocity.size()) + " joint velocities for " +
                                        std::to_string(velocity_.size()) + " joints");
        const auto expires_at = measured_at + std::chrono::milliseconds(answer.at("valid_for_ms").get<long>());
        if (now > expires_at || measured_at < measured_at_) return false;
        velocity_ = std::move(velocity);
        measured_at_ = measured_at;
        expires_at_ = expires_at;
        return true;
    }

    /// Joint velocities to command now: n, rad/s or m/s.
    std::vector<double> command(Clock::time_point now) const {
        const double silence_s = std::max(Seconds(now - expires_at_).count(), 0.0);
        std::vector<double> slower(velocity_.size());
        for (std::size_t joint = 0; joint < slower.size(); ++joint) {
            const double speed = std::max(std::abs(velocity_[joint]) - acceleration_[joint] * silence_s, 0.0);
            slower[joint] = std::copysign(speed, velocity_[joint]);
        }
        return slower;
    }

    /// Lets the ramp begin now, if it has not yet.
    void expire(Clock::time_point now) { expires_at_ = std::min(expires_at_, now); }

    /// Whether the ramp is over.
    bool is_at_rest(Clock::time_point now) const {
        const std::vector<double> velocity = command(now);
        return now >= expires_at_ && std::all_of(velocity.begin(), velocity.end(), [](double v) { return v == 0; });
    }

private:
    std::vector<double> acceleration_;
    std::vector<double> velocity_;
    Clock::time_point measured_at_{};
    Clock::time_point expires_at_{};
};

/// Calls in a thread of its own, so that whoever commands the arm is never held up by a late answer.
///
/// Once per period: `ask` with what was measured, `wait_until` the end of the period at most, then command what `command`
/// says. While the service is silent that ramps to rest; once there, `command` throws the last failure. A refusal is
/// thrown at once: then `stop`, and go on with `command` until `is_at_rest`.
class Loop {
public:
    Loop(Session& session, Watchdog& watchdog)
        : session_(session), watchdog_(watchdog), caller_([this] { call(); }) {}
    Loop(const Loop&) = delete;
    Loop& operator=(const Loop&) = delete;
    ~Loop() {
        {
            std::lock_guard lock(mutex_);
            is_over_ = true;
        }
        changed_.notify_all();
        caller_.join();
    }

    /// Sends a state, unless the answer to an earlier one is still to come.
    void ask(Measurement now) {
        std::lock_guard lock(mutex_);
        if (question_) return;
        question_ = std::move(now);
        measured_at_ = Clock::now();
        changed_.notify_all();
    }

    /// Waits for the answer; whether it has come.
    bool wait_until(Clock::time_point end) {
        std::unique_lock lock(mutex_);
        return changed_.wait_until(lock, end, [this] { return !question_; });
    }

    /// Joint velocities to command now: n, rad/s or m/s.
    std::vector<double> command() {
        std::lock_guard lock(mutex_);
        const auto now = Clock::now();
        if (failure_ && !is_stopped_ && (!is_silence_ || watchdog_.is_at_rest(now))) std::rethrow_exception(failure_);
        return watchdog_.command(now);
    }

    /// Lets the ramp begin; no more answers count and `command` throws no more.
    void stop() {
        std::lock_guard lock(mutex_);
        is_stopped_ = true;
        watchdog_.expire(Clock::now());
    }

    /// Whether the ramp is over.
    bool is_at_rest() {
        std::lock_guard lock(mutex_);
        return watchdog_.is_at_rest(Clock::now());
    }

private:
    void call() {
        std::unique_lock lock(mutex_);
        for (;;) {
            changed_.wait(lock, [this] { return is_over_ || question_; });
            if (is_over_) return;
            const Measurement now = *question_;
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
            if (!failure && !is_stopped_) watchdog_.obey(answer, measured_at_, Clock::now());
            question_.reset();
            changed_.notify_all();
        }
    }

    Session& session_;
    Watchdog& watchdog_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::optional<Measurement> question_;
    Clock::time_point measured_at_{};
    std::exception_ptr failure_;
    bool is_silence_ = false;
    bool is_stopped_ = false;
    bool is_over_ = false;
    std::thread caller_; // last: it uses the others
};

} // namespace revprio
