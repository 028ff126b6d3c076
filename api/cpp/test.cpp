// Tests of the client. They need two running services: ./test URL URL-WITH-TOKEN
#include <cstdio>
#include <cstdlib>

#include "revprio.hpp"

using revprio::Clock;
using revprio::Json;

namespace {

void check(bool holds, const char* claim) {
    if (holds) return;
    std::fprintf(stderr, "failed: %s\n", claim);
    std::exit(1);
}

/// Returns the exception that `action` must throw.
template <class Failure, class Action> Failure expect_throw(Action action, const char* claim) {
    try {
        action();
    } catch (const Failure& failure) {
        return failure;
    }
    check(false, claim);
    std::abort();
}

const std::vector<double> POSTURE{2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2};

/// Returns the x coordinate of the tool, m: applies the Denavit-Hartenberg transforms from the tool to the base.
double tool_x(const Json& robot, const std::vector<double>& q) {
    double x = 0, y = 0, z = 0;
    for (std::size_t joint = q.size(); joint-- > 0;) {
        const Json& link = robot.at("joints").at(joint).at("denavit_hartenberg");
        const double a = link.at("a_m"), d = link.at("d_m"), alpha = link.at("alpha_rad");
        const double theta = link.at("theta_rad").get<double>() + q[joint];
        const double u = x + a, v = std::cos(alpha) * y - std::sin(alpha) * z;
        z = std::sin(alpha) * y + std::cos(alpha) * z + d;
        x = std::cos(theta) * u - std::sin(theta) * v;
        y = std::sin(theta) * u + std::cos(theta) * v;
    }
    return x;
}

/// A closed loop with an arm simulated here equals the built-in simulation of the service.
void closed_loop(revprio::Client& client) {
    Json scenario = client.call("GET", "/v1/scenarios/stiff_wall");
    scenario["duration_s"] = 0.45;
    const Json wall = scenario.at("contacts").at(0), robot = client.robot("sawyer_dh");
    revprio::Session session(client, scenario.at("controller"));
    revprio::Measurement now;
    now.joint_position = scenario.at("start_joint_position").get<std::vector<double>>();
    now.joint_velocity = std::vector<double>(7, 0.0);
    const double start = tool_x(robot, now.joint_position);
    double peak = 0;
    for (int period = 0; period < 450; ++period) {
        const double depth = tool_x(robot, now.joint_position) - start - wall.at("offset_m").get<double>();
        const double force = std::max(wall.at("stiffness").get<double>() * depth, 0.0);
        now.force = {force, 0, 0};
        peak = std::max(peak, force);
        now.joint_velocity = session.step(now).at("joint_velocity").get<std::vector<double>>();
        for (std::size_t joint = 0; joint < 7; ++joint)
            now.joint_position[joint] += session.period_s() * (*now.joint_velocity)[joint];
    }
    check(peak > 100, "the arm touches the wall");

    const std::string path = "/v1/simulations/" +
                             client.call("POST", "/v1/simulations", {{"scenario", scenario}}, false).at("id").get<std::string>();
    while (client.call("GET", path).at("state") != "finished") std::this_thread::sleep_for(revprio::Seconds(0.1));
    const Json last = client.call("GET", path + "/trace").at("samples").at(449);
    for (std::size_t joint = 0; joint < 7; ++joint) {
        const double simulated = last.at("joint_velocity").at(joint);
        check(std::abs((*now.joint_velocity)[joint] - simulated) < 1e-9, "the loop equals the built-in simulation");
    }
}

void targets(revprio::Client& client) {
    revprio::Session session(client, client.call("GET", "/v1/scenarios/stiff_wall").at("controller"));
    revprio::Measurement now;
    now.joint_position = POSTURE;
    now.force = {0, 0, 0};
    now.targets["push x"] = Json::parse(R"({"force": [10]})");
    const Json followed = session.step(now).at("tasks").at(0);
    check(followed.at("target_state") == "following" && followed.at("target_force").at(0) == 10.0,
          "a task follows its target");
    now.targets["push x"] = Json::parse(R"({"velocity": [1]})");
    const auto problem = expect_throw<revprio::Problem>([&] { session.step(now); }, "another target is refused");
    check(problem.pointer == "/targets/push x/velocity", "the problem names the field of the target");
}

void refusals(revprio::Client& client) {
    const Json tasks = Json::parse(R"([{"axes": ["x"], "velocity": [0.05]}])");
    const Json good = {{"robot", "sawyer_dh"}, {"joint_position", POSTURE}, {"tasks", tasks}};
    check(client.resolve(good).at("joint_velocity").size() == 7, "the answer has a velocity for each joint");
    Json bad = good;
    bad["joint_position"] = {1, 2};
    const auto problem = expect_throw<revprio::Problem>([&] { client.resolve(bad); }, "a wrong vector size is refused");
    check(problem.status == 422 && problem.pointer == "/joint_position", "the problem names the field");
    check(!problem.is_silence, "a later call cannot succeed after a refusal");
    const Json items = client.resolve_batch({good, bad});
    check(items.at(0).contains("joint_velocity") && items.at(1).at("pointer") == "/items/1/joint_position",
          "a batch reports a problem per item");
    bad["joint_position"] = std::vector<double>{NAN};
    expect_throw<std::invalid_argument>([&] { client.resolve(bad); }, "a number that is not finite is not sent");

    revprio::Client unreachable("http://127.0.0.1:9");
    const auto failure = expect_throw<revprio::NoAnswer>([&] { unreachable.robot("sawyer_dh"); },
                                                         "an unreachable service raises NoAnswer");
    check(failure.is_silence, "a later call to an unreachable service may succeed");
}

void token(const std::string& url) {
    const auto problem = expect_throw<revprio::Problem>([&] { revprio::Client(url).robot("sawyer"); },
                                                        "the token is required");
    check(problem.status == 401, "a missing token gives 401");
    revprio::Options options;
    options.token = std::string(32, 's') + "\n";
    options.retries = 0;
    options.step_timeout = revprio::Seconds(10);
    revprio::Client client(url, options);
    const Json controller = client.call("GET", "/v1/scenarios/stiff_wall").at("controller");
    revprio::Session only(client, controller);
    const auto full = expect_throw<revprio::Problem>([&] { revprio::Session(client, controller); },
                                                     "a second session is refused");
    options.token = std::string(32, 's') + "\nt";
    expect_throw<std::invalid_argument>([&] { revprio::Client(url, options); }, "a token with a line break inside is refused");
    check(full.status == 503 && full.retry_after_s == 1.0 && full.is_silence, "a full service reports when to retry");
}

void watchdog() {
    const Json answer = {{"joint_velocity", {0.4, -0.1}}, {"valid_for_ms", 100}};
    const auto at = [](int milliseconds) { return Clock::time_point(std::chrono::milliseconds(1000 + milliseconds)); };
    const auto is_close = [](const std::vector<double>& given, double first, double second) {
        return std::abs(given.at(0) - first) < 1e-9 && std::abs(given.at(1) - second) < 1e-9;
    };
    check(is_close(revprio::Watchdog({2, 4}).command(at(0)), 0, 0) && revprio::Watchdog({2, 4}).is_at_rest(at(0)),
          "nothing moves before the first answer");
    revprio::Watchdog first({2, 4});
    first.command(at(-50));
    first.obey(answer, at(0), at(10));
    check(is_close(first.command(at(10)), 0.4, -0.1), "the first answer counts at once although rest was commanded before");
    revprio::Watchdog second({2, 4});
    second.command(at(-100));
    check(!second.obey(answer, at(-200), at(-50)) && second.obey(answer, at(0), at(0)), "an expired first answer is ignored");
    check(is_close(second.command(at(0)), 0.2, -0.1), "an answer after an expired first one is reached evenly");
    revprio::Watchdog dog({2, 4});
    check(!dog.obey(answer, at(0), at(101)), "an expired answer is ignored");
    check(dog.obey(answer, at(0), at(1)) && !dog.obey(answer, at(-1), at(1)), "an answer to an older state is ignored");
    check(is_close(dog.command(at(100)), 0.4, -0.1), "an answer is held while it is valid");
    check(is_close(dog.command(at(110)), 0.38, -0.06), "then each joint brakes at its own limit");
    check(!dog.is_at_rest(at(290)) && dog.is_at_rest(at(301)), "the joints come to rest");
    revprio::Watchdog rounded({2, 4});
    rounded.obey(answer, at(0), at(0));
    rounded.command(at(200));
    Json reached = answer, faster = answer;
    reached["joint_velocity"] = {0.22 + 1e-12, 0};
    faster["joint_velocity"] = {1, 1};
    rounded.obey(reached, at(210), at(210));
    rounded.command(at(210));
    rounded.obey(faster, at(220), at(220));
    check(is_close(rounded.command(at(220)), 1, 1), "rounding does not prolong the return");
    Json even = answer;
    even["stop_time_s"] = 0.2;
    revprio::Watchdog together({2, 4});
    check(together.obey(even, at(0), at(0)) && is_close(together.command(at(150)), 0.3, -0.075),
          "all joints come to rest together if the answer says when");
    check(!together.is_at_rest(at(290)) && together.is_at_rest(at(301)), "within that time");
    together.command(at(300));
    check(together.obey(answer, at(300), at(300)) && is_close(together.command(at(310)), 0.02, -0.04),
          "afterwards each joint accelerates at its own limit");
    check(is_close(together.command(at(500)), 0.2, 0), "the next answer may brake otherwise");
    Json braking = answer;
    braking["braking_deceleration"] = {8, nullptr};
    revprio::Watchdog told({2, 4});
    check(told.obey(answer, at(0), at(1)) && told.obey(braking, at(0), at(1)), "the same state may be answered again");
    check(is_close(told.command(at(110)), 0.32, -0.06), "the deceleration of the answer has precedence");
    check(is_close(dog.command(at(200)), 0.2, 0) && dog.obey(answer, at(200), at(205)), "answers come again");
    check(is_close(dog.command(at(210)), 0.22, -0.04), "then each joint accelerates at its own limit");
    check(is_close(dog.command(at(300)), 0.4, -0.1), "until it has the velocity of the answer");
    const auto unlimited = revprio::Watchdog::of(Json::parse(R"({"joints": [{"acceleration_limit": null}, {}]})"));
    auto sudden = unlimited;
    sudden.obey(answer, at(0), at(1));
    check(is_close(sudden.command(at(100)), 0.4, -0.1) && is_close(sudden.command(at(101)), 0, 0),
          "a joint without any deceleration stops at once");
    expect_throw<std::invalid_argument>([] { revprio::Watchdog({1, 0}); }, "limits must be positive");
}

/// A loop counts its periods, and says when it is too slow.
void pace() {
    const auto at = [](long milliseconds) { return Clock::time_point(std::chrono::milliseconds(5000 + milliseconds)); };
    const auto starts_with = [](const std::string& text, const std::string& start) { return text.rfind(start, 0) == 0; };

    revprio::Pace waiting(0.001);
    for (long period = 0; period <= 2000; ++period) {
        waiting.begin(at(period));
        if (period % 2 == 0) waiting.answer(at(period), at(period + 2));
    }
    const revprio::LoopReport& slow = waiting.report();
    check(slow.periods == 2001 && slow.steps == 1001 && slow.answered == 0 && slow.skipped == 0, "periods are counted");
    check(std::abs(slow.achieved_period_s - 0.002) < 1e-12, "the achieved period is that between answered states");
    check(slow.slow_windows == 2, "a slow loop is counted once per second");
    check(starts_with(slow.warning, "The loop reached 500 of 1000 periods in the last 1.0 s; answers took 2.0 ms. Use"),
          "the warning has the figures");

    revprio::Pace single(0.05);
    for (long period = 0; period <= 520; ++period) {
        single.begin(at(50 * period));
        const long of_52 = period % 52; // the answer to state 49 takes 2.5 periods
        if (of_52 < 50) single.answer(at(50 * period), at(50 * period + (of_52 < 49 ? 10 : 125)));
    }
    check(single.report().slow_windows == 0 && single.report().warning.empty(), "single late answers give no warning");
    check(std::abs(single.report().longest_period_s - 0.15) < 1e-9, "the longest period is reported");

    revprio::Pace busy(0.01);
    for (long period = 0; period <= 100; period += 2) {
        busy.begin(at(10 * period));
        busy.answer(at(10 * period), at(10 * period + 1));
    }
    check(busy.report().skipped == 50 && busy.report().answered == 51, "skipped periods are counted");
    check(busy.report().warning.find("The loop itself is late") != std::string::npos, "the cause is the loop itself");
}

/// A session replaces its controller without a jump.
void replaces_its_controller(revprio::Client& client) {
    Json controller = client.call("GET", "/v1/scenarios/stiff_wall").at("controller");
    revprio::Session session(client, controller);
    revprio::Measurement now;
    now.joint_position = POSTURE;
    now.force = {0, 0, 0};
    const auto before = session.step(now).at("joint_velocity").get<std::vector<double>>();
    controller["limits"] = "velocity";
    std::reverse(controller["tasks"].begin(), controller["tasks"].end());
    session.replace(controller);
    const Json answer = session.step(now);
    check(answer.at("tasks").at(0).at("name") == controller["tasks"][0]["name"], "the tasks are reordered");
    for (std::size_t joint = 0; joint < 7; ++joint) {
        const double velocity = answer.at("joint_velocity").at(joint);
        check(std::abs(velocity - before[joint]) <= 10 * session.period_s() * (1 + 1e-9), "no joint jumps");
    }
    controller["period_s"] = 0.5;
    const auto problem = expect_throw<revprio::Problem>([&] { session.replace(controller); }, "another period is refused");
    check(problem.pointer == "/period_s", "the refusal names the field");
}

/// Presets give controllers that the service accepts, and refuse what has no meaning.
void presets(revprio::Client& client) {
    Json controller{{"robot", "sawyer_dh"}, {"period_s", 0.001}, {"tasks", revprio::push("z", -15)}};
    revprio::PressOptions soft;
    soft.hold = {"y"};
    soft.stiffest = 1e5;
    check(revprio::push("x", 5, soft).at(1).at("axes") == Json({"y"}), "a push holds the axes that it is told");
    soft.hold = nullptr;
    check(revprio::push("x", 5, soft).size() == 1, "a push without a second task");
    revprio::Measurement now;
    now.joint_position = POSTURE;
    now.force = {0, 0, 0};
    revprio::Session pushing(client, controller);
    const Json contact = pushing.step(now).at("tasks").at(0).at("contact").at(0);
    check(contact.at("state") == "approach", "a push approaches");
    revprio::WipeOptions tilted;
    tilted.frame = {{"position", {0, 0, 0}}, {"orientation", {{"w", 0.8}, {"x", 0.6}, {"y", 0}, {"z", 0}}}};
    controller["tasks"] = revprio::wipe("z", -15, "y", tilted);
    revprio::Session wiping(client, controller);
    const Json tasks = wiping.step(now).at("tasks");
    check(tasks.size() == 3 && tasks.at(1).at("name") == "wipe", "a wipe has three tasks");
    expect_throw<std::invalid_argument>([] { revprio::push("z", 0); }, "a push without a force is refused");
    revprio::WipeOptions following;
    following.max_tilt_rad = 0.6;
    const auto followed = revprio::wipe("z", -15, "y", following);
    check(followed.at(0).at("law").at("surface").at("max_tilt_rad") == 0.6, "a wipe follows a surface");
    revprio::WipeOptions later;
    later.start_time_s = 3;
    const auto phase = revprio::wipe("z", -15, "y", later).at(1).at("law").at("target_displacement").at("phase_rad").get<double>();
    check(std::abs(phase + std::acos(0.0) + 3) < 1e-12, "a wipe begins when it is told");
    expect_throw<std::invalid_argument>([] { revprio::wipe("z", 5, "z"); }, "a wipe along the pressing axis is refused");
    for (const auto& held : {revprio::Json({"z"}), revprio::Json({"y"}), revprio::Json({"x", "x"})}) {
        revprio::WipeOptions twice;
        twice.hold = held;
        expect_throw<std::invalid_argument>([&] { revprio::wipe("z", 5, "y", twice); }, "an axis with two tasks is refused");
    }
    expect_throw<std::invalid_argument>([] { revprio::wipe("z", 5, "rx"); }, "a wipe that turns is refused");
    for (const revprio::Json& held : {revprio::Json("y"), revprio::Json("none"), revprio::Json(false), revprio::Json::object()}) {
        revprio::PressOptions unclear;
        unclear.hold = held;
        expect_throw<std::invalid_argument>([&] { revprio::push("x", 5, unclear); }, "an unclear `hold` is refused");
    }
}

/// A law that needs a wrench refuses a state without one; obstacles, channels and the own clock reach the service.
void states(revprio::Client& client) {
    Json controller = client.call("GET", "/v1/scenarios/stiff_wall").at("controller");
    controller["tasks"] = revprio::push("x", 5);
    controller["collisions"] = Json::parse(R"({"min_distance_m": 0.01, "obstacles": [{"name": "ball", "moves": true,
        "sphere": {"radius": 0.05}}]})");
    controller["robot"] = "panda";
    revprio::Session session(client, controller);
    revprio::Measurement now;
    now.joint_position = {0, -0.5, 0, -2, 0, 1.6, 0.8};
    now.obstacles.push_back({{"name", "ball"}, {"position", {1.5, 0, 0.5}}});
    const auto problem = expect_throw<revprio::Problem>([&] { session.step(now); }, "a force law needs a wrench");
    check(problem.status == 422 && problem.detail.find("wrench") != std::string::npos, "the problem names the wrench");
    now.force = {0, 0, 0};
    now.time_s = 12.5;
    check(session.step(now).at("joint_velocity").size() == 7, "an obstacle reaches the service");
}

