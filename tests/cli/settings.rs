//! `revprio config`, `revprio completions`, and what `serve` does with settings.

use std::process::{Command, Output};

use crate::program::{Scratch, failure, program, success};
use crate::serve::Server;

/// `config` with this environment.
fn config(arguments: &[&str], environment: &[(&str, &str)]) -> Output {
    let mut command: Command = program(&[&["config"], arguments].concat());
    command.env_remove("REVPRIO_CONFIG").envs(environment.iter().copied()).output().unwrap()
}

/// The line of one setting.
fn line(output: &Output, key: &str) -> String {
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let line = text.lines().find(|line| line.trim_start_matches("# ").starts_with(&format!("{key} ")));
    line.unwrap_or_else(|| panic!("{key} is not in {text}")).split_whitespace().collect::<Vec<_>>().join(" ")
}

fn refusal(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(1));
    String::from_utf8(output.stderr.clone()).unwrap()
}

#[test]
fn options_override_environment_file_and_defaults() {
    let scratch = Scratch::new("settings");
    let file = scratch.write("service.toml", "max_sessions = 1\nmax_lag_ms = 1\nheader_timeout_s = 1\n");
    let environment = [("REVPRIO_MAX_SESSIONS", "2"), ("REVPRIO_MAX_LAG_MS", "2"), ("REVPRIO_CONFIG", file.as_str())];
    let output = config(&["--max-sessions", "3"], &environment);
    assert_eq!(line(&output, "max_sessions"), "max_sessions = 3 # flag");
    assert_eq!(line(&output, "max_lag_ms"), "max_lag_ms = 2.0 # environment, REVPRIO_MAX_LAG_MS");
    assert_eq!(line(&output, "header_timeout_s"), format!("header_timeout_s = 1.0 # file, {file}"));
    assert_eq!(line(&output, "body_timeout_s"), "body_timeout_s = 10.0 # default");
    assert_eq!(line(&output, "token_file"), "# token_file is not set # default");
}

#[test]
fn output_of_config_is_a_file_with_the_same_settings() {
    let scratch = Scratch::new("settings_again");
    let flags = ["--allow-origin", "https://a.example", "--allow-origin", "http://[::1]:80", "--log-format", "json"];
    let printed = String::from_utf8(config(&flags, &[]).stdout).unwrap();
    let file = scratch.write("again.toml", &printed);
    let again = String::from_utf8(config(&["--config", &file], &[]).stdout).unwrap();
    let values = |text: &str| text.lines().map(|l| l.split(" # ").next().unwrap().to_owned()).collect::<Vec<_>>();
    assert_eq!(values(&printed), values(&again));
    assert!(printed.contains(r#"allow_origin = ["https://a.example", "http://[::1]:80"]"#), "{printed}");
}

#[test]
fn help_shows_the_effective_defaults() {
    // Without the line ends of the wrapped text.
    let help = success(&["serve", "--help"]).split_whitespace().collect::<Vec<_>>().join(" ");
    let printed = String::from_utf8(config(&[], &[]).stdout).unwrap();
    for line in printed.lines().filter(|line| !line.starts_with('#')) {
        let (key, rest) = line.split_once(" = ").unwrap();
        let value = rest.split(" # ").next().unwrap().trim().trim_matches('"').trim_end_matches(".0");
        let flag = format!("--{} ", key.replace('_', "-"));
        let told = help.split_once(&flag).unwrap().1.split_once("[default: ").unwrap().1;
        assert_eq!(told.split(']').next().unwrap(), value, "{key}");
    }
}

#[test]
fn errors_name_invalid_settings_and_their_source() {
    let scratch = Scratch::new("settings_wrong");
    for (text, parts) in [
        ("lisen = \"127.0.0.1:1\"", &["`lisen`", "line 1", "`listen`"][..]),
        ("max_sessions = 0", &["max_sessions, set by file", "at least 1"]),
        ("max_sessions = \"many\"", &["line 1", "max_sessions"]),
        ("body_timeout_s = 0.0", &["body_timeout_s", "positive"]),
        ("body_timeout_s = nan", &["body_timeout_s", "between"]),
        ("allow_origin = [\"https://a.example/page\"]", &["allow_origin", "without a path"]),
        ("listen = ", &["line 1"]),
    ] {
        let file = scratch.write("wrong.toml", text);
        let message = refusal(&config(&["--config", &file], &[]));
        for part in parts.iter().chain(&["wrong.toml"]) {
            assert!(message.contains(part), "{part} is not in {message}");
        }
    }
    let message = refusal(&config(&[], &[("REVPRIO_LISTEN", "here")]));
    assert!(message.contains("REVPRIO_LISTEN") && message.contains("'here'"), "{message}");
    assert!(refusal(&config(&["--max-lag-ms=-1"], &[])).contains("max_lag_ms, set by flag"));
    assert!(refusal(&config(&["--config", "no_such.toml"], &[])).contains("no_such.toml"));
}

#[test]
fn settings_file_of_the_systemd_unit_is_valid() {
    let shipped = config(&["--config", "api/deploy/service.toml"], &[]);
    assert_eq!(line(&shipped, "drain_delay_s"), "drain_delay_s = 2.0 # file, api/deploy/service.toml");
}

#[test]
fn serve_refuses_unsafe_settings() {
    let scratch = Scratch::new("settings_unsafe");
    let message = failure(&["serve", "--listen", "0.0.0.0:0"]);
    assert!(message.contains("--token-file") && message.contains("127.0.0.1"), "{message}");
    let empty = scratch.write("token", "");
    assert!(failure(&["serve", "--listen", "127.0.0.1:0", "--token-file", &empty]).contains("is empty"));
    assert!(failure(&["serve", "--listen", "127.0.0.1:0", "--tls-cert", &empty]).contains("needs tls_key"));
    assert!(failure(&["serve", "--listen", "127.0.0.1:0", "--log-level", "a=b=c"]).contains("log_level"));
    for level in ["warning", "bogus", ""] {
        let message = failure(&["serve", "--listen", "127.0.0.1:0", "--log-level", level]);
        assert!(message.contains("log_level, set by flag: is not a log level: give off, error, warn,"), "{message}");
    }
    let output = program(&["serve", "--listen", "localhost:8080"]).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2));
    assert!(message.contains("give an IP address and a port, for example 127.0.0.1:8080"), "{message}");
}

