//! `revprio sweep`.

use std::path::Path;
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::program::{Scratch, failure, files, program, success};
use crate::serve::Server;
use crate::simulate::short;

const VARY: [&str; 6] = [
    "--vary",
    "environment.stiffness=log:1e3..1e5:3",
    "--vary",
    "loop.lag_s=0,0.005",
    "--vary",
    "solver=auto,closed_form",
];

/// A directory with a short scenario, and its path.
fn scenario(name: &str) -> (Scratch, String) {
    let scratch = Scratch::new(name);
    // The wall is so near that the tool touches it within 0.12 s.
    let text = short("stiff_wall", "duration_s = 0.12").replacen("offset_m = 0.05", "offset_m = 0.001", 1);
    let file = scratch.write("mine.toml", &text);
    (scratch, file)
}

fn sweep(arguments: &[&str]) -> String {
    success(&[&["sweep"][..], arguments].concat())
}

fn table(directory: &Path) -> Vec<u8> {
    std::fs::read(directory.join("sweep-stiff_wall.parquet")).unwrap()
}

#[test]
fn table_does_not_depend_on_threads_shards_servers_or_interruptions() {
    let (scratch, file) = scenario("sweep");
    let out = |name: &str| scratch.argument(name);
    let said = sweep(&[&[&file, "--threads", "1", "--out", &out("one")][..], &VARY].concat());
    assert!(said.contains("\n12 cells: 12 finished\n"), "{said}");
    assert!(said.lines().next().unwrap().contains("peak_force_x_n"), "{said}");
    let one = table(&scratch.path().join("one"));
    let left = files(&scratch.path().join("one"));
    assert!(left.contains(&"sweep-stiff_wall-peak_force_x_n-auto.png".to_owned()), "{left:?}");
    assert!(!left.iter().any(|name| name.ends_with(".partial")), "{left:?}");

    let server = Server::start();
    sweep(&[&[&file, "--threads", "3", "--out", &out("three"), "--server", &server.url][..], &VARY].concat());
    assert!(table(&scratch.path().join("three")) == one, "three threads and a server");

    let parts: Vec<String> = (1..=3).map(|i| out(&format!("parts/sweep-stiff_wall.{i}-of-3.parquet"))).collect();
    for i in 1..=3 {
        sweep(&[&[&file, "--shard", &format!("{i}/3"), "--out", &out("parts")][..], &VARY].concat());
    }
    let missing = failure(&["sweep", "--out", &out("merged"), "--merge", &parts[0], &parts[2]]);
    assert!(missing.contains("4 of 12 cells are missing, cell 1 first"), "{missing}");
    sweep(&["--out", &out("merged"), "--merge", &parts[2], &parts[0], &parts[1]]);
    assert!(table(&scratch.path().join("merged")) == one, "three shards");
    assert_eq!(files(&scratch.path().join("merged")), left);

    interrupt(&[&[&file, "--threads", "1", "--out", &out("again")][..], &VARY].concat(), &scratch.path().join("again"));
    let resumed = program(&[&["sweep", &file, "--out", &out("again")][..], &VARY].concat()).output().unwrap();
    let said = String::from_utf8_lossy(&resumed.stderr);
    assert!(resumed.status.success() && said.contains("cells are already completed"), "{said}");
    assert!(table(&scratch.path().join("again")) == one, "an interruption");
}

/// Kills a sweep after some of its cells are completed.
fn interrupt(arguments: &[&str], out: &Path) {
    let mut child =
        program(&[&["sweep"][..], arguments].concat()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let (start, partial) = (Instant::now(), out.join("sweep-stiff_wall.partial"));
    while std::fs::read_to_string(&partial).map_or(0, |text| text.lines().count()) < 3 {
        assert!(start.elapsed() < Duration::from_mins(2), "no cell was completed");
        sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(partial.exists() && !out.join("sweep-stiff_wall.parquet").exists());
}

#[test]
fn no_table_of_another_sweep_is_overwritten() {
    let (scratch, file) = scenario("sweep_earlier");
    let run = |lag: &str| {
        let vary = format!("loop.lag_s={lag}");
        program(&["sweep", &file, "--out", &scratch.argument("out"), "--vary", &vary]).output().unwrap()
    };
    let (out, remark) = (scratch.path().join("out"), "table of another sweep");
    let said = |output: &std::process::Output| String::from_utf8_lossy(&output.stderr).contains(remark);
    assert!(!said(&run("0,0.005")));
    let (first, names) = (table(&out), files(&out));
    assert!(!said(&run("0,0.005")), "the same sweep");
    assert!(said(&run("0,0.004")));
    assert!(table(&out.join("earlier-1")) == first && table(&out) != first);
    assert_eq!(files(&out.join("earlier-1")), names);
}

#[test]
fn failed_cells_are_rows_of_the_table() {
    let (scratch, file) = scenario("sweep_wrong");
    let vary = ["--vary", "environment.stiffness=-1,1e3", "--vary", "controller.tasks.0.law.inertia=-15,15"];
    let said = sweep(&[&[&file, "--out", &scratch.argument("out")][..], &vary].concat());
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(lines[5], "4 cells: 1 finished, 3 refused", "{said}");
    // Two causes: the mass, and the wall.
    assert!(lines[6].starts_with("  ") && lines[6].contains(" of them: ") && lines[7].contains(" of them: "), "{said}");
    assert!(lines[6..8].iter().any(|line| line.contains("inertia")), "{said}");
    assert!(lines[1].contains("refused") && lines[4].contains("finished"), "{said}");
    assert!(lines[..5].iter().all(|line| line.chars().count() <= 100), "{said}");
}

#[test]
fn a_sweep_without_a_simulated_cell_fails() {
    let (scratch, file) = scenario("sweep_all_wrong");
    let vary = ["--vary", "environment.stiffness=-1,-2"];
    let output = program(&[&["sweep", &file, "--out", &scratch.argument("out")][..], &vary].concat()).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stdout).contains("2 cells: 2 refused"));
    assert!(String::from_utf8_lossy(&output.stderr).contains("no cell was simulated"));
    // What is right now is not taken for the rest of what was wrong.
    sweep(&[&file, "--out", &scratch.argument("out"), "--vary", "environment.stiffness=1e3"]);
}

#[test]
fn errors_are_found_before_the_first_run() {
    let (scratch, file) = scenario("sweep_refused");
    let out = scratch.argument("out");
    let refusal = |more: &[&str]| failure(&[&["sweep", &file, "--out", &out][..], more].concat());
    assert!(refusal(&["--vary", "environment.stifness=1,2"]).contains("stifness"));
    assert!(refusal(&["--vary", "loop.lag_s=0,1", "--vary", "loop.lag_s=2"]).contains("varied twice"));
    for other in ["velocity_loop.lag_s=2", "velocity_loop=2"] {
        assert!(refusal(&["--vary", "loop.lag_s=0,1", "--vary", other]).contains("varied twice, also as `loop.lag_s`"));
    }
    let walls = ["--vary", "contacts.*.stiffness=1e3", "--vary", "contacts.0.stiffness=1e4"];
    assert!(refusal(&walls).contains("varied twice"));
    assert!(refusal(&["--vary", "method=reverse_priority,newton"]).contains("newton"));
    assert!(refusal(&["--draw", "beauty"]).contains("known: rmse_force_x_n"));
    std::fs::write(scratch.path().join("out/sweep-stiff_wall.partial"), "another\n").unwrap();
    assert!(refusal(&["--vary", "loop.lag_s=0,1"]).contains("belongs to another sweep"));
    let output = program(&["sweep", &file, "--shard", "5/4"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
}