/// A call whose answer is lost is sent again, unless the service could then do something twice.
void repeats_only_what_is_safe() {
    httplib::Server service;
    std::mutex mutex;
    std::vector<std::string> received;
    const auto lose_answer = [&](const auto& request, auto& answer) {
        std::lock_guard lock(mutex);
        received.push_back(request.path);
        answer.set_content_provider(9, "application/json", [](auto, auto, auto&) { return false; });
    };
    service.Post(".*", lose_answer);
    service.Get(".*", lose_answer);
    const int port = service.bind_to_any_port("127.0.0.1");
    std::thread thread([&] { service.listen_after_bind(); });
    revprio::Options options;
    options.timeout = revprio::Seconds(60);
    revprio::Client client("http://127.0.0.1:" + std::to_string(port), options);
    const auto times = [&](const char* method, const std::string& path) {
        expect_throw<revprio::NoAnswer>([&] { client.call(method, path, Json::object()); }, "a lost answer raises NoAnswer");
        std::lock_guard lock(mutex);
        return std::count(received.begin(), received.end(), path);
    };
    const auto once = {"/v1/simulations/a/control", "/v1/simulations", "/v1/robots", "/v1/controllers"};
    for (const char* path : once) check(times("POST", path) == 1, "a call that is not safe to repeat is sent once");
    check(times("POST", "/v1/stability") == 3 && times("GET", "/v1/simulations/a") == 3, "others are sent again");
    service.stop();
    thread.join();
}

