//! First inputs: the examples, robots and scenarios of the repository.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::Target;

/// Returns the seeds of a target.
///
/// # Panics
///
/// If a file of the repository cannot be read.
pub fn seeds(target: Target) -> Vec<Vec<u8>> {
    let line = |route: &str, body: &[u8]| [route.as_bytes(), b"\n", body].concat();
    match target {
        Target::Json => requests().iter().map(|(route, body)| line(route, body.to_string().as_bytes())).collect(),
        Target::MessagePack => {
            requests().iter().map(|(route, body)| line(route, &rmp_serde::to_vec(body).unwrap())).collect()
        }
        Target::Stability => {
            ["stability.json", "stability_impedance.json"].map(|name| example(name).to_string().into()).into()
        }
        Target::Urdf => {
            let mut texts: Vec<Vec<u8>> =
                files("fixtures/robots", "urdf").iter().map(|path| std::fs::read(path).unwrap()).collect();
            let robot = example("robot.json");
            let word = |field: &str| robot[field].as_str().unwrap();
            texts.push(line(&format!("{} {}", word("base"), word("tip")), word("urdf").as_bytes()));
            texts
        }
        Target::Stream => {
            let text = states().iter().map(Value::to_string).collect::<Vec<_>>().join("\n");
            let mut binary = b"msgpack\n".to_vec();
            for state in states() {
                let message = rmp_serde::to_vec(&state).unwrap();
                binary.extend(u16::try_from(message.len()).unwrap().to_be_bytes());
                binary.extend(message);
            }
            // A masked text, a ping, a fragmented text, and a close frame.
            let bytes =
                b"bytes\n\x81\x82\x01\x02\x03\x04\x7a\x7f\x89\x80\x00\x00\x00\x00\x01\x81\x00\x00\x00\x00{\x80\x81\
                \x00\x00\x00\x00}\x88\x82\x00\x00\x00\x00\x03\xe8";
            vec![line("json", text.as_bytes()), binary, bytes.to_vec()]
        }
        Target::Controller => {
            let states = states().iter().map(Value::to_string).collect::<Vec<_>>().join("\n");
            controllers().iter().map(|controller| line(&controller.to_string(), states.as_bytes())).collect()
        }
    }
}

/// Routes and bodies of the requests among the examples.
fn requests() -> Vec<(&'static str, Value)> {
    let mut requests = vec![("resolve/batch", example("batch.json")), ("kinematics", example("kinematics.json"))];
    for path in files("api/examples", "json") {
        let name = path.file_name().unwrap().to_str().unwrap();
        let route = ["resolve", "step"].into_iter().find(|route| name.starts_with(route));
        requests.extend(route.map(|route| (route, example(name))));
    }
    requests
}

/// The controllers of the examples and of the scenarios.
fn controllers() -> Vec<Value> {
    let scenarios = files("fixtures/scenarios", "toml");
    let of_scenario = |path: &PathBuf| {
        let text = std::fs::read_to_string(path).unwrap();
        let scenario: Value = toml::from_str(&text).unwrap();
        scenario["controller"].clone()
    };
    let examples = ["controller.json", "controller_laws.json"].map(example);
    examples.into_iter().chain(scenarios.iter().map(of_scenario)).collect()
}

/// Three states in a row.
fn states() -> Vec<Value> {
    let state = |sequence: u32| {
        let mut state = example("state.json");
        state["sequence"] = sequence.into();
        state["time_s"] = (f64::from(sequence) * 1e-3).into();
        state
    };
    (17..20).map(state).collect()
}

fn example(name: &str) -> Value {
    let text = std::fs::read_to_string(root().join("api/examples").join(name)).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// Files of a folder with this ending, in order.
fn files(folder: &str, ending: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = entries.filter(|path| path.extension().is_some_and(|found| found == ending)).collect();
    files.sort();
    files
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}