#[test]
fn every_file_of_the_robots_directory_is_a_robot() {
    let scratch = Scratch::new("settings_robots");
    std::fs::create_dir_all(scratch.path().join("robots/meshes")).unwrap();
    let arm = include_str!("../../fixtures/robots/planar_3r.urdf");
    let rows = include_str!("../../fixtures/robots/sawyer_dh.toml");
    let srdf = r#"<robot name="left"><end_effector name="gripper" parent_link="hand"/></robot>"#;
    for (name, text) in [("left.urdf", arm), ("left.srdf", srdf), ("right.toml", rows), (".hidden", "")] {
        scratch.write(&format!("robots/{name}"), text);
    }
    let directory = scratch.argument("robots");
    // Every replica knows the robots from its start.
    for server in [(); 2].map(|()| Server::start_with(&["--robots-dir", &directory])) {
        for name in ["left", "right", "panda"] {
            assert!(server.get(&format!("/v1/robots/{name}")).starts_with("HTTP/1.1 200 "), "{name}");
        }
        let left = server.get("/v1/robots/left");
        assert!(left.contains(r#""tip":"hand""#), "the semantic description names the link of the hand: {left}");
    }
    let refused = |name: &str, text: &str| {
        let file = scratch.write(&format!("robots/{name}"), text);
        let message = failure(&["serve", "--robots-dir", &directory]);
        std::fs::remove_file(file).unwrap();
        assert!(message.contains(name), "{message}");
        message
    };
    assert!(refused("panda.urdf", arm).contains("rename the file"));
    assert!(refused("two words.urdf", arm).contains("rename the file"));
    assert!(refused("README.md", "").contains("robots are described in .urdf, .toml or .json"));
    refused("broken.urdf", "<robot>");
    refused("nobody.srdf", srdf);
    std::fs::remove_file(scratch.path().join("robots/left.srdf")).unwrap();
    refused("left.srdf", "<robot>");
    let missing = scratch.argument("missing");
    assert!(failure(&["serve", "--robots-dir", &missing]).contains("missing"));
    assert!(
        failure(&["serve", "--robots-dir", &directory, "--robot", &format!("{directory}/left.urdf,name=left")])
            .contains("rename the file")
    );
}

#[test]
fn own_robots_can_be_set_in_every_source() {
    let scratch = Scratch::new("settings_robot");
    let file = scratch.write("service.toml", "robot = [\"fixtures/robots/planar_3r.urdf,name=mine\"]");
    let flag = ["--robot", "fixtures/robots/planar_3r.urdf,name=a,tip=tool", "--robot", "other.toml"];
    let of_flags = r#"robot = ["fixtures/robots/planar_3r.urdf,name=a,tip=tool", "other.toml"] # flag"#;
    assert_eq!(line(&config(&flag, &[]), "robot"), of_flags);
    let of_environment = r#"robot = ["arm.urdf,tip=hand"] # environment, REVPRIO_ROBOT"#;
    assert_eq!(line(&config(&[], &[("REVPRIO_ROBOT", "arm.urdf,tip=hand")]), "robot"), of_environment);
    assert!(Server::start_with(&["--config", &file]).get("/v1/robots/mine").starts_with("HTTP/1.1 200 "));
    let wrong = scratch.write("wrong.toml", "robot = [\"a.urdf,tool=b\"]");
    assert!(refusal(&config(&["--config", &wrong], &[])).contains("`tool=b` is none of"));
    assert!(failure(&["serve", "--robot", "no_such.urdf"]).contains("no_such.urdf"));
}

#[test]
fn completion_scripts_contain_commands_and_options() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = success(&["completions", shell]);
        assert!(script.contains("simulate") && script.contains("token-file"), "{shell}");
    }
}