/// `Loop` states when each state was measured: while an answer is late, no state is sent, and their number does not tell the time.
void loop_states_the_time() {
    httplib::Server service;
    std::mutex mutex;
    std::vector<double> times;
    service.Post("/v1/controllers", [](const auto&, auto& answer) { answer.set_content(R"({"id": "a"})", "application/json"); });
    service.Delete("/v1/controllers/a", [](const auto&, auto& answer) { answer.status = 204; });
    service.Post("/v1/controllers/a/step", [&](const auto& request, auto& answer) {
        std::this_thread::sleep_for(std::chrono::milliseconds(30));
        std::lock_guard lock(mutex);
        times.push_back(Json::parse(request.body).at("time_s"));
        answer.set_content(R"({"joint_velocity": [0], "valid_for_ms": 1000})", "application/json");
    });
    const int port = service.bind_to_any_port("127.0.0.1");
    std::thread thread([&] { service.listen_after_bind(); });
    {
        revprio::Options options;
        options.step_timeout = revprio::Seconds(60);
        revprio::Client client("http://127.0.0.1:" + std::to_string(port), options);
        revprio::Session session(client, {{"period_s", 0.005}});
        revprio::Watchdog dog({1.0});
        revprio::Loop loop(session, dog);
        revprio::Measurement now;
        now.joint_position = {0};
        const auto count = [&] { std::lock_guard lock(mutex); return times.size(); };
        while (count() < 3) {
            loop.ask(now);
            loop.wait_until(Clock::now() + std::chrono::milliseconds(5));
        }
        loop.wait_until(Clock::now() + std::chrono::seconds(60));
        now.time_s = 1000;
        const auto sent = count();
        loop.ask(now);
        while (count() == sent) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    service.stop();
    thread.join();
    check(times.at(0) == 0, "the first state has the time 0");
    check(times.at(1) - times.at(0) >= 0.03 && times.at(2) - times.at(1) >= 0.03, "late answers count as the time they took");
    check(times.back() == 1000, "the program may state the time");
}

/// The session ends during the loop: the arm brakes within its limits and comes to rest.
void loop_ends_at_rest(revprio::Client& client) {
    Json controller = client.call("GET", "/v1/scenarios/stiff_wall").at("controller");
    controller["period_s"] = 0.01;
    const std::vector<double> limits{8, 8, 8, 8, 10, 10, 10};
    revprio::Watchdog dog(limits);
    revprio::Session session(client, controller);
    revprio::Measurement now;
    now.joint_position = POSTURE;
    now.force = {0, 0, 0};
    std::vector<double> command(7, 0.0);
    revprio::Loop loop(session, dog);
    const auto moves = [&command] {
        return std::any_of(command.begin(), command.end(), [](double v) { return v != 0; });
    };
    while (!moves()) {
        loop.ask(now);
        loop.wait_until(Clock::now() + std::chrono::milliseconds(10));
        command = loop.command();
    }
    const httplib::Headers owner{{"Revprio-Owner", client.owner()}};
    revprio::Client(client.url()).call("DELETE", "/v1/controllers/" + session.id(), nullptr, true, {}, owner);
    auto before = Clock::now(); // at or before the time for which `command` was computed
    expect_throw<revprio::Problem>(
        [&] {
            for (;;) {
                loop.ask(now);
                loop.wait_until(Clock::now() + std::chrono::milliseconds(10));
                const auto now_computed = Clock::now();
                command = loop.command();
                before = now_computed;
            }
        },
        "a state for a deleted session is refused");
    for (loop.stop(); !loop.is_at_rest();) {
        const auto earlier = before;
        before = Clock::now();
        const std::vector<double> slower = loop.command();
        // The first command of the ramp is that at the end of its period, 10 ms later.
        const double elapsed_s = revprio::Seconds(Clock::now() - earlier).count() + 0.01;
        for (std::size_t joint = 0; joint < 7; ++joint) {
            check(std::abs(slower[joint]) <= std::abs(command[joint]) + 1e-12, "no joint speeds up");
            check(std::abs(command[joint]) - std::abs(slower[joint]) <= limits[joint] * elapsed_s + 1e-12,
                  "no joint exceeds its braking limit");
        }
        command = slower;
    }
    const revprio::LoopReport report = loop.report();
    check(report.steps > 0 && report.steps <= report.periods, "the loop counts its periods and answers");
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 3) return std::fprintf(stderr, "test URL URL-WITH-TOKEN\n"), 2;
    revprio::Options options;
    options.step_timeout = revprio::Seconds(10);
    revprio::Client client(argv[1], options);
    watchdog();
    pace();
    refusals(client);
    closed_loop(client);
    targets(client);
    replaces_its_controller(client);
    presets(client);
    states(client);
    repeats_only_what_is_safe();
    loop_states_the_time();
    loop_ends_at_rest(client);
    token(argv[2]);
    std::puts("all tests passed");
}
