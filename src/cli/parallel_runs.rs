//! Runs of several scenarios on all cores, each against a server of its own.

use indicatif::ProgressBar;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};
use revprio_lab::report::run::Run;
use revprio_lab::simulator::{CallMode, Scenario, built_in_robot};

use super::error::CliError;
use super::experiment::{label, run_with, visible_bar};
use super::output::print_remark;
use super::service_choice::CalledService;
use super::target::Target;

/// Runs scenarios with built-in robots and shows the progress. The results are in the order of the scenarios.
///
/// Each run starts its own server on a free port and calls it over one connection in each control period.
pub fn run_all(scenarios: &[Scenario], title: &str) -> Vec<Result<Run, CliError>> {
    let bar = visible_bar(scenarios.iter().map(Scenario::cycles).sum(), title);
    // Without `with_max_len` a thread would get neighbouring scenarios, the long ones.
    let runs = scenarios.par_iter().with_max_len(1).map(|scenario| run_over_http(scenario, &bar)).collect();
    bar.finish();
    runs
}

fn run_over_http(scenario: &Scenario, bar: &ProgressBar) -> Result<Run, CliError> {
    let mut before = 0;
    let progress = |done| {
        bar.inc(done - before);
        before = done;
    };
    log_without_terminal(bar, || format!("{}: started", label(scenario)));
    let service = CalledService::start(None)?;
    let robot = built_in_robot(&scenario.controller.robot)?;
    let run = run_with(&robot, scenario, &service, CallMode::Session, progress)?;
    if let CalledService::Http(target) = &service {
        check_requests(target)?;
    }
    log_without_terminal(bar, || format!("{}: finished", label(scenario)));
    Ok(run)
}

/// Returns an error if the server did not answer exactly the requests that the client has sent.
fn check_requests(target: &Target) -> Result<(), CliError> {
    let (sent, answered) = (target.client.requests(), target.requests());
    if sent == answered { Ok(()) } else { Err(CliError::Requests { sent, answered }) }
}

fn log_without_terminal(bar: &ProgressBar, line: impl FnOnce() -> String) {
    if bar.is_hidden() {
        print_remark(line());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn short(name: &str) -> Scenario {
        Scenario { duration_s: 0.05, ..Scenario::find(name).unwrap() }
    }

    #[test]
    fn each_run_counts_the_requests_that_its_server_reports() {
        let (scenario, bar) = (short("stiff_wall"), ProgressBar::hidden());
        let requests = run_over_http(&scenario, &bar).unwrap().requests.unwrap();
        // One request opens the session and one closes it.
        assert_eq!(requests.count, 52);
        assert!(0.0 < requests.median_us && requests.median_us <= requests.p99_us);
        let service = CalledService::start(None).unwrap();
        let robot = built_in_robot(&scenario.controller.robot).unwrap();
        let run = run_with(&robot, &scenario, &service, CallMode::Session, |_| ()).unwrap();
        let CalledService::Http(target) = &service else { panic!("not over HTTP") };
        assert_eq!(answers_in_metrics(target), run.requests.unwrap().count);
    }

    /// Returns the sum of all routes.
    fn answers_in_metrics(target: &Target) -> u64 {
        let url = target.own.as_ref().unwrap().url() + "/metrics";
        let text = ureq::get(url).call().unwrap().body_mut().read_to_string().unwrap();
        let counts = text.lines().filter(|line| line.starts_with("revprio_requests_total{"));
        counts.map(|line| line.split_whitespace().last().unwrap().parse::<u64>().unwrap()).sum()
    }

    #[test]
    fn a_run_without_requests_has_no_count() {
        let (scenario, service) = (short("stiff_wall"), CalledService::in_process(None).unwrap());
        let robot = built_in_robot(&scenario.controller.robot).unwrap();
        let run = run_with(&robot, &scenario, &service, CallMode::Session, |_| ()).unwrap();
        assert_eq!(run.requests, None);
        let server = CalledService::start(None).unwrap();
        assert_eq!(server.requests(), Some(0));
    }

    #[test]
    fn requests_of_another_client_are_an_error() {
        let CalledService::Http(target) = CalledService::start(None).unwrap() else { panic!("not over HTTP") };
        assert!(check_requests(&target).is_ok());
        answers_in_metrics(&target);
        let message = check_requests(&target).unwrap_err().to_string();
        assert_eq!(message, "the client sent 0 requests, but its own service answered 1");
    }

    #[test]
    fn runs_are_in_the_order_of_the_scenarios_and_errors_among_them() {
        let unknown = |scenario: Scenario| {
            let mut scenario = scenario;
            scenario.controller.robot = "nobody".to_owned();
            scenario
        };
        let scenarios = [short("stiff_wall"), unknown(short("force_tracking")), short("force_tracking")];
        let runs = run_all(&scenarios, "three");
        let names: Vec<_> = runs.iter().map(|run| run.as_ref().map(|run| run.scenario.name.as_str()).ok()).collect();
        assert_eq!(names, [Some("stiff_wall"), None, Some("force_tracking")]);
    }
}
